"""What fluctuation blurs of a ray set, as far as its own rays show it."""

import numpy as np

from .beam_cells import BeamCells
from .record import Rays


def find_blur(made, rays: Rays, radii: list[float], bands: int, sectors: int) -> float:
    """Relative error of generated light that its difference from the file's rays shows.

    Light is counted in cells of spheres around the source, and in their bands alone, which tell less of it better; the
    larger difference counts. Rays of a file scatter by chance, or by less if they were chosen evenly, which its halves tell;
    a difference that this may be counts for nothing.

    Parameters
    ----------
    made : Drawn
    rays : Rays    In the order of the file.
    radii : list of float    Of the spheres. [m]
    bands, sectors : int    Of the cells.
    """
    if len(rays) < 2:
        return 0.0
    middle = rays.position.astype(np.float64).mean(axis=0)
    return max(_compare(made, rays, middle, radii, bands, parts) for parts in (1, sectors))


# ---- private ----


def _compare(made, rays: Rays, middle, radii, bands: int, sectors: int) -> float:
    """Root mean square of the difference in the cells of all spheres over that of the light, beyond chance. [-]"""
    weight = rays.weight / rays.weight.sum(dtype=np.float64)
    halves = (slice(0, len(rays) // 2), slice(len(rays) // 2, None))
    square = noise = scale = 0.0
    for radius in radii:
        cells = BeamCells(rays.position, rays.direction, weight, middle, radius, bands, sectors)
        where = cells.numbers(rays.position, rays.direction, radius)
        first, second = (np.bincount(where[part], weight[part], len(cells)) for part in halves)
        expected = first + second
        found = cells.shares(made.position, made.direction, made.flux, radius)
        square += float(((found - expected) ** 2).mean())
        scale += float((expected**2).mean())
        apart = first / max(first.sum(), 1e-300) - second / max(second.sum(), 1e-300)
        chance = np.bincount(where, weight**2, len(cells))
        noise += min(float(chance.mean()), 0.25 * float((apart**2).mean()))
        noise += float(expected.mean()) / len(made.flux)
    sure = 1.0 + 2.0 * np.sqrt(2.0 / (len(radii) * len(cells)))
    return float(np.sqrt(max(square - sure * noise, 0.0) / scale))
