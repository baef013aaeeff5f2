"""Dense pigment layers in Blender: their compositions as settings, and the tables computed of them."""
