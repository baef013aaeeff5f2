"""Mirrors: image sources, clipping, repeated reflection, and the reflectance of a dielectric's boundary."""

import numpy as np

from lumenray.engine.scene.material import Cauchy, Dielectric, Glossy
from lumenray.engine.scene.spectrum import Constant

from ..bench import Bench, Finding, Findings
from ..reference import Group
from ..stage import candela, glowing, material, quad
from .glass import angles_of, probe
from .registry import case

FAR = 50.0
"""Half side of mirrors that stand for endless ones. [m]"""

WHOLE = 2.0 * FAR


def mirror(key: str, reflectance: float):
    """Ideal mirror of a constant reflectance."""
    return material(key, Glossy(Constant(reflectance), 0.0))


def _wall(key: str, x: float, faces_back: bool = False):
    """Large mirror in a plane of constant x, that faces +x or -x."""
    y, z = (0.0, WHOLE, 0.0), (0.0, 0.0, WHOLE)
    return quad(key, (x, -FAR, -FAR), *((z, y) if faces_back else (y, z)), "mirror")


@case(
    "C18",
    "Specular reflection",
    "specular",
    quick=("C18.mirror_pt", "C18.mirror_total", "C18.fresnel"),
)
def run_mirrors(bench: Bench) -> Findings:
    """One mirror, two at right angles, two that face each other, and a boundary of glass."""
    groups = bench.groups("C18")
    if group := groups.get("C18.mirror_pt"):
        floor = quad("floor", (-FAR, -FAR, 0.0), (WHOLE, 0.0, 0.0), (0.0, WHOLE, 0.0), "mirror")
        items = [mirror("mirror", 0.8), floor, candela("lamp", (0.0, 0.0, 2.0), 1000.0)]
        yield bench.measure_group(items, group)
    yield from _measure_area(bench, groups)
    if group := groups.get("C18.corner"):
        yield _measure_corner(bench, group)
    if group := groups.get("C18.parallel"):
        yield _measure_parallel(bench, group)
    if group := groups.get("C18.fresnel"):
        glass = Dielectric(Cauchy(1.5))
        yield Finding(group, *probe(bench, glass, angles_of(group), group.allowed, "reflectance"))


def _measure_area(bench: Bench, groups: dict[str, Group]) -> Findings:
    """A luminous square before a small mirror: everything, and less what comes straight."""
    emitter = [
        glowing("shine", 1000.0),
        quad("emitter", (1.0, -0.5, 3.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), "shine"),
    ]
    both = [
        *emitter,
        mirror("mirror", 0.9),
        quad("wall", (0.0, -3.0, 0.0), (0.0, 6.0, 0.0), (0.0, 0.0, 2.0), "mirror"),
    ]
    if group := groups.get("C18.mirror_total"):
        yield bench.measure_group(both, group)
    if group := groups.get("C18.mirror_area"):
        # Half the variance each.
        half = group.allowed / np.sqrt(2.0)
        whole = bench.measure(both, group.positions, group.normals, half)
        straight = bench.measure(emitter, group.positions, group.normals, half)
        bench.show(group, both)
        yield Finding(
            group, whole.values - straight.values, np.hypot(whole.errors, straight.errors)
        )


def _measure_corner(bench: Bench, group: Group) -> Finding:
    """Two mirrors at right angles: each image is what its mirrors add."""
    lamp, paint = candela("lamp", (1.0, 1.5, 1.0), 1000.0), mirror("mirror", 0.9)
    first = _wall("wall x", 0.0)
    second = quad("wall y", (-FAR, 0.0, -FAR), (0.0, 0.0, WHOLE), (WHOLE, 0.0, 0.0), "mirror")
    # The double image is a sum of four readings, of which only the last is hard to get.
    allowed = group.allowed[3] * np.array([0.25, 0.25, 0.25, 0.9])
    values, variances = np.zeros((2, 4))
    for place, walls in enumerate(([], [first], [second], [first, second])):
        items = [lamp, paint, *walls]
        made = bench.measure(items, group.positions[0], group.normals[0], allowed[place])
        values[place], variances[place] = made.values[0], made.errors[0] ** 2
    bench.show(group, items)
    shares = np.array(
        [[1, 0, 0, 0], [-1, 1, 0, 0], [-1, 0, 1, 0], [1, -1, -1, 1], [0, 0, 0, 1]], dtype=float
    )
    return Finding(group, shares @ values, np.sqrt(shares**2 @ variances))


def _measure_parallel(bench: Bench, group: Group) -> Finding:
    """Two mirrors that face each other, with all images and with those of few reflections."""
    lamp = candela("lamp", (0.5, 0.0, 1.0), 1000.0)
    items = [lamp, mirror("mirror", 0.8), _wall("left", 0.0), _wall("right", 2.0, faces_back=True)]
    bench.show(group, items)
    values, errors = np.zeros((2, len(group.values)))
    for place, label in enumerate(group.labels):
        few = None if label == "all orders" else int(label.split()[2])
        made = bench.measure(
            items,
            group.positions[place],
            group.normals[place],
            group.allowed[place],
            reflections=few,
        )
        values[place], errors[place] = made.values[0], made.errors[0]
    return Finding(group, values, errors)
