"""Lighting requirements by activity, own summaries of what public sources state of standards; users' files stand beside."""

from pathlib import Path

FOLDER = Path(__file__).parent


def files() -> tuple[Path, ...]:
    """Return the files that ship, in order of their names."""
    return tuple(sorted(FOLDER.glob("*.toml")))
