"""Blender's camera and film as a camera of the engine."""

import math

import numpy as np

from ...engine.scene.camera import Camera, Projection
from .departures import CAMERA, tell


def film_size(render) -> tuple[int, int]:
    """Return width and height of the full picture. [pixel]"""
    share = render.resolution_percentage / 100.0
    return max(int(render.resolution_x * share), 1), max(int(render.resolution_y * share), 1)


def region(render) -> tuple[int, int, int, int]:
    """Return left, bottom, width and height of the part to be rendered. [pixel]"""
    width, height = film_size(render)
    if not render.use_border:
        return 0, 0, width, height
    left, right = (_whole(share, width) for share in (render.border_min_x, render.border_max_x))
    low, high = (_whole(share, height) for share in (render.border_min_y, render.border_max_y))
    return left, low, max(right - left, 1), max(high - low, 1)


def _whole(share: float, pixels: int) -> int:
    """Pixels of a share of them, cut off as Blender does, in its precision."""
    return int(np.float32(share) * np.float32(pixels))


def convert_camera(source, scene, scale: float, report) -> Camera:
    """Convert a camera object.

    Parameters
    ----------
    source : bpy.types.Object    Evaluated camera object.
    scene : bpy.types.Scene    For film size, aspect and border.
    scale : float    Metres per Blender unit.
    report : ConversionReport
    """
    data = source.data
    tell(CAMERA, data, source.name, report)
    full_width, full_height = film_size(scene.render)
    left, low, width, height = region(scene.render)
    frame = np.array(source.matrix_world, dtype=np.float64)
    frame[:3, :3] /= np.maximum(np.linalg.norm(frame[:3, :3], axis=0), 1e-30)
    frame[:3, 3] *= scale
    common = {
        "frame": frame,
        "width": width,
        "height": height,
        "clip_start": data.clip_start * scale,
    }
    # The part of the full film that is rendered, as shares of its sides.
    centre_x = (left + 0.5 * width) / full_width - 0.5
    centre_y = (low + 0.5 * height) / full_height - 0.5
    if data.type == "PANO":
        return Camera(projection=Projection.EQUIRECTANGULAR, **_panorama(data, report), **common)

    corners = np.array([list(corner) for corner in data.view_frame(scene=scene)], dtype=np.float64)
    size = corners.max(axis=0)[:2] - corners.min(axis=0)[:2]
    middle = 0.5 * (corners.max(axis=0) + corners.min(axis=0))[:2]
    unit = scale if data.type == "ORTHO" else 1.0 / abs(corners[0, 2])
    size, middle = size * unit, middle * unit
    return Camera(
        projection=Projection.ORTHOGRAPHIC if data.type == "ORTHO" else Projection.PERSPECTIVE,
        extent_x=size[0] * width / full_width,
        extent_y=size[1] * height / full_height,
        shift_x=middle[0] + centre_x * size[0],
        shift_y=middle[1] + centre_y * size[1],
        **lens_of(source, data, scale),
        **common,
    )


def lens_of(source, data, scale) -> dict:
    """Aperture and focus, nothing when depth of field is off."""
    if not data.dof.use_dof or data.type != "PERSP":
        return {}
    distance = data.dof.focus_distance
    if data.dof.focus_object is not None:
        away = data.dof.focus_object.matrix_world.translation - source.matrix_world.translation
        view = source.matrix_world.col[2].xyz.normalized()
        distance = abs(away.dot(view))
    radius = 0.5e-3 * data.lens / max(data.dof.aperture_fstop, 1e-3)
    return {"aperture_radius": radius * scale, "focus_distance": distance * scale}


def _panorama(data, report) -> dict:
    """Ranges of an equirectangular camera."""
    holder = data if hasattr(data, "panorama_type") else getattr(data, "cycles", None)
    kind = getattr(holder, "panorama_type", "EQUIRECTANGULAR")
    if kind != "EQUIRECTANGULAR":
        report.error(
            data.name, f"{kind.lower()} panoramas are not supported", "rendered as equirectangular"
        )
        return {}
    return {
        "longitude": (
            getattr(holder, "longitude_min", -math.pi),
            getattr(holder, "longitude_max", math.pi),
        ),
        "latitude": (
            getattr(holder, "latitude_min", -0.5 * math.pi),
            getattr(holder, "latitude_max", 0.5 * math.pi),
        ),
    }
