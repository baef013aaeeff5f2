"""How many rays a cloth's tables take."""

import numpy as np

from .composition import Cloth

INCIDENCES = np.radians([0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 80.0, 87.0])
"""Angles of incidence of tables. [rad]"""

QUARTER, ROUND = np.radians(np.arange(0.0, 91.0, 15.0)), np.radians(np.arange(0.0, 360.0, 30.0))
"""Rotations of orthotropic cloths, and of others. [rad]"""

RAYS, DRAFT_RAYS = 120_000, 12_000
"""Rays of each direction of a table, and of one for a look."""


def rays_of(draft: bool) -> int:
    """Rays of each direction from which light comes; ``draft``: for a look."""
    return DRAFT_RAYS if draft else RAYS


def is_alike(cloth: Cloth) -> bool:
    """Whether a cloth is the same seen from its back, and in mirrors along its yarns.

    Yarns of one kind of plain weave change places when it is turned over.
    """
    return cloth.weave.is_orthotropic and cloth.pile is None


def rays_in_all(cloth: Cloth, draft: bool) -> int:
    """Rays that the tables of a cloth take."""
    return rays_of(draft) * directions_of(cloth)


def directions_of(cloth: Cloth) -> int:
    """Directions that rays are sent from, with the normal counted twice."""
    if is_alike(cloth):
        return 2 + len(QUARTER) * (len(INCIDENCES) - 1)
    turns = len(ROUND) // 2 if cloth.weave.turns_back and cloth.pile is None else len(ROUND)
    return 2 * (2 + turns * (len(INCIDENCES) - 1))
