"""Cases still to come."""
