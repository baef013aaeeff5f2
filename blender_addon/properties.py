"""What the user can set: one property group per kind of data-block, reached as ``data.lumenray``."""

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ..engine.photometry import units
from .bake import settings as bake_settings
from .bake import tables as baked_tables
from .bake.settings import LumenrayBakeSettings, LumenrayLookSettings
from .cloths import settings as cloth_settings
from .daylight import following
from .daylight import settings as daylight_settings
from .daylight.following import follow_edit
from .daylight.settings import (
    LumenrayArcSettings,
    LumenrayPlaceSettings,
    LumenraySunSettings,
    LumenrayTimeSettings,
)
from .daylight_year import settings as year_settings
from .daylight_year.settings import LumenrayYearSettings
from .environment import settings as environment_settings
from .environment.settings import LumenrayEnvironmentSettings
from .foundation.settings import (
    identity_property,
    light_group_property,
    redraw_views,
    tag_owner,
)
from .ground import LumenrayGroundSettings
from .inks import settings as ink_settings
from .light_settings import LumenrayLightSettings
from .luminaires.settings import LumenrayEmptySettings, LumenrayLuminaireSettings
from .material_settings import LumenrayMaterialSettings
from .modelling import settings as modelling_settings
from .modelling.settings import LumenrayModellingSettings
from .paints import settings as paint_settings
from .raysets.settings import LumenrayRaysetSettings
from .rendering import mix_settings
from .rendering import settings as render_settings
from .rendering.mix_settings import LumenrayLightMixSettings
from .rendering.settings import LumenrayRenderSettings, LumenrayViewportSettings
from .reporting import settings as report_settings
from .reporting.settings import LumenrayReportSettings
from .scattering.settings import LumenrayMeasuredSettings
from .sensors import settings as sensor_settings
from .sensors.settings import LumenraySensorSettings, LumenraySensorsSettings
from .sky import SOURCES, LumenraySkySettings


def _redraw_all(self, context):
    """As `redraw_views`, and have drivers of the baked look evaluated: they read the property."""
    redraw_views(self, context)
    if self.id_data.lumenray.look.is_shown:
        tag_owner(self, context)


def _rate_anew(self, context):
    """As `tag_owner`, and have the Sun light that follows the world's time keep its lumens."""
    tag_owner(self, context)
    if self.id_data.world is not None:
        following.follow_world(self.id_data.world)


def _has_density(self):
    return self.density > 0.0


def _state_density(self, is_own):
    """Begin with the scene's density, and end with none of the object's own."""
    self.density = bpy.context.scene.lumenray.bake.density if is_own else 0.0


class LumenrayWorldSettings(PropertyGroup):
    """Where the light from outside comes from, and what the numbers in the world's background mean."""

    uid: identity_property()
    source: EnumProperty(
        name="Sky",
        description="What the scene is surrounded by. Default World Nodes: as Blender shows it",
        items=SOURCES,
        default="NODES",
        update=follow_edit,
    )
    sky: PointerProperty(type=LumenraySkySettings)
    place: PointerProperty(type=LumenrayPlaceSettings)
    time: PointerProperty(type=LumenrayTimeSettings)
    sun: PointerProperty(type=LumenraySunSettings)
    arc: PointerProperty(type=LumenrayArcSettings)
    environment: PointerProperty(type=LumenrayEnvironmentSettings)
    ground: PointerProperty(type=LumenrayGroundSettings)
    unit: EnumProperty(
        name="Unit",
        description=(
            "What colour times strength of the background stands for. Default Blender: your worlds keep their light"
        ),
        items=[
            ("BLENDER", "Blender", "Radiance in W/(m² sr), times the scene's lumens per watt", 0),
            ("LUMINANCE", "cd/m²", "Luminance: a white pixel times the strength, in cd/m²", 1),
            (
                "ILLUMINANCE",
                "lx",
                "Scale the background so that a horizontal plane, or one that faces elsewhere, has this illuminance",
                2,
            ),
            (
                "RADIANCE",
                "Radiance",
                "Radiance in W/(m² sr), times the 179 lm/W by which Radiance reads its own pictures",
                3,
            ),
            ("WHITE", "White", "Luminance of a white pixel times the strength, which you state", 4),
        ],
        default="BLENDER",
        update=tag_owner,
    )
    white: FloatProperty(
        name="White Luminance",
        description=(
            "Luminance that a white pixel, of 1, times the strength stands for, in cd/m². Default 1000: white paper by a "
            "window"
        ),
        default=1000.0,
        min=0.0,
        max=1e9,
        soft_max=1e5,
        update=tag_owner,
    )
    illuminance: FloatProperty(
        name="Horizontal Illuminance",
        description=(
            "On an unobstructed horizontal plane, or on one that faces where the meter did, in lx, bright sources and "
            "a mended sun included. Default 10000: an overcast day"
        ),
        default=10000.0,
        min=0.0,
        max=1e6,
        update=tag_owner,
    )
    light_group: light_group_property("the surroundings, without Sun lights,")


class LumenrayObjectSettings(PropertyGroup):
    """Per-object settings of the bake, and the luminaire or the sensors that an empty is."""

    uid: identity_property()
    density: FloatProperty(
        name="Lumels per Metre",
        description=(
            "Density of this object's lux map in lumels per metre, whatever the units of the scene. Default 0: the "
            "scene's density counts"
        ),
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
        description=(
            "Compute the back sides of this object's faces too, as for a sheet that is lit from both sides. Default "
            "off: of a solid they lie inside"
        ),
        default=False,
        update=tag_owner,
    )
    light_group: light_group_property("this luminaire")
    baked_image: PointerProperty(
        name="Lux Atlas",
        description="Image with the illuminance of this object in lx",
        type=bpy.types.Image,
    )
    baked_uv: StringProperty(
        name="UV Map of the Atlas", description="UV map by which the atlas lies on this object"
    )
    baked_back_uv: StringProperty(
        name="UV Map of the Back", description="UV map by which the atlas lies on the back sides"
    )
    luminaire: PointerProperty(type=LumenrayEmptySettings)
    sensor: PointerProperty(type=LumenraySensorSettings)
    is_luminaire_body: BoolProperty(
        name="Luminaire Body",
        description=(
            "Shows where a luminaire is; no part of the light calculation, so that it cannot block its own light. "
            "Default off: objects are part of the light"
        ),
        default=False,
        update=tag_owner,
    )


class LumenrayTextSettings(PropertyGroup):
    """What a text data-block remembers of the photometric file that it was made of."""

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

    uid: identity_property()


class LumenraySceneSettings(PropertyGroup):
    """Settings of a scene: what pictures, views and bakes share, and a group for each of them."""

    render: PointerProperty(type=LumenrayRenderSettings)
    viewport: PointerProperty(type=LumenrayViewportSettings)
    light_mix: PointerProperty(type=LumenrayLightMixSettings)
    bake: PointerProperty(type=LumenrayBakeSettings)
    baked: PointerProperty(type=baked_tables.LumenrayBakedResults)
    look: PointerProperty(type=LumenrayLookSettings)
    year: PointerProperty(type=LumenrayYearSettings)
    sensors: PointerProperty(type=LumenraySensorsSettings)
    report: PointerProperty(type=LumenrayReportSettings)
    modelling: PointerProperty(type=LumenrayModellingSettings)
    seed: IntProperty(
        name="Seed",
        description=(
            "Number that all random choices follow from: same seed, same result. Default 0: any number will do"
        ),
        default=0,
        min=0,
        max=2**31 - 1,
        update=redraw_views,
    )
    use_cluster: BoolProperty(
        name="Compute on the Cluster",
        description=(
            "Have the workers of your cluster compute pictures, lux maps, sensors and the daylight of a year; live views "
            "and tables of materials stay on this computer. Default off: nothing leaves it"
        ),
        default=False,
    )
    transport: EnumProperty(
        name="Transport",
        description=(
            "What is carried along each path. Default Automatic: wavelengths are carried only where colours need it"
        ),
        items=[
            ("AUTO", "Automatic", "Photometric if the scene is neutral, else spectral", 0),
            ("MONO", "Photometric", "One number per path; exact only in neutral scenes", 1),
            ("SPECTRAL", "Spectral", "Four wavelengths per path, 360 to 830 nm", 2),
        ],
        default="AUTO",
        update=redraw_views,
    )
    efficacy: FloatProperty(
        name="Lumens per Blender Watt",
        description=(
            "Photometric meaning in lm/W of Blender's own watts, for lights and shaders without physical "
            "parameters; glTF uses 683. Default 177.83: what Cycles assumes"
        ),
        default=units.BLENDER_EFFICACY,
        min=1e-3,
        max=units.LUMINOUS_EFFICACY,
        precision=2,
        update=_rate_anew,
    )
    exposure: EnumProperty(
        name="Exposure",
        description=(
            "Which luminance becomes 1.0 in the picture. Default White Luminance: pictures can be compared by eye"
        ),
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
        description=(
            "Luminance in cd/m² that becomes 1.0. Default 200: paper that reflects 80 % has 127 under 500 lx and is "
            "not burnt out"
        ),
        default=200.0,
        min=1e-6,
        max=1e9,
        soft_max=20000.0,
        update=_redraw_all,
    )
    ev100: FloatProperty(
        name="EV100",
        description=(
            "Exposure value at ISO 100, in steps of a factor of two; full sun has 15. Default 8: it suits an office"
        ),
        default=8.0,
        min=-20.0,
        max=30.0,
        update=_redraw_all,
    )


CLASSES = (
    LumenrayLuminaireSettings,
    LumenrayEmptySettings,
    LumenrayTextSettings,
    LumenrayRaysetSettings,
    LumenrayLightSettings,
    LumenrayMeasuredSettings,
    *paint_settings.CLASSES,
    *ink_settings.CLASSES,
    *cloth_settings.CLASSES,
    LumenrayMaterialSettings,
    LumenraySkySettings,
    *daylight_settings.CLASSES,
    *environment_settings.CLASSES,
    *year_settings.CLASSES,
    *sensor_settings.CLASSES,
    LumenrayGroundSettings,
    LumenrayWorldSettings,
    LumenrayObjectSettings,
    LumenrayCameraSettings,
    *render_settings.CLASSES,
    *mix_settings.CLASSES,
    *report_settings.CLASSES,
    *modelling_settings.CLASSES,
    *bake_settings.CLASSES,
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
