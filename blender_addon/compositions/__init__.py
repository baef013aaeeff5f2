"""What surfaces by their composition share, paints, pigment layers and cloths: descriptions, tables, and their use."""
