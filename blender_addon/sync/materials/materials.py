"""Conversion of Blender materials."""

import logging
from dataclasses import replace

import bpy
import numpy as np

from ....engine.scene.checks import DEEPEST_MIX
from ....engine.scene.material import (
    Black,
    Coated,
    Diffuse,
    Emission,
    Holdout,
    Material,
    Mix,
    Transparent,
)
from ....engine.scene.scene import content_digest
from ....engine.scene.spectrum import Constant, Illuminant
from ...foundation.node_trees import uses_nodes
from ...foundation.report import ConversionReport
from ..departures import MATERIAL, tell
from ..images.cache import ImageCache
from ..nodes.dependencies import nodes_of
from ..nodes.fields import Field, as_colour, as_texture, constant, luminance
from ..nodes.rays import SPLITTING, RayContext
from ..spectra import light_spectrum
from .closures import Closure
from .overrides import convert_override
from .relief import relief_of_displacement
from .shaders import convert_shader
from .volumes import with_volume

_logger = logging.getLogger(__name__)

DEFAULT_REFLECTANCE, DEFAULT_COAT = 0.8, (1.5, 0.5)
"""Diffuse reflectance that Blender gives to a mesh without a material, and index and roughness of its coat. [-]"""

LARGEST_RADIANCE = 1e20
"""Radiance from which on an emission is a slip: no sum of light could be told beside it. [W/(m2 sr)]"""


def default_material(material_id: str) -> Material:
    """Return what a mesh without a material gets: grey that is coated as Cycles has it from Blender 5 on, matt before."""
    grey = Constant(DEFAULT_REFLECTANCE)
    surface = Diffuse(grey) if bpy.app.version < (5, 0, 0) else Coated(grey, *DEFAULT_COAT)
    return Material(material_id, "Default", surface)


def convert_material(
    material: bpy.types.Material,
    material_id: str,
    report: ConversionReport,
    efficacy: float,
    images: ImageCache | None = None,
    is_patient: bool = True,
    metres: float = 1.0,
    context: RayContext | None = None,
) -> Material:
    """Convert a Blender material.

    Parameters
    ----------
    material : bpy.types.Material    Original or evaluated.
    material_id : str    Stable key of the result.
    report : ConversionReport    Gets a row for everything that is not taken over as it is.
    efficacy : float    What one watt of Blender's radiance stands for. [lm/W]
    images : ImageCache or None    What was read of images before.
    is_patient : bool    Whether to wait for a scattering file that is being read.
    metres : float    That a unit of Blender stands for. [m]
    context : RayContext or None    In which its nodes are evaluated for light; None: as they are for all objects.

    Returns
    -------
    Material    Never fails for an odd node tree: what cannot be understood becomes diffuse grey
        and a row of the report.
    """
    settings = getattr(material, "lumenray", None)
    if settings is not None and settings.use_override:
        surface, emission = convert_override(settings, report, material.name, is_patient)
        return Material(material_id, material.name, surface, emission, material.pass_index)
    _report_working_space(report)
    tell(MATERIAL, material, material.name, report)
    context = context or material_context(material, report, images)
    context.material_index, context.metres = float(material.pass_index), metres
    made = _convert_nodes(material, material_id, context, efficacy)
    if not _tells_rays_apart(material):
        return made
    own = ConversionReport()
    camera = context.branch(own)
    camera.is_camera = True
    seen = _convert_nodes(material, f"{material_id}/seen", camera, efficacy)
    if content_digest(seen) == content_digest(made):
        return made
    report.include_new(own)
    _tell_seen(seen.surface, material.name, report)
    return replace(made, seen=seen)


def _tells_rays_apart(material) -> bool:
    """Tell whether nodes of a material know the camera's rays from others, or make holes for them."""
    return uses_nodes(material) and any(
        node.bl_idname in SPLITTING for node in nodes_of(material.node_tree)
    )


def _tell_seen(surface, name: str, report) -> None:
    """Note what the camera sees of a material that light meets otherwise."""
    if isinstance(surface, Holdout):
        report.info(name, "a holdout", "pictures are transparent there; to light it is black")
        return
    report.info(
        name,
        "the camera sees another surface than light meets",
        "pictures show what the camera sees; light, and all that is measured, follows the other",
    )
    if _mixes_holdout(surface):
        report.warn(
            name,
            "a holdout is mixed with another shader",
            "its share is black; pictures are not transparent there",
        )


def _mixes_holdout(surface) -> bool:
    if isinstance(surface, Mix):
        return _mixes_holdout(surface.first) or _mixes_holdout(surface.second)
    return isinstance(surface, Holdout)


def _convert_nodes(material, material_id: str, context: RayContext, efficacy: float) -> Material:
    """Convert what rays of light, or those of the camera, meet of a material."""
    report = context.report
    try:
        closure = _convert_tree(material, context)
        depth = 0 if closure.surface is None else closure.surface.depth
    except RecursionError:
        closure, depth = Closure(), None
    except (ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError):
        _logger.exception("Material %s", material.name)
        report.error(
            material.name,
            "The node tree cannot be understood; please send the file to the developers",
            f"diffuse grey {DEFAULT_REFLECTANCE} is used",
        )
        closure, depth = Closure(Diffuse(Constant(DEFAULT_REFLECTANCE))), 0
    if depth is None or depth > DEEPEST_MIX:
        report.error(
            material.name,
            f"More than {DEEPEST_MIX} shaders are mixed into each other",
            f"diffuse grey {DEFAULT_REFLECTANCE} is used",
        )
        closure = replace(closure, surface=Diffuse(Constant(DEFAULT_REFLECTANCE)))
    emission = _emission(closure, efficacy, material.name, report)
    if closure.surface is not None and closure.surface.has_relief:
        maps = list(dict.fromkeys(each.uv_map for each in closure.surface.pictures))
        if len(maps) > 1:
            report.warn(
                material.name,
                f"Its pictures and its relief lie on the UV maps {', '.join(map(repr, maps))}",
                f"all are laid by {maps[0]!r}",
            )
    if closure.surface is not None:
        _tell_tangents(closure.surface, material.name, report)
    return Material(
        material_id, material.name, closure.surface or Black(), emission, material.pass_index
    )


def _tell_tangents(surface, name: str, report) -> None:
    """Note tangents that follow another UV map than that of the pictures."""
    maps = list(dict.fromkeys(picture.uv_map for picture in surface.pictures))
    used = maps[0] if maps else next(iter(surface.grain_maps), "")
    for other in dict.fromkeys(surface.grain_maps):
        if other != used:
            report.warn(
                name,
                f"The tangent follows UV map {other!r}",
                f"it follows {used or 'the default one'!r}",
            )


def _report_working_space(report):
    space = getattr(bpy.data, "colorspace", None)
    name = getattr(space, "working_space", "Linear Rec.709")
    if name != "Linear Rec.709":
        report.warn(
            "Colour management",
            f"The file's working space is {name}",
            "colours are read as linear Rec. 709",
        )


def material_context(material, report, images=None) -> RayContext:
    """Return the conversion of a material's nodes for all objects, which notes what it would need to know of one."""
    context = RayContext(material.name, report, images)
    context.is_material = True
    return context


def _convert_tree(material, context: RayContext) -> Closure:
    report = context.report
    if not uses_nodes(material):
        colour = np.clip(material.diffuse_color[:3], 0, 1)
        return Closure(Diffuse(as_colour(constant(*colour))))
    output = material.node_tree.get_output_node("CYCLES")
    if output is None:
        report.warn(material.name, "The node tree has no material output", "black is used")
        return Closure(Black())
    is_volume = output.inputs["Volume"].is_linked
    if output.inputs["Displacement"].is_linked and material.displacement_method != "DISPLACEMENT":
        displaces = material.displacement_method == "BOTH"
        context.relief = relief_of_displacement(output, context, displaces)
    if not output.inputs["Surface"].is_linked:
        if is_volume:
            surface = with_volume(Transparent(), output, context)
            return Closure(surface)
        report.warn(material.name, "Nothing is linked to the surface", "black is used", output.name)
    closure = convert_shader(output.inputs["Surface"], context)
    if is_volume:
        closure = replace(closure, surface=with_volume(closure.surface, output, context))
    return closure


def _emission(closure: Closure, efficacy: float, name: str, report) -> Emission | None:
    """Turn Blender's radiance into luminance."""
    if closure.radiance is None:
        return None
    radiance = closure.radiance.settled()
    low, largest = radiance.limits()
    if low < 0:
        report.error(name, "Its emission is negative", "no light is given there")
    if largest > LARGEST_RADIANCE:
        report.error(name, f"Its emission is {largest:.3g} W/(m2 sr)", "it gives no light")
        return None
    if radiance.is_stand_in:
        mean = efficacy * float(luminance(radiance.mean())[0])
        report.error(
            name,
            "Its emission depends on what cannot be taken over",
            f"the mean of what comes out is used, {mean:.4g} cd/m2 over the surface",
        )
    values = np.maximum(radiance.values, 0)
    if largest <= 0:
        return None
    if not radiance.is_constant:
        pattern = as_texture(Field(values / largest, radiance.layout))
        white = Illuminant("D65")
        return Emission(white, efficacy * largest, pattern, closure.two_sided)
    colour = np.broadcast_to(values, 3)
    amount = efficacy * float(luminance(values)[0])
    spectrum = closure.spectrum or light_spectrum(colour)
    return Emission(spectrum, amount, None, closure.two_sided)
