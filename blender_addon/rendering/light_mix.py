"""The light mix of a scene: its levels, the light groups of its last picture, and the image in which they are added up anew.

Blender lets nobody change a render's result but the engine that renders, so a mix of a finished picture is an image of its
own, which editors that showed the result show from then on. What was kept belongs to the session, not to the file.
"""

from dataclasses import dataclass, replace

import bpy
from bpy.app.handlers import persistent

from ...imports import loaded_when_used
from .. import readout
from ..foundation.exposure import white_luminance
from ..foundation.handlers import leave, listen
from ..foundation.redraw import areas, redraw

with loaded_when_used():
    import numpy as np

    from ...engine import light_mix, views
    from ...engine.photometry import colour as photometry_colour
    from ...engine.scene import light_groups as engine_groups
    from .. import light_groups

IMAGE = "Lumenray Mix"
"""Name of the image that holds the mix of the last picture."""

PREFIX = "Combined_"
"""Beginning of the names of passes with the light of one group, as Cycles calls them."""

LONGEST = 63
"""Most bytes of the name of a pass."""

OTHERS = "Other Lights"
"""What the group of lights that are in no other is called for people."""

BLACK = 1e-6
"""Brightest component of colours that are taken for black, which light cannot be. [-]"""


@dataclass(frozen=True)
class Kept:
    """The last picture of a scene, by group, and the mean of each group's light in it.

    ``unit``: of the means, lx where illuminance was computed, else cd/m².
    """

    picture: "views.Picture"
    means: dict[str, float]
    unit: str


_kept: dict[int, Kept] = {}
"""By the session uid of the scene."""


# ---- groups and levels ----


def groups_of(scene, luminous) -> tuple:
    """Return the light groups that a scene's pictures are to keep apart. ``luminous``: as of `SceneSync.luminous`.

    Raises
    ------
    SceneError    There are too many.
    """
    return light_groups.find_groups(luminous, scene.world, scene.lumenray.light_mix.groups.lower())


def names_of(groups, luminous) -> list[str]:
    """Return the names of all groups, that of the lights in none of them last if there are any."""
    members = {member for group in groups for member in group.members}
    rest = [engine_groups.REST] if groups and any(key not in members for key, _ in luminous) else []
    return [group.name for group in groups] + rest


def levels_of(scene) -> "light_mix.LightMix":
    """Return how the groups of a scene are to shine; as they are while none are kept apart."""
    settings = scene.lumenray.light_mix
    if settings.groups == "NONE":
        return light_mix.LightMix()
    return levels_of_rows(settings.rows)


def levels_of_rows(rows) -> "light_mix.LightMix":
    """Return the levels that rows of settings say."""
    return light_mix.LightMix(
        tuple(light_mix.Level(row.name, row.factor, _colour(row), row.is_on) for row in rows)
    )


def _colour(row) -> tuple[float, float, float]:
    colour = tuple(row.colour)
    return colour if max(colour) > BLACK else (1.0, 1.0, 1.0)


def list_rows(scene, names) -> None:
    """Make a row of levels for each group; rows of names that were there keep what they are set to."""
    rows = scene.lumenray.light_mix.rows
    wanted = [*names]
    for number in reversed(range(len(rows))):
        if rows[number].name not in wanted:
            rows.remove(number)
    for name in wanted:
        if name not in rows:
            rows.add().name = name
    for number, name in enumerate(wanted):
        rows.move(rows.find(name), number)
    redraw("PROPERTIES", "VIEW_3D")


def is_listed(scene, names) -> bool:
    """Whether there is a row for each group."""
    known = {row.name for row in scene.lumenray.light_mix.rows}
    return set(names) <= known


def label_of(name: str) -> str:
    """What a group is called for people."""
    return OTHERS if name == engine_groups.REST else name


# ---- pictures ----


def pass_names(scene) -> list[str]:
    """Names of the passes that a scene's pictures have for the groups that are listed."""
    settings = scene.lumenray.light_mix
    return [] if settings.groups == "NONE" else name_passes([row.name for row in settings.rows])


def name_passes(names) -> list[str]:
    """Return the name of the pass of each group, no longer than Blender allows, and each another."""
    made: list[str] = []
    for name in names:
        number, end = 1, ""
        while (cut := _cut(PREFIX + name, LONGEST - len(end)) + end) in made:
            number += 1
            end = f"~{number}"
        made.append(cut)
    return made


def _cut(text: str, size: int) -> str:
    return text.encode()[:size].decode(errors="ignore")


def mix_picture(scene, picture) -> "tuple[views.Picture, str]":
    """Return a picture at the levels of a scene, and what they change, in words."""
    levels = levels_of(scene)
    words = levels.text() if picture.groups else ""
    return picture.mixed(levels), f"light mix: {words}" if words else ""


def group_layers(picture, white: float) -> "dict[str, np.ndarray]":
    """Light of each group of a picture by the name of its pass, (h, w, 4) float32. ``white``: what becomes 1. [cd/m2]"""
    names = name_passes([group.name for group in picture.groups])
    lights = (shown_light(picture, group, white) for group in picture.groups)
    return dict(zip(names, lights, strict=True))


def shown_light(picture, light, white: float) -> "np.ndarray":
    """Return what is shown of a picture or of one of its groups, without surroundings where film is clear. (h, w, 4) float32

    ``white``: luminance that becomes 1. [cd/m2]
    """
    tristimulus = light.tristimulus
    if light.backdrop is not None:
        tristimulus = np.maximum(tristimulus - light.backdrop, 0.0)
    shown = np.ones((*tristimulus.shape[:2], 4), dtype=np.float32)
    shown[..., :3] = photometry_colour.scene_linear(tristimulus, white)
    if picture.coverage is not None:
        shown[..., 3] = picture.coverage
    return shown


def keep(scene, picture) -> None:
    """Keep a finished picture of a scene, to be mixed anew; one without groups takes the place of an older one too."""
    if not picture.groups:
        _kept.pop(scene.session_uid, None)
        return
    has_lux = picture.illuminance is not None
    means = {
        group.name: float((group.illuminance if has_lux else group.tristimulus[..., 1]).mean())
        for group in picture.groups
    }
    lean = replace(picture, bands=None, band_edges=None)
    _kept[scene.session_uid] = Kept(lean, means, "lx" if has_lux else "cd/m²")
    list_rows(scene, means)
    if IMAGE in bpy.data.images:
        _paint(scene)


def has_kept(scene) -> bool:
    """Whether the groups of a picture of the scene are there."""
    return scene.session_uid in _kept


def show_mix(scene):
    """Add the groups of the last picture up at the scene's levels; return the image that shows them, None without groups."""
    image = _paint(scene)
    if image is None:
        return None
    for area in areas("IMAGE_EDITOR"):
        space = area.spaces.active
        if space.image is None or space.image.type == "RENDER_RESULT":
            space.image = image
        if space.image == image:
            area.tag_redraw()
    return image


def _paint(scene):
    """Make the image of the mix, or bring it up to date; None without groups."""
    kept = _kept.get(scene.session_uid)
    if kept is None:
        return None
    mixed, _ = mix_picture(scene, kept.picture)
    white = white_luminance(scene.lumenray) or photometry_colour.automatic_white(
        mixed.tristimulus[..., 1]
    )
    pixels = shown_light(mixed, mixed, white)
    image = _image(*pixels.shape[1::-1])
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    return image


def _image(width: int, height: int):
    image = bpy.data.images.get(IMAGE)
    if image is not None and tuple(image.size) != (width, height):
        bpy.data.images.remove(image)
        image = None
    if image is None:
        image = bpy.data.images.new(IMAGE, width, height, alpha=True, float_buffer=True)
        # Seen as the render's result is.
        image.use_view_as_render = True
    return image


def describe(scene, row) -> tuple[tuple[str, str], ...]:
    """Say what a row's factor means, and what the group gives in the last picture, as labels and values."""
    factor = row.factor if row.is_on else 0.0
    lines = [("flux", f"{100.0 * factor:.3g} % of its lumens")]
    kept = _kept.get(scene.session_uid)
    if kept is not None and row.name in kept.means:
        mean = kept.means[row.name]
        name = "mean illuminance" if kept.unit == "lx" else "mean luminance"
        now, before = (readout.format_amount(x, kept.unit) for x in (factor * mean, mean))
        lines.append((name, now if factor == 1.0 else f"{now} of {before}"))
        total = sum(
            each.factor * kept.means.get(each.name, 0.0)
            for each in scene.lumenray.light_mix.rows
            if each.is_on
        )
        lines.append((f"{name} of all", readout.format_amount(total, kept.unit)))
    return tuple(lines)


# ---- changes ----

_stale: set[int] = set()
"""Session uids of scenes whose image is not that of their levels."""


def changed(self, context):
    """Take note of a level that was changed: the views mix at once, and the image of the last picture soon."""
    redraw("VIEW_3D")
    mix_soon(self.id_data)


def mix_soon(scene) -> None:
    """Have the image of a scene's last picture mixed when Blender is idle, once for many changes."""
    if scene.session_uid not in _kept:
        return
    _stale.add(scene.session_uid)
    if bpy.app.background:
        _mix_stale()
    elif not bpy.app.timers.is_registered(_mix_stale):
        bpy.app.timers.register(_mix_stale)


def _mix_stale() -> None:
    for scene in bpy.data.scenes:
        if scene.session_uid in _stale:
            show_mix(scene)
    _stale.clear()


@persistent
def _undone(*_):
    for scene in bpy.data.scenes:
        mix_soon(scene)


@persistent
def _loaded(*_):
    _kept.clear()


@persistent
def _saving(*_):
    image = bpy.data.images.get(IMAGE)
    if image is not None and image.is_dirty:
        image.pack()


_HANDLERS = {
    "undo_post": _undone,
    "redo_post": _undone,
    "load_pre": _loaded,
    "save_pre": _saving,
}


def attach():
    """Listen for undos, other files and saves."""
    listen(_HANDLERS)


def detach():
    """Listen no longer, and let go of all pictures."""
    leave(_HANDLERS)
    if bpy.app.timers.is_registered(_mix_stale):
        bpy.app.timers.unregister(_mix_stale)
    _kept.clear()
