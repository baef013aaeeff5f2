"""What light is judged by, against standards and other programs: glare, colour, isolux, verdicts; `run` is its door."""
