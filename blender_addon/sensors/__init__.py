"""Sensors as objects of the scene: what is set, where they stand, the job that measures, and what they hold in the file."""
