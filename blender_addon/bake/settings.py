"""Settings of bakes, reached as ``scene.lumenray.bake``, and of how baked light is shown, as ``scene.lumenray.look``."""

from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ..foundation.settings import PATH_OPTIONS, percentage, tag_owner


class LumenrayBakeSettings(PropertyGroup):
    """What a bake is asked for. Those that the engine's `BakeOrder` has by the same name go into it as they are."""

    density: FloatProperty(
        name="Lumels per Metre",
        description=(
            "Resolution of lux maps on the surface in lumels per metre, whatever the units of the scene; the one "
            "knob of the layout. Default 8: lumels of 12.5 cm show shadows of furniture"
        ),
        default=8.0,
        min=0.01,
        max=1000.0,
        soft_max=100.0,
    )
    from_textures: BoolProperty(
        name="Match Textures",
        description=(
            "Raise the density of surfaces with pictures to that of the pictures. Default off: light changes less "
            "than pictures do"
        ),
        default=False,
    )
    largest: IntProperty(
        name="Page Size",
        description="Side of the largest atlas page in lumels. Default 2048: every graphics card takes it",
        default=2048,
        min=32,
        max=8192,
    )
    pages: IntProperty(
        name="Most Pages",
        description=(
            "Largest number of pages, to which all charts shrink alike, which is reported. Default 0: as many as it "
            "takes"
        ),
        default=0,
        min=0,
        max=1000,
    )
    margin: IntProperty(
        name="Margin",
        description=(
            "Number of lumels by which charts are extended so that no seam shows. Default 4: enough for views at a "
            "quarter of the size"
        ),
        default=4,
        min=1,
        max=64,
    )
    cone: FloatProperty(
        name="Cone Angle",
        description=(
            "Largest angle between a chart's direction and the normals of its faces; smaller distorts less. Default "
            "57°: lumels stretch to less than twice their length"
        ),
        default=1.0,
        min=0.05,
        max=1.5,
        subtype="ANGLE",
    )
    detail: FloatProperty(
        name="Detail Threshold",
        description=(
            "Charts whose neighbouring lumels differ by less than this share of the mean illuminance get half the "
            "density after a first pass. Default 0: all keep their density"
        ),
        default=0.0,
        min=0.0,
        max=1.0,
        precision=3,
        subtype="FACTOR",
    )
    layers: EnumProperty(
        name="Layers",
        description=(
            "Whose share of the illuminance is kept apart, to be dimmed and recoloured after the bake. Default "
            "None: each layer takes memory"
        ),
        items=[
            ("NONE", "None", "All light together", 0),
            ("GROUPS", "Light Groups", "A layer for each light group that lights name", 1),
            ("EACH", "Each Luminaire", "A layer for each light, glowing material and the sky", 2),
        ],
        default="NONE",
    )
    exitance: BoolProperty(
        name="Exitance in Colour",
        description=(
            "Also compute the light that leaves the surfaces, in colour, for real-time views and glTF. Default off: "
            "lux need no colours"
        ),
        default=False,
    )
    denoise: BoolProperty(
        name="Denoise Exitance",
        description=(
            "Let Open Image Denoise, which comes with the extension Lumenray Denoiser, take the noise out of the "
            "exitance; lux stay as computed. Default off: what is seen is what was computed"
        ),
        default=False,
    )
    isolux: BoolProperty(
        name="Isolux Lines",
        description=(
            "Also draw the lux maps with lines of equal illuminance, as PNG and as SVG. Default off: the maps have their "
            "false colours"
        ),
        default=False,
    )
    method: EnumProperty(
        name="Method",
        description=(
            "What stands for the radiance beyond the first bounce. Default Automatic: fast where that is exact"
        ),
        items=[
            ("AUTO", "Automatic", "What suits the scene; the report says which and why", 0),
            ("CELLS", "Cells", "Radiance kept on coarse cells: fast; its bias is measured", 1),
            ("PATHS", "Paths", "Paths to their end: no bias at all, much slower", 2),
        ],
        default="AUTO",
    )
    caustics: EnumProperty(
        name="Caustics",
        description=(
            "Whether light is also traced from the lights, through glass and off curved mirrors. Default Automatic: "
            "it takes time only where it counts"
        ),
        items=[
            ("AUTO", "Automatic", "Where the scene has what bends light", 0),
            ("ON", "On", "Always", 1),
            ("OFF", "Off", "Never; such light is missing then", 2),
        ],
        default="AUTO",
    )
    use_error: BoolProperty(
        name="Relative Error",
        description="Stop at a relative standard error. Default on: the answer is as good as you ask for",
        default=True,
    )
    error: FloatProperty(
        name="Relative Error",
        description=(
            "Standard error of all lumels together, divided by the mean, as a share. Default 0.02: 2 %, less than "
            "lamps and meters differ by"
        ),
        default=0.02,
        min=0.0001,
        max=1.0,
        precision=4,
    )
    error_percent: percentage(
        "error",
        "Relative Error",
        "Standard error of all lumels together, divided by the mean. Default 2 %: less than lamps and meters differ by",
    )
    use_absolute: BoolProperty(
        name="Absolute Error",
        description="Stop at a standard error in lx. Default off: the relative error counts",
        default=False,
    )
    absolute: FloatProperty(
        name="Absolute Error",
        description="Standard error of all lumels together, in lx. Default 5: 1 % of the 500 lx of an office",
        default=5.0,
        min=1e-6,
        max=1e9,
        soft_max=1000.0,
    )
    use_time: BoolProperty(
        name="Time",
        description="Stop after a time, whatever the error is then. Default off: the error ends a bake",
        default=False,
    )
    time: FloatProperty(
        name="Time",
        description=(
            "Time of baking in seconds, an interrupted bake's earlier time included. Default 600: ten minutes "
            "suffice for most rooms"
        ),
        default=600.0,
        min=0.1,
        max=1e7,
        subtype="TIME_ABSOLUTE",
    )
    use_samples: BoolProperty(
        name="Samples",
        description="Stop after a number of samples per lumel. Default off: the error ends a bake",
        default=False,
    )
    samples: IntProperty(
        name="Samples",
        description=(
            "Number of samples per lumel, on the mean of all. Default 1024: more than most rooms need for 1 %"
        ),
        default=1024,
        min=2,
        max=1 << 20,
    )
    use_checkpoint: BoolProperty(
        name="Keep Progress",
        description=(
            "Write the state into the folder from time to time, so that an interrupted bake can go on. Default on: "
            "no work is lost"
        ),
        default=True,
    )
    overwrite: BoolProperty(
        name="Overwrite Other Bakes",
        description=(
            "Write into the folder whatever it holds; else a bake of other objects or settings goes to a folder "
            "with the next number. Default off: no result is lost"
        ),
        default=False,
    )
    use_gltf: BoolProperty(
        name="glTF",
        description=(
            "Also write the baked objects with their light as baked.glb, for viewers on the web. Default off: only "
            "such viewers need it"
        ),
        default=False,
    )
    gltf_textures: IntProperty(
        name="Most Textures",
        description=(
            "Largest number of textures in the glTF file, both looks together; pages are put together to keep to "
            "it. Default 16: every browser takes so many"
        ),
        default=16,
        min=1,
        soft_max=64,
    )
    gltf_size: IntProperty(
        name="Texture Size",
        description=(
            "Largest side of a texture of the glTF file in pixels; larger pages are halved. Default 2048: "
            "telephones take it too"
        ),
        default=2048,
        min=1,
        max=16384,
        subtype="PIXEL",
    )
    folder: StringProperty(
        name="Folder",
        description="Where lux maps are written as EXR; empty: lux_ and the file's name, beside the file",
        subtype="DIR_PATH",
        options=PATH_OPTIONS,
    )


class LumenrayBakedLayer(PropertyGroup):
    """One light group of the baked light, dimmed and coloured without computing anew. Its ``name`` is the group's."""

    strength: FloatProperty(
        name="Strength",
        description="Factor on the light of this group. Default 1: it shines as it was baked",
        default=1.0,
        min=0.0,
        max=1000.0,
        soft_max=2.0,
        subtype="FACTOR",
        update=tag_owner,
    )
    colour: FloatVectorProperty(
        name="Colour",
        description=(
            "Colour of this group's light as a linear colour; it never changes the amount of light. Default white: "
            "it shines as it was baked"
        ),
        subtype="COLOR",
        size=3,
        default=(1.0, 1.0, 1.0),
        min=0.0,
        max=1.0,
        update=tag_owner,
    )


class LumenrayLookSettings(PropertyGroup):
    """How baked light is shown."""

    is_shown: BoolProperty(
        name="Baked Light Shown",
        description="Whether materials show baked light in EEVEE and material preview",
        options={"HIDDEN"},
    )
    kind: EnumProperty(
        name="Look",
        description="How baked light is shown. Default Light: as an eye would see it",
        items=[
            ("LIGHT", "Light", "Base colour times illuminance, dimmed and coloured by layers", 0),
            ("EXITANCE", "Exitance", "The light that leaves the surfaces, as baked in colour", 1),
            (
                "FALSE",
                "False Colours",
                "Illuminance in lx on a scale; needs the view transform Standard",
                2,
            ),
        ],
        default="LIGHT",
        update=tag_owner,
    )
    low: FloatProperty(
        name="From",
        description=(
            "Illuminance at the lower end of the false colours, in lx. Default 0: the scale begins with darkness"
        ),
        default=0.0,
        min=0.0,
        max=1e9,
        update=tag_owner,
    )
    high: FloatProperty(
        name="To",
        description=(
            "Illuminance at the upper end of the false colours, in lx. Default 1000: twice the 500 lx of EN 12464-1 "
            "for offices"
        ),
        default=1000.0,
        min=1e-6,
        max=1e9,
        update=tag_owner,
    )
    figure: StringProperty(
        name="Figure",
        description="Which figure of a year is shown in place of baked light; empty: none",
        options={"HIDDEN"},
    )
    unit: StringProperty(
        name="Unit",
        description="Of the ends of the false colours",
        default="lx",
        options={"HIDDEN"},
    )
    lux_low: FloatProperty(
        name="From",
        description="Lower end of the scale for illuminance while a figure is shown, in lx",
        options={"HIDDEN"},
    )
    lux_high: FloatProperty(
        name="To",
        description="Upper end of the scale for illuminance while a figure is shown, in lx",
        default=1000.0,
        options={"HIDDEN"},
    )
    layers: CollectionProperty(type=LumenrayBakedLayer)
    layer_index: IntProperty(
        name="Active Layer", description="Layer whose settings are shown", min=0
    )


CLASSES = (LumenrayBakeSettings, LumenrayBakedLayer, LumenrayLookSettings)
