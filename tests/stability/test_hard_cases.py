"""Numbers that break careless arithmetic: far coordinates, tiny and huge scales, odd scenes."""

import math

import numpy as np
import pytest
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.requirements.plan import make_plan
from lumenray.engine.scene.light import Output, PointLight, Quantity, SunLight, UniformWorld
from lumenray.engine.scene.material import (
    Black,
    Cauchy,
    Dielectric,
    Emission,
    Glossy,
    IorTable,
    Material,
    ThinGlass,
)
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.scene import Scene, SceneDelta
from lumenray.engine.scene.spectrum import Constant, Illuminant, Rgb

INTENSITY = Quantity.LUMINOUS_INTENSITY


def moved(mesh, offset, scale=1.0):
    from dataclasses import replace

    return replace(mesh, vertices=mesh.vertices * scale + offset)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("scale", [0.05, 1.0, 1e4])
@pytest.mark.parametrize("offset", [(0, 0, 0), (1e5, -2e5, 3e4)])
def test_a_room_gives_the_same_lux_far_from_the_origin_and_at_any_scale(offset, scale):
    offset = np.array(offset, float)
    lamp = PointLight(
        "l", "l", Output(INTENSITY, 100.0 * scale**2), np.array([1, 1, 1.5]) * scale + offset
    )
    session = session_of(moved(box(2, 2, 2), offset, scale), paint(0.5), lamp)
    made = session.measure(
        [np.array([0.7, 1.2, 0.8]) * scale + offset], [[0, 0, 1]], StopRule(samples=1 << 16)
    )
    # The same room at the origin in metres, to the same seed.
    plain = session_of(
        box(2, 2, 2),
        paint(0.5),
        PointLight("l", "l", Output(INTENSITY, 100.0), np.array([1, 1, 1.5])),
    )
    expected = plain.measure([[0.7, 1.2, 0.8]], [[0, 0, 1]], StopRule(samples=1 << 16), seed=1)
    error = np.hypot(made.standard_error[0], expected.standard_error[0])
    assert (
        abs(made.illuminance[0] - expected.illuminance[0])
        < 3.5 * error + 5e-3 * expected.illuminance[0]
    )


@pytest.mark.parametrize("distance", [0.01, 0.1, 1.0, 100.0, 10000.0])
def test_the_inverse_square_law_holds_over_six_decades(distance):
    lamp = PointLight("l", "l", Output(INTENSITY, 1.0), np.array([0.0, 0.0, distance]))
    made = session_of(lamp).measure([[0, 0, 0]], [[0, 0, 1]], StopRule(samples=32))
    assert made.illuminance[0] == pytest.approx(1.0 / distance**2, rel=1e-4)


def test_order_and_ids_of_items_do_not_matter():
    items = [box(2, 2, 2), paint(0.5), PointLight("a", "a", Output(INTENSITY, 10.0), np.ones(3))]
    first, second = Scene(), Scene()
    first.apply(SceneDelta(changed=tuple(items)))
    second.apply(SceneDelta(changed=tuple(reversed(items))))
    assert first.hash() == second.hash()
    second.apply(SceneDelta(removed=("a",)))
    assert first.hash() != second.hash()


def test_perfect_mirrors_facing_each_other_come_to_an_end():
    mirror = Material("paint", "paint", Glossy(Constant(1.0), 0.0))
    lamp = PointLight("l", "l", Output(INTENSITY, 1.0), np.ones(3), 0.1)
    made = session_of(box(2, 2, 2), mirror, lamp).measure(
        [[0.5, 0.5, 0.5]], [[0, 0, 1]], StopRule(samples=64)
    )
    assert np.isfinite(made.illuminance).all()


def test_a_scene_with_nothing_in_it_is_dark_and_harmless():
    assert session_of().measure([[0, 0, 0]], [[0, 0, 1]], StopRule(samples=4)).illuminance[0] == 0.0


def test_degenerate_triangles_do_no_harm():
    sliver = Mesh(
        "s",
        "s",
        np.zeros((3, 3)),
        np.array([[0, 1, 2]], np.int32),
        ("glow",),
        np.zeros(1, np.int32),
    )
    glow = Material("glow", "glow", Black(), Emission(Constant(1.0), 100.0))
    made = session_of(sliver, glow, UniformWorld(1.0)).measure(
        [[0, 0, 1]], [[0, 0, 1]], StopRule(samples=256)
    )
    assert made.illuminance[0] == pytest.approx(np.pi, rel=0.05)


def test_broken_meshes_are_refused_in_words():
    room = box(1, 1, 1)
    room.vertices[0, 0] = np.nan
    with pytest.raises(SceneError, match="not a finite number"):
        session_of(room, paint(0.5)).measure([[0, 0, 0]], [[0, 0, 1]], StopRule(samples=4))
    stray = box(1, 1, 1)
    stray.triangles[0, 0] = 99
    with pytest.raises(SceneError, match="outside its list"):
        session_of(stray, paint(0.5)).measure([[0, 0, 0]], [[0, 0, 1]], StopRule(samples=4))
    with pytest.raises(SceneError, match="does not hold"):
        session_of(box(1, 1, 1, "nowhere")).measure([[0, 0, 0]], [[0, 0, 1]], StopRule(samples=4))
    with pytest.raises(SceneError, match="sensor 2"):
        session_of().measure([[0, 0, 0], [0, 0, 0]], [[0, 0, 1], [0, 0, 0]], StopRule(samples=4))


def window_room(pane):
    """Room with a window in one wall, the sky outside, with or without a pane."""
    room = box(3, 3, 3)
    # The wall at y = 3 becomes a frame around an opening of 1 x 1 m.
    wall = [t for t in room.triangles if not (room.vertices[t, 1] > 2.9).all()]
    from dataclasses import replace

    room = replace(
        room, triangles=np.array(wall, np.int32), material_index=np.zeros(len(wall), np.int32)
    )
    parts = [
        quad("below", (0, 3, 0), (0, 0, 1), (3, 0, 0), "paint"),
        quad("above", (0, 3, 2), (0, 0, 1), (3, 0, 0), "paint"),
        quad("left", (0, 3, 1), (0, 0, 1), (1, 0, 0), "paint"),
        quad("right", (2, 3, 1), (0, 0, 1), (1, 0, 0), "paint"),
    ]
    items = [room, *parts, paint(0.5), UniformWorld(1000.0, Illuminant("D65"))]
    if pane:
        items += [quad("pane", (1, 3, 1), (0, 0, 1), (1, 0, 0), "pane"), pane]
    return items


def test_aiming_at_panes_does_not_change_the_mean():
    places, up = [[1.5, 1.5, 0.8], [0.5, 2.5, 1.0]], [[0, 0, 1], [0, 0.6, 0.8]]
    clear = Material("pane", "pane", ThinGlass(1.0, Constant(1.0)))
    rule = StopRule(samples=1 << 16)
    aimed = session_of(*window_room(clear)).measure(places, up, rule)
    plain = session_of(*window_room(None)).measure(places, up, rule, seed=2)
    error = np.hypot(aimed.standard_error, plain.standard_error)
    assert (np.abs(aimed.illuminance - plain.illuminance) < 3.5 * error).all()
    # And it pays: the same number of samples, a smaller error.
    assert aimed.standard_error.mean() < 0.6 * plain.standard_error.mean()


@pytest.mark.parametrize("angle", [math.radians(0.53), math.radians(5.0)])
def test_a_sun_through_a_pane_keeps_its_transmittance(angle):
    sun = SunLight("s", "s", Output(Quantity.ILLUMINANCE, 10000.0), np.array([0, 0, -1.0]), angle)
    pane = quad("pane", (-50, -50, 1), (100, 0, 0), (0, 100, 0), "pane")
    glass = Material("pane", "pane", ThinGlass(1.5, Constant(0.9)))
    made = session_of(sun, pane, glass).measure([[0, 0, 0]], [[0, 0, 1]], StopRule(samples=1 << 13))
    single = 0.04
    expected = (1 - single) ** 2 * 0.9 / (1 - (single * 0.9) ** 2) * 10000.0
    assert abs(made.illuminance[0] - expected) < 3 * made.standard_error[0] + 0.003 * expected


def test_dispersion_moves_light_but_does_not_change_its_amount():
    # A closed black-walled lamp in a big glass slab's place: a dispersive pane between sky and sensor.
    slab = [
        quad("front", (-40, -40, 1.0), (0, 80, 0), (80, 0, 0), "glass"),
        quad("back", (-40, -40, 1.5), (80, 0, 0), (0, 80, 0), "glass"),
    ]
    sky = UniformWorld(100.0, Illuminant("D65"))
    rule = StopRule(samples=1 << 15)
    answers = []
    for ior in (
        Cauchy(1.5, 0.0),
        Cauchy(1.488, 0.0042),
        IorTable(np.array([400.0, 700.0]), np.array([1.514, 1.496])),
    ):
        glass = Material("glass", "glass", Dielectric(ior))
        made = session_of(*slab, glass, sky).measure(
            [[0, 0, 0]], [[0, 0, 1]], rule, transport="spectral"
        )
        answers.append((made.illuminance[0], made.standard_error[0]))
    for value, error in answers[1:]:
        assert (
            abs(value - answers[0][0]) < 3.5 * np.hypot(error, answers[0][1]) + 0.01 * answers[0][0]
        )


def test_the_kind_of_transport_follows_from_the_scene():
    neutral, coloured = Scene(), Scene()
    neutral.apply(
        SceneDelta(
            changed=(
                box(1, 1, 1),
                paint(0.5),
                PointLight("l", "l", Output(INTENSITY, 1.0), np.ones(3)),
            )
        )
    )
    assert not make_plan(neutral).spectral
    assert make_plan(neutral, transport="spectral").spectral
    red = Material("paint", "paint", Glossy(Rgb(0.8, 0.1, 0.1), 0.3))
    coloured.apply(SceneDelta(changed=(box(1, 1, 1), red)))
    made = make_plan(coloured)
    assert made.spectral
    assert "paint" in made.reasons[0]
    with pytest.raises(SceneError, match="auto, mono or spectral"):
        make_plan(neutral, transport="rgb")


def test_light_that_no_path_can_find_is_named():
    glass = Material("glass", "Vase", Dielectric(Cauchy(1.5, 0.0)))
    slab = quad("front", (-1, -1, 1.0), (0, 2, 0), (2, 0, 0), "glass")
    ideal = PointLight("l", "Bulb", Output(INTENSITY, 1.0), np.array([0, 0, 2.0]))
    real = PointLight("l", "Bulb", Output(INTENSITY, 1.0), np.array([0, 0, 2.0]), 0.1)
    rule = StopRule(samples=16)
    told = session_of(slab, glass, ideal).measure([[0, 0, 0]], [[0, 0, 1]], rule).provenance.notes
    assert "Bulb" in told[0]
    assert "Vase" in told[0]
    assert (
        not session_of(slab, glass, real).measure([[0, 0, 0]], [[0, 0, 1]], rule).provenance.notes
    )
