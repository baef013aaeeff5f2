"""The bake in Blender: its job, the images, UV maps and looks that it leaves, and its results in the file."""
