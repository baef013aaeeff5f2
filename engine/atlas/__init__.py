"""Lux maps on surfaces: charts of meshes, pages, lumels, seams and what lies between them."""
