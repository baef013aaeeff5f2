"""Luminaires against the inverse-square law, form factors, quadrature over the opening, and what must be conserved."""

from dataclasses import replace

import numpy as np
import pytest
from luminaires import (
    DISTRIBUTIONS,
    OPENINGS,
    POINT,
    flux,
    frame_of,
    illuminance,
    intensity,
    luminaire,
    shown_area,
    turn,
)
from small_scenes import quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.distribution import Opening
from lumenray.engine.scene.light import AreaLight, Output, Quantity
from lumenray.engine.scene.material import Conductor, Material
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Blackbody, Rgb
from lumenray.engine.views import ViewSettings

pytestmark = [pytest.mark.mitsuba, pytest.mark.validation]

LUMENS = 1000.0
CENTRE = np.array([0.3, -0.2, 3.0])
SHAPES = {"point": POINT, **OPENINGS}


def sphere_points(count):
    """Directions spread evenly over the sphere, by the golden angle. (n, 3)"""
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    angle = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count) + 0.3
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(angle), flat * np.sin(angle), z], axis=1)


def around(distribution, seed, count=64):
    """Directions of the luminaire's axes: half of them all over its grid's angles, the rest all around. (n, 3)"""
    rng = np.random.default_rng(seed)
    half = count // 2
    azimuth = rng.uniform(0.0, 2.0 * np.pi, half)
    polar = rng.uniform(distribution.polar[0], distribution.polar[-1], half)
    flat = np.sin(polar)
    made = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), -np.cos(polar)], axis=1)
    return np.concatenate([made @ distribution.frame.T, sphere_points(count - half)])


def normals_near(direction, seed):
    """Unit normals within about 60 degrees of the way back along directions (n, 3)."""
    made = -direction + 0.6 * np.random.default_rng(seed).normal(size=direction.shape)
    return made / np.linalg.norm(made, axis=1, keepdims=True)


# ---- points: the inverse-square law ----


def test_points_give_their_intensity_by_the_inverse_square_law():
    session = session_of(luminaire("even", key="l"))
    for seed, (name, distribution) in enumerate(DISTRIBUTIONS.items()):
        rotation = turn(seed)
        light = luminaire(distribution, POINT, CENTRE, rotation, LUMENS, "l")
        session.apply(SceneDelta(changed=(light,)))
        local = around(distribution, seed)
        distance = 10.0 ** np.random.default_rng(seed).uniform(-1.0, 1.5, len(local))
        towards = local @ rotation.T
        normals = normals_near(towards, seed)
        places = CENTRE + distance[:, None] * towards
        made = session.measure(places, normals, StopRule(samples=16))
        cosine = np.maximum(-(towards * normals).sum(axis=1), 0.0)
        scale = LUMENS / flux(distribution) * cosine / distance**2
        expected = intensity(distribution, local) * scale
        # Within the single precision of an angle, the steepest flank of a distribution may be climbed.
        slack = 3e-5 * distribution.intensity.max() * scale
        assert (np.abs(made.illuminance - expected) <= 1e-4 * expected + slack).all(), name
        assert (expected > 0.0).mean() > 0.2, name


def test_a_quarter_turn_about_the_beam_swaps_the_planes():
    # Of the batwing, C0 and C90 differ; the frames of types A and B have their beams along -z as well.
    places, up = [[0.7, 0.0, -1.0], [0.0, 0.7, -1.0]], [[0, 0, 1.0]] * 2
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    rule = StopRule(samples=16)
    for name in ("batwing", "type A", "type B"):
        straight = session_of(luminaire(name)).measure(places, up, rule).illuminance
        turned = session_of(luminaire(name, rotation=quarter)).measure(places, up, rule).illuminance
        assert turned[1] == pytest.approx(straight[0], rel=1e-3)
        assert abs(straight[0] - straight[1]) > 0.01 * straight[0]


# ---- openings: quadrature, closed forms, the far field ----


def places_near(opening, seed, count=8):
    """Places and normals around an opening, from right beside it to ten of its sizes away, in its axes."""
    rng = np.random.default_rng(seed)
    size = np.linalg.norm(opening.size)
    direction = rng.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    distance = size * np.concatenate(
        [rng.uniform(0.52, 0.8, count // 2), rng.uniform(0.8, 10.0, count - count // 2)]
    )
    return distance[:, None] * direction, normals_near(direction, seed)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("name", OPENINGS)
@pytest.mark.parametrize("shape", ["asymmetric", "spot"])
def test_openings_light_their_surroundings_as_quadrature_says(name, shape):
    opening, rotation = OPENINGS[name], turn(3)
    light = luminaire(shape, opening, CENTRE, rotation, LUMENS)
    places, normals = places_near(opening, 1)
    if shape == "spot":
        # In the beam.
        places[:, :2] *= 0.3
        places[:, 2] = -np.abs(places[:, 2]) - 0.4
        normals = normals_near(places / np.linalg.norm(places, axis=1, keepdims=True), 2)
    places, normals = places @ rotation.T + CENTRE, normals @ rotation.T
    made = session_of(light).measure(places, normals, StopRule(samples=1 << 13), seed=1)
    expected = illuminance(light, places, normals, 256, is_scattered=True)
    slack = 1e-3 * expected + 1e-5 * expected.max()
    assert (np.abs(made.illuminance - expected) < 4.0 * made.standard_error + slack).all()
    assert np.median(made.standard_error / np.maximum(expected, 1e-3 * expected.max())) < 0.02


def corner_factors(a, b, height):
    """Form factors from an element below the corner of a rectangle a x b to it, facing it and upright (facing along a).

    References
    ----------
    J. R. Howell: A Catalog of Radiation Heat Transfer Configuration Factors, B-3 and B-4 (after Hamilton and Morgan, 1952).
    """
    c = height
    to_a, to_b = np.hypot(a, c), np.hypot(b, c)
    facing = a / to_a * np.arctan(b / to_a) + b / to_b * np.arctan(a / to_b)
    upright = np.arctan(b / c) - c / to_a * np.arctan(b / to_a)
    return facing / (2.0 * np.pi), upright / (2.0 * np.pi)


@pytest.mark.parametrize("height", [0.1, 0.7, 4.0])
def test_a_lambertian_rectangle_has_the_form_factors_of_one(height):
    a, b = 0.6, 0.4
    light = luminaire("lambertian", Opening("rectangle", (a, b, 0.0)), CENTRE, lumens=LUMENS)
    luminance = LUMENS / (np.pi * a * b)
    # Below a corner.
    corner = CENTRE - [0.5 * a, 0.5 * b, height]
    normals = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    corners = np.tile(corner, (3, 1))
    made = session_of(light).measure(corners, normals, StopRule(samples=1 << 15), seed=2)
    facing, along_a = corner_factors(a, b, height)
    _, along_b = corner_factors(b, a, height)
    expected = np.pi * luminance * np.array([facing, along_a, along_b])
    assert (np.abs(made.illuminance - expected) < 4.0 * made.standard_error + 1e-3 * expected).all()
    assert (made.standard_error < 0.01 * expected).all()


@pytest.mark.parametrize("height", [0.1, 0.7, 4.0])
def test_a_lambertian_disk_has_the_form_factor_of_one(height):
    radius = 0.25
    opening = Opening("ellipse", (2.0 * radius, 2.0 * radius, 0.0))
    light = luminaire("lambertian", opening, CENTRE, lumens=LUMENS)
    luminance = LUMENS / (np.pi * np.pi * radius**2)
    aside = np.array([0.0, 0.15, 0.25, 0.6])
    places = CENTRE + np.stack([aside, np.zeros(4), np.full(4, -height)], axis=1)
    made = session_of(light).measure(
        places, np.tile([0.0, 0.0, 1.0], (4, 1)), StopRule(samples=1 << 15), seed=2
    )
    # Howell's catalog, B-13.
    squared = height**2 + aside**2
    root = np.sqrt((squared + radius**2) ** 2 - 4.0 * radius**2 * aside**2)
    expected = np.pi * luminance * 0.5 * (1.0 - (squared - radius**2) / root)
    assert (np.abs(made.illuminance - expected) < 4.0 * made.standard_error + 1e-3 * expected).all()
    assert (made.standard_error < 0.01 * expected).all()


def test_an_even_sphere_is_a_point_to_a_sensor_that_sees_all_of_it():
    radius = 0.2
    light = luminaire("even", OPENINGS["sphere"], CENTRE, lumens=LUMENS)
    luminance = LUMENS / (4.0 * np.pi**2 * radius**2)
    distance = np.array([0.21, 0.25, 0.4, 1.0, 10.0, 1000.0])
    towards = sphere_points(len(distance))
    places = CENTRE + distance[:, None] * towards
    made = session_of(light).measure(places, -towards, StopRule(samples=1 << 16))
    expected = np.pi * luminance * (radius / distance) ** 2
    # Scattered rays begin a tenth of a millimetre above a sensor.
    slack = (1e-3 + 2.4e-4 / distance) * expected
    assert (np.abs(made.illuminance - expected) < 4.0 * made.standard_error + slack).all()
    # And nobody sees it from behind.
    assert session_of(light).measure(places, towards, StopRule(samples=64)).illuminance.max() == 0.0


@pytest.mark.parametrize("name", OPENINGS)
def test_far_away_every_opening_is_a_point(name):
    opening, rotation = OPENINGS[name], turn(5)
    # Of a body the side that is seen stands out towards the sensor, so its light comes from nearer than the centre.
    sizes = 50.0 if opening.shape in {"rectangle", "ellipse"} or name == "sphere" else 2000.0
    distance = sizes * max(opening.size)
    # The middles of cells: a bilinear function has no bend there.
    azimuth, polar = np.meshgrid(np.deg2rad([7.5, 97.5, 232.5]), np.deg2rad([18.75, 41.25, 63.75]))
    flat = np.sin(polar)
    local = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), -np.cos(polar)], axis=-1)
    towards = local.reshape(-1, 3) @ rotation.T
    places = CENTRE + distance * towards
    rule = StopRule(samples=1 << 14)
    made = [
        session_of(luminaire("batwing", shape, CENTRE, rotation, LUMENS)).measure(
            places, -towards, rule
        )
        for shape in (opening, POINT)
    ]
    error = 4.0 * made[0].standard_error
    assert (error < 2e-3 * made[1].illuminance).all()
    difference = np.abs(made[0].illuminance - made[1].illuminance)
    assert (difference < 1e-3 * made[1].illuminance + error).all()


# ---- what is conserved ----


@pytest.mark.one_at_a_time
@pytest.mark.parametrize(
    ("shape", "name"),
    [("type A", "point"), ("batwing", "cylinder"), ("asymmetric", "box"), ("irregular", "ellipse")],
)
def test_all_flux_arrives_at_a_sphere_of_sensors(transport, shape, name):
    radius, count = 1.0, 4096
    # The middle lies off the luminaire's.
    towards = sphere_points(count) @ turn(9).T
    middle = CENTRE + np.array([0.1, -0.05, 0.2])
    light = luminaire(shape, SHAPES[name], CENTRE, turn(6), LUMENS, spectrum=Blackbody(3000.0))
    made = session_of(light).measure(
        middle + radius * towards,
        -towards,
        StopRule(samples=64),
        transport=transport,
    )
    arriving = made.illuminance.mean() * 4.0 * np.pi * radius**2
    error = np.sqrt((made.standard_error**2).sum()) / count * 4.0 * np.pi * radius**2
    assert arriving == pytest.approx(LUMENS, rel=5e-3)
    assert error < 2e-3 * LUMENS


@pytest.mark.parametrize("shape", ["rectangle", "ellipsoid"])
def test_all_flux_of_a_narrow_beam_arrives_on_the_floor(shape):
    # 6 degrees between half values; a sensor in the middle of each of 64 x 64 squares.
    opening = Opening(shape, (0.6, 0.3, 0.0 if shape == "rectangle" else 0.2))
    light = luminaire("spot", opening, CENTRE, lumens=LUMENS)
    height, side, count = 1.0, 1.6, 64
    place = ((np.arange(count) + 0.5) / count - 0.5) * side
    x, y = np.meshgrid(place, place)
    floor = np.full(x.size, -height)
    places = CENTRE + np.stack([x.ravel(), y.ravel(), floor], axis=1)
    up = np.tile([0.0, 0.0, 1.0], (x.size, 1))
    made = session_of(light).measure(places, up, StopRule(samples=64))
    error = np.sqrt((made.standard_error**2).mean() / x.size) * side**2
    assert error < 3e-3 * LUMENS
    assert made.illuminance.mean() * side**2 == pytest.approx(
        LUMENS, abs=4.0 * error + 1e-3 * LUMENS
    )


PLACES = np.array([[0.0, 0.0, 1.0], [1.0, -1.0, 0.5], [-0.5, 0.8, 2.2], [0.4, 0.3, 4.0]])
NORMALS = np.array([[0.0, 0.0, 1.0], [-0.5, 0.4, 1.0], [1.0, 0.0, 0.3], [0.0, 0.2, -1.0]])
TRIO = (
    luminaire("asymmetric", POINT, (0.0, 0.0, 3.0), turn(1), 700.0, "a"),
    luminaire("batwing", OPENINGS["rectangle"], (1.0, 0.5, 3.0), turn(2), 500.0, "b"),
    luminaire("spike", OPENINGS["cylinder"], (-0.5, 0.2, 2.8), turn(3), 900.0, "c"),
)


def test_light_of_several_luminaires_adds_up():
    rule = StopRule(samples=1 << 14)
    both = session_of(*TRIO).measure(PLACES, NORMALS, rule)
    alone = [session_of(light).measure(PLACES, NORMALS, rule, seed=3) for light in TRIO]
    total = sum(made.illuminance for made in alone)
    error = np.sqrt(both.standard_error**2 + sum(made.standard_error**2 for made in alone))
    assert (np.abs(both.illuminance - total) < 4.0 * error + 1e-4 * total).all()
    assert (error < 0.02 * total).all()


def test_ids_and_order_do_not_matter():
    rule = StopRule(samples=256)
    first = session_of(*TRIO).measure(PLACES, NORMALS, rule, seed=5)
    others = [replace(light, id=f"z{k}", name="?") for k, light in enumerate(TRIO[::-1])]
    second = session_of(*others[1:], others[0]).measure(PLACES, NORMALS, rule, seed=5)
    np.testing.assert_array_equal(first.illuminance, second.illuminance)


def test_a_rigid_motion_of_everything_changes_nothing():
    rule = StopRule(samples=1 << 14)
    rotation, offset = turn(11), np.array([40.0, -25.0, 60.0])
    moved = []
    for light in TRIO:
        place, axes = light.frame[:3, 3] @ rotation.T + offset, rotation @ light.frame[:3, :3]
        moved.append(replace(light, frame=frame_of(place, axes)))
    here = session_of(*TRIO).measure(PLACES, NORMALS, rule)
    there = session_of(*moved).measure(PLACES @ rotation.T + offset, NORMALS @ rotation.T, rule, 7)
    error = np.hypot(here.standard_error, there.standard_error)
    assert (
        np.abs(here.illuminance - there.illuminance) < 4.0 * error + 1e-4 * here.illuminance
    ).all()


def test_light_is_in_proportion_to_the_flux():
    rule = StopRule(samples=256)
    first = session_of(*TRIO).measure(PLACES, NORMALS, rule)
    # A power of two, so that rounding does not choose another light here and there.
    brighter = [
        replace(light, output=replace(light.output, value=32.0 * light.output.value))
        for light in TRIO
    ]
    second = session_of(*brighter).measure(PLACES, NORMALS, rule)
    np.testing.assert_allclose(second.illuminance, 32.0 * first.illuminance, rtol=1e-6)


def test_only_proportions_of_the_intensities_count():
    rule = StopRule(samples=256)
    first = session_of(TRIO[1]).measure(PLACES, NORMALS, rule)
    known = TRIO[1].distribution
    more = replace(known, intensity=1234.5 * known.intensity)
    second = session_of(replace(TRIO[1], distribution=more)).measure(PLACES, NORMALS, rule)
    np.testing.assert_allclose(second.illuminance, first.illuminance, rtol=1e-5)


@pytest.mark.slow
def test_a_tint_keeps_the_lumens():
    rule = StopRule(samples=1 << 13)
    plain = session_of(*TRIO).measure(PLACES, NORMALS, rule, transport="mono")
    for colour in (Rgb(1.0, 0.1, 0.05), Blackbody(12000.0)):
        tinted = [replace(x, output=replace(x.output, spectrum=colour)) for x in TRIO]
        made = session_of(*tinted).measure(PLACES, NORMALS, rule, seed=4, transport="spectral")
        error = np.hypot(plain.standard_error, made.standard_error)
        assert (
            np.abs(made.illuminance - plain.illuminance) < 4.0 * error + 1e-3 * plain.illuminance
        ).all()
        assert (error < 0.03 * plain.illuminance).all()


# ---- what is seen ----


def looking(frame, width, height, size):
    """Orthographic camera, which sees everything in one direction: the way of its -z."""
    return Camera(frame, Projection.ORTHOGRAPHIC, width, height, size, size * height / width)


@pytest.mark.slow
def test_a_camera_sees_intensity_over_shown_area():
    # All kinds in a row, each turned and with a distribution of its own; the last is hidden.
    kinds = list(
        zip(
            OPENINGS.items(),
            ("batwing", "asymmetric", "type A", "type B", "up and down", "irregular", "spike"),
            strict=True,
        )
    )
    lights = [
        luminaire(shape, opening, (float(k), 0.0, 0.0), turn(40 + k), 100.0 + 50.0 * k, name)
        for k, ((name, opening), shape) in enumerate(kinds)
    ]
    lights.append(
        luminaire(
            "even", OPENINGS["sphere"], (7.0, 0.0, 0.0), key="hidden", visible_to_camera=False
        )
    )
    # 128 pixels are 8 m, each of the lights in the middle of 16 of them.
    frame = frame_of((3.5, 0.0, 5.0))
    picture = session_of(*lights).render(
        looking(frame, 128, 16, 8.0), ViewSettings(StopRule(samples=64))
    )
    luminance = picture.tristimulus[..., 1].reshape(16, 8, 16)
    for k, light in enumerate(lights[:-1]):
        away = np.array([[0.0, 0.0, 1.0]]) @ light.frame[:3, :3]
        scale = light.output.value / flux(light.distribution)
        expected = scale * intensity(light.distribution, away) / shown_area(light.opening, away)
        middle = luminance[7:9, k, 7:9]
        assert middle == pytest.approx(expected[0], rel=1e-3, abs=1e-6), light.name
        # And all of it together is the intensity.
        seen = luminance[:, k].sum() * (8.0 / 128.0) ** 2
        assert seen == pytest.approx(
            scale * intensity(light.distribution, away)[0], rel=0.03, abs=1e-6
        ), light.name
    assert luminance[:, 7].max() == 0.0


@pytest.mark.parametrize("roughness", [0.1, 0.35])
@pytest.mark.slow
def test_a_rough_mirror_shows_a_luminaire_as_it_shows_an_area_light(roughness):
    size_x, size_y = 0.6, 0.4
    place = frame_of((0.0, 0.0, 1.0), turn(2) if roughness < 0.2 else None)
    down = place.copy()
    down[:3, :3] = np.eye(3)
    metal = Material("metal", "metal", Conductor("Al", roughness))
    floor = quad("floor", (-2, -2, 0), (4, 0, 0), (0, 4, 0), "metal")
    output = Output(Quantity.LUMINOUS_FLUX, LUMENS)
    lights = (
        replace(luminaire("lambertian", Opening("rectangle", (size_x, size_y, 0.0))), frame=down),
        AreaLight("a", "a", output, down, size_x, size_y),
    )
    # Oblique, so that the highlight lies in the middle.
    angle = np.deg2rad(40.0)
    c, s = np.cos(angle), np.sin(angle)
    tilted = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    camera = looking(frame_of((0.0, 0.6 - 3.0 * s, 3.0 * c), tilted), 24, 24, 2.4)
    blocks, errors = [], []
    for seed, light in enumerate(lights):
        made = session_of(light, metal, floor).render(
            camera, ViewSettings(StopRule(samples=256), seed=seed)
        )
        blocks.append(made.tristimulus[..., 1].reshape(6, 4, 6, 4).mean(axis=(1, 3)))
        errors.append((made.luminance_error**2).reshape(6, 4, 6, 4).sum(axis=(1, 3)) / 256.0)
    error = np.sqrt(errors[0] + errors[1])
    difference = np.abs(blocks[0] - blocks[1])
    assert (difference < 4.5 * error + 2e-3 * blocks[1]).all()
    assert blocks[1].max() > 20.0 * error[blocks[1] == blocks[1].max()]
