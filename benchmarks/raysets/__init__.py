"""Ray sets: error over the size of the file, lux maps close by, speed."""
