"""Settings of the light mix, reached as ``scene.lumenray.light_mix``."""

from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
)
from bpy.types import PropertyGroup

from ..foundation.settings import redraw_views
from . import light_mix


class LumenrayGroupLevel(PropertyGroup):
    """One light group of pictures, dimmed and coloured without rendering anew. Its ``name`` is the group's."""

    is_on: BoolProperty(
        name="On",
        description="Whether the lights of this group shine in the mix. Default on: as in the scene",
        default=True,
        update=light_mix.changed,
    )
    factor: FloatProperty(
        name="Factor",
        description=(
            "Factor on the luminous flux of this group's lights: 0.5 is half their lumens, exactly as if they were "
            "dimmed before the render. Default 1: the flux that the scene states"
        ),
        default=1.0,
        min=0.0,
        max=1000.0,
        soft_max=2.0,
        subtype="FACTOR",
        update=light_mix.changed,
    )
    colour: FloatVectorProperty(
        name="Colour",
        description=(
            "Colour that the light of this group is seen through, as a linear colour; only its hue counts, the flux "
            "stays. It acts on the picture, not on spectra. Default white: the colour that was rendered"
        ),
        subtype="COLOR",
        size=3,
        default=(1.0, 1.0, 1.0),
        min=0.0,
        max=1.0,
        update=light_mix.changed,
    )


class LumenrayLightingScene(PropertyGroup):
    """Levels of all light groups under a name, such as day, evening or emergency. Its ``name`` is for people."""

    rows: CollectionProperty(type=LumenrayGroupLevel)


class LumenrayLightMixSettings(PropertyGroup):
    """Which light groups pictures and views keep apart, and how they are mixed."""

    groups: EnumProperty(
        name="Light Groups",
        description=(
            "Whose light pictures and rendered views keep apart, to be mixed without new samples. Default None: the "
            "groups share the samples, so that each is noisier"
        ),
        items=[
            ("NONE", "None", "All light together", 0),
            (
                "GROUPS",
                "Each Group",
                "Each light group that lights name, and the others together",
                1,
            ),
            ("EACH", "Each Luminaire", "Each light, glowing material and the sky", 2),
        ],
        default="NONE",
        update=redraw_views,
    )
    rows: CollectionProperty(type=LumenrayGroupLevel)
    row_index: IntProperty(name="Active Group", description="Group whose light is told", min=0)
    scenes: CollectionProperty(type=LumenrayLightingScene)
    scene_index: IntProperty(
        name="Active Lighting Scene", description="Lighting scene that buttons are about", min=0
    )


CLASSES = (LumenrayGroupLevel, LumenrayLightingScene, LumenrayLightMixSettings)
