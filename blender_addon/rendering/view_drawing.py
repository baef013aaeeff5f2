"""Frames of the rendered view on the screen: pictures under Blender's view transform, false colours above it."""

import textwrap
from dataclasses import dataclass

import blf
import bpy
import gpu
from gpu_extras.batch import batch_for_shader
from gpu_extras.presets import draw_texture_2d
from mathutils import Matrix

from ...imports import loaded_when_used
from .. import readout
from . import viewport

with loaded_when_used():
    import numpy as np

    from ...engine.analysis import false_colour

SCALE_WIDTH, SCALE_MARGIN, SCALE_STEPS = 18, 24, 64
"""Width of the scale of false colours, its distance from the region's edges, and its bands. [pixel]"""

OVERLAY_POWER = 2.2
"""Power by which Blender encodes what is drawn above a 3D view, in place of the curve of sRGB."""

TEXT_SIZE = 13
"""Height of the scale's numbers. [point]"""

LINE, MOST_LINES = 18, 2
"""Height of a line of what a picture says of itself [pixel], and lines at most: they end where the scale begins."""

EEVEE = {"BLENDER_EEVEE", "BLENDER_EEVEE_NEXT"}
"""Names of Blender's own engine for real time; versions 4.2 to 4.5 call it by the second."""

MARK_LINES = (((1.0, 1.0, 1.0, 1.0), 2.6), ((0.05, 0.05, 0.05, 1.0), 1.2))
"""Colours and widths of lines of equal value, the one below first. [pixel]"""

_textures: dict[int, tuple[int, object]] = {}


def draw_frame(view) -> None:
    """Draw a view's frame over its whole region, as scene-linear light or, below false colours, black."""
    frame = view.frame
    if frame is None:
        return
    texture = _texture(view)
    region = view.size
    if not frame.is_display_referred:
        draw_texture_2d(texture, (0, 0), *region)


def draw_colours() -> None:
    """Draw false colours above the view but below Blender's texts and handles; called by Blender for every 3D view."""
    view = _view_in_false_colours()
    if view is None:
        return
    test = gpu.state.depth_test_get()
    gpu.state.depth_test_set("NONE")
    with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
        gpu.matrix.load_identity()
        gpu.matrix.load_projection_matrix(Matrix.Identity(4))
        _draw_display_colours(_texture(view))
    gpu.state.depth_test_set(test)


def draw_scale() -> None:
    """Draw the scale of false colours; called by Blender for every 3D view, in pixels."""
    view = _view_in_false_colours()
    scale = _baked_scale() if view is None else view.frame
    if view is not None:
        _draw_marks(view.frame, bpy.context.region)
    if scale is not None:
        _draw_scale(scale, bpy.context.region)


@dataclass(frozen=True)
class Scale:
    """What a scale of false colours tells, as a `views.Frame` does."""

    low: float
    high: float
    unit: str
    is_logarithmic: bool = False
    greys: "np.ndarray | None" = None
    statement: str = ""


def _baked_scale() -> Scale | None:
    """Return the scale of baked light in false colours, None where the view shows none."""
    look = bpy.context.scene.lumenray.look
    if not look.is_shown or look.kind != "FALSE":
        return None
    kind = bpy.context.space_data.shading.type
    if kind != "MATERIAL" and (kind != "RENDERED" or bpy.context.engine not in EEVEE):
        return None
    return Scale(look.low, look.high, look.unit)


def _view_in_false_colours():
    """Return the view in the region that is drawn, None where it shows no false colours."""
    view = viewport.view_at(bpy.context.region)
    if view is None or view.frame is None or not view.frame.is_display_referred:
        return None
    return view if bpy.context.space_data.shading.type == "RENDERED" else None


def forget(view) -> None:
    """Let go of a view's texture."""
    _textures.pop(view.number, None)


def _texture(view):
    """Texture of the view's frame, made anew only for a new frame."""
    known = _textures.get(view.number)
    if known is not None and known[0] == view.frame_number:
        return known[1]
    pixels = view.frame.pixels
    if view.frame.is_display_referred:
        # Blender encodes what is drawn above the view.
        pixels = pixels**OVERLAY_POWER
    pixels = np.ascontiguousarray(pixels, dtype=np.float32)
    height, width = pixels.shape[:2]
    buffer = gpu.types.Buffer("FLOAT", width * height * 4, pixels.reshape(-1))
    texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer)
    _textures[view.number] = (view.frame_number, texture)
    return texture


def _draw_display_colours(texture) -> None:
    """Draw a texture whose colours are what the screen shall show over the whole region."""
    shader = _linear_image_shader()
    batch = batch_for_shader(
        shader,
        "TRI_FAN",
        {
            "pos": ((-1, -1), (1, -1), (1, 1), (-1, 1)),
            "texCoord": ((0, 0), (1, 0), (1, 1), (0, 1)),
        },
    )
    shader.uniform_sampler("image", texture)
    gpu.state.blend_set("NONE")
    batch.draw(shader)


def _linear_image_shader():
    """Blender's shader for images of linear light, which in older versions is the one for all images."""
    try:
        return gpu.shader.from_builtin("IMAGE_SCENE_LINEAR_TO_REC709_SRGB")
    except ValueError:
        return gpu.shader.from_builtin("IMAGE")


def _draw_marks(frame, region) -> None:
    """Draw lines of equal value with their levels, and values at points, over the whole region."""
    size = np.array([region.width, region.height], dtype=np.float32)
    if frame.lines is not None and len(frame.lines):
        shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
        places = (frame.lines * size).reshape(-1, 2)
        content = {"pos": np.pad(places, [(0, 0), (0, 1)]).astype(np.float32)}
        batch = batch_for_shader(shader, "LINES", content)
        zoom = bpy.context.preferences.system.pixel_size
        gpu.state.blend_set("ALPHA")
        shader.uniform_float("viewportSize", tuple(size))
        for colour, width in MARK_LINES:
            shader.uniform_float("color", colour)
            shader.uniform_float("lineWidth", width * zoom)
            batch.draw(shader)
        gpu.state.blend_set("NONE")
    blf.enable(0, blf.SHADOW)
    blf.shadow(0, 5, 0.0, 0.0, 0.0, 1.0)
    blf.color(0, 1.0, 1.0, 1.0, 1.0)
    blf.size(0, TEXT_SIZE)
    taken: list[tuple] = []
    for rows in (frame.labels, frame.values):
        # Lines first: where there is no room for all, values give way.
        for x, y, value in () if rows is None else rows:
            _write_mark(readout.format_amount(float(value), ""), x * size[0], y * size[1], taken)
    blf.disable(0, blf.SHADOW)


def _write_mark(text: str, x: float, y: float, taken: list) -> None:
    """Write a text about a place unless it would cover another one."""
    width, height = blf.dimensions(0, text)
    box = (x - 0.5 * width - 2, y - 0.5 * height - 2, x + 0.5 * width + 2, y + 0.5 * height + 2)
    if any(
        box[0] < other[2] and other[0] < box[2] and box[1] < other[3] and other[1] < box[3]
        for other in taken
    ):
        return
    taken.append(box)
    blf.position(0, box[0] + 2, box[1] + 2, 0)
    blf.draw(0, text)


def _draw_scale(frame, region) -> None:
    """Draw the scale with numbers and unit at the left edge."""
    height = max(min(region.height - 4 * SCALE_MARGIN, 400), 60)
    left, low = _free_edge(bpy.context.area, region) + SCALE_MARGIN, 2 * SCALE_MARGIN
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    gpu.state.blend_set("ALPHA")
    _fill(shader, left - 8, low - 12, SCALE_WIDTH + 90, height + 44, (0.0, 0.0, 0.0, 0.55))
    has_greys = frame.greys is not None
    for step in range(SCALE_STEPS):
        share = (step + 0.5) / SCALE_STEPS
        bottom, top = (low + height * (step + k) / SCALE_STEPS for k in (0, 1))
        colour = _for_shader(np.full(3, frame.greys[step])) if has_greys else _colour(share)
        _fill(shader, left, bottom, SCALE_WIDTH, top - bottom + 0.5, (*colour, 1.0))
    gpu.state.blend_set("NONE")
    blf.size(0, TEXT_SIZE)
    blf.color(0, 1.0, 1.0, 1.0, 1.0)
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        blf.position(0, left + SCALE_WIDTH + 8, low + height * share - 5, 0)
        blf.draw(0, readout.format_amount(_value(frame, share), ""))
    blf.position(0, left, low + height + 14, 0)
    blf.draw(0, frame.unit)
    if frame.statement:
        _draw_statement(shader, frame.statement, left - 8, region.width - SCALE_MARGIN)


def _draw_statement(shader, words: str, left: float, right: float) -> None:
    """Write what a picture is at the lower edge, on as many lines as it takes. [pixel]"""
    width = max(int((right - left) / (0.55 * TEXT_SIZE)), 20)
    lines = textwrap.wrap(words, width)[:MOST_LINES]
    gpu.state.blend_set("ALPHA")
    height = LINE * len(lines) + 4
    _fill(shader, left, 2, right - left, height, (0.0, 0.0, 0.0, 0.55))
    gpu.state.blend_set("NONE")
    for number, line in enumerate(reversed(lines)):
        blf.position(0, left + 8, 8 + LINE * number, 0)
        blf.draw(0, line)


def _free_edge(area, region) -> int:
    """Where the region's left part is not covered by the tools any more. [pixel]"""
    tools = next((each for each in area.regions if each.type == "TOOLS"), None)
    if tools is None or tools.width <= 1 or tools.x > region.x + region.width // 2:
        return 0
    return max(tools.x + tools.width - region.x, 0)


def _value(frame, share: float) -> float:
    """Value at a place of the scale, the same as `analysis.display` puts there."""
    if frame.is_logarithmic:
        return frame.low * (frame.high / frame.low) ** share
    return frame.low + share * (frame.high - frame.low)


def _colour(share: float) -> tuple:
    place = share * (len(false_colour.STOPS) - 1)
    below = min(int(place), len(false_colour.STOPS) - 2)
    part = place - below
    return _for_shader(
        false_colour.STOPS[below] * (1.0 - part) + false_colour.STOPS[below + 1] * part
    )


def _for_shader(colour) -> tuple:
    """Colour to be given to Blender's shader so that the screen shows ``colour``: the shader takes sRGB for granted."""
    linear = colour**OVERLAY_POWER
    return tuple(np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055))


def _fill(shader, x, y, width, height, colour) -> None:
    batch = batch_for_shader(
        shader,
        "TRI_FAN",
        {"pos": ((x, y), (x + width, y), (x + width, y + height), (x, y + height))},
    )
    shader.uniform_float("color", colour)
    batch.draw(shader)


_handles = []


def attach():
    """Draw over every 3D view from now on."""
    if _handles or bpy.app.background:
        return
    for function, stage in ((draw_colours, "POST_VIEW"), (draw_scale, "POST_PIXEL")):
        _handles.append(bpy.types.SpaceView3D.draw_handler_add(function, (), "WINDOW", stage))


def detach():
    """Draw no more."""
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    _textures.clear()
