"""Scattering on the device: lobes that are evaluated and sampled exactly, and Mitsuba's plug-in of them."""
