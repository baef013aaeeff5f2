"""Tables of the last bake of a scene, as they are kept in the file: property groups, reached as ``scene.lumenray.baked``."""

from bpy.props import (
    BoolProperty,
    CollectionProperty,
    FloatProperty,
    IntProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

UNKNOWN = 1e30
"""Errors and ends of ranges from here on are not known; Blender's numbers have no infinity."""


class LumenrayResultRow(PropertyGroup):
    """One lux map. ``relative_error`` is that of its lumels, ``mean_error`` that of ``mean``."""

    name: StringProperty(name="Name", description="Object that the map lies on")
    mean: FloatProperty(name="Mean", description="Mean over the area, in the unit of the row")
    minimum: FloatProperty(
        name="Minimum",
        description="Smallest value on the surface, without what noise adds, in the unit of the row",
    )
    minimum_low: FloatProperty(
        name="From", description="The smallest value is hardly below this, in the unit of the row"
    )
    minimum_high: FloatProperty(
        name="To", description="The smallest value is hardly above this, in the unit of the row"
    )
    maximum: FloatProperty(
        name="Maximum",
        description="Largest value on the surface, without what noise adds, in the unit of the row",
    )
    maximum_low: FloatProperty(
        name="From", description="The largest value is hardly below this, in the unit of the row"
    )
    maximum_high: FloatProperty(
        name="To", description="The largest value is hardly above this, in the unit of the row"
    )
    uniformity: FloatProperty(
        name="Uniformity", description="Smallest value over the mean, as a share"
    )
    uniformity_low: FloatProperty(
        name="From", description="The uniformity is hardly below this share"
    )
    uniformity_high: FloatProperty(
        name="To", description="The uniformity is hardly above this share"
    )
    mean_error: FloatProperty(
        name="Error of the Mean", description="Standard error of the mean, in the unit of the row"
    )
    relative_error: FloatProperty(
        name="Relative Error",
        description="Standard error of the single values divided by the mean, as a share",
    )
    bias: FloatProperty(
        name="Bias",
        description="What the method adds to the mean on the whole, as measured, in the unit of the row",
    )
    bias_error: FloatProperty(
        name="Error of the Bias", description="Standard error of the bias, in the unit of the row"
    )
    samples: IntProperty(name="Samples", description="Number of samples per lumel")
    lumels: IntProperty(name="Lumels", description="Number of lumels on the surface")
    density: FloatProperty(name="Density", description="Lumels per metre that were reached")
    invalid: IntProperty(
        name="Inside Solids", description="Number of lumels that were filled from their neighbours"
    )
    is_smoothed: BoolProperty(
        name="Smoothed",
        description="Whether an older version smoothed the map after its error was known",
    )
    unit: StringProperty(name="Unit", description="Unit of the values of this row", default="lx")


class LumenrayBakedResults(PropertyGroup):
    """The last bake of a scene: a row for each map, the whole, and what has changed since."""

    rows: CollectionProperty(type=LumenrayResultRow)
    row_index: IntProperty(name="Active Map", description="Map whose details are shown", min=0)
    relative_error: FloatProperty(
        name="Relative Error",
        description="Standard error of all lumels divided by the mean, as a share",
    )
    simplified: FloatProperty(
        name="Simplified",
        description="Largest relative error by what was not modelled, as a share; it is in the error",
    )
    mean: FloatProperty(name="Mean", description="Mean of everything that was baked, in lx")
    seconds: FloatProperty(
        name="Time", description="Time that the bake took, in seconds", subtype="TIME_ABSOLUTE"
    )
    pages: IntProperty(name="Pages", description="Number of pages of the atlas")
    shrink: FloatProperty(
        name="Shrink", description="Factor on all densities that made the charts fit"
    )
    seam_pairs: IntProperty(name="Seam Points", description="Number of places where charts meet")
    seam_before: FloatProperty(name="Steps", description="Steps at seams before matching, in lx")
    seam_after: FloatProperty(name="Steps Left", description="Steps at seams after matching, in lx")
    seam_noise: FloatProperty(
        name="Noise of Steps", description="Standard error of the steps at seams, in lx"
    )
    shortfall: StringProperty(name="Shortfall", description="What of its rule the bake has not met")
    folder: StringProperty(name="Folder", description="Where the files were written")
    scene_hash: StringProperty(
        name="Scene", description="Fingerprint of the scene that was baked", options={"HIDDEN"}
    )
    serial: StringProperty(name="Bake", description="Tells one bake from all others", options={"HIDDEN"})  # fmt: skip
    changed: StringProperty(
        name="Changed", description="What has changed since the bake; empty: nothing"
    )


CLASSES = (LumenrayResultRow, LumenrayBakedResults)
