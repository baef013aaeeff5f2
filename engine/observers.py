"""Observers in a scene: glare that eyes are exposed to, from fisheye pictures of all that is before them."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .accuracy.stopping import Progress, StopRule
from .analysis.glare_sources import THRESHOLD
from .analysis.observer_glare import FIGURES, rate_observer
from .analysis.observer_view import eye_camera
from .errors import Cancelled
from .formats.luminance_picture import view_of_camera
from .light_mix import NEUTRAL, LightMix, undim
from .scene.light_groups import LightGroup
from .views import ViewSettings

PARTS = 4
"""Pictures with samples of their own, whose figures differ by their errors."""

FREEDOM = PARTS - 1
"""Degrees of freedom of the errors."""

DARK = "where an observer sees no light at all, or too little to be found, glare is not rated"
"""What is told of those."""

SIZE, SAMPLES = 600, 16
"""Width and height of the pictures [pixel], and samples of a pixel in all of them together."""


def find_unseen(scene) -> list[str]:
    """Names of the lights of a `Scene` that no eye can see, as they have no size: their glare is in no rating."""
    made = []
    for light in scene.lights.values():
        is_point = getattr(light, "radius", None) == 0.0
        opening = getattr(light, "opening", None)
        if is_point or (opening is not None and opening.shape == "point"):
            made.append(light.name)
    return sorted(made)


def rate_observers(
    session,
    positions,
    directions,
    size: int = SIZE,
    samples: int = SAMPLES,
    threshold: float = THRESHOLD,
    seed: int = 0,
    transport: str = "auto",
    progress: Callable[[Progress], None] | None = None,
    is_cancelled: Callable[[], bool] = lambda: False,
) -> tuple[dict[str, np.ndarray], tuple[str, ...]]:
    """Rate what observers see; parameters, answer and errors as of `rate_mixes`, which see, of all light together."""
    (table,), notes = rate_mixes(
        session, positions, directions, (), (NEUTRAL,), size, samples, threshold, seed, transport, progress, is_cancelled
    )  # fmt: skip
    return table, notes


def rate_mixes(
    session,
    positions,
    directions,
    groups: tuple[LightGroup, ...],
    mixes: tuple[LightMix, ...],
    size: int = SIZE,
    samples: int = SAMPLES,
    threshold: float = THRESHOLD,
    seed: int = 0,
    transport: str = "auto",
    progress: Callable[[Progress], None] | None = None,
    is_cancelled: Callable[[], bool] = lambda: False,
) -> tuple[list[dict[str, np.ndarray]], tuple[str, ...]]:
    """Rate what observers see with the light groups at several levels, which share the pictures.

    Parameters
    ----------
    session : Session or RemoteSession    With the scene.
    positions, directions : (n, 3) array    Of the eyes [m], and where they look.
    groups : tuple of LightGroup    Kept apart in the pictures; none: all light together.
    mixes : tuple of LightMix    Levels of the groups, for each of which all is rated.
    size : int    Width and height of the pictures; an odd one is raised by one. [pixel]
    samples : int    Of a pixel, in all pictures of an observer together.
    threshold : float    Luminance above which pixels are part of glare sources. [cd/m2]
    progress : callable or None    Gets a `Progress`.
    is_cancelled : callable    Asked before every picture.

    Returns
    -------
    list of dict of str to (n, 2) array
        Of every mix, by `observer_glare.FIGURES`: values and standard errors; NaN where one has no meaning, as UGR where
        nothing dazzles. What is a source is told by the picture without dimming, as a luminaire that is dimmed below the
        threshold stays one: light that is dimmed as a whole by f changes UGR by 8 log10 f.
    tuple of str    Notes for people.

    Raises
    ------
    SceneError    An observer has no line of sight.
    Cancelled    It was cancelled.
    """
    # Samples are of all groups together, of which each is to be known as well as all light would be.
    rule = StopRule(samples=max(samples // PARTS, 1) * max(len(groups), 1))
    # Sums over all pixels need few paths, which takes less time than finding the light of cells.
    wanted = ViewSettings(rule, seed, transport=transport, method="paths", groups=groups)
    rows, notes, seconds = [[] for _ in mixes], {}, 0.0
    for number, (place, direction) in enumerate(zip(positions, directions, strict=True)):
        camera = eye_camera(place, direction, size + size % 2)
        pictures, full = ([[] for _ in mixes] for _ in range(2))
        for part in range(PARTS):
            if is_cancelled():
                raise Cancelled("cancelled")
            made = session.render(camera, replace(wanted, seed=(seed + part) % 2**31))
            for row, whole, levels in zip(pictures, full, mixes, strict=True):
                seen = made if levels.is_neutral else made.mixed(levels)
                row.append(np.maximum(seen.tristimulus[..., 1], 0.0).astype(np.float64))
                if levels.is_dimmed:
                    whole.append(np.maximum(undim(made.groups, levels), 0.0))
            notes |= dict.fromkeys(made.provenance.notes)
            seconds += made.provenance.seconds
        for row, seen, whole in zip(rows, pictures, full, strict=True):
            if all(picture.any() for picture in seen):
                undimmed = np.stack(whole) if whole else None
                row.append(
                    rate_observer(np.stack(seen), view_of_camera(camera), threshold, undimmed)
                )
            else:
                row.append(dict.fromkeys(FIGURES, (np.nan, np.nan)))
                notes[DARK] = None
        if progress is not None:
            done = (number + 1) / len(positions)
            stage = f"observer {number + 1} of {len(positions)}"
            progress(Progress(done, rule.samples * PARTS, np.inf, seconds, None, stage))
    tables = [
        {name: np.array([each[name] for each in row], dtype=np.float64) for name in FIGURES}
        for row in rows
    ]
    return tables, tuple(notes)
