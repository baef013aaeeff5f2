"""Cities with their coordinates and time zones, and the reader that also takes a user's list of them."""
