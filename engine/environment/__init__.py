"""Equirectangular pictures as light: what they hold, their bright sources as lights of their own, and suns mended."""
