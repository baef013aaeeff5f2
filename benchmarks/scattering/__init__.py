"""Measured materials: storage over error, sampling, speed, pictures."""
