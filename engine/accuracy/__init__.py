"""Errors: means with standard errors, when to stop, forecasts, and whether two witnesses agree."""
