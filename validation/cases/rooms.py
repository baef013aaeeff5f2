"""Black rooms with one opening, and the skies that they are measured under."""

from collections.abc import Iterable, Sequence

import numpy as np

from lumenray.engine.scene.light import CieSky
from lumenray.engine.scene.material import Material, Surface, ThinGlass, Transparent
from lumenray.engine.scene.spectrum import Constant

from .. import stage
from ..bench import Bench, Finding, Findings
from ..reference import Group

HORIZONTAL = 100.0
"""Horizontal illuminance of the skies, so that readings are percent of it. [lx]"""

UNIFORM = 5
"""Type of the sky that is equally bright everywhere; groups that do not depend on the sky are measured under it."""

SUN_ELEVATION = np.radians(60.0)

OPEN = stage.material("open", Transparent())
"""An opening with nothing in it."""

FACES = {
    "floor": ((0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (0.0, 4.0, 0.0)),
    "ceiling": ((0.0, 0.0, 3.0), (4.0, 0.0, 0.0), (0.0, 4.0, 0.0)),
    "front": ((0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (0.0, 0.0, 3.0)),
    "back": ((0.0, 4.0, 0.0), (4.0, 0.0, 0.0), (0.0, 0.0, 3.0)),
    "left": ((0.0, 0.0, 0.0), (0.0, 4.0, 0.0), (0.0, 0.0, 3.0)),
    "right": ((4.0, 0.0, 0.0), (0.0, 4.0, 0.0), (0.0, 0.0, 3.0)),
}
"""Corner and edges of the faces of the room [0, 4] x [0, 4] x [0, 3]. [m]"""


def glass(key: str, surface: Surface | None = None) -> Material:
    """Pane of case C07: 6 mm, n = 1.52, transmittance 0.88 at normal incidence; or of another surface."""
    # The glass body's own share of that, without the losses at its two faces.
    return stage.material(key, surface or ThinGlass(1.52, Constant(0.95841544)))


def room(face: str, hole: tuple[tuple, tuple], pane: Material) -> tuple:
    """Room with an opening.

    Parameters
    ----------
    face : str    The one of `FACES` that has the opening.
    hole : ((float, float), (float, float))    Its ranges along the face's edges. [m]
    pane : Material    What is in the opening.

    Returns
    -------
    tuple of items
    """
    items = [stage.BLACK, pane]
    for key, sides in FACES.items():
        if key != face:
            items.append(stage.quad(key, *sides, "black"))
    corner, *edges = (np.asarray(x) for x in FACES[face])
    shares = [np.divide(h, np.linalg.norm(e)) for h, e in zip(hole, edges, strict=True)]
    start = corner + sum(s[0] * e for s, e in zip(shares, edges, strict=True))
    items.append(
        stage.quad(
            "opening", start, *(np.ptp(s) * e for s, e in zip(shares, edges, strict=True)), pane.id
        )
    )
    if any(np.ptp(s) < 1.0 for s in shares):
        items.append(stage.frame(face, corner, *edges, *shares, "black"))
    return tuple(items)


def sky(kind: int, towards_sun, ground_reflectance: float = 0.0) -> CieSky:
    """Sky of a CIE type with readings in percent."""
    return CieSky(kind, np.asarray(towards_sun), HORIZONTAL, ground_reflectance)


def with_prefix(groups: dict[str, Group], prefix: str) -> list[Group]:
    """Those of the groups whose id begins so."""
    return [group for key, group in groups.items() if key.startswith(prefix)]


def measure_under_skies(
    bench: Bench, items: tuple, groups: Iterable[Group], towards_sun, ground_reflectance=0.0
) -> Findings:
    """Measure each group under the sky that its id ends with (``sky12``), those of one sky together."""
    by_sky: dict[int, list[Group]] = {}
    for group in groups:
        number = group.id.rpartition(".sky")[2]
        by_sky.setdefault(int(number) if number.isdigit() else UNIFORM, []).append(group)
    for kind, those in sorted(by_sky.items()):
        yield from measure_together(
            bench, (*items, sky(kind, towards_sun, ground_reflectance)), those
        )


def measure_together(bench: Bench, items: tuple, groups: Sequence[Group]) -> Findings:
    """Measure the sensors of several groups in one call."""
    made = bench.measure(
        items,
        np.concatenate([group.positions for group in groups]),
        np.concatenate([group.normals for group in groups]),
        np.concatenate([group.allowed for group in groups]),
    )
    start = 0
    for group in groups:
        bench.show(group, items)
        part = slice(start, start + len(group.values))
        start = part.stop
        yield Finding(group, made.values[part], made.errors[part])
