"""C40: lamps in the middle of a closed ball of clear glass, at sensors, in lux maps and in pictures."""

import numpy as np

from lumenray.engine.scene.material import Cauchy, Dielectric

from ..bench import Bench, Finding, Findings
from ..reference import Group
from ..stage import box, glowing, lumen, material, matt, sphere
from .means import ENOUGH, look, mean_by_bake, mean_of_picture, reseeded
from .registry import case

FLUX = 1000.0
"""Of the lamps. [lm]"""

REFLECTANCE = 0.5
"""Of the rooms. [-]"""

BULB = 0.03
"""Radius of the glass. [m]"""

FINE = 96
"""Parallels of the glass."""

EDGE = 3.0
"""Of the cube that is baked, the middle of which is the origin. [m]"""

CUBE_AREA = 6.0 * EDGE**2
"""[m2]"""

RADIUS = 2.0
"""Of the sphere about the origin, in which sensors and pictures are. [m]"""

PLACE = (0.5, 0.2, 0.6)
"""Of the bulb in there. [m]"""

GLASS = material("glass", Dielectric(Cauchy(1.5)))

PAINT = matt("paint", REFLECTANCE)

CUBE = box("room", (-0.5 * EDGE,) * 3, (0.5 * EDGE,) * 3, "paint", inwards=True)

EYE, VIEW = (-0.4, 0.3, -0.5), 0.02
"""Of the pictures: where they are taken from [m], and their width at unit distance."""


@case(
    "C40",
    "Lamp in a glass bulb",
    "glass",
    quick=("C40.map10", "C40.sensors10"),
)
def run_bulbs(bench: Bench) -> Findings:
    """Points, spheres and a glowing mesh; what a group holds is told by its id."""
    for key, group in bench.groups("C40").items():
        if key.startswith("C40.map"):
            yield _bake(bench, group)
        elif key.startswith("C40.sensors"):
            items = _bulb(group.labels[0], PLACE, [PAINT, _shell()])
            yield bench.measure_group(items, group)
        else:
            yield _photograph(bench, group)


def _shell():
    return sphere("room", (0.0, 0.0, 0.0), RADIUS, "paint", inwards=True)


def _bulb(label: str, place, room: list) -> list:
    """Items of a room with the lamp that a label begins with: ``point``, ``sphere 10 mm`` or ``mesh 5 mm``."""
    kind, *size = label.partition(",")[0].split()
    radius = 1e-3 * float(size[0]) if size else 0.0
    items = [*room, GLASS, sphere("bulb", place, BULB, "glass", rings=FINE, smooth=True)]
    if kind == "mesh":
        body = sphere("body", place, radius, "glow", rings=48)
        return [*items, body, glowing("glow", FLUX / (np.pi * body.areas().sum()))]
    return [*items, lumen("lamp", place, FLUX, radius=radius)]


def _bake(bench: Bench, group: Group) -> Finding:
    found = []
    for number, label in enumerate(group.labels):
        items = _bulb(label, (0.0, 0.0, 0.1), [PAINT, CUBE])
        allowed = group.allowed[number]
        found.append(
            mean_by_bake(reseeded(bench, number), items, (CUBE,), allowed, CUBE_AREA, ENOUGH)
        )
    return Finding(group, *np.array(found).T)


def _photograph(bench: Bench, group: Group) -> Finding:
    """Luminance of the wall at places that the groups' positions tell."""
    shell, found = _shell(), []
    for number, (label, place) in enumerate(zip(group.labels, group.positions, strict=True)):
        items = _bulb(label, PLACE, [PAINT, shell])
        view = look(EYE, place, VIEW)
        allowed = group.allowed[number]
        found.append(mean_of_picture(reseeded(bench, number), items, view, allowed))
    return Finding(group, *np.array(found).T)
