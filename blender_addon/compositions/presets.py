"""Presets of compositions."""


def title_of(name: str) -> str:
    """Return the name of a preset for people."""
    return name.replace("_", " ").capitalize()
