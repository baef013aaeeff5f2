"""The daylight of a year at sensors, from what they have of every part of the sky, and what standards make of it."""
