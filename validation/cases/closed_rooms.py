"""C42 to C44: closed rooms whose mean illuminance follows from the lamp's flux, however hard its light is to find."""

import numpy as np

from lumenray.engine.scene.light import Output, Quantity, SpotLight
from lumenray.engine.scene.material import Glossy
from lumenray.engine.scene.spectrum import Constant

from ..bench import Bench, Finding, Findings
from ..reference import Group
from ..stage import box, lumen, material, matt, quad, without
from .means import ENOUGH, mean_by_bake, reseeded
from .registry import case

FLUX = 1000.0
"""Of the lamps, in whole rooms. [lm]"""

EDGE = 3.0
"""Of the rooms. [m]"""

AREA = 6.0 * EDGE**2
"""[m2]"""

ROOM = box("room", (0.0, 0.0, 0.0), (EDGE, EDGE, EDGE), "paint", inwards=True)

SILVER = material("silver", Glossy(Constant(1.0), 0.0))

MIRROR = quad("mirror", (0.5 * EDGE, 0.0, 0.0), (0.0, 0.0, EDGE), (0.0, EDGE, 0.0), "silver")


def _half_room():
    """Half of the room, open where the mirror closes it."""
    half = box("room", (0.0, 0.0, 0.0), (0.5 * EDGE, EDGE, EDGE), "paint", inwards=True)
    is_open = (half.vertices[half.triangles][..., 0] == 0.5 * EDGE).all(axis=1)
    return without(half, is_open)


def _means(bench: Bench, group: Group, room, area: float, make) -> Finding:
    """Mean over a room's maps for every label of a group; ``make`` gives the items from a label."""
    found = []
    for number, label in enumerate(group.labels):
        items = [room, *make(label.partition(",")[0])]
        found.append(
            mean_by_bake(
                reseeded(bench, number), items, (room,), group.allowed[number], area, ENOUGH
            )
        )
    return Finding(group, *np.array(found).T)


@case("C42", "Lamp close to a wall", "stability", quick=("C42.point",))
def run_close_lamps(bench: Bench) -> Findings:
    """A point and a small sphere 0.1 mm off a wall, and a spot of a twentieth of a degree."""
    for group in bench.groups("C42").values():
        yield _means(bench, group, ROOM, AREA, _lit_closely)


def _lit_closely(label: str) -> list:
    if label == "spot":
        output, towards = (
            Output(Quantity.LUMINOUS_FLUX, FLUX),
            np.array([0.1, 0.2, -1.0]) / np.sqrt(1.05),
        )
        place = np.array([1.5, 1.5, 2.0])
        lamp = SpotLight("lamp", "lamp", output, place, towards, np.radians(0.05), 0.5)
    else:
        lamp = lumen("lamp", (1e-4, 1.4, 1.3), FLUX, radius=5e-5 if label == "sphere" else 0.0)
    return [matt("paint", 0.5), lamp]


@case("C43", "White box", "interreflection", quick=())
def run_white_boxes(bench: Bench) -> Findings:
    """A lamp in a box of reflectance 0.95 and 0.99."""
    for group in bench.groups("C43").values():
        yield _means(bench, group, ROOM, AREA, _whitened)


def _whitened(label: str) -> list:
    return [matt("paint", float(label)), lumen("lamp", (1.5, 1.4, 1.3), FLUX)]


@case("C44", "Half a room before a mirror", "specular", quick=("C44.half",))
def run_half_rooms(bench: Bench) -> Findings:
    """A mirror that loses nothing stands for the room's other half and its lamp."""
    for group in bench.groups("C44").values():
        yield _means(bench, group, _half_room(), 0.5 * AREA, _mirrored)


def _mirrored(label: str) -> list:
    """Items with a lamp of half the flux, at so many metres from the wall that faces the mirror."""
    lamp = lumen("lamp", (float(label.removesuffix(" m")), 1.4, 1.3), 0.5 * FLUX)
    return [matt("paint", 0.5), SILVER, MIRROR, lamp]
