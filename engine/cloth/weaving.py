"""From the description of a cloth to its surface."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ..scattering.data.evaluation import totals
from .kept import default_folder, key_of, load_woven, save_woven
from .plan import rays_of
from .reader import parse_cloth
from .readings import linear_colour, read_sheet
from .surface import WovenSurface
from .woven import weave


def weave_surface(
    content: dict,
    *,
    draft: bool = False,
    folder: Path | None = None,
    seed: int = 0,
    report: Callable[[float], None] = lambda share: None,
) -> WovenSurface:
    """Compute what a cloth scatters, unless it is kept from before. A variant of Mitsuba must be active.

    Parameters
    ----------
    content : dict    Description, as `reader.parse_cloth` takes it.
    draft : bool    As of `plan.rays_of`.
    folder : Path or None    Where computed cloths are kept; None: `kept.default_folder`.
    report : callable    Told from time to time which share of the work is done; what it raises ends it.

    Raises
    ------
    FileFormatError    The description breaks the schema or names what there is not; or the folder cannot be written.
    SceneError    Rays got lost, or the pile is too dense.
    """
    cloth, folder = parse_cloth(content), folder or default_folder()
    rays = rays_of(draft)
    key = key_of(cloth, rays, seed)
    held = load_woven(key, folder)
    if held is not None:
        return held
    woven = weave(cloth, rays=rays, seed=seed, report=report)
    sides = woven.sides
    wavelengths = sides["front_reflection"].wavelengths
    reflected, passed = (
        linear_colour(totals(sides[f"front_{part}"], [0.0], [0.0])[0, 0], wavelengths)
        for part in ("reflection", "transmission")
    )
    made = WovenSurface(
        woven.surface,
        read_sheet(woven),
        reflected,
        # What passes straight has no colour.
        np.maximum(passed - woven.openness, 0.0),
        max(side.error for side in sides.values()),
        woven.rays,
        seed,
        key,
        tuple(woven.notes()),
    )
    save_woven(made, folder)
    # Files have half precision, and whoever asks again gets the same.
    return load_woven(key, folder) or made
