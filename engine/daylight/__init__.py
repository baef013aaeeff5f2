"""Daylight of a whole year: what its illuminances are judged by, with the error of each figure, and pictures of it."""
