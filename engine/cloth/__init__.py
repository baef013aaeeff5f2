"""Cloth from its threads: light in a thread, weaves of them, and the tables of measured materials that come of it."""
