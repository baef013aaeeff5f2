"""Luminaires on the device: intensity tables, openings and Mitsuba's emitters made of them."""
