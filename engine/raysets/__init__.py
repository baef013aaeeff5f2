"""Ray files of measured and computed sources: read, surveyed, reduced, written, and made ready as lights."""
