"""When paths of sensors end: by what surfaces reflect, early where a user wants it, exact either way."""

import numpy as np
import pytest
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.requirements.plan import make_plan
from lumenray.engine.requirements.roulette import USUAL, mean_reflectance
from lumenray.engine.scene.light import AreaLight, Output, Quantity
from lumenray.engine.scene.material import Diffuse, Glossy, Material
from lumenray.engine.scene.mesh import Geometry, Placement
from lumenray.engine.scene.modelling import Modelling, Switch
from lumenray.engine.scene.scene import Scene, SceneDelta
from lumenray.engine.scene.spectrum import Constant, Rgb
from lumenray.engine.scene.texture import ImageTexture

EARLY = Modelling((("roulette", Switch.OFF),))


def scene_of(*items):
    scene = Scene()
    scene.apply(SceneDelta(changed=items))
    return scene


def decision_of(plan):
    return next(each for each in plan.decisions if each.name == "roulette")


def sheet(name, area, material):
    """Level square at a height of its own."""
    side = np.sqrt(area)
    return quad(name, (0, 0, 0), (side, 0, 0), (0, side, 0), material)


def test_reflectances_count_by_area():
    items = (
        paint(0.2, "dark"),
        paint(0.8, "white"),
        sheet("a", 30.0, "dark"),
        sheet("b", 10.0, "white"),
    )
    assert mean_reflectance(scene_of(*items)) == pytest.approx((30 * 0.2 + 10 * 0.8) / 40)
    assert mean_reflectance(scene_of()) == 0.0


def test_objects_that_share_a_shape_count_by_their_size():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    shape = Geometry("g", square, np.array([[0, 1, 2], [0, 2, 3]], np.int32), np.zeros(2, np.int32))
    large = np.diag([3.0, 3.0, 3.0, 1.0])
    objects = (
        Placement("a", "a", "g", np.eye(4), ("dark",)),
        Placement("b", "b", "g", large, ("white",)),
    )
    scene = scene_of(paint(0.2, "dark"), paint(0.8, "white"), shape, *objects)
    assert mean_reflectance(scene) == pytest.approx((0.2 + 9 * 0.8) / 10)


def test_pictures_count_by_their_mean_colours_by_the_eye_and_others_as_usual():
    pixels = np.zeros((2, 2, 1), np.float32)
    pixels[0] = 0.6
    for surface, expected in (
        (Diffuse(ImageTexture(pixels)), 0.3),
        (Diffuse(Rgb(0.5, 0.5, 0.5)), 0.5),
        (Glossy(Constant(0.9), 0.3), 0.9),
    ):
        scene = scene_of(Material("m", "m", surface), sheet("a", 1.0, "m"))
        assert mean_reflectance(scene) == pytest.approx(expected, abs=0.02)
    assert mean_reflectance(scene_of(paint(0.5, "other"), sheet("a", 1.0, "nobody"))) == USUAL


def test_a_switch_lets_it_begin_at_once():
    plan = make_plan(scene_of(box(2, 2, 2), paint(0.5)))
    assert plan.reflectance == pytest.approx(0.5)
    assert (decision_of(plan).choice, decision_of(plan).bound) == ("once a path counts little", 0.0)
    plan = make_plan(scene_of(box(2, 2, 2), paint(0.5), EARLY))
    assert (plan.reflectance, decision_of(plan).choice) == (0.0, "from the third vertex on")
    # Nor is there anything to wait for where nothing is reflected.
    assert decision_of(make_plan(scene_of(box(2, 2, 2), paint(0.0)))).saving == 0.0


@pytest.mark.mitsuba
def test_a_white_room_that_looks_dark_by_area_is_measured_as_ever():
    """By the black ground around it surfaces reflect next to nothing, so roulette begins at once: dearer, no less right."""
    frame = np.eye(4)
    frame[:3, 3] = 1.0, 1.0, 1.99
    lamp = AreaLight("a", "a", Output(Quantity.LUMINOUS_FLUX, 1000.0), frame, 0.5, 0.5)
    ground = quad("ground", (-500, -500, -1), (1000, 0, 0), (0, 1000, 0), "black")
    items = (
        box(2, 2, 2),
        paint(0.8),
        Material("black", "black", Diffuse(Constant(0.0))),
        ground,
        lamp,
    )
    made = []
    for more in ((), (EARLY,)):
        session = session_of(*items, *more)
        made.append(session.measure([[0.6, 0.7, 0.5]], [[0, 0, 1]], StopRule(error=0.005), 1))
    apart = made[0].illuminance[0] - made[1].illuminance[0]
    errors = np.hypot(*(each.standard_error[0] for each in made))
    assert abs(apart) < 4.0 * errors
