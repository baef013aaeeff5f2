"""Scattering as data: tables, patches and trees, evaluated in double precision, resampled and stored."""
