"""Faults of physics that the validation suite has to find; its door is `python -m lumenray.validation.mutations`."""
