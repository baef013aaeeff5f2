"""Cloths against reference values and themselves, both ways of light, from near and from afar, and the cost."""
