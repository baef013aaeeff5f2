"""Measured scattering of surfaces: its files, its tables and its light transport."""
