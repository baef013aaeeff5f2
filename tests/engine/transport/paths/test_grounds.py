"""Surroundings that lie on a ground, and photos that cover a part of them, against what geometry says is seen."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Ground, ImageWorld, Photo, UniformWorld
from lumenray.engine.scene.material import Glossy, Material
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

CENTRE, LEVEL = np.array([2.0, -1.0, 1.5]), -0.5
GROUND = Ground(CENTRE, LEVEL, 1e4)
SPECK = quad("speck", (50, 50, 50), (1e-3, 0, 0), (0, 1e-3, 0), "paint")


def fading_map(rows=64):
    """Luminance that falls evenly with the elevation, from 9 at the zenith to 1 at the nadir. [cd/m2]"""
    levels = 1.0 + 8.0 * (np.arange(rows) + 0.5) / rows
    return np.repeat(levels[:, None, None], 2 * rows, axis=1).astype(np.float32)


def level_of(direction):
    """What `fading_map` shows in a direction. [cd/m2]"""
    direction = np.asarray(direction) / np.linalg.norm(direction, axis=-1, keepdims=True)
    return 1.0 + 8.0 * (0.5 + np.arcsin(direction[..., 2]) / np.pi)


def look_along(position, forward, up=(0, 0, 1), extent=0.02, size=4):
    """Camera of a small field."""
    forward = np.asarray(forward, float) / np.linalg.norm(forward)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([right, np.cross(right, forward), -forward], axis=1)
    frame[:3, 3] = position
    return Camera(frame, Projection.PERSPECTIVE, size, size, extent, extent)


def seen(session, camera, samples=16, **more):
    made = session.render(camera, ViewSettings(StopRule(samples=samples), method="paths", **more))
    return made.tristimulus[..., 1]


def met(position, forward):
    """Where a ray meets the ground."""
    position, forward = np.asarray(position, float), np.asarray(forward, float)
    return position + forward * ((LEVEL - position[2]) / forward[2])


def world(ground=GROUND, **more):
    return ImageWorld(ImageTexture(fading_map()), 1.0, ground=ground, **more)


def test_the_ground_shows_what_the_map_saw_there_and_the_sky_stays_at_infinity():
    session = session_of(paint(0.5), SPECK, world())
    for position, forward in (
        ((0.0, 0.0, 1.0), (1.0, 0.0, -1.0)),
        ((8.0, 3.0, 0.2), (-0.5, 0.2, -0.3)),
        (CENTRE, (0.3, 0.3, -0.4)),
    ):
        expected = level_of(met(position, forward) - CENTRE)
        camera = look_along(position, forward)
        assert seen(session, camera).mean() == pytest.approx(expected, rel=2e-3)
    up = (0.3, 0.1, 0.5)
    assert seen(session, look_along((8.0, 3.0, 0.2), up)).mean() == pytest.approx(
        level_of(up), rel=2e-3
    )


def test_far_away_the_ground_passes_into_what_lies_at_infinity():
    """At the radius' end it is the map as ever, without a step anywhere on the way."""
    session = session_of(paint(0.5), SPECK, world(Ground(CENTRE, LEVEL, 10.0)))
    position = np.array([2.0, -1.0, 5.0])
    # By the distance from the centre at which the ray meets the ground.
    distances = np.array([2.0, 4.99, 5.01, 6.0, 7.0, 8.0, 9.0, 9.98, 10.02, 14.0])
    found = []
    for distance in distances:
        forward = np.array([distance, 0.0, LEVEL - position[2]])
        found.append(seen(session, look_along(position, forward, extent=1e-3)).mean())
    near = level_of(np.array([[d, 0.0, LEVEL - CENTRE[2]] for d in distances]))
    far = level_of(np.array([[d, 0.0, LEVEL - position[2]] for d in distances]))
    assert found[:3] == pytest.approx(near[:3], rel=3e-3)
    assert found[-2:] == pytest.approx(far[-2:], rel=3e-3)
    assert found[-3] == pytest.approx(far[-3], rel=3e-3)
    # As far as the distances let the elevation change.
    assert np.abs(np.diff(found)[[1, 7]]).max() < 0.02
    assert np.abs(np.diff(found)[2:7]).max() < 0.2


def test_mirrors_show_the_ground_from_where_they_are():
    """A level mirror that faces down, seen from below."""
    mirror = Material("mirror", "mirror", Glossy(Constant(0.8), 0.0))
    plate = quad("plate", (-1, -1, 1.0), (0, 2, 0), (2, 0, 0), "mirror")
    session = session_of(mirror, plate, world())
    position, forward = np.array([0.0, 0.0, 0.2]), np.array([0.4, 0.1, 0.8])
    hit = position + forward * (0.8 / forward[2])
    expected = 0.8 * level_of(met(hit, forward * [1, 1, -1]) - CENTRE)
    found = seen(session, look_along(position, forward), samples=64)
    assert found.mean() == pytest.approx(expected, rel=3e-3)


def test_a_sensor_that_faces_the_ground_measures_it():
    """Against the integral over the plane, by places on it."""
    session = session_of(paint(0.5), SPECK, world())
    at = np.array([1.0, 0.5, 0.5])
    measured = session.measure([at], [(0, 0, -1)], StopRule(samples=1 << 14))
    mu, phi = np.meshgrid(
        (np.arange(400) + 0.5) / 400, 2 * np.pi * (np.arange(400) + 0.5) / 400, indexing="ij"
    )
    # Cosine-distributed directions.
    sine = np.sqrt(mu)
    directions = np.stack([sine * np.cos(phi), sine * np.sin(phi), -np.sqrt(1.0 - mu)], axis=-1)
    hits = at + directions * ((LEVEL - at[2]) / directions[..., 2:3])
    expected = np.pi * level_of(hits - CENTRE).mean()
    assert measured.illuminance[0] == pytest.approx(expected, rel=0.01)


def test_edits_of_the_ground_reach_the_picture():
    session = session_of(paint(0.5), SPECK, world(None))
    position, forward = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, -1.0])
    camera = look_along(position, forward)
    plain = seen(session, camera).mean()
    assert plain == pytest.approx(level_of(forward), rel=2e-3)
    session.apply(SceneDelta(changed=(world(),)))
    laid = seen(session, camera).mean()
    assert laid == pytest.approx(level_of(met(position, forward) - CENTRE), rel=2e-3)
    session.apply(SceneDelta(changed=(world(replace(GROUND, level=-1.0)),)))
    lower = position + forward * 2.0 - CENTRE
    assert seen(session, camera).mean() == pytest.approx(level_of(lower), rel=2e-3)
    session.apply(SceneDelta(changed=(world(None),)))
    assert seen(session, camera).mean() == pytest.approx(plain, rel=1e-5)


def photo_of(camera, pixels, luminance=3.0):
    return Photo(
        ImageTexture(pixels),
        luminance,
        camera.frame[:3, :3],
        camera.extent_x,
        camera.extent_y,
        camera.shift_x,
        camera.shift_y,
    )


def ramp(width=64, height=48):
    """Photo whose luminance is linear over it, so that filters of pixels change nothing. (h, w, 1)"""
    x = (np.arange(width) + 0.5) / width
    y = (np.arange(height) + 0.5) / height
    return (1.0 + 2.0 * x[None, :] + 4.0 * y[:, None])[..., None].astype(np.float32)


def test_the_camera_that_took_a_photo_sees_it_and_others_see_the_world_beside_it():
    taken = replace(look_along((0, 0, 1.6), (1, 0.2, -0.1), extent=0.8, size=8), shift_x=0.1)
    session = session_of(
        paint(0.5), SPECK, UniformWorld(0.0, seen=UniformWorld(7.0, photo=photo_of(taken, ramp())))
    )
    found = seen(session, taken, samples=256)
    x = (np.arange(8) + 0.5) / 8
    expected = 3.0 * (1.0 + 2.0 * x[None, :] + 4.0 * x[:, None])
    assert found[1:-1, 1:-1] == pytest.approx(expected[1:-1, 1:-1], rel=0.01)
    away = look_along((0, 0, 1.6), (-1, 0, 0))
    assert seen(session, away, samples=256).mean() == pytest.approx(7.0, rel=0.01)


def test_a_photo_on_the_ground_is_seen_in_mirrors_as_if_it_lay_there():
    """The ray from the mirror meets the ground where the camera of the photo saw a part of it."""
    taken = look_along(CENTRE, (1, 0.0, -0.4), extent=1.2, size=8)
    mirror = Material("mirror", "mirror", Glossy(Constant(0.8), 0.0))
    plate = quad("plate", (4, -3, 1.0), (0, 4, 0), (4, 0, 0), "mirror")
    photo = photo_of(taken, ramp())
    session = session_of(mirror, plate, UniformWorld(0.0, ground=GROUND, photo=photo))
    position, forward = np.array([5.0, -1.0, 0.0]), np.array([0.2, 0.1, 0.9])
    hit = position + forward * (1.0 / forward[2])
    away = met(hit, forward * [1, 1, -1]) - CENTRE
    local = taken.frame[:3, :3].T @ away
    u, v = local[:2] / -local[2] / 1.2 + 0.5
    assert 0.05 < u < 0.95
    assert 0.05 < v < 0.95
    expected = 0.8 * 3.0 * (1.0 + 2.0 * u + 4.0 * v)
    found = seen(session, look_along(position, forward, extent=1e-3), samples=64)
    assert found.mean() == pytest.approx(expected, rel=5e-3)


def test_a_coloured_photo_keeps_its_colour():
    pixels = np.broadcast_to(np.float32([0.8, 0.3, 0.1]), (6, 8, 3)).copy()
    taken = look_along((0, 0, 1.6), (1, 0.2, -0.1), extent=0.8)
    session = session_of(
        paint(0.5), SPECK, UniformWorld(0.0, seen=UniformWorld(0.0, photo=photo_of(taken, pixels)))
    )
    made = session.render(taken, ViewSettings(StopRule(samples=256), method="paths"))
    to_xyz = np.linalg.inv(
        np.array(
            [
                [3.2404542, -1.5371385, -0.4985314],
                [-0.969266, 1.8760108, 0.041556],
                [0.0556434, -0.2040259, 1.0572252],
            ]
        )
    )
    expected = 3.0 * to_xyz @ [0.8, 0.3, 0.1]
    assert made.tristimulus[1:-1, 1:-1].mean(axis=(0, 1)) == pytest.approx(expected, rel=0.02)
