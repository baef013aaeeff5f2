"""Light over bends traced to the camera: against lux maps, and against plain paths where these find the light."""

from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import bake
from glass_scenes import GLASS, ball, point, slab, sun
from ray_lamps import lamp_at, lumels_of
from small_scenes import paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Output, Quantity
from lumenray.engine.scene.material import Glossy, Material, Transparent
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

SIDE = 1.2
CELLS = 6
FLOOR = quad("floor", (-SIDE / 2, -SIDE / 2, 0), (SIDE, 0, 0), (0, SIDE, 0), "paint")
LENS = ball("lens", 0.15, (0, 0, 0.4), "glass", 96)
LAMP = point([0.06, 0.03, 0.7])


def camera(projection=Projection.ORTHOGRAPHIC, pixels=36, height=1.5, tilt=0.0, **more):
    """From above, turned about x. [rad]"""
    frame = np.eye(4)
    c, s = np.cos(tilt), np.sin(tilt)
    frame[:3, :3] = [[1, 0, 0], [0, c, -s], [0, s, c]]
    frame[:3, 3] = 0.0, -height * np.tan(tilt), height
    wide = SIDE if projection is Projection.ORTHOGRAPHIC else SIDE / height
    return Camera(
        frame=frame,
        projection=projection,
        width=pixels,
        height=pixels,
        **{"extent_x": wide, "extent_y": wide, **more},
    )


def under_lens(**more):
    """Camera between the lens and the floor, so that all of the caustic is seen at once."""
    return camera(Projection.PERSPECTIVE, **{"height": 0.24, "pixels": 36} | more)


def picture_of(items, view, samples, seed=0, **more):
    return session_of(*items).render(view, ViewSettings(StopRule(samples=samples), seed, **more))


def cells_of(luminance, count=CELLS):
    step = luminance.shape[0] // count
    return luminance.reshape(count, step, count, step).mean(axis=(1, 3))


INNER = 0.96
"""Side of what is compared with maps: what lies beside it leaks into no pixel."""


def lux_of(items, samples, count):
    """Illuminance of the middle of the floor by squares, of its map. (count, count) [lx]"""
    result = bake(items, ("floor",), samples, density=50.0, margin=1)
    values, places = lumels_of(result, FLOOR)
    inside = (np.abs(places[:, :2]) < 0.5 * INNER).all(axis=1)
    column, row = ((places[inside, :2] / INNER + 0.5) * count).astype(int).T
    area = values.area[inside]
    lux = np.bincount(row * count + column, area * values.illuminance[inside], count**2)
    return (lux / np.bincount(row * count + column, area, count**2)).reshape(count, count)


def shown_of(items, samples, count):
    """The same by the luminance of pictures, and one of these.

    The filter of a pixel does not keep the sum of what is finer than pixels, but over quarters of a pixel's shifts.
    """
    wide, session, shown = INNER / 0.24, session_of(*items), []
    for number in range(16):
        shift = (np.array([number % 4, number // 4]) - 1.5) * (0.25 * wide / 48)
        view = under_lens(
            extent_x=wide, extent_y=wide, shift_x=shift[0], shift_y=shift[1], pixels=48
        )
        made = session.render(view, ViewSettings(StopRule(samples=samples // 16), number))
        shown.append(cells_of(made.tristimulus[..., 1], count) * (np.pi / 0.5))
    return np.mean(shown, axis=0), made


@pytest.mark.slow
def test_pictures_sensors_and_maps_agree_about_a_caustic():
    """A point lamp through a ball of glass: the floor's luminance is its illuminance times 0.5 / pi."""
    items = (paint(0.5), GLASS, FLOOR, LENS, LAMP)
    lux = lux_of(items, 1024, 3)
    shown, _ = shown_of(items, 512, 3)
    # Lumels and pixels part the edge of the ball's shadow a little differently.
    np.testing.assert_allclose(shown, lux, rtol=0.01, atol=0.005 * lux.mean())
    # A sensor is a point and the caustic fine, so they stand closely all over the middle square.
    edge = ((np.arange(64) + 0.5) / 64 - 0.5) * INNER / 3
    x, y = (each.ravel() for each in np.meshgrid(edge, edge))
    places = np.stack([x, y, np.zeros_like(x)], axis=1)
    made = session_of(*items).measure(
        places, np.broadcast_to((0, 0, 1.0), places.shape), StopRule(samples=1 << 10)
    )
    error = np.sqrt((made.standard_error**2).sum()) / made.illuminance.sum()
    assert error < 0.1
    assert made.illuminance.mean() == pytest.approx(lux[1, 1], rel=0.01 + 3.0 * error)


VIEWS = {
    "perspective": under_lens(pixels=24, tilt=0.2, shift_x=0.3),
    "lens": under_lens(pixels=24, aperture_radius=0.02, focus_distance=0.2),
    "orthographic": camera(pixels=24, height=0.24, tilt=0.15),
    "round": camera(
        Projection.EQUIRECTANGULAR, pixels=24, height=0.24, extent_x=2.8, extent_y=np.pi
    ),
    "orthographic lens": camera(
        pixels=24, height=0.24, aperture_radius=0.05, focus_distance=0.2, aperture_blades=5
    ),
    "equidistant": camera(
        Projection.EQUIDISTANT, pixels=24, height=0.24, extent_x=2.6, extent_y=2.6, field=2.6
    ),
    "equisolid": camera(Projection.EQUISOLID, pixels=24, height=0.24, extent_x=3.0, extent_y=2.4),
    "mirror ball": camera(
        Projection.MIRROR_BALL, pixels=24, height=0.24, extent_x=1.4, extent_y=1.4, clip_end=0.6
    ),
    "cylinder": camera(
        Projection.CENTRAL_CYLINDRICAL, pixels=24, height=0.24, extent_x=2.4, extent_y=3.0
    ),
    "cube face": camera(
        Projection.CUBE_FACE, pixels=24, height=0.24, extent_x=1.6, extent_y=1.6, tilt=0.2
    ),
}
"""From below the ball, which would show its own share of chance."""


def plain_and_traced(items, view, samples, monkeypatch, **more):
    """The picture by plain paths, and with all light over bends traced."""
    from lumenray.engine.transport.light_tracing import camera_light, light_paths
    from lumenray.engine.transport.pictures import picture

    # However large the lamp is.
    monkeypatch.setattr(light_paths, "SMALL_SURFACE", 1.0)
    monkeypatch.setattr(camera_light, "CHEAPER", 1e9)
    traced = picture_of(items, view, samples, **more)
    session = session_of(*items)
    scene = session._prepare("auto", False)
    scene.settle()
    settings = ViewSettings(StopRule(samples=8 * samples), **more)
    plain, *_ = picture.render(scene, view, settings, uses_cells=False)
    return plain, vars(traced)


@pytest.mark.parametrize("name", VIEWS)
@pytest.mark.slow
def test_no_light_counts_twice_in_any_view(name, monkeypatch):
    """A lamp that paths find: through the lens, behind a sheet, on what mirrors a little too."""
    satin = Material("satin", "satin", Glossy(Constant(0.8), 0.6))
    plate = slab((-0.5, -0.5, 0.0), (-0.1, 0.1, 0.02), "satin", "plate")
    # A sheet that mirrors nothing: highlights in it would be left to chance.
    foil = Material("foil", "foil", Transparent(Constant(0.8)))
    pane = quad("pane", (-2, -2, 0.1), (4, 0, 0), (0, 4, 0), "foil")
    lamp = point([0.1, 0.05, 0.9], radius=0.2)
    items = (paint(0.5), GLASS, satin, foil, FLOOR, plate, pane, LENS, lamp)
    made = plain_and_traced(items, VIEWS[name], 256, monkeypatch)
    for count in (1, 2):
        plain, traced = (cells_of(each["tristimulus"][..., 1], count) for each in made)
        squares = sum(cells_of(each["luminance_error"].astype(float) ** 2, count) for each in made)
        error = np.sqrt(squares) / (24 / count)
        assert (np.abs(traced - plain) < 4.5 * error + 0.005 * plain).all(), (plain, traced, error)
        assert (error < 0.015 * count * plain).all(), error / plain


@pytest.mark.slow
def test_colours_and_bands_are_traced_too(monkeypatch):
    """A lamp of one colour on a floor of another, through glass."""
    red = paint(0.5, "paint")
    lamp = replace(LAMP, radius=0.02)
    items = (red, GLASS, FLOOR, LENS, lamp)
    view = under_lens(pixels=24)
    for transport in ("mono", "spectral"):
        more = {"transport": transport, "bands": 4}
        picture = picture_of(items, view, 512, **more)
        weights = picture.bands.reshape(-1, 4).sum(axis=0)
        luminance = picture.tristimulus.reshape(-1, 3).sum(axis=0)
        if transport == "mono":
            expected = weights / luminance[1], luminance / luminance[1]
    np.testing.assert_allclose(weights / luminance[1], expected[0], rtol=0.02)
    np.testing.assert_allclose(luminance / luminance[1], expected[1], rtol=0.02)


@pytest.mark.slow
def test_traced_light_is_linear_in_the_lamps():
    """Half the sum of two lamps' pictures, or what both give together."""
    other = replace(point([-0.15, -0.1, 0.8]), id="other", name="other")
    view = under_lens(pixels=24)
    alone = [
        picture_of((paint(0.5), GLASS, FLOOR, LENS, lamp), view, 512).tristimulus[..., 1]
        for lamp in (LAMP, other)
    ]
    both = picture_of((paint(0.5), GLASS, FLOOR, LENS, LAMP, other), view, 512)
    np.testing.assert_allclose(
        cells_of(both.tristimulus[..., 1]), cells_of(alone[0] + alone[1]), rtol=0.04
    )
    double = replace(LAMP, output=Output(Quantity.LUMINOUS_INTENSITY, 200.0))
    twice = picture_of((paint(0.5), GLASS, FLOOR, LENS, double), view, 512).tristimulus[..., 1]
    np.testing.assert_allclose(twice, 2.0 * alone[0], rtol=1e-4)


@pytest.mark.slow
def test_the_stated_error_of_a_caustic_is_the_true_one():
    items = (paint(0.5), GLASS, FLOOR, LENS, LAMP)
    view = under_lens(pixels=24)
    made = [picture_of(items, view, 32, seed) for seed in range(8)]
    values = np.stack([each.tristimulus[..., 1].astype(float) for each in made])
    true = np.sqrt(values.var(axis=0, ddof=1).mean())
    stated = np.sqrt(np.mean([each.luminance_error.astype(float) ** 2 for each in made]))
    assert 0.8 < stated / true < 1.25


def test_a_sun_through_a_ball_lights_what_the_camera_sees():
    """All that the ball lets through lands on the floor: its shadow holds nearly as much light as it takes."""
    items = (paint(0.5), GLASS, FLOOR, LENS, sun([0, 0, -1.0]))
    picture = picture_of(items, under_lens(), 64)
    lux = picture.tristimulus[..., 1].mean() * np.pi / 0.5
    # Fresnel's losses of a ball of index 1.5 are a tenth of what meets it.
    lost = 0.09 * np.pi * 0.15**2 / SIDE**2
    assert lux == pytest.approx(1000.0 * (1.0 - lost), rel=0.01)


@pytest.mark.slow
def test_cameras_that_light_is_not_traced_to_look_for_it_themselves():
    """A polynomial whose first power stands alone is an equidistant fisheye, but that is not known of it."""
    items = (paint(0.5), GLASS, FLOOR, LENS, replace(LAMP, radius=0.02))
    size = {"extent_x": 2.2, "extent_y": 2.2, "field": 2.2, "height": 0.24, "pixels": 16}
    shown, notes = [], []
    for projection, samples in ((Projection.EQUIDISTANT, 256), (Projection.POLYNOMIAL, 512)):
        made = picture_of(items, camera(projection, **size), samples)
        shown.append(made.tristimulus[..., 1].mean())
        notes.append(" ".join(made.provenance.notes))
    assert "is not traced" not in notes[0]
    assert "is not traced to a camera of this projection" in notes[1]
    assert shown[0] == pytest.approx(shown[1], rel=0.03)


def test_places_beside_the_picture_do_not_decide_what_is_traced():
    """Where surfaces cross the plane of the camera, light that it does not see would weigh most of all."""
    from lumenray.engine.transport.light_tracing.bent_lights import bent_lights
    from lumenray.engine.transport.light_tracing.camera_light import CameraLight
    from lumenray.engine.transport.paths.film import Film

    wide = quad("wide", (-2, -2, 0), (4, 0, 0), (0, 4, 0), "paint")
    scene = session_of(paint(0.6), GLASS, wide, LENS, LAMP)._prepare("auto", False)
    scene.settle()
    view = camera(Projection.PERSPECTIVE, pixels=24, height=0.2, tilt=1.2)
    view = replace(view, extent_x=1.2, extent_y=1.2)
    with bent_lights(scene):
        settings = ViewSettings(StopRule(samples=2))
        assert CameraLight(scene, Film(view, scene.origin), settings).is_needed


def test_pictures_without_bends_are_those_of_paths_alone():
    from lumenray.engine.transport.light_tracing.camera_light import CameraLight
    from lumenray.engine.transport.paths.film import Film
    from lumenray.engine.transport.pictures import picture

    items = (paint(0.5), FLOOR, LAMP)
    session = session_of(*items)
    scene = session._prepare("auto", False)
    scene.settle()
    view, settings = camera(pixels=16), ViewSettings(StopRule(samples=4))
    assert not CameraLight(scene, Film(view, scene.origin), settings).is_needed
    alone, *_ = picture.render(scene, view, settings, uses_cells=False)
    np.testing.assert_array_equal(
        session_of(*items).render(view, settings).tristimulus, alone["tristimulus"]
    )


@pytest.mark.slow
def test_pictures_show_a_ray_set_through_a_lens():
    """Its own rays, as the map has them; sensors and reflections know a point with its intensities."""
    lamp = lamp_at(np.array([0.06, 0.03, 0.72]))
    items = (paint(0.5), GLASS, FLOOR, LENS, lamp)
    lux = lux_of(items, 1024, 3)
    shown, made = shown_of(items, 256, 3)
    np.testing.assert_allclose(shown, lux, rtol=0.02, atol=0.005 * lux.mean())
    assert any("ray set 'led'" in note for note in made.provenance.notes)
