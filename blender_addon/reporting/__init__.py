"""The report of a scene: what sensors told, luminaires and pictures brought together (gathering), and the files of it."""
