"""Pictures of the surroundings in a world: what the user sets about their light, what was found in them, suns placed."""
