"""Daylight by place and time: what the user sets of them, the moment that they state, and the Sun light that follows it."""
