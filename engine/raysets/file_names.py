"""What ray files are called."""

ENDINGS = (".tm25ray", ".ray", ".dat", ".dis", ".txt", ".rsf", ".src", ".sdf")
"""Of names of ray files, where files are looked for."""
