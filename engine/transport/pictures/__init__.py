"""Pictures of a camera: light of matt surfaces by separate kinds of samples that end at cells, all other by paths."""
