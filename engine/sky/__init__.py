"""Surroundings that give light: skies of the CIE and pictures of the world."""
