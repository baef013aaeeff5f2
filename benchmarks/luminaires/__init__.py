"""Luminaires: agreement with Radiance, speed of look-up, noise of a next event."""
