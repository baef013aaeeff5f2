"""What the last bake of a scene found, kept with the scene, and whether the scene is still the one that was baked.

The tables are saved with the file. What Blender reports as changed since makes them out of date, and says what it was; only
comparing the whole scene with the one that was baked makes them current again, because undo brings flags back as well.
"""

import uuid
from contextlib import contextmanager
from dataclasses import dataclass, field
from weakref import WeakSet

import bpy
from bpy.app.handlers import persistent

from ...imports import loaded_when_used
from ..foundation import open_file
from ..foundation.handlers import leave, listen
from ..modelling.wishes import read_wishes
from ..sensors.settings import is_sensor
from ..sync.meshes import MESH_TYPES
from ..sync.visibility import LIGHT_RAYS
from .tables import UNKNOWN

with loaded_when_used():
    from ...engine.baking import order
    from ...engine.scene import scene as engine_scene
    from ..sync import scene as sync_scene

MOST_NAMES = 3
"""Changed data-blocks that are named."""

_SHAPES = {"MESH", "CURVE", "CURVES", "META", "LATTICE", "POINTCLOUD", "VOLUME"}
_SHADING = {"LIGHT", "MATERIAL", "WORLD", "IMAGE", "TEXTURE"}
_SHOWN = MESH_TYPES | {"LIGHT", "EMPTY"}
_RAYS = (*LIGHT_RAYS, "visible_camera")


class Watch:
    """Takes note of what changes from now on; for the time that a bake runs."""

    def __init__(self):
        self.names: dict[str, None] = {}
        _remember()
        _tracker.watches.add(self)

    def end(self) -> dict[str, None]:
        """Take no more notes, and return the names."""
        _tracker.watches.discard(self)
        return self.names


@dataclass
class _Tracker:
    """What is known of changes in the open file.

    ``outdated``: what has changed since bakes of this session, by serial; undo may take the flag in the file back, but not
    what it undoes. All others are what was seen last, by session uid: ``settings`` of scenes that count, ``sliders``, how
    baked light is shown, ``rays`` that meet objects, ``members`` of collections, and the objects that are ``shown`` in view
    layers, by uid of the scene and name. Blender tells changes of the last three as it tells much that changes no light:
    with flags that come with every relation that is built anew, or with none.
    """

    watches: WeakSet = field(default_factory=WeakSet)
    outdated: dict[str, str] = field(default_factory=dict)
    settings: dict[int, tuple] = field(default_factory=dict)
    sliders: dict[int, tuple] = field(default_factory=dict)
    rays: dict[int, tuple] = field(default_factory=dict)
    shown: dict[tuple[int, str], dict[int, bool]] = field(default_factory=dict)
    members: dict[int, tuple] = field(default_factory=dict)
    is_ignoring: bool = False


_tracker = _Tracker()


def store_results(
    scene, result: "order.BakeResult", folder, changed=(), shortfall: str = ""
) -> None:
    """Keep a finished bake in place of the one before.

    Parameters
    ----------
    scene : bpy.types.Scene
    result : BakeResult
    folder : Path
    changed : iterable of str    Names of what has changed while the bake ran.
    shortfall : str    What of its rule the bake has not met.
    """
    scene.lumenray.property_unset("baked")
    kept = scene.lumenray.baked
    for made in result.maps:
        _store_map(kept.rows.add(), made)
    kept.relative_error, kept.mean = _known(result.relative_standard_error), result.mean
    marks, seams = result.history.marks, result.seams
    kept.seconds = marks[-1].seconds if marks else 0.0
    kept.pages, kept.shrink = len(result.pages), result.shrink
    kept.seam_pairs, kept.seam_noise = seams.pairs, seams.noise
    kept.seam_before, kept.seam_after = seams.before, seams.after
    kept.shortfall, kept.folder = shortfall, str(folder)
    if result.maps:
        origin = result.maps[0].provenance
        kept.scene_hash, kept.simplified = origin.scene_hash, origin.simplified
    _remember()
    kept.serial = uuid.uuid4().hex
    _note(scene, changed)


def check_current(scene, depsgraph) -> bool:
    """Compare the scene with the one that was baked, take note of what comes of it and return whether they are the same."""
    kept = scene.lumenray.baked
    held = engine_scene.Scene()
    held.apply(sync_scene.convert_scene(depsgraph).delta)
    if held.hash() != kept.scene_hash:
        if not kept.changed:
            _note(scene, ["the scene"])
        return False
    _tracker.outdated.pop(kept.serial, None)
    kept.changed = ""
    return True


@contextmanager
def unchanged(scene):
    """Let our own changes pass, which are none of the light."""
    # What the user changed before has to be heard first.
    _flush(scene)
    before, _tracker.is_ignoring = _tracker.is_ignoring, True
    try:
        yield
        _flush(scene)
        _tracker.sliders[scene.session_uid] = _sliders_of(scene)
    finally:
        _tracker.is_ignoring = before


# ---- private ----


def _flush(scene) -> None:
    for layer in scene.view_layers:
        layer.update()


def _store_map(item, made) -> None:
    item.name, item.mean = made.name, made.mean
    for name, extreme in (
        ("minimum", made.least),
        ("maximum", made.largest),
        ("uniformity", made.uniformity),
    ):
        setattr(item, name, extreme.value)
        setattr(item, f"{name}_low", extreme.low)
        setattr(item, f"{name}_high", _known(extreme.high))
    item.mean_error = _known(made.mean_standard_error)
    item.relative_error = _known(made.relative_standard_error)
    item.bias, item.bias_error = made.bias, _known(made.bias_error)
    item.samples, item.lumels = round(made.samples), made.lumels
    item.density, item.invalid = made.density, made.invalid


def _known(error: float) -> float:
    return min(error, UNKNOWN)


def _note(scene, names) -> None:
    """Say what has changed since the bake of a scene, beside what is said already."""
    kept = scene.lumenray.baked
    names = list(names)
    if not names:
        return
    said = kept.changed.split(", ") if kept.changed else []
    fresh = [name for name in names if name not in said]
    if not fresh or said[-1:] == ["…"]:
        return
    said += fresh
    if len(said) > MOST_NAMES:
        said = [*said[:MOST_NAMES], "…"]
    kept.changed = ", ".join(said)
    _tracker.outdated[kept.serial] = kept.changed


def _kept_scenes() -> list:
    """Scenes that have a bake."""
    return [scene for scene in bpy.data.scenes if scene.lumenray.baked.serial]


def _remember() -> None:
    """Take what is there as seen, so that the first change is known as one."""
    seen = _tracker.settings, _tracker.rays, _tracker.shown, _tracker.members
    if not (_kept_scenes() or _tracker.watches):
        # Nobody has listened, so what was seen may be old.
        for known in seen:
            known.clear()
    settings, rays, shown, members = seen
    for item in bpy.data.objects:
        rays.setdefault(item.session_uid, _rays_of(item))
    for scene in bpy.data.scenes:
        settings.setdefault(scene.session_uid, _settings_of(scene))
        for collection in (scene.collection, *scene.collection.children_recursive):
            members.setdefault(collection.session_uid, _members_of(collection))
        for layer in scene.view_layers:
            shown.setdefault((scene.session_uid, layer.name), _shown_in(scene, layer))


def _settings_of(scene) -> tuple:
    """Settings of a scene that change its light, and tag it as others do that do not."""
    unit, world = scene.unit_settings, scene.world
    return (
        scene.lumenray.efficacy,
        unit.system,
        unit.scale_length,
        0 if world is None else world.session_uid,
        read_wishes(scene.lumenray.modelling),
    )


def _sliders_of(scene) -> tuple:
    """Settings of how baked light is shown, which the nodes of its materials follow."""
    own = scene.lumenray
    layers = tuple((row.name, row.strength, *row.colour) for row in own.look.layers)
    exposure = (own.exposure, own.white_luminance, own.ev100)
    return (own.look.kind, own.look.low, own.look.high, own.efficacy, exposure, layers)


def _rays_of(item) -> tuple:
    """Which rays meet an object."""
    return tuple(getattr(item, name) for name in _RAYS)


def _shown_in(scene, layer) -> dict[int, bool]:
    """Session uids of the objects that are shown in a view layer, each with whether it is there for indirect light only."""
    return {
        item.session_uid: item.indirect_only_get(view_layer=layer)
        for item in scene.objects
        if item.visible_get(view_layer=layer)
    }


def _members_of(collection) -> tuple:
    """What of a collection counts for the light: its members but sensors, what is hidden, and where instances have it."""
    return (
        frozenset(
            (item.session_uid, item.hide_render, item.hide_viewport)
            for item in collection.objects
            if not is_sensor(item)
        ),
        frozenset(
            (each.session_uid, each.hide_render, each.hide_viewport)
            for each in (collection, *collection.children_recursive)
        ),
        tuple(collection.instance_offset),
    )


def _changed_members(collection) -> bool:
    """Whether a collection has other members than when it was seen last, or is new."""
    now = _members_of(collection)
    before = _tracker.members.get(collection.session_uid)
    _tracker.members[collection.session_uid] = now
    return before != now


def _changed_rays(item) -> bool:
    """Whether other rays meet an object than when it was seen last."""
    now = _rays_of(item)
    before = _tracker.rays.setdefault(item.session_uid, now)
    _tracker.rays[item.session_uid] = now
    return before != now


def _changed_shown(scene, layer) -> list:
    """Objects that came into view, went out of it or became indirect since they were seen last."""
    now, key = _shown_in(scene, layer), (scene.session_uid, layer.name)
    before = _tracker.shown.get(key, now)
    _tracker.shown[key] = now
    uids = {uid for uid, _ in before.items() ^ now.items()}
    # What was removed is told with its collection.
    if not uids:
        return []
    return [item for item in scene.objects if item.session_uid in uids and _may_light(item)]


def _may_light(item) -> bool:
    """Whether an object is of a type that gives or takes light, which sensors do not."""
    return item.type in _SHOWN and not is_sensor(item)


def _is_light(update, is_look: bool) -> bool:
    """Whether what Blender reports may change the light of a scene. ``is_look``: whether the baked look has changed."""
    block = update.id.original
    kind = block.id_type
    if kind == "MATERIAL" and is_look and not update.is_updated_transform:
        # Drivers of the look have run, which Blender does not tell from an edit of the material's nodes.
        return False
    if kind == "OBJECT":
        is_other = _changed_rays(block)
        is_moved = update.is_updated_transform or update.is_updated_geometry
        return _may_light(block) and (is_moved or is_other)
    if kind == "COLLECTION":
        return update.is_updated_geometry and _changed_members(block)
    if kind in _SHAPES:
        return update.is_updated_geometry
    return kind in _SHADING


def _concerns(block, scene, told) -> bool:
    """Whether a data-block is part of a scene; ``told``: the scene whose graph reports it."""
    if block.id_type == "OBJECT":
        # Graphs hold what their scene needs: instanced objects of collections that are in no scene, too.
        return scene == told or scene.objects.get(block.name) == block
    if block.id_type == "WORLD":
        return scene.world == block
    return True


@persistent
def _after_update(scene, depsgraph):
    kept = _kept_scenes()
    # The graph of a render is new and calls everything changed.
    if _tracker.is_ignoring or not (kept or _tracker.watches) or depsgraph.mode == "RENDER":
        return
    own = scene.original if scene.is_evaluated else scene
    sliders = _sliders_of(own)
    is_look = own.lumenray.look.is_shown and _tracker.sliders.get(own.session_uid) != sliders
    _tracker.sliders[own.session_uid] = sliders
    blocks = [update.id.original for update in depsgraph.updates if _is_light(update, is_look)]
    if any(update.id.id_type == "SCENE" for update in depsgraph.updates):
        now = _settings_of(own)
        if _tracker.settings.setdefault(own.session_uid, now) != now:
            _tracker.settings[own.session_uid] = now
            blocks.append(own)
        layer = own.view_layers.get(depsgraph.view_layer.name)
        if layer is not None:
            blocks += _changed_shown(own, layer)
    for watch in _tracker.watches:
        watch.names |= dict.fromkeys(block.name for block in blocks)
    for each in kept:
        _note(each, [block.name for block in blocks if _concerns(block, each, own)])


@persistent
def _after_undo(*_):
    for scene in bpy.data.scenes:
        kept = scene.lumenray.baked
        if kept.serial in _tracker.outdated and not kept.changed:
            kept.changed = _tracker.outdated[kept.serial]


@persistent
def _after_load(*_):
    for known in (
        _tracker.outdated,
        _tracker.settings,
        _tracker.sliders,
        _tracker.rays,
        _tracker.shown,
        _tracker.members,
    ):
        known.clear()
    _remember()
    for scene in bpy.data.scenes:
        _tracker.sliders[scene.session_uid] = _sliders_of(scene)


_HANDLERS = {
    "depsgraph_update_post": _after_update,
    "frame_change_post": _after_update,
    "undo_post": _after_undo,
    "redo_post": _after_undo,
    "load_post": _after_load,
}


def attach():
    """Listen to Blender."""
    open_file.look(_remember)
    listen(_HANDLERS)


def detach():
    """Listen no longer."""
    leave(_HANDLERS)
    open_file.look_no_more(_remember)
    _tracker.watches.clear()
