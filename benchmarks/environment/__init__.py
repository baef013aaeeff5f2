"""Pictures of the surroundings: illuminance kept, suns found and mended, noise, files that are none; `run` is the door."""
