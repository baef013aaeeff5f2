"""Forecasts of the time that pictures and measurements take, taken early; `run` is the door."""
