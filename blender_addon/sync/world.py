"""Blender's world, or the sky that stands in its place, as the surroundings of the engine's scene."""

import math

import numpy as np

from ...engine.scene.checks import LARGEST_AMOUNT
from ...engine.scene.light import CieSky, ImageWorld, UniformWorld
from ...engine.scene.spectrum import Daylight
from ...engine.scene.texture import ImageTexture
from ...engine.sky.cie import sun_direction
from ...engine.sky.picture import describe_faults, find_illuminance
from ..foundation.node_trees import uses_nodes
from ..foundation.report import ConversionReport
from ..sky import UPWARDS, depends_on_sun, onto_horizon
from .images.cache import ImageCache
from .lights.emission_node import mean_light
from .nodes.evaluation import Context
from .nodes.fields import luminance
from .nodes.graph import find_socket, trace
from .spectra import light_spectrum


def convert_world(
    world,
    world_id: str,
    efficacy: float,
    report: ConversionReport,
    images: ImageCache | None = None,
    sun_lamp: np.ndarray | None = None,
):
    """Convert the world.

    Parameters
    ----------
    world : bpy.types.World or None
    world_id : str    Stable key of the result.
    efficacy : float    Lumens per Blender watt. [lm/W]
    images : ImageCache or None    What was read of images before.
    sun_lamp : (3,) array or None    Unit vector to where the scene's Sun light shines from; see `follows_sun_lamp`.

    Returns
    -------
    UniformWorld, ImageWorld, CieSky or None    None when it is black.
    """
    if world is None:
        return None
    if world.lumenray.source == "CIE":
        return convert_sky(world, world_id, report, sun_lamp)
    images = ImageCache() if images is None else images
    background = _background(world, report, images)
    if background is None:
        return None
    colour_socket, strength, groups = background
    picture = _environment(colour_socket, groups, world.name, report, images)
    settings = world.lumenray
    per_unit = strength * (efficacy if settings.unit == "BLENDER" else 1.0)
    if picture is None:
        rgb = np.array(world.color)
        if colour_socket is not None:
            context = Context(world.name, report, images)
            rgb = mean_light(colour_socket, 3, context, groups)
        amount = float(np.ravel(luminance(rgb))[0]) * per_unit
        if settings.unit == "ILLUMINANCE":
            amount = settings.illuminance / math.pi
        if not 0.0 <= amount <= LARGEST_AMOUNT:
            report.error(world.name, f"its luminance is {amount:.3g} cd/m2", "the world is black")
            return None
        return UniformWorld(amount, light_spectrum(rgb), world_id) if amount > 0.0 else None
    image, rotation = picture
    if settings.unit == "ILLUMINANCE":
        given = find_illuminance(image, rotation, UPWARDS)
        if given <= 0.0:
            report.error(
                world.name, "the upper half of the environment is black", "it gives no light"
            )
            return None
        per_unit = settings.illuminance / given
    return ImageWorld(image, per_unit, rotation, world_id) if per_unit > 0.0 else None


def world_of(scene, view_layer):
    """Return the world that a view layer has, None if it has none."""
    if not view_layer.use_sky:
        return None
    return getattr(view_layer, "world_override", None) or scene.world


def follows_sun_lamp(world) -> bool:
    """Tell whether a world, or None, depends on where the scene's Sun light shines from."""
    if world is None or world.lumenray.source != "CIE":
        return False
    sky = world.lumenray.sky
    return sky.use_sun_lamp and depends_on_sun(sky)


def convert_sky(
    world, world_id: str, report: ConversionReport, sun_lamp: np.ndarray | None
) -> CieSky | None:
    """Convert the sky of the CIE that a world has; the parameters are those of `convert_world`."""
    settings = world.lumenray.sky
    if settings.illuminance <= 0.0:
        return None
    if not depends_on_sun(settings):
        # The same for every sun, so that moving one does not send the sky anew.
        sun = UPWARDS
    elif settings.use_sun_lamp and sun_lamp is not None:
        sun = onto_horizon(sun_lamp)
        if sun_lamp[2] < 0.0:
            report.warn(
                world.name,
                "the Sun light shines from below the horizon, where no sky is defined",
                "the sky is that of a sun on the horizon",
            )
    else:
        sun = sun_direction(settings.elevation, settings.azimuth)
    return CieSky(
        type=int(settings.type),
        towards_sun=sun,
        illuminance=settings.illuminance,
        ground_reflectance=settings.ground_reflectance,
        spectrum=Daylight(settings.colour_temperature),
        id=world_id,
    )


def _background(world, report, images):
    """Colour socket, strength and groups of the Background node; None when nothing is there."""
    tree = world.node_tree if uses_nodes(world) else None
    if tree is None:
        return None, 1.0, ()
    output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
    if output is None:
        return None
    volume = find_socket(output.inputs, "Volume")
    if volume is not None and volume.is_linked:
        report.error(world.name, "the world has a volume", "it is left out")
    origin = trace(find_socket(output.inputs, "Surface"))
    if not origin.is_output:
        return None
    node = origin.socket.node
    if node.bl_idname not in {"ShaderNodeBackground", "ShaderNodeEmission"}:
        report.error(
            world.name,
            f"{node.bl_label} is not converted in a world",
            "the world is black",
            node.name,
        )
        return None
    context = Context(world.name, report, images)
    strength = float(mean_light(find_socket(node.inputs, "Strength"), 1, context, origin.groups)[0])
    if not 0.0 <= strength <= LARGEST_AMOUNT:
        report.error(world.name, f"the strength is {strength:.3g}", "the world is black", node.name)
        return None
    return find_socket(node.inputs, "Color"), strength, origin.groups


def _environment(socket, groups, name, report, images):
    """Picture and rotation behind the colour socket, None when it is no environment texture."""
    if socket is None:
        return None
    origin = trace(socket, groups)
    if not origin.is_output or origin.socket.node.bl_idname != "ShaderNodeTexEnvironment":
        return None
    node = origin.socket.node
    if node.projection != "EQUIRECTANGULAR":
        report.error(
            name,
            "mirror-ball environments are not converted",
            "it is read as equirectangular",
            node.name,
        )
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
    return image, _rotation(find_socket(node.inputs, "Vector"), origin.groups, name, report)


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


def _rotation(socket, groups, name, report) -> np.ndarray:
    """Matrix from world directions to map directions."""
    origin = trace(socket, groups)
    if not origin.is_output:
        return np.eye(3)
    node = origin.socket.node
    if node.bl_idname == "ShaderNodeTexCoord" and origin.socket.name in {"Generated", "Object"}:
        return np.eye(3)
    if node.bl_idname == "ShaderNodeMapping":
        from mathutils import Euler

        angles = Euler(find_socket(node.inputs, "Rotation").default_value)
        turned = np.array(angles.to_matrix(), dtype=np.float64)
        if node.vector_type == "TEXTURE":
            turned = turned.T
        for key, neutral in (("Scale", 1.0), ("Location", 0.0)):
            given = find_socket(node.inputs, key)
            if given is not None and any(abs(v - neutral) > 1e-6 for v in given.default_value):
                report.warn(
                    name,
                    f"the environment's mapping has a {key.lower()}",
                    "only its rotation is used",
                    node.name,
                )
        return turned @ _rotation(find_socket(node.inputs, "Vector"), origin.groups, name, report)
    report.warn(
        name,
        f"{node.bl_label} drives the environment's direction",
        "the environment is not rotated",
        node.name,
    )
    return np.eye(3)
