"""Rays that end at cells: what they bring where they meet panes first."""

import numpy as np
import pytest
from small_scenes import paint, quad, session_of

from lumenray.engine.scene.material import Black, Emission, Material, ThinGlass, Transparent
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.transport import backend

pytestmark = pytest.mark.mitsuba

RAYS = 4096
BEYOND, BEHIND = 1000.0, 400.0
"""Luminance of what a ray sees through a pane, and in it. [cd/m2]"""


@pytest.fixture(autouse=True)
def kernels():
    backend.start(spectral=False)


def glowing(name, height, luminance, faces_up):
    """Square of 2 m that shines up or down."""
    x, y = (2.0, 0.0, 0.0), (0.0, 2.0, 0.0)
    edges = (x, y) if faces_up else (y, x)
    glow = Emission(luminance=luminance, two_sided=False)
    return quad(name, (-1.0, -1.0, height), *edges, f"{name} glow"), Material(
        f"{name} glow", f"{name} glow", Black(), glow
    )


def look_up(pane, is_exact):
    """Luminance along rays that look up at a pane, ray by ray. (RAYS,) [cd/m2]"""
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.transport.lux_maps.cached_gather import incoming
    from lumenray.engine.transport.lux_maps.cells import CellSet

    session = session_of(
        *glowing("ceiling", 3.0, BEYOND, False),
        *glowing("floor", -1.0, BEHIND, True),
        quad("pane", (-1.0, -1.0, 1.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0), "pane"),
        Material("pane", "pane", pane),
        quad("wall", (5.0, -1.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 2.0), "paint"),
        paint(0.5),
    )
    scene = session._prepare("mono", False)
    scene.settle()
    cells = CellSet(scene, 64, lambda numbers: np.ones(len(numbers)) / len(numbers))
    places = np.random.default_rng(1).uniform(-0.5, 0.5, (2, RAYS)).astype(np.float32)
    local = scene.local(np.column_stack([*places, np.zeros(RAYS)]))
    start = mi.Point3f(*(mi.Float(np.ascontiguousarray(column)) for column in local.T))
    rest, read = incoming(
        scene,
        cells,
        mi.Ray3f(start, mi.Vector3f(0.0, 0.0, 1.0)),
        None,
        mi.PCG32(size=RAYS),
        mi.Float(0.0),
        start,
        dr.full(mi.Bool, True, RAYS),
        mi.Float(1.0),
        is_exact=is_exact,
    )
    return np.array((rest + read)[0])


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("is_exact", [False, True], ids=["cells", "paths"])
@pytest.mark.parametrize("internal", [1.0, 0.5])
def test_a_pane_is_seen_through_and_in_at_once(internal, is_exact):
    # Straight on, one face of glass of index 1.5 reflects 4 %; the rest follows from the inner reflections.
    face = 0.04
    once = (1.0 - face) ** 2 / (1.0 - (face * internal) ** 2)
    through, mirrored = internal * once, face * (1.0 + internal**2 * once)
    found = look_up(ThinGlass(1.5, Constant(internal)), is_exact)
    np.testing.assert_allclose(found, through * BEYOND + mirrored * BEHIND, rtol=1e-5)


def test_what_is_only_passed_counts_once():
    found = look_up(Transparent(Constant(0.7)), False)
    np.testing.assert_allclose(found, 0.7 * BEYOND, rtol=1e-5)
