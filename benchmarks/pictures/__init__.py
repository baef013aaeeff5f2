"""Pictures: time to an error beside Cycles and plain paths, bias and stated errors; `run` is the door."""
