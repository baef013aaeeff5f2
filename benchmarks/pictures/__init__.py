"""Pictures: time to an error beside Cycles and plain paths, bias, stated errors and forecasts; `run` is the door."""
