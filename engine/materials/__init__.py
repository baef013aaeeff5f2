"""Reflectance models that Mitsuba lacks, as its plug-ins."""
