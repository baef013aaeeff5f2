"""What the user can set: one property group per kind of data-block, reached as ``data.lumenray``."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ..engine.photometry import units
from ..libraries import spectra
from .bake import tables as baked_tables
from .foundation.settings import PATH_OPTIONS, SpectrumSettings, enum_from_names, tag_owner
from .luminaires.settings import LumenrayEmptySettings, LumenrayLuminaireSettings
from .raysets.settings import LumenrayRaysetSettings
from .scattering.settings import LumenrayMeasuredSettings
from .sky import SOURCES, LumenraySkySettings


def _identity():
    """Property of the identity; `identity` alone writes it."""
    return StringProperty(name="Identity", options={"HIDDEN"})


def _redraw(self, context):
    """Draw the 3D views again: what they show depends on the property, the scene does not."""
    for window in context.window_manager.windows if context.window_manager else ():
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def _redraw_all(self, context):
    """As `_redraw`, and have drivers of the baked look evaluated: they read the property."""
    _redraw(self, context)
    if self.id_data.lumenray.is_baked_shown:
        tag_owner(self, context)


def _follow_override(self, context):
    """Show the look of a measured material, or what the material was before."""
    from .scattering.look_nodes import follow_override

    follow_override(self.id_data)
    tag_owner(self, context)


def _switch_physical(self, context):
    """Let physical parameters start with what the light gives, not with a number of their own."""
    from . import light_amount

    settle = light_amount.start if self.use_physical else light_amount.forget
    settle(self.id_data, context.scene)
    tag_owner(self, context)


def _percentage(name: str, title: str, description: str):
    """Property that shows a share, which scripts and files have, in per cent."""

    def read(self):
        return 100.0 * getattr(self, name)

    def write(self, value):
        setattr(self, name, 0.01 * value)

    return FloatProperty(
        name=title,
        description=description,
        min=0.01,
        max=100.0,
        soft_max=10.0,
        precision=2,
        subtype="PERCENTAGE",
        get=read,
        set=write,
        options={"SKIP_SAVE"},
    )


def _has_density(self):
    return self.density > 0.0


def _state_density(self, is_own):
    """Begin with the scene's density, and end with none of the object's own."""
    self.density = bpy.context.scene.lumenray.bake_density if is_own else 0.0


def _light_group(of: str):
    """Property that names the layer of a bake that a light belongs to."""
    return StringProperty(
        name="Light Group",
        description=f"Layer of lux maps that {of} belongs to; all without a group share one layer",
        maxlen=63,
    )


QUANTITIES = [
    ("LUMINOUS_FLUX", "Luminous Flux [lm]", "Total light emitted, in lumens", 0),
    ("LUMINOUS_INTENSITY", "Luminous Intensity [cd]", "On the axis of the light, in candelas", 1),
    (
        "ILLUMINANCE",
        "Illuminance [lx]",
        "At 1 m on the axis; for a sun on a plane that faces it",
        2,
    ),
    ("LUMINANCE", "Luminance [cd/m²]", "Of the luminous surface of an area light", 3),
    (
        "RADIANT_FLUX",
        "Radiant Flux [W]",
        "Optical watts between 360 and 830 nm, not electrical watts; for a sun W/m²",
        4,
    ),
]


class LumenrayLightSettings(SpectrumSettings, PropertyGroup):
    """Physical parameters of a light; ignored while `use_physical` is off."""

    version: IntProperty(default=1, options={"HIDDEN"})
    uid: _identity()
    use_physical: BoolProperty(
        name="Physical Parameters",
        description=(
            "State this light in photometric units instead of Blender's watts; it starts with what the light gives now"
        ),
        default=False,
        update=_switch_physical,
    )
    quantity: EnumProperty(
        name="Quantity",
        description="What the value means",
        items=QUANTITIES,
        default="LUMINOUS_FLUX",
        update=tag_owner,
    )
    value: FloatProperty(
        name="Value",
        description="Amount of light in the unit of the quantity",
        default=1000.0,
        min=0.0,
        max=1e12,
        soft_max=100000.0,
        update=tag_owner,
    )
    tube_length: FloatProperty(
        name="Tube Length",
        description=(
            "Length of a straight tube along the light's X axis, with dark ends; 0 is a ball, which is what Blender's own "
            "renders show in any case"
        ),
        default=0.0,
        min=0.0,
        soft_max=10.0,
        subtype="DISTANCE",
        unit="LENGTH",
        update=tag_owner,
    )
    luminaire: PointerProperty(type=LumenrayLuminaireSettings)
    rayset: PointerProperty(type=LumenrayRaysetSettings)
    light_group: _light_group("this light")


class LumenrayMaterialSettings(SpectrumSettings, PropertyGroup):
    """Physical override of a material; the node tree is used while `use_override` is off."""

    version: IntProperty(default=1, options={"HIDDEN"})
    uid: _identity()
    use_override: BoolProperty(
        name="Physical Override",
        description="Use these measurable parameters in place of the node tree",
        default=False,
        update=_follow_override,
    )
    model: EnumProperty(
        name="Model",
        description="Kind of surface",
        items=[
            ("DIFFUSE", "Diffuse", "Matt reflection and, if set, diffuse transmission", 0),
            ("COATED", "Coated", "Matt base under a clear gloss coat: paint, plastic, varnish", 1),
            ("CONDUCTOR", "Metal", "Metal by its complex refractive index", 2),
            ("DIELECTRIC", "Solid Glass", "Transparent body that refracts", 3),
            ("THIN_GLASS", "Pane", "Thin sheet of glass as one surface", 4),
            ("EMITTER", "Emitter", "Luminous surface, black by itself", 5),
            ("MEASURED", "Measured", "Scattering measured or computed: a BRDF or BTDF file", 6),
        ],
        default="DIFFUSE",
        update=_follow_override,
    )
    reflectance_source: EnumProperty(
        name="Reflectance From",
        description="Where the reflectance comes from",
        items=[
            ("VALUE", "Value", "The same at all wavelengths", 0),
            ("COLOR", "Colour", "Upsampled from a linear colour", 1),
            ("FILE", "File", "Spectral reflectance from a file", 2),
        ],
        default="VALUE",
        update=tag_owner,
    )
    reflectance: FloatProperty(
        name="Reflectance",
        description="Diffuse reflectance, 0 to 1",
        default=0.5,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=tag_owner,
    )
    reflectance_color: FloatVectorProperty(
        name="Colour",
        description="Diffuse reflectance as a linear colour",
        subtype="COLOR",
        size=3,
        default=(0.5, 0.5, 0.5),
        min=0.0,
        max=1.0,
        update=tag_owner,
    )
    reflectance_file: StringProperty(
        name="Reflectance File",
        description="Text or CSV with wavelength [nm] and reflectance 0..1, or .spdx",
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
        update=tag_owner,
    )
    transmittance: FloatProperty(
        name="Transmittance",
        description="Diffuse transmittance of a matt sheet; internal transmittance of a pane",
        default=0.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=tag_owner,
    )
    pane_source: EnumProperty(
        name="Pane From",
        description="How the pane is stated",
        items=[
            ("GLASS", "Glass", "Refractive index and internal transmittance of clear glass", 0),
            ("FILE", "Data Sheet", "Table of transmittance and reflectance by angle", 1),
        ],
        default="GLASS",
        update=tag_owner,
    )
    pane_file: StringProperty(
        name="Data Sheet",
        description="Text or CSV with angle to the normal [degree], transmittance 0..1 and reflectance 0..1",
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
        update=tag_owner,
    )
    roughness: FloatProperty(
        name="Roughness",
        description="0 is a mirror; the microfacet width is its square, as in Blender",
        default=0.2,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=tag_owner,
    )
    ior_source: EnumProperty(
        name="Refractive Index From",
        description="How the refractive index is stated",
        items=[
            ("CONSTANT", "Value", "The same at all wavelengths", 0),
            ("CAUCHY", "Cauchy", "n = A + B / wavelength², wavelength in micrometres", 1),
            ("FILE", "File", "Table of wavelength [nm] and index", 2),
        ],
        default="CONSTANT",
        update=tag_owner,
    )
    ior: FloatProperty(
        name="Refractive Index",
        description="Index at all wavelengths, or Cauchy's A",
        default=1.5,
        min=1.0,
        max=4.0,
        precision=4,
        update=tag_owner,
    )
    cauchy_b: FloatProperty(
        name="Cauchy B",
        description="Dispersion in µm²: about 0.0042 for crown glass, 0.0134 for dense flint",
        default=0.0042,
        min=0.0,
        max=0.1,
        precision=5,
        update=tag_owner,
    )
    ior_file: StringProperty(
        name="Index File",
        description="Text or CSV with wavelength [nm] and refractive index",
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
        update=tag_owner,
    )
    metal: EnumProperty(
        name="Metal",
        description="Complex refractive index by name",
        items=enum_from_names(spectra.conductor_names()),
        update=tag_owner,
    )
    luminance: FloatProperty(
        name="Luminance",
        description="Luminance of the emitting surface in cd/m²",
        default=1000.0,
        min=0.0,
        max=1e10,
        soft_max=50000.0,
        update=tag_owner,
    )
    two_sided: BoolProperty(
        name="Both Sides Emit",
        description="Off: only the side that the normal points to",
        default=True,
        update=tag_owner,
    )
    measured: PointerProperty(type=LumenrayMeasuredSettings)
    light_group: _light_group("what glows with this material")


class LumenrayWorldSettings(PropertyGroup):
    """Where the light from outside comes from, and what the numbers in the world's background mean."""

    version: IntProperty(default=1, options={"HIDDEN"})
    uid: _identity()
    source: EnumProperty(
        name="Sky",
        description="What the scene is surrounded by",
        items=SOURCES,
        default="NODES",
        update=tag_owner,
    )
    sky: PointerProperty(type=LumenraySkySettings)
    unit: EnumProperty(
        name="Unit",
        description="What colour times strength of the background stands for",
        items=[
            ("BLENDER", "Blender", "Radiance in W/(m² sr), times the scene's lumens per watt", 0),
            ("LUMINANCE", "cd/m²", "Luminance: a white pixel times the strength, in cd/m²", 1),
            (
                "ILLUMINANCE",
                "lx",
                "Scale the background so that the upper half gives this horizontal illuminance",
                2,
            ),
        ],
        default="BLENDER",
        update=tag_owner,
    )
    illuminance: FloatProperty(
        name="Horizontal Illuminance",
        description="On an unobstructed horizontal plane, in lx",
        default=10000.0,
        min=0.0,
        max=1e6,
        update=tag_owner,
    )
    light_group: _light_group("the surroundings, without Sun lights,")


class LumenrayObjectSettings(PropertyGroup):
    """Per-object settings of the bake, and the luminaire that an empty is."""

    version: IntProperty(default=1, options={"HIDDEN"})
    uid: _identity()
    density: FloatProperty(
        name="Lumels per Metre",
        description="Density of this object's lux map, per metre whatever the units of the scene; 0 takes the scene's",
        default=0.0,
        min=0.0,
        max=1000.0,
        update=tag_owner,
    )
    use_density: BoolProperty(
        name="Own Density",
        description="Give this object's lux map another density than the scene's",
        get=_has_density,
        set=_state_density,
    )
    two_sided: BoolProperty(
        name="Both Sides",
        description="Compute the back sides of this object's faces too, as for a sheet that is lit from both sides",
        default=False,
        update=tag_owner,
    )
    light_group: _light_group("this luminaire")
    baked_image: PointerProperty(
        name="Lux Atlas",
        description="Image with the illuminance of this object",
        type=bpy.types.Image,
    )
    baked_uv: StringProperty(
        name="UV Map of the Atlas", description="UV map by which the atlas lies on this object"
    )
    baked_back_uv: StringProperty(
        name="UV Map of the Back", description="UV map by which the atlas lies on the back sides"
    )
    luminaire: PointerProperty(type=LumenrayEmptySettings)
    is_luminaire_body: BoolProperty(
        name="Luminaire Body",
        description="Shows where a luminaire is; no part of the light calculation, so that it cannot block its own light",
        default=False,
        update=tag_owner,
    )


class LumenrayTextSettings(PropertyGroup):
    """What a text data-block remembers of the photometric file that it was made of."""

    version: IntProperty(default=1, options={"HIDDEN"})
    digest: StringProperty(
        name="Content Hash",
        description="SHA-256 of the bytes of the photometric file; empty if the text is none",
        options={"HIDDEN"},
    )
    encoding: StringProperty(
        name="Encoding",
        description="How the file's bytes stand for its text",
        default="utf-8",
        options={"HIDDEN"},
    )


class LumenrayCameraSettings(PropertyGroup):
    """Identity of a camera."""

    version: IntProperty(default=1, options={"HIDDEN"})
    uid: _identity()


class LumenrayBakedLayer(PropertyGroup):
    """One light group of the baked light, dimmed and coloured without computing anew. Its ``name`` is the group's."""

    strength: FloatProperty(
        name="Strength",
        description="Factor on the light of this group; 1 is as baked",
        default=1.0,
        min=0.0,
        max=1000.0,
        soft_max=2.0,
        subtype="FACTOR",
        update=tag_owner,
    )
    colour: FloatVectorProperty(
        name="Colour",
        description="Colour of this group's light as a linear colour; it never changes the amount of light",
        subtype="COLOR",
        size=3,
        default=(1.0, 1.0, 1.0),
        min=0.0,
        max=1.0,
        update=tag_owner,
    )


class LumenraySceneSettings(PropertyGroup):
    """Render, bake and film settings."""

    version: IntProperty(default=1, options={"HIDDEN"})

    stop: EnumProperty(
        name="Stop By",
        description="When the render is done",
        items=[
            ("SAMPLES", "Samples", "After a number of samples per pixel", 0),
            ("ERROR", "Error", "When the picture's relative standard error is reached", 1),
            ("TIME", "Time", "After a time", 2),
        ],
        default="SAMPLES",
    )
    samples: IntProperty(
        name="Samples",
        description="Paths per pixel",
        default=64,
        min=2,
        max=1 << 20,
    )
    error: FloatProperty(
        name="Relative Error",
        description="Standard error of the pixels relative to their luminance, dark ones to the mean",
        default=0.02,
        min=0.0001,
        max=1.0,
        precision=4,
    )
    error_percent: _percentage(
        "error",
        "Error",
        "Standard error of the pixels relative to their luminance, dark ones to the mean",
    )
    time: FloatProperty(
        name="Time",
        description="Time of rendering",
        default=60.0,
        min=0.1,
        max=1e7,
        subtype="TIME_ABSOLUTE",
    )
    seed: IntProperty(
        name="Seed",
        description="Same seed, same result",
        default=0,
        min=0,
        max=2**31 - 1,
        update=_redraw,
    )
    transport: EnumProperty(
        name="Transport",
        description="What is carried along each path",
        items=[
            ("AUTO", "Automatic", "Photometric if the scene is neutral, else spectral", 0),
            ("MONO", "Photometric", "One number per path; exact only in neutral scenes", 1),
            ("SPECTRAL", "Spectral", "Four wavelengths per path, 360 to 830 nm", 2),
        ],
        default="AUTO",
        update=_redraw,
    )
    efficacy: FloatProperty(
        name="Lumens per Blender Watt",
        description=(
            "Photometric meaning of Blender's own watts, for lights and shaders without physical "
            "parameters: 177.83 lm/W is what Cycles assumes, glTF uses 683"
        ),
        default=units.BLENDER_EFFICACY,
        min=1e-3,
        max=units.LUMINOUS_EFFICACY,
        precision=2,
        update=tag_owner,
    )
    exposure: EnumProperty(
        name="Exposure",
        description="Which luminance becomes 1.0 in the picture",
        items=[
            ("LUMINANCE", "White Luminance", "State the luminance that becomes 1.0", 0),
            ("EV100", "EV at ISO 100", "State the exposure value of a camera", 1),
            ("AUTO", "Automatic", "Set white from the picture itself; never use it to compare", 2),
        ],
        default="LUMINANCE",
        update=_redraw_all,
    )
    white_luminance: FloatProperty(
        name="White Luminance",
        description="Luminance in cd/m² that becomes 1.0",
        default=200.0,
        min=1e-6,
        max=1e9,
        soft_max=20000.0,
        update=_redraw_all,
    )
    ev100: FloatProperty(
        name="EV100",
        description="Exposure value at ISO 100; 8 suits an office, 15 full sun",
        default=8.0,
        min=-20.0,
        max=30.0,
        update=_redraw_all,
    )
    viewport_display: EnumProperty(
        name="Viewport Shows",
        description="What the 3D view shows in rendered shading",
        items=[
            ("PICTURE", "Picture", "In colour, as in the render", 0),
            ("LUMINANCE", "Luminance", "Without colour", 1),
            ("FALSE_LUMINANCE", "False Colours [cd/m²]", "Luminance in cd/m², with a scale", 2),
            (
                "FALSE_ILLUMINANCE",
                "False Colours [lx]",
                "Illuminance of the visible surfaces in lx, with a scale; takes about twice the time",
                3,
            ),
        ],
        default="PICTURE",
        update=_redraw,
    )
    viewport_samples: IntProperty(
        name="Viewport Samples",
        description="Paths per pixel after which the view in rendered shading rests",
        default=256,
        min=2,
        max=1 << 20,
        update=_redraw,
    )
    viewport_automatic: BoolProperty(
        name="Automatic Scale",
        description="Set the top of the scale from the view itself",
        default=True,
        update=_redraw,
    )
    viewport_low: FloatProperty(
        name="From",
        description="Lower end of the scale of false colours, in its unit",
        default=0.0,
        min=0.0,
        max=1e9,
        update=_redraw,
    )
    viewport_high: FloatProperty(
        name="To",
        description="Upper end of the scale of false colours, in its unit",
        default=1000.0,
        min=1e-6,
        max=1e9,
        update=_redraw,
    )
    viewport_logarithmic: BoolProperty(
        name="Logarithmic",
        description="Equal ratios take equal lengths of the scale",
        default=False,
        update=_redraw,
    )
    use_smoothing: BoolProperty(
        name="Smooth Noise",
        description=(
            "Filter the noise of the Combined pass, guided by its own error; all other passes stay as computed"
        ),
        default=False,
    )
    use_spectral_file: BoolProperty(
        name="Spectral EXR",
        description="Write a spectral OpenEXR beside the picture",
        default=False,
    )
    spectral_bands: IntProperty(
        name="Bands",
        description="Number of wavelength bands from 380 to 780 nm",
        default=20,
        min=2,
        max=400,
    )
    use_pass_luminance: BoolProperty(
        name="Luminance", description="Luminance pass in cd/m²", default=True
    )
    use_pass_illuminance: BoolProperty(
        name="Illuminance",
        description="Illuminance of the visible surface in lx; costs about as much as the picture",
        default=False,
    )

    bake_density: FloatProperty(
        name="Lumels per Metre",
        description=(
            "Resolution of lux maps on the surface, per metre whatever the units of the scene; the one knob of the layout"
        ),
        default=8.0,
        min=0.01,
        max=1000.0,
        soft_max=100.0,
    )
    bake_from_textures: BoolProperty(
        name="Match Textures",
        description="Raise the density of surfaces with pictures to that of the pictures",
        default=False,
    )
    bake_size: IntProperty(
        name="Page Size",
        description="Side of the largest atlas page in lumels",
        default=2048,
        min=32,
        max=8192,
    )
    bake_pages: IntProperty(
        name="Most Pages",
        description="All charts shrink alike to fit on so many pages, which is reported; 0: as many as it takes",
        default=0,
        min=0,
        max=1000,
    )
    bake_margin: IntProperty(
        name="Margin",
        description="Lumels by which charts are extended so that no seam shows",
        default=4,
        min=1,
        max=64,
    )
    bake_cone: FloatProperty(
        name="Cone Angle",
        description="Largest angle between a chart's direction and the normals of its faces; smaller distorts less",
        default=1.0,
        min=0.05,
        max=1.5,
        subtype="ANGLE",
    )
    bake_detail: FloatProperty(
        name="Detail Threshold",
        description=(
            "Charts whose neighbouring lumels differ by less than this share of the mean illuminance get half the "
            "density after a first pass; 0: none do"
        ),
        default=0.0,
        min=0.0,
        max=1.0,
        precision=3,
        subtype="FACTOR",
    )
    bake_layers: EnumProperty(
        name="Layers",
        description="Whose share of the illuminance is kept apart, to be dimmed and recoloured after the bake",
        items=[
            ("NONE", "None", "All light together", 0),
            ("GROUPS", "Light Groups", "A layer for each light group that lights name", 1),
            ("EACH", "Each Luminaire", "A layer for each light, glowing material and the sky", 2),
        ],
        default="NONE",
    )
    bake_exitance: BoolProperty(
        name="Exitance in Colour",
        description="Also compute the light that leaves the surfaces, in colour, for real-time views and glTF",
        default=False,
    )
    bake_smooth: BoolProperty(
        name="Smooth Maps",
        description="Smooth within charts after the error is known; the result says that it was done",
        default=False,
    )
    bake_method: EnumProperty(
        name="Method",
        description="What stands for the radiance beyond the first bounce",
        items=[
            ("AUTO", "Automatic", "What suits the scene; the report says which and why", 0),
            ("CELLS", "Cells", "Radiance kept on coarse cells: fast; its bias is measured", 1),
            ("PATHS", "Paths", "Paths to their end: no bias at all, much slower", 2),
        ],
        default="AUTO",
    )
    bake_caustics: EnumProperty(
        name="Caustics",
        description="Whether light is also traced from the lights, through glass and off curved mirrors",
        items=[
            ("AUTO", "Automatic", "Where the scene has what bends light", 0),
            ("ON", "On", "Always", 1),
            ("OFF", "Off", "Never; such light is missing then", 2),
        ],
        default="AUTO",
    )
    bake_use_error: BoolProperty(
        name="Relative Error", description="Stop at a relative standard error", default=True
    )
    bake_error: FloatProperty(
        name="Relative Error",
        description="Standard error of all lumels together, divided by the mean: 0.02 is 2 %",
        default=0.02,
        min=0.0001,
        max=1.0,
        precision=4,
    )
    bake_error_percent: _percentage(
        "bake_error",
        "Relative Error",
        "Standard error of all lumels together, divided by the mean",
    )
    bake_use_absolute: BoolProperty(
        name="Absolute Error", description="Stop at a standard error in lx", default=False
    )
    bake_absolute: FloatProperty(
        name="Absolute Error",
        description="Standard error of all lumels together, in lx",
        default=5.0,
        min=1e-6,
        max=1e9,
        soft_max=1000.0,
    )
    bake_use_time: BoolProperty(name="Time", description="Stop after a time", default=False)
    bake_time: FloatProperty(
        name="Time",
        description="Time of baking, an interrupted bake's earlier time included",
        default=600.0,
        min=0.1,
        max=1e7,
        subtype="TIME_ABSOLUTE",
    )
    bake_use_samples: BoolProperty(
        name="Samples", description="Stop after a number of samples per lumel", default=False
    )
    bake_samples: IntProperty(
        name="Samples",
        description="Samples per lumel, on the mean of all",
        default=1024,
        min=2,
        max=1 << 20,
    )
    bake_checkpoint: BoolProperty(
        name="Keep Progress",
        description="Write the state into the folder from time to time, so that an interrupted bake can go on",
        default=True,
    )
    bake_overwrite: BoolProperty(
        name="Overwrite Other Bakes",
        description=(
            "Write into the folder whatever it holds; else a bake of other objects or settings goes to a folder with the "
            "next number"
        ),
        default=False,
    )
    bake_gltf: BoolProperty(
        name="glTF",
        description="Also write the baked objects with their light as baked.glb, for viewers on the web",
        default=False,
    )
    bake_gltf_textures: IntProperty(
        name="Most Textures",
        description="Textures that the glTF file may have, both looks together; pages are put together to keep to it",
        default=16,
        min=1,
        soft_max=64,
    )
    bake_gltf_size: IntProperty(
        name="Texture Size",
        description="Largest side of a texture of the glTF file; larger pages are halved",
        default=2048,
        min=1,
        max=16384,
        subtype="PIXEL",
    )
    bake_folder: StringProperty(
        name="Folder",
        description="Where lux maps are written as EXR; empty: lux_ and the file's name, beside the file",
        subtype="DIR_PATH",
        options=PATH_OPTIONS,
    )

    is_baked_shown: BoolProperty(
        name="Baked Light Shown",
        description="Whether materials show baked light in EEVEE and material preview",
        options={"HIDDEN"},
    )
    baked_look: EnumProperty(
        name="Look",
        description="How baked light is shown",
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
    baked_low: FloatProperty(
        name="From",
        description="Illuminance at the lower end of the false colours, in lx",
        default=0.0,
        min=0.0,
        max=1e9,
        update=tag_owner,
    )
    baked_high: FloatProperty(
        name="To",
        description="Illuminance at the upper end of the false colours, in lx",
        default=1000.0,
        min=1e-6,
        max=1e9,
        update=tag_owner,
    )
    baked: PointerProperty(type=baked_tables.LumenrayBakedResults)
    baked_layers: CollectionProperty(type=LumenrayBakedLayer)
    baked_layer_index: IntProperty(
        name="Active Layer", description="Layer whose settings are shown", min=0
    )


CLASSES = (
    LumenrayLuminaireSettings,
    LumenrayEmptySettings,
    LumenrayTextSettings,
    LumenrayRaysetSettings,
    LumenrayLightSettings,
    LumenrayMeasuredSettings,
    LumenrayMaterialSettings,
    LumenraySkySettings,
    LumenrayWorldSettings,
    LumenrayObjectSettings,
    LumenrayCameraSettings,
    LumenrayBakedLayer,
    *baked_tables.CLASSES,
    LumenraySceneSettings,
)

POINTERS = (
    (bpy.types.Light, LumenrayLightSettings),
    (bpy.types.Material, LumenrayMaterialSettings),
    (bpy.types.World, LumenrayWorldSettings),
    (bpy.types.Object, LumenrayObjectSettings),
    (bpy.types.Camera, LumenrayCameraSettings),
    (bpy.types.Text, LumenrayTextSettings),
    (bpy.types.Scene, LumenraySceneSettings),
)


def attach():
    """Attach the groups to Blender's data-blocks; the classes must be registered."""
    for owner, group in POINTERS:
        owner.lumenray = PointerProperty(type=group)


def detach():
    """Take the groups off again."""
    for owner, _ in POINTERS:
        del owner.lumenray
