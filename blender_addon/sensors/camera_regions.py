"""Cameras as luminance meters: where the parts of their pictures look, and where they are drawn."""

import numpy as np

from ...engine.camera_luminance import find_regions
from ...engine.errors import SceneError
from ...engine.formats.luminance_picture import view_of_camera
from ...engine.scene.camera import Camera
from ..foundation.identity import identity_of
from ..foundation.report import ConversionReport
from ..sync.camera import convert_camera

AHEAD = 0.5
"""How far before the camera the parts are drawn, and how wide those of panoramas are. [m]"""

OPTICS = (
    "type",
    "lens",
    "sensor_width",
    "sensor_height",
    "sensor_fit",
    "shift_x",
    "shift_y",
    "ortho_scale",
)
"""Settings of a camera that say what its picture shows."""


def camera_of(empty, scene):
    """Return the camera whose picture an empty stands for.

    Raises
    ------
    SceneError    Neither the empty nor the scene has one.
    """
    camera = empty.lumenray.sensor.camera or scene.camera
    if camera is None:
        raise SceneError("there is no camera; choose one, or give the scene one")
    return camera


def lay_regions(empty, depsgraph, metres: float):
    """Return the parts of a camera's picture, row by row from the lower left.

    Parameters
    ----------
    metres : float    Per Blender unit.

    Returns
    -------
    camera : Camera
    positions, directions : (n, 3) array    [m]
    frame : (4, 4) array    Of the plane in which they are drawn. [m]
    plane : (n, 2) array    Their places in it. [m]

    Raises
    ------
    SceneError    There is no camera, its view is none that an eye could have, or it is no luminances that are asked for.
    """
    settings = empty.lumenray.sensor
    if settings.quantity != "LUMINANCE":
        raise SceneError(
            "the parts of a camera's picture tell luminances; set the quantity to Luminance"
        )
    source = camera_of(empty, depsgraph.scene).evaluated_get(depsgraph)
    converted = convert_camera(source, depsgraph.scene, metres, ConversionReport())
    shape = settings.rows, settings.columns
    camera = find_regions(converted, shape)
    view = view_of_camera(camera)
    columns, rows = np.meshgrid(
        camera.width * (np.arange(shape[1]) + 0.5) / shape[1],
        camera.height * (np.arange(shape[0]) + 0.5) / shape[0],
    )
    local, _ = view.directions(columns.ravel(), rows.ravel())
    turn, place = camera.frame[:3, :3], camera.frame[:3, 3]
    shares = np.column_stack([columns.ravel() / camera.width, rows.ravel() / camera.height]) - 0.5
    extent = np.array(view.extent)
    if not is_flat(camera):
        extent /= extent.max()
    frame = camera.frame.copy()
    frame[:3, 3] = place - AHEAD * turn[:, 2]
    plane = AHEAD * (shares * extent + (np.array(view.shift) if is_flat(camera) else 0.0))
    return camera, np.tile(place, (len(plane), 1)), local @ turn.T, frame, plane


def is_flat(camera: Camera) -> bool:
    """Whether a camera's picture lies in a plane before it."""
    return camera.projection.value == "perspective"


def camera_signature(empty) -> tuple:
    """What of a camera says what its picture shows."""
    settings = empty.lumenray.sensor
    camera = settings.camera or next(
        (scene.camera for scene in empty.users_scene if scene.camera is not None), None
    )
    if camera is None:
        return ()
    matrix = tuple(round(float(value), 6) for row in camera.matrix_world for value in row)
    optics = tuple(getattr(camera.data, name) for name in OPTICS)
    own = tuple(round(value, 6) if isinstance(value, float) else value for value in optics)
    return (identity_of(camera), settings.rows, settings.columns, *own, matrix)
