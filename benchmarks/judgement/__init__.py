"""From light to judgement: glare, colour, isolux lines and verdicts against other programs and exact values."""
