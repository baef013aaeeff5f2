"""Lux maps beside references and other programs: stated errors, forecasts, speed, leaks, scale."""
