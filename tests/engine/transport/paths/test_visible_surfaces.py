"""What a job looks at: the insides of rooms, not their outsides; also what stands behind glass."""

import numpy as np
import pytest
from baking_rooms import moved
from small_scenes import box, paint, quad, session_of

from lumenray.engine.scene.light import UniformWorld
from lumenray.engine.scene.material import Cauchy, Dielectric, Material
from lumenray.engine.scene.spectrum import Constant

pytestmark = pytest.mark.mitsuba


def find_sides(items, place, cells=2000):
    """Shares of the sides of every object's cells that are seen from a place that looks up: by name, front and back."""
    from lumenray.engine.transport.lux_maps.cells import CellSet
    from lumenray.engine.transport.paths.visible_surfaces import Sight

    session = session_of(*items)
    compiled = session._prepare("auto", False)
    compiled.settle()
    places = compiled.local(np.tile(np.asarray(place, float), (1 << 15, 1)))
    sight = Sight(compiled, places, np.tile([0.0, 0.0, 1.0], (1 << 15, 1)), 1)
    made = CellSet(compiled, cells, lambda numbers: np.full(len(numbers), 1.0 / len(numbers)))
    seen = np.zeros(2 * made.count, dtype=bool)
    seen[sight.sides(made)[0]] = True
    shapes = np.array(made._shape).reshape(made.count, -1)[:, 0]
    shares = {}
    for key, part, _ in compiled.parts():
        own = np.flatnonzero((shapes == part.number) & (made.area > 0.0))
        if len(own):
            shares[key] = (seen[2 * own].mean(), seen[2 * own + 1].mean())
    return shares, sight, made


WORLD = UniformWorld(1000.0, Constant(1.0))


def test_of_a_room_in_the_open_only_the_inside_is_seen():
    room = moved(box(3.0, 3.0, 3.0, "paint"), "room", (0, 0, 0))
    far = moved(box(3.0, 3.0, 3.0, "paint"), "neighbour", (9, 0, 0))
    shares, sight, cells = find_sides((paint(0.5), room, far, WORLD), (1.5, 1.5, 0.0))
    inside, outside = shares["room"]
    assert inside > 0.99
    assert outside == 0.0
    assert shares["neighbour"] == (0.0, 0.0)
    numbers = sorted({part.number for _, part, _ in cells.scene.parts()})
    assert sorted(sight.shares(numbers)) == [0.0, 1.0]


@pytest.mark.parametrize("is_glass", [True, False])
def test_what_stands_behind_a_pane_is_seen_if_it_lets_light_through(is_glass):
    """A slab of solid glass parts a box in two."""
    room = moved(box(2.0, 2.0, 4.0, "paint"), "room", (0, 0, 0))
    slab = moved(box(2.0, 2.0, 0.1, "slab", inwards=False), "slab", (0, 0, 1.5))
    shelf = quad("shelf", (0.5, 0.5, 3.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), "paint")
    slab_paint = (
        Material("slab", "slab", Dielectric(Cauchy(1.5, 0.0)))
        if is_glass
        else paint(0.5, name="slab")
    )
    shares, _, _ = find_sides((paint(0.5), slab_paint, room, slab, shelf, WORLD), (1.0, 1.0, 0.0))
    assert (max(shares["shelf"]) > 0.9) == is_glass


def test_finer_cells_can_be_read_from_nearer():
    room = moved(box(3.0, 3.0, 3.0, "paint"), "room", (0, 0, 0))
    shares = []
    for count in (500, 8000):
        _, sight, cells = find_sides((paint(0.5), room, WORLD), (1.5, 1.5, 0.0), count)
        shares.append(sight.near_share(2.0 * np.array(cells._near)))
    # From the middle of the floor nothing is near but in coarse cells.
    assert shares[0] >= shares[1]
    _, corner, coarse = find_sides((paint(0.5), room, WORLD), (0.05, 1.5, 0.0), 500)
    _, same, fine = find_sides((paint(0.5), room, WORLD), (0.05, 1.5, 0.0), 8000)
    nearer = [s.near_share(2.0 * np.array(c._near)) for s, c in ((corner, coarse), (same, fine))]
    assert nearer[0] > nearer[1] > 0.2
