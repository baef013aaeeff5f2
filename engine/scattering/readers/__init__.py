"""Scattering files; `reader` is the one door to all of them."""
