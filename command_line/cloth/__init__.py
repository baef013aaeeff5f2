"""The commands ``lumenray cloth``: cloths from their yarns."""
