"""The sun that casts a shadow in a picture: from what is seen of a thing and of its shadow's end on level ground."""

import numpy as np

from ..errors import SceneError
from ..scene.camera import Camera, Projection

LEAST_SLOPE = 1e-9
"""Slope of a ray below which it is taken as level. [-]"""


def view_ray(camera: Camera, place) -> tuple[np.ndarray, np.ndarray]:
    """Return where a camera's ray through a place of the film begins, and its unit direction. (3,) [m], (3,)

    Parameters
    ----------
    camera : Camera    Perspective or orthographic.
    place : (2,) array    From the film's lower left corner, as shares of its sides. [-]

    Raises
    ------
    SceneError    The camera is a panorama.
    """
    if camera.projection.is_panoramic:
        raise SceneError("the sun is found by shadows in pictures of cameras that are no panoramas")
    frame = np.asarray(camera.frame, dtype=np.float64)
    axes = frame[:3, :3] / np.linalg.norm(frame[:3, :3], axis=0)
    x = (float(place[0]) - 0.5) * camera.extent_x + camera.shift_x
    y = (float(place[1]) - 0.5) * camera.extent_y + camera.shift_y
    if camera.projection is Projection.ORTHOGRAPHIC:
        return frame[:3, 3] + axes @ [x, y, 0.0], -axes[:, 2]
    direction = axes @ [x, y, -1.0]
    return frame[:3, 3], direction / np.linalg.norm(direction)


def meet_ground(camera: Camera, place, level: float) -> np.ndarray:
    """Return where a camera sees level ground. (3,) [m]

    Parameters
    ----------
    camera, place    As of `view_ray`.
    level : float    Height of the ground. [m]

    Raises
    ------
    SceneError    It is not seen there.
    """
    start, direction = view_ray(camera, place)
    if abs(direction[2]) < LEAST_SLOPE or (level - start[2]) / direction[2] <= 0.0:
        raise SceneError(
            "the ground is not seen there: the place lies on or above the horizon of the picture"
        )
    return start + direction * ((level - start[2]) / direction[2])


def find_sun(camera: Camera, level: float, foot, top, end) -> np.ndarray:
    """Return the direction to the sun that casts a shadow.

    Parameters
    ----------
    camera : Camera    As it stood when the picture was taken.
    level : float    Height of the ground. [m]
    foot, top, end : (2,) array
        Where in the picture the foot of something upright is, its top, and the end of its shadow on the ground; as of
        `view_ray`.

    Returns
    -------
    (3,) array    Unit vector.

    Raises
    ------
    SceneError    Foot or end are not on the ground, the top is not above the foot, or nothing can be said of it.

    Notes
    -----
    The foot gives the place on the ground, and the top lies straight above it, where the ray through the picture's top
    passes the vertical line nearest. Seen from straight above, the height of the top cannot be told.
    """
    base, shadow = meet_ground(camera, foot, level), meet_ground(camera, end, level)
    start, direction = view_ray(camera, top)
    plan = direction[:2] @ direction[:2]
    if plan < LEAST_SLOPE:
        raise SceneError("the top is seen from straight above, so its height is not known")
    way = (base - start)[:2] @ direction[:2] / plan
    height = start[2] + way * direction[2] - level
    if way <= 0.0 or height <= 0.0:
        raise SceneError("the top is not above the foot")
    towards = base + np.array([0.0, 0.0, height]) - shadow
    return towards / np.linalg.norm(towards)
