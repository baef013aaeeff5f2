"""Blender's camera and film as a camera of the engine."""

import math
from dataclasses import dataclass

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


@dataclass(frozen=True)
class FilmPart:
    """What of the full film is shown.

    Parameters
    ----------
    width, height : int    [pixel]
    centre : (float, float)    Its middle to that of the full film, as shares of the sides of that.
    share : (float, float)    Its sides, likewise.
    """

    width: int
    height: int
    centre: tuple[float, float] = (0.0, 0.0)
    share: tuple[float, float] = (1.0, 1.0)


def rendered_part(render) -> FilmPart:
    """Return the part of the film that is to be rendered."""
    full = film_size(render)
    left, low, width, height = region(render)
    sides = ((left, width, full[0]), (low, height, full[1]))
    return FilmPart(
        width,
        height,
        tuple((first + 0.5 * size) / whole - 0.5 for first, size, whole in sides),
        tuple(size / whole for _, size, whole in sides),
    )


def convert_camera(source, scene, scale: float, report, part: FilmPart | None = None) -> Camera:
    """Convert a camera object.

    Parameters
    ----------
    source : bpy.types.Object    Evaluated camera object.
    scene : bpy.types.Scene    For film size, aspect and border.
    scale : float    Metres per Blender unit.
    report : ConversionReport
    part : FilmPart or None    None: what is to be rendered.
    """
    data = source.data
    tell(CAMERA, data, source.name, report)
    part = rendered_part(scene.render) if part is None else part
    frame = np.array(source.matrix_world, dtype=np.float64)
    frame[:3, :3] /= np.maximum(np.linalg.norm(frame[:3, :3], axis=0), 1e-30)
    frame[:3, 3] *= scale
    common = {
        "frame": frame,
        "width": part.width,
        "height": part.height,
        "clip_start": data.clip_start * scale,
        "clip_end": data.clip_end * scale,
        **lens_of(source, data, scale),
    }
    if data.type == "PANO":
        return Camera(**panorama_of(data, scene.render, part, report), **common)

    corners = np.array([list(corner) for corner in data.view_frame(scene=scene)], dtype=np.float64)
    size = corners.max(axis=0)[:2] - corners.min(axis=0)[:2]
    middle = 0.5 * (corners.max(axis=0) + corners.min(axis=0))[:2]
    unit = scale if data.type == "ORTHO" else 1.0 / abs(corners[0, 2])
    size, middle = size * unit, middle * unit
    return Camera(
        projection=Projection.ORTHOGRAPHIC if data.type == "ORTHO" else Projection.PERSPECTIVE,
        extent_x=size[0] * part.share[0],
        extent_y=size[1] * part.share[1],
        shift_x=middle[0] + part.centre[0] * size[0],
        shift_y=middle[1] + part.centre[1] * size[1],
        **common,
    )


def lens_of(source, data, scale) -> dict:
    """Aperture and focus, nothing when depth of field is off."""
    lens = data.dof
    if not lens.use_dof:
        return {}
    distance = lens.focus_distance
    if lens.focus_object is not None:
        away = lens.focus_object.matrix_world.translation - source.matrix_world.translation
        view = source.matrix_world.col[2].xyz.normalized()
        distance = abs(away.dot(view))
    # Orthographic cameras have no focal length: Cycles takes one unit for it.
    length = 1.0 if data.type == "ORTHO" else 1e-3 * data.lens
    return {
        "aperture_radius": 0.5 * length / max(lens.aperture_fstop, 1e-5) * scale,
        "aperture_blades": lens.aperture_blades,
        "aperture_rotation": lens.aperture_rotation,
        "aperture_ratio": lens.aperture_ratio,
        "focus_distance": distance * scale,
    }


def panorama_of(data, render, part: FilmPart, report) -> dict:
    """Projection of a panoramic camera and its film, as fields of `Camera`."""
    # Before Blender 5 these settings came with Cycles.
    holder = data if hasattr(data, "panorama_type") else getattr(data, "cycles", None)
    kind = getattr(holder, "panorama_type", "unknown")
    if kind not in PANORAMAS:
        report.error(
            data.name, f"{kind.lower()} panoramas are not supported", "rendered as equirectangular"
        )
        kind, holder = "EQUIRECTANGULAR", None
    made = PANORAMAS[kind](holder, _sensor(data, render))
    sides = zip("xy", made.pop("extent"), made.pop("middle", (0.0, 0.0)), strict=True)
    offsets = zip(part.centre, (data.shift_x, data.shift_y), part.share, strict=True)
    for (axis, size, middle), (centre, shift, share) in zip(sides, offsets, strict=True):
        made[f"extent_{axis}"] = float(size * share)
        made[f"shift_{axis}"] = float(middle + (centre + shift) * size)
    return made


def _sensor(data, render) -> tuple[float, float]:
    """Width and height of the sensor behind a fisheye. [mm]"""
    width, height = film_size(render)
    width, height = width * render.pixel_aspect_x, height * render.pixel_aspect_y
    is_vertical = data.sensor_fit == "VERTICAL"
    size = data.sensor_height if is_vertical else data.sensor_width
    is_wide = width > height if data.sensor_fit == "AUTO" else not is_vertical
    return (size, size * height / width) if is_wide else (size * width / height, size)


def _equirectangular(holder, _sensor) -> dict:
    low, high = (
        np.array(
            [
                getattr(holder, f"longitude_{end}", sign * math.pi),
                getattr(holder, f"latitude_{end}", sign * 0.5 * math.pi),
            ]
        )
        for end, sign in (("min", -1.0), ("max", 1.0))
    )
    return {
        "projection": Projection.EQUIRECTANGULAR,
        "extent": high - low,
        "middle": 0.5 * (low + high),
    }


def _equidistant(holder, _sensor) -> dict:
    field = holder.fisheye_fov
    return {"projection": Projection.EQUIDISTANT, "extent": (field, field), "field": field}


def _equisolid(holder, sensor) -> dict:
    extent = tuple(side / holder.fisheye_lens for side in sensor)
    return {"projection": Projection.EQUISOLID, "extent": extent, "field": holder.fisheye_fov}


def _polynomial(holder, sensor) -> dict:
    powers = tuple(getattr(holder, f"fisheye_polynomial_k{power}") for power in range(5))
    return {
        "projection": Projection.POLYNOMIAL,
        "extent": sensor,
        "field": holder.fisheye_fov,
        "polynomial": powers,
    }


def _mirror_ball(_holder, _sensor) -> dict:
    return {"projection": Projection.MIRROR_BALL, "extent": (2.0, 2.0)}


def _cube_face(_holder, _sensor) -> dict:
    side = 0.5 * math.pi
    return {"projection": Projection.CUBE_FACE, "extent": (side, side)}


def _cylinder(holder, _sensor) -> dict:
    low, high = (
        np.array([getattr(holder, f"central_cylindrical_range_{axis}_{end}") for axis in "uv"])
        for end in ("min", "max")
    )
    unit = np.array([1.0, 1.0 / holder.central_cylindrical_radius])
    return {
        "projection": Projection.CENTRAL_CYLINDRICAL,
        "extent": (high - low) * unit,
        "middle": 0.5 * (low + high) * unit,
    }


PANORAMAS = {
    "EQUIRECTANGULAR": _equirectangular,
    "FISHEYE_EQUIDISTANT": _equidistant,
    "FISHEYE_EQUISOLID": _equisolid,
    "FISHEYE_LENS_POLYNOMIAL": _polynomial,
    "MIRRORBALL": _mirror_ball,
    "EQUIANGULAR_CUBEMAP_FACE": _cube_face,
    "CENTRAL_CYLINDRICAL": _cylinder,
}
"""Fields of `Camera` by the kind of panorama; ``extent`` and ``middle`` of the full film without its shift."""
