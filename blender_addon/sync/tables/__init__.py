"""What the engine has already, and which of it may be out of date."""
