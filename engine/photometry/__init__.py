"""Spectra and their photometric integrals, colour, and the units; conversions stand in `units` alone."""
