"""The daylight of a year of Blender's scene: what is asked, the job that finds it, and where its answers are kept."""
