"""Files of older versions: their settings are carried over to where they stand now.

Blender keeps what a file says of a property that is no longer declared. What was renamed or has become part of a group is
known by its old name, so that no number of a version is needed; after it was carried over, the old one is gone.
"""

import re

import bpy
from bpy.app.handlers import persistent

from .foundation import open_file

MOVED = {
    "stop": "render.stop",
    "samples": "render.samples",
    "error": "render.error",
    "time": "render.time",
    "use_smoothing": "render.use_denoising",
    "render.use_smoothing": "render.use_denoising",
    "use_spectral_file": "render.use_spectral_file",
    "spectral_bands": "render.spectral_bands",
    "use_pass_luminance": "render.use_pass_luminance",
    "use_pass_illuminance": "render.use_pass_illuminance",
    "viewport_display": "viewport.display",
    "viewport_samples": "viewport.samples",
    "viewport_automatic": "viewport.automatic",
    "viewport_low": "viewport.low",
    "viewport_high": "viewport.high",
    "viewport_logarithmic": "viewport.logarithmic",
    "bake_density": "bake.density",
    "bake_from_textures": "bake.from_textures",
    "bake_size": "bake.largest",
    "bake_pages": "bake.pages",
    "bake_margin": "bake.margin",
    "bake_cone": "bake.cone",
    "bake_detail": "bake.detail",
    "bake_layers": "bake.layers",
    "bake_exitance": "bake.exitance",
    "bake_smooth": "bake.denoise",
    "bake.smooth": "bake.denoise",
    "bake_method": "bake.method",
    "bake_caustics": "bake.caustics",
    "bake_use_error": "bake.use_error",
    "bake_error": "bake.error",
    "bake_use_absolute": "bake.use_absolute",
    "bake_absolute": "bake.absolute",
    "bake_use_time": "bake.use_time",
    "bake_time": "bake.time",
    "bake_use_samples": "bake.use_samples",
    "bake_samples": "bake.samples",
    "bake_checkpoint": "bake.use_checkpoint",
    "bake_overwrite": "bake.overwrite",
    "bake_gltf": "bake.use_gltf",
    "bake_gltf_textures": "bake.gltf_textures",
    "bake_gltf_size": "bake.gltf_size",
    "bake_folder": "bake.folder",
    "is_baked_shown": "look.is_shown",
    "baked_look": "look.kind",
    "baked_low": "look.low",
    "baked_high": "look.high",
    "baked_layers": "look.layers",
    "baked_layer_index": "look.layer_index",
}
"""Settings of scenes below ``lumenray``: where they stood before, most of them before there were groups, and where now."""

_PATH = re.compile(r"^lumenray\.([\w.]+)(?=\W|$)")


def migrate() -> None:
    """Carry the settings of all scenes of the open file over, with the animation and the drivers that name them."""
    carried = [scene for scene in bpy.data.scenes if _carry(scene)]
    if not carried:
        return
    # No other data-block has settings of these names.
    for action in bpy.data.actions:
        for curve in _curves(action):
            curve.data_path = _renamed(curve.data_path)
    for block in _animated():
        for curve in block.animation_data.drivers:
            curve.data_path = _renamed(curve.data_path)
            for variable in curve.driver.variables:
                for target in variable.targets:
                    target.data_path = _renamed(target.data_path)


def _carry(scene) -> bool:
    """Carry one scene's settings over; whether there were any."""
    kept, is_carried = _stored(scene), False
    for old, new in MOVED.items():
        group, name = _walk(kept, old, lambda place, part: place.get(part, {}))
        if name in group:
            _assign(*_walk(scene.lumenray, new, getattr), group[name])
            del group[name]
            is_carried = True
    return is_carried


def _walk(place, path: str, step) -> tuple:
    """Return the group at the end of a path, and the name of the setting in it."""
    *parts, name = path.split(".")
    for part in parts:
        place = step(place, part)
    return place, name


def _stored(scene):
    """Return what the file says of a scene's settings, by name, declared or not."""
    if bpy.app.version >= (5, 0, 0):
        properties = scene.bl_system_properties_get()
        return {} if properties is None else properties.get("lumenray", {})
    return scene.get("lumenray", {})


def _assign(group, name: str, value) -> None:
    """Set a property to what a file says of it: numbers stand for items of enumerations, too."""
    kind = group.bl_rna.properties[name]
    if kind.type == "COLLECTION":
        # An older version has written this file again, and what it says is newer.
        getattr(group, name).clear()
        for row in value:
            item = getattr(group, name).add()
            for key in list(row.keys()):
                _assign(item, key, row[key])
        return
    if kind.type == "ENUM":
        value = next((each.identifier for each in kind.enum_items if each.value == value), None)
        if value is None:
            return
    setattr(group, name, bool(value) if kind.type == "BOOLEAN" else value)


def _renamed(path: str) -> str:
    """Return the path of a setting as it is now."""
    return _PATH.sub(lambda match: f"lumenray.{MOVED.get(match[1], match[1])}", path)


def _animated():
    """All data-blocks of the file with drivers, node trees inside others too."""
    for collection in bpy.data.bl_rna.properties:
        blocks = getattr(bpy.data, collection.identifier)
        if not isinstance(blocks, bpy.types.bpy_prop_collection):
            continue
        for block in blocks:
            for each in (block, getattr(block, "node_tree", None)):
                if each is not None and getattr(each, "animation_data", None) is not None:
                    yield each


def _curves(action):
    """All curves of an action; it has layers since Blender 4.4."""
    if not hasattr(action, "layers"):
        yield from action.fcurves
        return
    for layer in action.layers:
        for strip in layer.strips:
            for bag in strip.channelbags:
                yield from bag.fcurves


@persistent
def _after_change(*_):
    migrate()


_HANDLERS = ("load_post", "blend_import_post", "undo_post", "redo_post")
"""Where data of older versions can come from. Blender before 4.3 does not tell of what is appended."""


def attach():
    """Listen to Blender before all others, and look at the file that is open."""
    for name in _HANDLERS:
        known = getattr(bpy.app.handlers, name, None)
        if known is not None and _after_change not in known:
            known.insert(0, _after_change)
    open_file.look(migrate)


def detach():
    """Listen no longer."""
    for name in _HANDLERS:
        known = getattr(bpy.app.handlers, name, ())
        if _after_change in known:
            known.remove(_after_change)
    open_file.look_no_more(migrate)
