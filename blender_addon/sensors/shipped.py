"""Requirements that ship, read once."""

import functools

from ...engine.judgement.reader import known_requirements
from ...engine.judgement.requirement import Requirement


@functools.cache
def shipped_requirements() -> dict[str, Requirement]:
    """Return the requirements that ship, by key."""
    return known_requirements()
