"""The commands ``lumenray environment``: pictures of the surroundings analysed, taken apart, mended; door: `commands`."""
