"""Evaluation of a material's nodes for rays of one kind: those that carry light, or those of the camera."""

from ...foundation.report import ConversionReport
from ..images.cache import ImageCache
from .evaluation import Context
from .fields import Field, constant

CAMERA_RAYS = "Is Camera Ray"
"""Output of the Light Path node that tells rays of the camera from all others."""

SPLITTING = {"ShaderNodeLightPath", "ShaderNodeHoldout"}
"""Nodes by which the camera may see another surface than light meets."""

UNKNOWN = {"Ray Length", "Transparent Depth"}
"""Outputs of the Light Path node that are not the same for all rays of the camera."""


class RayContext(Context):
    """The conversion of a material, as light meets it or as the camera sees it.

    Parameters
    ----------
    datablock, report, images    As of `Context`.
    is_camera : bool
    """

    def __init__(
        self,
        datablock: str,
        report: ConversionReport,
        images: ImageCache | None = None,
        is_camera: bool = False,
    ):
        super().__init__(datablock, report, images)
        self.is_camera = is_camera

    def take_output(self, at) -> Field | None:
        """Return what a Light Path node gives for these rays; None: it is not known, or the same for all."""
        if at.node.bl_idname != "ShaderNodeLightPath":
            return super().take_output(at)
        name = at.output.identifier
        if name == CAMERA_RAYS:
            return constant(float(self.is_camera))
        return constant(0.0) if self.is_camera and name not in UNKNOWN else None
