"""What the user sets about a ray file: how it is read, how its rays fluctuate, and how much light it gives."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty
from bpy.types import PropertyGroup

from ...engine.errors import LumenrayError
from ..file_assets.settings import settings_of_light, switch
from ..foundation.settings import PATH_OPTIONS, tag_owner
from ..foundation.units import metres_per_unit

AMOUNTS = [
    ("FILE", "File", "The flux that the file states, or that its rays sum up to", 0),
    ("LUMENS", "Lumens", "State the flux; the file gives the places and directions only", 1),
]

SPECTRUM_SOURCES = [
    ("FILE", "File", "The spectrum that the file states; colour of the light without one", 0),
    ("LIGHT", "Own", "The spectrum or colour that is chosen for the light", 1),
]

SYMMETRIES = [
    ("AUTO", "As Found", "Even about an axis where the rays do not speak against it", 0),
    ("ON", "Rotational", "It is known that the light is the same all around its axis", 1),
    ("OFF", "None", "Only what the rays themselves show", 2),
]

UNITS = [
    ("mm", "mm", "Millimetres", 0),
    ("cm", "cm", "Centimetres", 1),
    ("m", "m", "Metres", 2),
    ("inch", "in", "Inches", 3),
]


def _read_spread(self):
    """Spread of the starting points in Blender units, so that it is shown in those of the scene."""
    return 1e-3 * self.width_position / metres_per_unit(bpy.context.scene)


def _write_spread(self, value):
    self.width_position = 1e3 * value * metres_per_unit(bpy.context.scene)


def _keep(self, context):
    """What is ready already is written at once."""
    from .files import ray_files

    if not (self.keep_index and self.filepath):
        return
    try:
        ray_files.keep(self)
    except LumenrayError as error:
        text = str(error)
        self.keep_index = False
        context.window_manager.popup_menu(
            lambda menu, _: menu.layout.label(text=text), title="Not kept", icon="ERROR"
        )


class LumenrayRaysetSettings(PropertyGroup):
    """Ray file of a point, spot or area light, whose own kind, size and beam do not count then."""

    use_file: BoolProperty(
        name="Ray File",
        description=(
            "Shine as the rays of a measured or computed source do, in place of Blender's own light. Switches a "
            "luminaire's photometric file off. Default off: there is no file at first"
        ),
        default=False,
        update=switch,
    )
    filepath: StringProperty(
        name="File",
        description=(
            "Ray file: IES TM-25, Zemax, LightTools, SPEOS, ASAP, TracePro or plain text, told apart by content. "
            "Its +Z is the light's own -Z. 'library:' and a name is one of ours"
        ),
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
        update=tag_owner,
    )
    amount: EnumProperty(
        name="Flux From",
        description="What states the amount of light before dimming. Default File: that is what was measured",
        items=AMOUNTS,
        default="FILE",
        update=tag_owner,
    )
    luminous_flux: FloatProperty(
        name="Luminous Flux",
        description="Flux of the source before dimming, in lumens. Default 100: a small white LED",
        default=100.0,
        min=0.0,
        max=1e9,
        soft_max=10000.0,
        update=tag_owner,
    )
    dimming: FloatProperty(
        name="Dimming",
        description="Share of the full flux that the source is set to, 0 to 1. Default 1: it is not dimmed",
        default=1.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=tag_owner,
    )
    spectrum_source: EnumProperty(
        name="Spectrum From",
        description=(
            "What states how the light is distributed over the wavelengths. Default File: the maker knows it best"
        ),
        items=SPECTRUM_SOURCES,
        default="FILE",
        update=tag_owner,
    )
    symmetry: EnumProperty(
        name="Symmetry",
        description=(
            "Whether every ray stands for all that differ from it by a turn: few rays then tell far more. Default "
            "As Found: the rays themselves decide it"
        ),
        items=SYMMETRIES,
        default="AUTO",
        update=tag_owner,
    )
    use_widths: BoolProperty(
        name="Own Fluctuation",
        description=(
            "State how far new rays differ from those of the file, instead of finding it from their neighbours. "
            "Default off: the neighbours tell it well"
        ),
        default=False,
        update=tag_owner,
    )
    width_position: FloatProperty(
        name="Position",
        description=(
            "Standard deviation of the starting points of new rays from those of the file, in millimetres. Default "
            "0: they start at the same points"
        ),
        default=0.0,
        min=0.0,
        max=1e6,
        precision=4,
        update=tag_owner,
    )
    position_spread: FloatProperty(
        name="Position",
        description="Standard deviation of the starting points of new rays from those of the file",
        min=0.0,
        precision=5,
        subtype="DISTANCE",
        get=_read_spread,
        set=_write_spread,
    )
    width_direction: FloatProperty(
        name="Direction",
        description=(
            "Standard deviation of the directions of new rays from those of the file. Default 0°: they go the same "
            "way"
        ),
        default=0.0,
        min=0.0,
        max=1.0,
        subtype="ANGLE",
        update=tag_owner,
    )
    unit: EnumProperty(
        name="Length Unit",
        description="Unit of length of text files that do not tell theirs. Default mm: most programs write it",
        items=UNITS,
        default="mm",
        update=tag_owner,
    )
    is_luminous: BoolProperty(
        name="Lumens",
        description=(
            "Text files that do not tell it have rays in lumens instead of watts. Default off: most programs write "
            "watts"
        ),
        default=False,
        update=tag_owner,
    )
    keep_index: BoolProperty(
        name="Keep Prepared Rays",
        description=(
            "Write what is found out about the rays into a file beside theirs (its name and '.prepared'), so that "
            "it need not be found out again. Default off: no file is written unasked"
        ),
        default=False,
        update=_keep,
    )
    show_rays: BoolProperty(
        name="Show Rays",
        description=(
            "Draw where the light starts, and some of its rays, in the 3D view. Default on: it shows where the "
            "light goes"
        ),
        default=True,
        update=tag_owner,
    )


def rays_of(thing) -> LumenrayRaysetSettings | None:
    """Return the settings of an object's ray file, the evaluated ones of an evaluated object; None where none can be."""
    is_light = thing is not None and thing.type == "LIGHT"
    return settings_of_light(thing.data, "rayset") if is_light else None


def active_rays(context) -> LumenrayRaysetSettings | None:
    """Return the settings of the ray file that a panel or an operator is about."""
    light = getattr(context, "light", None)
    if light is not None:
        return settings_of_light(light, "rayset")
    return rays_of(getattr(context, "object", None))


def is_rayset(thing) -> bool:
    """Whether an object shines as a ray file says."""
    settings = rays_of(thing)
    return settings is not None and settings.use_file
