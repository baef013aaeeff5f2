"""The sun's direction from a thing and its shadow in a picture: by projecting both by hand, for cameras of many kinds."""

import numpy as np
import pytest

from lumenray.engine.errors import SceneError
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.sky.shadow_sun import find_sun, meet_ground

LEVEL = 0.3


def camera(position, target, extent=(0.9, 0.6), shift=(0.0, 0.0), kind=Projection.PERSPECTIVE):
    forward = np.subtract(target, position) / np.linalg.norm(np.subtract(target, position))
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([right, np.cross(right, forward), -forward], axis=1)
    frame[:3, 3] = position
    return Camera(frame, kind, 600, 400, *extent, *shift)


def project(eye, point):
    """Where a point shows on the film, as shares of its sides: by the matrix, not by rays."""
    local = np.linalg.inv(eye.frame) @ [*point, 1.0]
    x, y = local[:2] if eye.projection is Projection.ORTHOGRAPHIC else local[:2] / -local[2]
    return (
        (x - eye.shift_x) / eye.extent_x + 0.5,
        (y - eye.shift_y) / eye.extent_y + 0.5,
    )


CAMERAS = {
    "level": camera((0, -8, 1.9), (0, 0, 1.9)),
    "from above": camera((4, -6, 5.0), (0, 0, 0)),
    "shifted": camera((-3, -8, 1.7), (0, 0, 1.2), shift=(0.1, -0.05)),
    "orthographic": camera((4, -6, 5.0), (0, 0, 0), (12.0, 8.0), kind=Projection.ORTHOGRAPHIC),
}


@pytest.mark.parametrize("name", CAMERAS)
@pytest.mark.parametrize(("azimuth", "altitude"), [(10, 20), (130, 45), (250, 65), (60, 25)])
def test_the_sun_is_where_it_cast_the_shadow_from(name, azimuth, altitude):
    eye = CAMERAS[name]
    a, h = np.radians([azimuth, altitude])
    sun = np.array([np.sin(a) * np.cos(h), np.cos(a) * np.cos(h), np.sin(h)])
    foot = np.array([0.4, 0.2, LEVEL])
    top = foot + np.array([0, 0, 1.6])
    end = top - sun * (1.6 / sun[2])
    places = [project(eye, each) for each in (foot, top, end)]
    assert find_sun(eye, LEVEL, *places) == pytest.approx(sun, abs=1e-9)
    # A hand that is off by a pixel of 600 turns the sun by less than a degree.
    off = [np.add(place, (1 / 600, 0)) for place in places[2:]]
    turned = find_sun(eye, LEVEL, *places[:2], *off)
    assert np.degrees(np.arccos(min(turned @ sun, 1.0))) < 1.0


def test_what_cannot_be_is_said():
    eye = CAMERAS["level"]
    foot, top, end = (project(eye, each) for each in ((0, 0, LEVEL), (0, 0, 1), (1, 0, LEVEL)))
    with pytest.raises(SceneError, match="above the horizon"):
        find_sun(eye, LEVEL, foot, top, (0.5, 0.9))
    with pytest.raises(SceneError, match="not above the foot"):
        find_sun(eye, LEVEL, foot, project(eye, (0, 0, 0)), end)
    above = camera((0.001, 0, 5), (0, 0, 0))
    with pytest.raises(SceneError, match="straight above"):
        find_sun(above, LEVEL, (0.4, 0.4), project(above, (0.001, 0, 0)), (0.6, 0.6))
    panorama = Camera(np.eye(4), Projection.EQUIRECTANGULAR, 8, 4)
    with pytest.raises(SceneError, match="no panoramas"):
        meet_ground(panorama, (0.5, 0.2), 0.0)
