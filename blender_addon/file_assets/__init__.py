"""The file behind a light or a material: read once for all, embedded or linked, its state in a sentence, its pictures."""
