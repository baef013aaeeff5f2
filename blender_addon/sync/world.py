"""Blender's world, or the sky that stands in its place, as the surroundings of the engine's scene."""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from mathutils import Euler

from ...engine.photometry.units import RADIANCE_EFFICACY
from ...engine.scene.checks import LARGEST_AMOUNT
from ...engine.scene.light import ImageWorld, UniformWorld
from ...engine.scene.scene import content_digest
from ...engine.scene.texture import ImageTexture
from ...engine.sky.cie import sun_direction
from ...engine.sky.picture import describe_faults, find_illuminance
from ...imports import loaded_when_used
from ..daylight.moment import follows_frames
from ..foundation.node_trees import uses_nodes
from ..foundation.report import ConversionReport
from ..sky import needs_moment, takes_lamp
from ..sun_direction import UPWARDS
from .images.cache import ImageCache
from .nodes.dependencies import nodes_of
from .nodes.directions import DirectionContext
from .nodes.evaluation import Context, evaluate_field
from .nodes.fields import Field, luminance, rgb
from .nodes.graph import find_socket, trace
from .nodes.mapping import legacy_matrix
from .spectra import light_spectrum
from .visibility import sees_world
from .world_shaders import BACKGROUNDS, world_radiance
from .world_suns import Disk, find_disks, illuminance_of, make_suns

with loaded_when_used():
    from . import skies, world_sources

LEAST_HEIGHT, LARGEST_HEIGHT = 256, 2048
"""Of a picture that is made of a world's nodes. [pixel]"""

SKY_HEIGHT = 512
"""Of a picture with a Sky Texture, least. [pixel]"""

LONGEST_WAY = 100
"""Mixtures of which one shader shows that are looked through."""

SEES_SUN = "pictures show its disk"
"""What is done about a sun that the camera does not see."""

LOW = 2
"""Of pictures of what is the same in all directions. [pixel]"""


def convert_world(
    world,
    world_id: str,
    efficacy: float,
    report: ConversionReport,
    images: ImageCache | None = None,
    sun_lamp: np.ndarray | None = None,
    gives_light: bool = True,
    when: "skies.SkyTime | None" = None,
):
    """Convert the world and its suns, and what the camera sees of it where that is something else.

    Parameters
    ----------
    world : bpy.types.World or None
    world_id : str    Stable key of the result.
    efficacy : float    Lumens per Blender watt. [lm/W]
    images : ImageCache or None    What was read of images before.
    sun_lamp : (3,) array or None    Unit vector to where the scene's Sun light shines from; see `follows_sun_lamp`.
    gives_light : bool    Whether surfaces are lit by it; the camera sees it all the same.
    when : SkyTime or None    As of `convert_sky`.

    Returns
    -------
    UniformWorld, ImageWorld, a sky by formula or None    None when it is black.
    tuple of SunLight    Of its Sky Textures.
    """
    if world is None:
        return None, ()
    black = UniformWorld(0.0, id=world_id)
    images = ImageCache() if images is None else images
    made, suns = _convert_own(world, world_id, efficacy, report, images, sun_lamp, when)
    if suns and not gives_light:
        report.warn(world.name, "its sun is there for the camera alone", "it is left out")
        suns = ()
    seen = _convert_seen(world, world_id, efficacy, report, images, made, bool(suns)) or black
    lit = (made if gives_light else None) or black
    if content_digest(seen) == content_digest(lit):
        return None if lit is black else lit, suns
    return replace(lit, seen=seen), suns


def _convert_own(world, world_id: str, efficacy: float, report, images, sun_lamp, when):
    """Convert a world by what lights surfaces; return it and its suns."""
    if world.lumenray.source == "CIE":
        return skies.convert_sky(world, world_id, report, sun_lamp, when), ()
    shown = _taken(world, _shown(world, report, images), report)
    if shown is None:
        return None, ()
    factor = _unit_of(world, shown, efficacy)
    if factor is None:
        report.error(world.name, "the upper half of the environment is black", "it gives no light")
        return None, ()
    made = _of_shown(world, world_id, shown, factor, report)
    suns = make_suns(shown.disks, factor, world_id, world.name, report)
    world_sources.tell_brightness(world, suns, report)
    return made, suns


def _convert_seen(world, world_id: str, efficacy: float, report, images, made, has_sun: bool):
    """Return what the camera sees of a world, None where that is nothing.

    ``made``: what lights surfaces; ``has_sun``: whether a sun does.
    """
    if not sees_world(world):
        report.info(
            world.name,
            "the camera does not see the world",
            "pictures are black there; it gives its light",
        )
        if has_sun:
            report.warn(world.name, "the camera does not see the sun either", SEES_SUN)
        return None
    tree = world.node_tree if uses_nodes(world) else None
    tells_rays_apart = (
        world.lumenray.source != "CIE"
        and tree is not None
        and any(node.bl_idname == "ShaderNodeLightPath" for node in nodes_of(tree))
    )
    if not tells_rays_apart:
        return made
    own = ConversionReport()
    shown = _shown(world, own, images, is_camera=True)
    seen = None
    if shown is not None:
        lit = _shown(world, ConversionReport(), images) or shown
        if _is_same_picture(shown, lit):
            # The light that shines in the place of a source is seen as well.
            shown = _taken(world, shown, ConversionReport())
        lit = _taken(world, lit, ConversionReport())
        factor = _unit_of(world, lit, efficacy) or _unit_of(world, shown, efficacy) or 0.0
        seen = _of_shown(world, world_id, shown, factor, own)
    if has_sun and not (shown is not None and shown.disks):
        report.warn(world.name, "the nodes hide the sun from the camera", SEES_SUN)
    before, after = (None if each is None else content_digest(each) for each in (made, seen))
    if before == after:
        return made
    report.include_new(own)
    report.info(
        world.name,
        "the camera sees another world than what lights surfaces",
        "pictures show it; light, and all that is measured, comes from the other",
    )
    return seen


def _unit_of(world, shown: "_Shown", efficacy: float) -> float | None:
    """Luminance that 1 in a world's nodes stands for; None where none gives the illuminance that is asked for. [cd/m2]"""
    settings = world.lumenray
    if settings.unit != "ILLUMINANCE":
        plain = {"BLENDER": efficacy, "RADIANCE": RADIANCE_EFFICACY, "WHITE": settings.white}
        return plain.get(settings.unit, 1.0)
    normal = meter_normal(settings.environment)
    if isinstance(shown.colour, ImageTexture):
        given = find_illuminance(shown.colour, shown.rotation, normal)
    else:
        given = math.pi * float(np.ravel(luminance(shown.colour))[0])
    given *= shown.strength
    # The strength is in the disks.
    given += sum(illuminance_of(disk) * max(disk.towards @ normal, 0.0) for disk in shown.disks)
    return settings.illuminance / given if given > 0.0 else None


def meter_normal(settings) -> np.ndarray:
    """Return the unit vector in which the plane faces whose illuminance is stated, by a world's environment settings."""
    if settings.meter_elevation >= 0.5 * math.pi - 1e-6:
        return UPWARDS
    return sun_direction(settings.meter_elevation, settings.meter_azimuth)


def _is_same_picture(shown: "_Shown", lit: "_Shown") -> bool:
    first, second = shown.colour, lit.colour
    if not (isinstance(first, ImageTexture) and isinstance(second, ImageTexture)):
        return False
    return first.pixels is second.pixels or np.array_equal(first.pixels, second.pixels)


def _taken(world, shown: "_Shown | None", report) -> "_Shown | None":
    """Return what a world shows with the bright sources of its picture as disks, where that is asked for."""
    if shown is None or not world.lumenray.environment.use_sources:
        return shown
    if not isinstance(shown.colour, ImageTexture):
        return shown
    taken = world_sources.take_sources(world, shown.colour, shown.rotation, report)
    disks = tuple(
        replace(disk, irradiance=shown.strength * disk.irradiance) for disk in taken.disks
    )
    return replace(shown, colour=taken.image, disks=(*shown.disks, *disks))


def find_picture(world, efficacy: float, report) -> "tuple[ImageTexture, np.ndarray, float] | None":
    """Return the picture that lights a world's surfaces, its rotation as of `ImageWorld`, and what a value of 1 is.

    Parameters
    ----------
    world : bpy.types.World
    efficacy : float    Lumens per Blender watt. [lm/W]
    report : ConversionReport    Told what is odd about it.

    Returns
    -------
    ImageTexture, (3, 3) array, float [cd/m2], or None where the world shows no picture, or a black one
    """
    if world.lumenray.source == "CIE":
        return None
    shown = _shown(world, report, ImageCache())
    if shown is None or not isinstance(shown.colour, ImageTexture):
        return None
    factor = _unit_of(world, _taken(world, shown, ConversionReport()), efficacy)
    if factor is None or shown.strength <= 0.0:
        return None
    return shown.colour, shown.rotation, shown.strength * factor


def _of_shown(world, world_id: str, shown: "_Shown", factor: float, report):
    """Return the world that nodes show, None where it is black. ``factor``: what 1 in it stands for. [cd/m2]"""
    if isinstance(shown.colour, ImageTexture):
        per_unit = shown.strength * factor
        if per_unit <= 0.0:
            return None
        return ImageWorld(shown.colour, per_unit, shown.rotation, world_id)
    amount = float(np.ravel(luminance(shown.colour))[0]) * shown.strength * factor
    if not 0.0 <= amount <= LARGEST_AMOUNT:
        report.error(world.name, f"its luminance is {amount:.3g} cd/m2", "the world is black")
        return None
    return UniformWorld(amount, light_spectrum(shown.colour), world_id) if amount > 0.0 else None


def world_of(scene, view_layer):
    """Return the world that a view layer has, None if it has none."""
    if not view_layer.use_sky:
        return None
    return getattr(view_layer, "world_override", None) or scene.world


def follows_sun_lamp(world) -> bool:
    """Tell whether a world, or None, depends on where the scene's Sun light shines from."""
    return world is not None and world.lumenray.source == "CIE" and takes_lamp(world.lumenray.sky)


def follows_time(world) -> bool:
    """Tell whether a world, or None, depends on the scene's frame although nothing of it is animated."""
    if world is None or world.lumenray.source != "CIE" or not follows_frames(world):
        return False
    return needs_moment(world.lumenray.sky)


@dataclass(frozen=True, eq=False)
class _Shown:
    """What a world's nodes show.

    ``colour``: (3,) array, or an equirectangular `ImageTexture`; ``strength``: what it is multiplied by; ``rotation``: from
    the world's directions to those of the picture, (3, 3); ``disks``: of suns, which are not in the colour.
    """

    colour: object
    strength: float = 1.0
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))
    disks: tuple[Disk, ...] = ()


def _shown(world, report, images, is_camera: bool = False) -> _Shown | None:
    """Return what a world shows to rays that gather light, or to the camera; None where that is nothing."""
    tree = world.node_tree if uses_nodes(world) else None
    if tree is None:
        return _Shown(np.array(world.color))
    output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
    if output is None:
        return None
    volume = find_socket(output.inputs, "Volume")
    if volume is not None and volume.is_linked:
        report.medium(world.name, "the world has a volume", "it is left out")
    surface = find_socket(output.inputs, "Surface")
    origin = _only_branch(trace(surface), world.name, images, is_camera)
    if not origin.is_output:
        return None
    if origin.socket.node.bl_idname in BACKGROUNDS:
        found = _plain_background(origin, world.name, report, images)
        if found is not None:
            return found
    wanted = _height_of(tree)
    height = min(wanted, LARGEST_HEIGHT)
    if wanted > height:
        report.error(
            world.name,
            f"a picture of {wanted} rows is changed by nodes, which are evaluated in {height}",
            "small bright spots, such as a sun, may be lost or count too much; link the picture straight to the Background",
        )
    context = DirectionContext(world.name, report, images, height, is_camera)
    radiance = world_radiance(surface, context)
    if radiance is None:
        return None
    shown = _of_field(radiance, world.name, report)
    if shown is None or not context.skies:
        return shown
    disks = find_disks(surface, context.skies, world.name, report, images, is_camera)
    return replace(shown, disks=disks)


def _of_field(radiance: Field, name: str, report) -> _Shown | None:
    """Return a world whose nodes give a radiance."""
    if radiance.is_spread or (radiance.is_constant and radiance.is_stand_in):
        report.error(
            name,
            "The world's light depends on what cannot be taken over",
            "the mean of what comes out is used in all directions",
        )
    elif radiance.is_stand_in:
        report.error(
            name, "The world's light depends on what cannot be taken over", "its mean is used"
        )
    radiance = radiance.settled()
    if radiance.is_constant:
        colour = np.array(rgb(radiance.values), dtype=np.float64)
        if not np.all(np.abs(colour) <= LARGEST_AMOUNT):
            report.error(name, f"its radiance is {colour.max():.3g}", "the world is black")
            return None
        if colour.min() < 0.0:
            report.warn(name, "a part of the world's colour is negative", "0 is used")
        return _Shown(np.maximum(colour, 0.0))
    pixels = np.ascontiguousarray(rgb(radiance.values), dtype=np.float32).view()
    # What follows from it is then found once.
    pixels.flags.writeable = False
    image = ImageTexture(pixels, name=name)
    for message, remedy in describe_faults(image):
        report.warn(name, message, remedy)
    return _Shown(image)


def _only_branch(origin, name: str, images, is_camera: bool):
    """Return where the one shader comes from that mixtures let show, as those do that tell rays apart."""
    for _ in range(LONGEST_WAY):
        node = origin.socket.node if origin.is_output else None
        if node is None or node.bl_idname != "ShaderNodeMixShader":
            break
        context = DirectionContext(name, ConversionReport(), images, LOW, is_camera)
        factor = evaluate_field(node.inputs[0], context, origin.groups)
        if factor.is_stand_in or not (factor.is_everywhere(0) or factor.is_everywhere(1)):
            break
        origin = trace(node.inputs[1 + int(factor.is_everywhere(1))], origin.groups)
    return origin


def _height_of(tree) -> int:
    """Return the height that a picture needs to show all that a world's nodes show. [pixel]"""
    heights = [
        node.image.size[1]
        for node in nodes_of(tree)
        if node.bl_idname == "ShaderNodeTexEnvironment" and node.image is not None
    ]
    has_sky = any(node.bl_idname == "ShaderNodeTexSky" for node in nodes_of(tree))
    return max([SKY_HEIGHT if has_sky else LEAST_HEIGHT, *heights])


def _plain_background(origin, name, report, images) -> _Shown | None:
    """Return a picture that is turned and nothing else, pixel by pixel as it is; None where the background is no such."""
    node, groups = origin.socket.node, origin.groups
    colour = trace(find_socket(node.inputs, "Color"), groups)
    if not colour.is_output or colour.socket.node.bl_idname != "ShaderNodeTexEnvironment":
        return None
    texture = colour.socket.node
    rotation = _rotation(find_socket(texture.inputs, "Vector"), colour.groups)
    if texture.projection != "EQUIRECTANGULAR" or rotation is None:
        return None
    if legacy_matrix(texture) is not None:
        return None
    strength = trace(find_socket(node.inputs, "Strength"), groups)
    context = Context(name, ConversionReport(), images)
    value = evaluate_field(find_socket(node.inputs, "Strength"), context, groups)
    if strength.is_output and (value.is_stand_in or not value.is_constant):
        return None
    factor = float(luminance(value.mean())[0])
    if not 0.0 <= factor <= LARGEST_AMOUNT:
        report.error(name, f"the strength is {factor:.3g}", "the world is black", node.name)
        factor = 0.0
    return _Shown(_picture_of(texture, name, report, images), factor, rotation)


def _picture_of(node, name, report, images) -> ImageTexture:
    """Read the picture of an environment texture."""
    reading = images.read(
        node.image, True, lambda message, remedy: report.warn(name, message, remedy, node.name)
    )
    if reading is None:
        file = f" ({node.image.filepath})" if node.image and node.image.filepath else ""
        report.miss(
            name,
            f"the environment texture has no picture that can be read{file}",
            "the world is uniform grey 0.5",
            node.name,
        )
    pixels = np.full((2, 4, 3), 0.5, dtype=np.float32) if reading is None else reading.colour
    image = ImageTexture(
        pixels,
        interpolation="closest" if node.interpolation == "Closest" else "linear",
        name=node.image.name if node.image else "",
    )
    if reading is not None:
        _judge(image, node, name, report)
    return image


def _judge(image: ImageTexture, node, name: str, report: ConversionReport) -> None:
    """Say what is odd about a picture of the surroundings."""
    for message, remedy in describe_faults(image):
        report.warn(name, message, remedy, node.name)
    height, width = image.pixels.shape[:2]
    if width != 2 * height:
        report.warn(
            name,
            f"the environment picture '{image.name}' has {width} x {height} pixels, a full sphere is twice as wide as high",
            "it is stretched over the sphere; is it another projection, such as a fisheye's?",
            node.name,
        )
    if node.interpolation in {"Cubic", "Smart"}:
        report.info(
            name,
            f"the environment texture's interpolation is {node.interpolation}",
            "it is linear between the pixels' middles",
            node.name,
        )


def _rotation(socket, groups) -> np.ndarray | None:
    """Matrix from world directions to map directions; None where they are not only turned."""
    origin = trace(socket, groups)
    if not origin.is_output:
        return np.eye(3)
    node = origin.socket.node
    if node.bl_idname == "ShaderNodeTexCoord" and origin.socket.name in {"Generated", "Object"}:
        return np.eye(3)
    if node.bl_idname != "ShaderNodeMapping" or node.vector_type == "NORMAL":
        return None
    for key, neutral in (("Scale", 1.0), ("Location", 0.0), ("Rotation", None)):
        given = find_socket(node.inputs, key)
        if given is None:
            continue
        is_odd = neutral is not None and any(abs(v - neutral) > 1e-6 for v in given.default_value)
        if is_odd or trace(given, origin.groups).is_output:
            return None
    angles = Euler(find_socket(node.inputs, "Rotation").default_value)
    turned = np.array(angles.to_matrix(), dtype=np.float64)
    if node.vector_type == "TEXTURE":
        turned = turned.T
    inner = _rotation(find_socket(node.inputs, "Vector"), origin.groups)
    return None if inner is None else turned @ inner
