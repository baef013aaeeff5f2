"""Effect paints against reference values, Monte Carlo, a clock and their own readings fitted."""
