"""Things far out of reach and mixtures without end are refused by their names, before they reach native code."""

import numpy as np
import pytest
from small_scenes import paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import (
    AreaLight,
    Output,
    PointLight,
    Quantity,
    SpotLight,
    UniformWorld,
)
from lumenray.engine.scene.material import Diffuse, Emission, Glossy, Material, Mix
from lumenray.engine.scene.mesh import Geometry, Placement
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

FLOOR = quad("floor", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "paint")
WORLD = UniformWorld(100.0, Constant(1.0))
LUMENS = Output(Quantity.LUMINOUS_FLUX, 100.0)
FAR = np.array([1e30, 0.0, 0.0])


def at(place):
    frame = np.eye(4)
    frame[:3, 3] = place
    return frame


def measured(*items):
    return session_of(FLOOR, paint(0.5), WORLD, *items).measure(
        [(0, 0, 0)], [(0, 0, 1)], StopRule(samples=64)
    )


@pytest.mark.parametrize(
    "item",
    [
        quad("odd", (1e30, 0, 0), (1, 0, 0), (0, 1, 0), "paint"),
        PointLight("p", "odd", LUMENS, FAR),
        PointLight("p", "odd", LUMENS, np.zeros(3), 1e30),
        SpotLight("s", "odd", LUMENS, FAR, np.array([0.0, 0.0, -1.0]), 0.5),
        AreaLight("a", "odd", LUMENS, at(FAR), 1.0, 1.0),
        AreaLight("a", "odd", LUMENS, at((0, 0, 3)), 1e30, 1.0),
    ],
)
def test_what_lies_out_of_reach_is_refused_by_its_name(item):
    with pytest.raises(
        SceneError, match=r"'odd' reaches 1e\+30 m|'odd' reaches 5e\+29 m|'odd' .*1e\+30"
    ):
        measured(item)


def test_a_placement_out_of_reach_is_refused_by_its_name():
    shape = Geometry("g", FLOOR.vertices, FLOOR.triangles, np.zeros(2, np.int32))
    odd = Placement("o", "odd", "g", at(FAR), ("paint",))
    with pytest.raises(SceneError, match="object 'odd' reaches"):
        measured(shape, odd)
    session = session_of(FLOOR, paint(0.5), WORLD, shape, Placement("o", "odd", "g", at((5, 0, 0)), ("paint",)))  # fmt: skip
    camera = Camera(at((0, 0, 3e20)), Projection.PERSPECTIVE, 4, 4)
    with pytest.raises(SceneError, match="camera reaches"):
        session.render(camera, ViewSettings(StopRule(samples=4)))


@pytest.mark.parametrize(
    "item",
    [
        PointLight("p", "odd", Output(Quantity.LUMINOUS_FLUX, 1e30), np.zeros(3)),
        Material("m", "odd", emission=Emission(luminance=1e30)),
        UniformWorld(1e30),
    ],
)
def test_light_that_no_number_holds_is_refused_by_its_name(item):
    with pytest.raises(SceneError, match=r"('odd'|the world): its amount of light is 1e\+30"):
        measured(item)


def test_mixtures_without_end_are_refused_by_their_name():
    surface = Diffuse(Constant(0.5))
    for _ in range(60):
        surface = Mix(surface, Glossy(Constant(0.5), 0.3))
    with pytest.raises(SceneError, match="'odd': 60 mixtures lie in each other"):
        measured(Material("odd", "odd", surface))


def test_a_scene_so_wide_that_its_places_are_coarse_says_so():
    wide = quad("wide", (-4e5, -4e5, -5), (8e5, 0, 0), (0, 8e5, 0), "paint")
    (note,) = (note for note in measured(wide).provenance.notes if "km wide" in note)
    assert "mm" in note
    assert not any("km wide" in note for note in measured().provenance.notes)
