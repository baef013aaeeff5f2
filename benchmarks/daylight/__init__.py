"""Natural light beside other programs: the sun's place, skies, and the year of one room; `run` is its door."""
