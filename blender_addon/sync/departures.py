"""Settings of Blender and Cycles that change pictures there and are not taken over: what is said when one is in use.

What is taken over stands where it is read; what Cycles approximates and this engine does in full (bounces, caustics,
clamping) is no departure of ours.
"""

from collections.abc import Callable
from dataclasses import dataclass

from ..foundation.report import Severity

WARNING, ERROR, INFO = Severity.WARNING, Severity.ERROR, Severity.INFO

ALL_BOUNCES = 1024
"""What Cycles has where a light may be reflected as often as paths are long."""

BALL = 0.1
"""Radius from which on it shows whether a light is a ball or a disk that faces every point. [Blender unit]"""


@dataclass(frozen=True)
class Departure:
    """A setting.

    Parameters
    ----------
    path : str    From its owner, by dots; ``{}`` in the message stands for its value.
    differs : callable    ``differs(value, owner)``: whether it changes anything.
    message, remedy : str
    severity : Severity
    """

    path: str
    differs: Callable
    message: str
    remedy: str
    severity: Severity = WARNING


def _on(value, _owner) -> bool:
    return bool(value)


def _off(value, _owner) -> bool:
    return not value


def _unlike(neutral) -> Callable:
    return lambda value, _owner: value != neutral


def _in_focus(differs: Callable) -> Callable:
    """Only where depth of field is on."""
    return lambda value, owner: owner.dof.use_dof and differs(value, owner)


def _simplified(differs: Callable) -> Callable:
    """Only where the scene is simplified."""
    return lambda value, owner: owner.render.use_simplify and differs(value, owner)


CAMERA = (
    Departure(
        "type",
        lambda value, _: value not in {"PERSP", "ORTHO", "PANO"},
        "cameras of type {} are not supported",
        "it is rendered in perspective",
        ERROR,
    ),
    Departure(
        "dof.focus_subtarget",
        _in_focus(_on),
        "the camera is focused on the bone '{}'",
        "it is focused on the armature's origin",
    ),
)

LIGHT = (
    Departure(
        "cycles.max_bounces",
        lambda value, _: value < ALL_BOUNCES,
        "Cycles lets the light be reflected {} times at most",
        "all its light counts",
    ),
    Departure(
        "use_soft_falloff",
        lambda value, owner: value and owner.shadow_soft_size > BALL,
        "soft falloff makes the light a disk that faces every point in Cycles",
        "it is a ball of the same intensity, by (radius / distance)² brighter near by",
        INFO,
    ),
)

WORLD = (
    Departure(
        "cycles.max_bounces",
        lambda value, _: value < ALL_BOUNCES,
        "Cycles lets the world's light be reflected {} times at most",
        "all its light counts",
    ),
)

MATERIAL = (
    Departure(
        "cycles.use_bump_map_correction",
        _off,
        "the correction of bump maps is off",
        "it is on: facets shade each other near the horizon",
        INFO,
    ),
    Departure(
        "use_transparent_shadow",
        _off,
        "transparent shadows are off",
        "light passes what is transparent in it, as the eye does",
    ),
)

OBJECT = (
    Departure(
        "cycles.use_adaptive_subdivision",
        _on,
        "adaptive subdivision is on",
        "the levels of the modifier for renders are used",
        INFO,
    ),
)

SCENE = (
    Departure(
        "render.use_multiview",
        _on,
        "stereo and multiple views are not supported",
        "one picture is rendered, from the camera itself",
        ERROR,
    ),
    Departure("render.use_freestyle", _on, "Freestyle draws no lines here", "there are none"),
    Departure(
        "cycles.film_exposure",
        lambda value, _: abs(value - 1.0) > 1e-6,
        "Cycles' film exposure of {:.3g} is not used",
        "Lumenray's film settings state the exposure; a white luminance divided by it shows the same picture",
    ),
    Departure(
        "cycles.film_transparent_glass",
        lambda value, owner: value and owner.render.film_transparent,
        "glass is transparent on the film in Cycles",
        "what is seen through glass covers the film",
    ),
    Departure(
        "cycles.use_camera_cull",
        _simplified(_on),
        "Cycles leaves out objects that the camera does not see",
        "all are there",
        INFO,
    ),
    Departure(
        "cycles.use_distance_cull",
        _simplified(_on),
        "Cycles leaves out objects that are far from the camera",
        "all are there",
        INFO,
    ),
    Departure(
        "cycles.texture_limit_render",
        _simplified(_unlike("OFF")),
        "Cycles makes textures smaller than {} pixels",
        "they have their own size",
        INFO,
    ),
)

STILL = (
    Departure(
        "render.use_motion_blur",
        _on,
        "motion blur is for renders",
        "views, lux maps and sensors have the frame's own moment",
        INFO,
    ),
)
"""What is told of a scene of which one moment counts."""

SHUTTER = (
    Departure(
        "cycles.rolling_shutter_type",
        _unlike("NONE"),
        "the shutter rolls over the picture in Cycles",
        "it is open for all of the picture at once",
    ),
)
"""What is told of a scene of which pictures are blurred."""

UNMADE_PASSES = (
    "use_pass_vector",
    "use_pass_position",
    "use_pass_uv",
    "use_pass_mist",
    "use_pass_shadow",
    "use_pass_ambient_occlusion",
    "use_pass_emit",
    "use_pass_environment",
    "use_pass_diffuse_direct",
    "use_pass_diffuse_indirect",
    "use_pass_diffuse_color",
    "use_pass_glossy_direct",
    "use_pass_glossy_indirect",
    "use_pass_glossy_color",
    "use_pass_transmission_direct",
    "use_pass_transmission_indirect",
    "use_pass_transmission_color",
    "use_pass_subsurface_direct",
    "use_pass_subsurface_indirect",
    "use_pass_subsurface_color",
    "use_pass_cryptomatte_object",
    "use_pass_cryptomatte_material",
    "use_pass_cryptomatte_asset",
)
"""Passes of Blender that are not made."""


def tell(table: tuple[Departure, ...], owner, name: str, report) -> None:
    """Note which settings of a table are in use.

    Parameters
    ----------
    table : tuple of Departure
    owner : bpy.types.ID    That has them; what this version of Blender lacks is passed over.
    name : str    Of the owner, for the report.
    report : ConversionReport
    """
    for each in table:
        value = owner
        for step in each.path.split("."):
            value = getattr(value, step, None)
        if value is not None and each.differs(value, owner):
            report.add(each.severity, name, "", each.message.format(value), each.remedy)


def tell_passes(view_layer, report) -> None:
    """Note which passes are wanted and not made."""
    wanted = [name for name in UNMADE_PASSES if getattr(view_layer, name, False)]
    if wanted:
        names = ", ".join(view_layer.bl_rna.properties[name].name for name in wanted)
        report.warn(view_layer.name, f"these passes are not made: {names}", "they are missing")
