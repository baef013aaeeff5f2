"""The scene as pure data: items with ids, the delta that changes them, and the hash of all."""
