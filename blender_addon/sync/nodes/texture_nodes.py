"""Nodes that lay a picture or a regular pattern over the surface.

Every function takes the node's `Inputs` and returns the `Field` of the wanted output.
"""

import numpy as np

from ....engine.scene.memo import recall
from ..images.pixels import MISSING
from . import patterns, texel_textures
from .fields import SAMPLES, Field, Layout, constant, mean_of_picture, spread
from .mapping import Placement, legacy_matrix, resolve_placement
from .needs import SURFACE, tile
from .texel_textures import with_black_border

_BRICK_TILE = 1024

TOLD_LOSS = 0.005
"""By how much Blender may show a picture darker without a word. [-]"""


def _image(at):
    node, image = at.node, at.node.image
    context, is_straight = at.context, node.outputs["Alpha"].is_linked
    key = (image.session_uid if image else 0, is_straight)
    if key not in context.readings:
        context.readings[key] = context.images.read_tiles(image, is_straight, at.note)
    reading = context.readings[key]
    for message in () if reading is None else reading.missing:
        at.miss(message, "the magenta that Cycles shows is used")
    if reading is None:
        place = f" ({image.filepath})" if image and image.filepath else ""
        name = f"Image {image.name!r}{place} cannot be read" if image else "No image is chosen"
        (at.miss if image else at.fail)(name, f"grey {MISSING} is used")
        return _constant_instead(1.0 if at.output.identifier == "Alpha" else MISSING)
    if at.output.identifier == "Alpha":
        return _laid(at, reading.alpha, reading.tiles)
    if reading.loss > TOLD_LOSS and node.interpolation != "Closest":
        at.note(
            f"Blender mixes encoded values between the pixels of image {image.name!r}, "
            f"and shows it {100.0 * reading.loss:.2g} % darker",
            "light is mixed, so that the mean is that of the pixels",
        )
    return _colour_mapped(at, _laid(at, _usable(at, reading.colour), reading.tiles))


def _usable(at, pixels):
    """Return the pixels of a picture with 0 in place of what is no number."""
    bad = recall(pixels, "bad", lambda v: int((~np.isfinite(v)).any(axis=-1).sum()))
    if not bad:
        return pixels
    at.fail(f"Image {at.node.image.name!r} has {bad} pixels that are no numbers", "0 is used")
    return recall(pixels, "usable", lambda v: np.nan_to_num(v, posinf=0.0, neginf=0.0))


def _constant_instead(value):
    return Field(constant(value).values, None, True)


def _laid(at, pixels, tiles):
    node = at.node
    if node.interpolation in {"Cubic", "Smart"}:
        at.remark(f"{node.interpolation} interpolation", "linear interpolation is used")
    if at.context.has_texels:
        return texel_textures.look_up_picture(at, pixels, tiles)
    if node.projection != "FLAT":
        at.note(f"{node.projection.capitalize()} projection", "the picture's mean is used")
        at.context.needs.add(SURFACE)
        return Field(mean_of_picture(pixels), None, True)
    placement = placement_of(at, is_uv_by_default=True)
    if placement is None:
        at.note("Texture coordinates other than a UV map", "the picture's mean is used")
        at.context.needs.add(SURFACE)
        return Field(mean_of_picture(pixels), None, True)
    transform, extension = placement.transform, node.extension.lower()
    if extension == "clip" and tiles:
        at.remark("Tiles that are black outside", "the pixels at their edges go on")
        extension = "extend"
    elif extension == "clip":
        pixels, transform = with_black_border(pixels, transform)
        extension = "extend"
    interpolation = "closest" if node.interpolation == "Closest" else "linear"
    layout = Layout(placement.uv_map, transform, interpolation, extension, node.image.name, tiles)
    return Field(pixels, layout)


def _colour_mapped(at, field):
    settings = at.node.color_mapping
    is_plain = (
        settings.brightness == 1.0
        and settings.contrast == 1.0
        and settings.saturation == 1.0
        and settings.blend_factor == 0.0
        and not settings.use_color_ramp
    )
    if not is_plain:
        at.note("The texture's own colour adjustment is not supported", "it is left out")
    return field


def placement_of(at, is_uv_by_default: bool) -> Placement | None:
    """Return where the Vector input of a texture node lies; None if that is not on a UV map.

    Parameters
    ----------
    at : Inputs
    is_uv_by_default : bool    Whether Blender takes a UV map where nothing is linked.
    """
    socket = at.node.inputs["Vector"]
    is_linked = any(not link.is_muted for link in socket.links)
    if at.context.has_texels:
        return None
    if is_linked:
        placement = resolve_placement(socket, at.groups, at.constant_of)
    else:
        placement = Placement("", np.eye(4)) if is_uv_by_default else None
    legacy = legacy_matrix(at.node)
    if placement is None or legacy is None:
        return placement
    return placement.after(legacy)


def _scaled_placement(at):
    """Return where a pattern lies, with the node's scale; None if that is not on a UV map."""
    placement = placement_of(at, is_uv_by_default=False)
    scale = at.plain("Scale")
    if placement is None:
        at.context.needs.add(SURFACE)
        return None
    matrix = np.diag([scale, scale, scale, 1.0])
    return placement.after(matrix)


def _checker(at):
    if at.context.has_texels:
        return _chequered(at, texel_textures.draw_checker(at))
    placement = _scaled_placement(at)
    if placement is None:
        at.note("A checker without a UV map", "the mean of its two colours is used")
        share = spread(np.arange(SAMPLES)[:, None] % 2)
    else:
        # One field of the checker is half of the repeating picture.
        transform = np.diag([0.5, 0.5, 1.0]) @ placement.transform
        layout = Layout(placement.uv_map, transform, "closest", "repeat", at.node.name)
        level = np.floor(placement.matrix[2, 3] + 1e-6)
        share = Field(patterns.CHECKER if level % 2 == 0 else 1 - patterns.CHECKER, layout)
    return _chequered(at, share)


def _chequered(at, share):
    if at.output.identifier == "Fac":
        return share
    return at.map(lambda f, a, b: a * f + b * (1 - f), share, at("Color1"), at("Color2"))


def _brick(at):
    node = at.node
    names = ("Mortar Size", "Mortar Smooth", "Bias", "Brick Width", "Row Height")
    sizes = [at.plain(name) for name in names]
    if sizes[3] == 0 or sizes[4] == 0:
        return at("Color1")
    bonding = patterns.Bonding(
        *sizes, node.offset, node.offset_frequency, node.squash, node.squash_frequency
    )
    if at.context.has_texels:
        return _painted(at, *texel_textures.draw_bricks(at, bonding))
    placement = _scaled_placement(at)
    scale = at.plain("Scale")
    transform = np.eye(3) if placement is None else placement.transform
    if placement is None:
        transform = np.diag([scale, scale, 1.0])
    places = (np.arange(_BRICK_TILE) + 0.5) / _BRICK_TILE
    u, v = np.meshgrid(places, places)
    x = transform[0, 0] * u + transform[0, 1] * v + transform[0, 2]
    y = transform[1, 0] * u + transform[1, 1] * v + transform[1, 2]
    mortar, tint = (
        part[..., None].astype(np.float32) for part in patterns.draw_bricks(x, y, bonding)
    )
    if placement is None:
        at.note("A brick pattern without a UV map", "its mean colour is used")
        # Both of the same places, so that joints stay joints.
        places = np.random.default_rng(1).integers(0, _BRICK_TILE, (2, SAMPLES))
        fields = [spread(part[tuple(places)]) for part in (mortar, tint)]
    else:
        at.remark("A brick pattern never repeats", "it is drawn for one UV tile and repeated")
        at.context.needs.add(tile(placement.uv_map))
        layout = Layout(placement.uv_map, np.eye(3), "linear", "repeat", node.name)
        fields = [Field(mortar, layout), Field(tint, layout)]
    return _painted(at, *fields)


def _painted(at, mortar, tint):
    if at.output.identifier == "Fac":
        return mortar

    def paint(mortar, tint, first, second, joint):
        return (first * (1 - tint) + second * tint) * (1 - mortar) + joint * mortar

    return at.map(paint, mortar, tint, at("Color1"), at("Color2"), at("Mortar"))


def _ies(at):
    factor = at.context.take_profile(at.node)
    if factor is None:
        at.fail(
            "An IES texture shapes the light of lamps only; a glowing surface shines alike in all directions",
            "0 is used; use a luminaire",
        )
        return constant(0.0)
    if any(not link.is_muted for link in at.node.inputs["Vector"].links):
        at.note("Nodes turn the directions of an IES texture", "the light's own axes are used")
    return at.map(lambda strength: strength * factor, at("Strength"))


FUNCTIONS = {
    "ShaderNodeTexImage": _image,
    "ShaderNodeTexChecker": _checker,
    "ShaderNodeTexBrick": _brick,
    "ShaderNodeTexIES": _ies,
}
"""What each node does, by its ``bl_idname``."""
