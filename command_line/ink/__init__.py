"""The commands ``lumenray ink``: dense pigment layers from their composition."""
