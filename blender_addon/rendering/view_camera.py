"""The camera of a 3D view."""

from dataclasses import dataclass, fields

import numpy as np

from ...engine.scene.camera import Camera, Projection
from ..foundation.units import metres_per_unit
from ..sync.camera import convert_camera, lens_of


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
    source = scene.camera if view.view_perspective == "CAMERA" else None
    if source is not None and source.type == "CAMERA" and source.data.type == "PANO":
        from ..foundation.report import ConversionReport

        made = convert_camera(source, scene, scale, ConversionReport())
        return ViewFrame(_resized(made, region))
    return ViewFrame(camera_of_matrices(view, region, scale, source))


def camera_of_matrices(view, region, scale: float, source=None) -> Camera:
    """Camera from a view's matrices, which hold shift, zoom and clipping too.

    Parameters
    ----------
    view : bpy.types.RegionView3D
    region : bpy.types.Region    For its size.
    scale : float    Metres per Blender unit.
    source : bpy.types.Object or None    The camera that is looked through, for its lens.
    """
    frame = np.array(view.view_matrix.inverted(), dtype=np.float64)
    frame[:3, :3] /= np.maximum(np.linalg.norm(frame[:3, :3], axis=0), 1e-30)
    frame[:3, 3] *= scale
    window = np.array(view.window_matrix, dtype=np.float64)
    common = {"frame": frame, "width": region.width, "height": region.height}
    if abs(window[3, 2]) < 0.5:
        # Orthographic: x_ndc = w00 x + w03, z_ndc = w22 z + w23.
        return Camera(
            projection=Projection.ORTHOGRAPHIC,
            extent_x=2.0 / window[0, 0] * scale,
            extent_y=2.0 / window[1, 1] * scale,
            shift_x=-window[0, 3] / window[0, 0] * scale,
            shift_y=-window[1, 3] / window[1, 1] * scale,
            clip_start=(1.0 + window[2, 3]) / window[2, 2] * scale,
            **common,
        )
    # Perspective: x_ndc = (w00 x + w02 z) / -z.
    lens = lens_of(source, source.data, scale) if source is not None else {}
    return Camera(
        projection=Projection.PERSPECTIVE,
        extent_x=2.0 / window[0, 0],
        extent_y=2.0 / window[1, 1],
        shift_x=window[0, 2] / window[0, 0],
        shift_y=window[1, 2] / window[1, 1],
        clip_start=window[2, 3] / (window[2, 2] - 1.0) * scale,
        **lens,
        **common,
    )


def _resized(camera: Camera, region) -> Camera:
    from dataclasses import replace

    return replace(camera, width=region.width, height=region.height)
