"""The light of a ray file as rays in lumens: those of the file where they are enough, else rays generated from them."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from .cloud import MOST_HELD, Fluctuation, RayCloud, hold_rays, make_cloud
from .reader import read_rays
from .record import RayFile
from .survey import Survey, hold_luminous, luminous_rays

ENOUGH = 5_000_000
"""Rays of a file above which none are generated for pictures and distributions."""

GENERATED = 1 << 23
"""Rays that are generated otherwise."""

PIECE = 1 << 19
"""Rays that are generated at a time."""

PREPARING = 0.6
"""Share of the progress that preparing rays for generation counts for."""


@dataclass(frozen=True, eq=False)
class Light:
    """Rays of a source. ``pieces``: a call gives (position [m], direction, flux [lm]) piece by piece.

    Parameters
    ----------
    pieces : callable
    cloud : RayCloud or None    What they are generated from; None: they are those of the file.
    """

    pieces: Callable[[], Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]]
    cloud: RayCloud | None


def light_of(
    file: RayFile,
    survey: Survey,
    fluctuation: Fluctuation | None = None,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Light:
    """Return the light of a file in lumens.

    Raises
    ------
    FileFormatError    The file's rays carry watts, and nothing tells of which wavelengths; or none of it is visible.
    Cancelled
    """
    if survey.rays >= ENOUGH and fluctuation is None:

        def read():
            for rays in read_rays(file, cancelled=cancelled):
                lit = luminous_rays(file, survey, rays)
                yield lit.position, lit.direction, lit.weight

        return Light(read, None)
    told = progress or (lambda share: None)
    held = hold_rays(file, MOST_HELD, seed, cancelled=cancelled)
    held, flux = hold_luminous(file, survey, held)
    cloud = make_cloud(held, flux, fluctuation, seed, lambda s: told(PREPARING * s), cancelled)

    def generate():
        rng = np.random.default_rng(seed + 1)
        share = GENERATED // PIECE
        for number in range(share):
            drawn = cloud.draw(PIECE, rng)
            told(PREPARING + (1.0 - PREPARING) * (number + 1) / share)
            yield drawn.position, drawn.direction, drawn.flux / share

    return Light(generate, cloud)
