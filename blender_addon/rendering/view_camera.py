"""The camera of a 3D view."""

import math
from dataclasses import dataclass, fields

import numpy as np

from ...engine.scene.camera import Camera, Projection
from ..foundation.report import ConversionReport
from ..foundation.units import metres_per_unit
from ..sync.camera import FilmPart, convert_camera, lens_of


@dataclass(frozen=True, eq=False)
class ViewFrame:
    """A camera that knows when it is the same as another."""

    camera: Camera

    def __eq__(self, other):
        """Compare the cameras by what they see."""
        return isinstance(other, ViewFrame) and all(
            np.array_equal(getattr(self.camera, entry.name), getattr(other.camera, entry.name))
            for entry in fields(Camera)
        )

    __hash__ = None


def view_camera(context, depsgraph) -> ViewFrame:
    """Return the camera through which a region shows the scene.

    Parameters
    ----------
    context : bpy.types.Context    Of a 3D view.
    depsgraph : bpy.types.Depsgraph    That the view shows.
    """
    view, region, scene = context.region_data, context.region, depsgraph.scene
    scale = metres_per_unit(scene)
    is_through = view.view_perspective == "CAMERA" and scene.camera is not None
    source = scene.camera if is_through and scene.camera.type == "CAMERA" else None
    if source is not None and source.data.type == "PANO":
        part = part_of_region(view, region, source.data.view_frame(scene=scene))
        return ViewFrame(convert_camera(source, scene, scale, ConversionReport(), part))
    end = context.space_data.clip_end if source is None else source.data.clip_end
    return ViewFrame(camera_of_matrices(view, region, scale, source, end))


def part_of_region(view, region, frame) -> FilmPart:
    """Return what a region shows of a camera's film, whose frame it draws somewhere within.

    Parameters
    ----------
    view : bpy.types.RegionView3D    That looks through the camera.
    region : bpy.types.Region    For its size.
    frame : sequence of Vector    Corners of the film in the camera's axes.
    """
    window = np.array(view.window_matrix, dtype=np.float64)
    corners = np.array([[*corner, 1.0] for corner in frame], dtype=np.float64) @ window.T
    corners = corners[:, :2] / corners[:, 3:]
    size, middle = np.ptp(corners, axis=0), 0.5 * (corners.max(axis=0) + corners.min(axis=0))
    return FilmPart(region.width, region.height, tuple(-middle / size), tuple(2.0 / size))


def camera_of_matrices(view, region, scale: float, source=None, end=math.inf) -> Camera:
    """Camera from a view's matrices, which hold shift, zoom and clipping too.

    Parameters
    ----------
    view : bpy.types.RegionView3D
    region : bpy.types.Region    For its size.
    scale : float    Metres per Blender unit.
    source : bpy.types.Object or None    The camera that is looked through, for its lens.
    end : float    Of the clipping of a view in perspective, whose matrix rounds it off. [Blender unit]
    """
    frame = np.array(view.view_matrix.inverted(), dtype=np.float64)
    frame[:3, :3] /= np.maximum(np.linalg.norm(frame[:3, :3], axis=0), 1e-30)
    frame[:3, 3] *= scale
    window = np.array(view.window_matrix, dtype=np.float64)
    common = {"frame": frame, "width": region.width, "height": region.height}
    lens = lens_of(source, source.data, scale) if source is not None else {}
    if abs(window[3, 2]) < 0.5:
        # Orthographic: x_ndc = w00 x + w03, z_ndc = w22 z + w23.
        return Camera(
            projection=Projection.ORTHOGRAPHIC,
            extent_x=2.0 / window[0, 0] * scale,
            extent_y=2.0 / window[1, 1] * scale,
            shift_x=-window[0, 3] / window[0, 0] * scale,
            shift_y=-window[1, 3] / window[1, 1] * scale,
            clip_start=(window[2, 3] + 1.0) / window[2, 2] * scale,
            clip_end=(window[2, 3] - 1.0) / window[2, 2] * scale,
            **lens,
            **common,
        )
    # Perspective: x_ndc = (w00 x + w02 z) / -z.
    return Camera(
        projection=Projection.PERSPECTIVE,
        extent_x=2.0 / window[0, 0],
        extent_y=2.0 / window[1, 1],
        shift_x=window[0, 2] / window[0, 0],
        shift_y=window[1, 2] / window[1, 1],
        clip_start=window[2, 3] / (window[2, 2] - 1.0) * scale,
        clip_end=end * scale if math.isfinite(end) else None,
        **lens,
        **common,
    )
