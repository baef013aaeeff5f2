"""Random small rooms against long runs of paths from the lights."""
