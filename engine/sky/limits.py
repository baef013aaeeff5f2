"""Ranges of years and of heights for which the sun is computed."""

FIRST_YEAR, LAST_YEAR = 1900, 2100
"""Years for which the sun is computed."""

HIGHEST, LOWEST = 9000.0, -500.0
"""Range of heights above the sea at which people stand. [m]"""
