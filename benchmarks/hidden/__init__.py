"""Light that is hard to find, with many seeds, against closed forms."""
