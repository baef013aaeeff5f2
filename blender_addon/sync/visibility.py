"""What Blender lets an object do with some rays and not with others: taken over where light allows it, told where not."""

from dataclasses import dataclass

LIGHT_RAYS = {
    "visible_diffuse": "diffuse",
    "visible_glossy": "glossy",
    "visible_transmission": "transmission",
    "visible_shadow": "shadow",
}
"""Blender's switches for rays that carry light in surfaces' scenes, and what people know them by."""

NO_ID = 0x7FFFFFFF
"""Fills up an instance's identity where it lies less deep than it could."""

WHOLE = "it takes part in light whole; switch these rays off together to leave it out of the light, or all on"
"""What is done about an object that light meets in part."""


@dataclass(frozen=True)
class Visibility:
    """``camera``: whether the camera sees it; ``light``: whether light meets it; ``off``: the light rays that do not."""

    camera: bool
    light: bool
    off: tuple[str, ...]


def visibility_of(source, parent=None, view_layer=None) -> Visibility:
    """Return which rays meet an object.

    Parameters
    ----------
    source : bpy.types.Object    Of an instance what it shows.
    parent : bpy.types.Object or None    What makes the instance; rays that do not meet it do not meet the instance.
    view_layer : bpy.types.ViewLayer or None    Its collections may be there for indirect light only.
    """
    owners = [source] if parent is None else [source, parent]
    off = tuple(
        word
        for name, word in LIGHT_RAYS.items()
        if not all(getattr(owner, name) for owner in owners)
    )
    camera = all(owner.visible_camera for owner in owners)
    if view_layer is not None and source.original.indirect_only_get(view_layer=view_layer):
        camera = False
    return Visibility(camera, len(off) < len(LIGHT_RAYS), off)


def collection_flags(view_layer) -> bytes:
    """Which collections of a view layer are there for indirect light only, and which are holdouts, in their order."""
    flags, waiting = bytearray(), [view_layer.layer_collection]
    while waiting:
        layer = waiting.pop()
        flags.append(2 * layer.indirect_only + layer.holdout)
        waiting += layer.children
    return bytes(flags)


def find_unrendered(view_layer) -> set[int]:
    """Session uids of objects that lie in collections which are disabled in renders, and in no other ones."""
    everyone, rendered = set(), set()
    waiting = [(view_layer.layer_collection, True)]
    while waiting:
        layer, renders = waiting.pop()
        renders &= not layer.collection.hide_render
        if not layer.exclude:
            own = {item.session_uid for item in layer.collection.objects}
            everyone |= own
            rendered |= own if renders else set()
        waiting += [(child, renders) for child in layer.children]
    return everyone - rendered


def is_rendered(instance, unrendered: set[int]) -> bool:
    """Whether renders show an instance.

    Parameters
    ----------
    instance : bpy.types.DepsgraphObjectInstance
    unrendered : set of int    As of `find_unrendered`.
    """
    parent = instance.parent if instance.is_instance else None
    if instance.object.hide_render or (parent is not None and parent.hide_render):
        return False
    # What is instanced within instances need not be shown by itself.
    is_within = parent is not None and instance.persistent_id[1] != NO_ID
    top = instance.object if parent is None else parent
    return is_within or top.original.session_uid not in unrendered


def is_blurred(source, instance, setting: str = "use_motion_blur") -> bool:
    """Whether an instance, and what makes it, is blurred where it moves; ``use_deform_motion``: where its shape does."""
    owners = [source, instance.parent] if instance.is_instance else [source]
    # Settings of Cycles are there with its add-on alone.
    settings = (getattr(owner, "cycles", None) for owner in owners if owner is not None)
    return all(getattr(each, setting, True) for each in settings)


def tell_visibility(found: Visibility, name: str, report) -> None:
    """Note what of an object's visibility is not Blender's."""
    if not found.light:
        seen = "the camera alone sees it" if found.camera else "it can only be measured and baked"
        report.info(
            name, "the object's ray visibility is off for light", f"{seen}; light passes it"
        )
    elif found.off:
        report.error(name, f"light meets the object but for {_listed(found.off)} rays", WHOLE)


def is_dark(source, name: str, report) -> bool:
    """Tell whether a light lights nothing by its ray visibility; note where it would light in part."""
    off = [LIGHT_RAYS[key] for key in list(LIGHT_RAYS)[:3] if not getattr(source, key)]
    if len(off) == 3:
        report.info(name, "the light's ray visibility is off for light", "it gives none")
        return True
    if off:
        report.error(name, f"the light does not light by {_listed(off)} rays", "it lights by all")
    return False


def is_holdout(source, parent=None, view_layer=None) -> bool:
    """Tell whether the camera sees a hole in place of an object; parameters as of `visibility_of`.

    What makes an instance decides for it, as in Cycles.
    """
    owner = (source if parent is None else parent).original
    if owner.is_holdout:
        return True
    return view_layer is not None and owner.holdout_get(view_layer=view_layer)


def is_catcher(source, parent=None) -> bool:
    """Tell whether the camera sees but the shadows on an object; parameters as of `visibility_of`.

    What makes an instance, or what it shows, decides for it, as in Cycles.
    """
    owners = [source] if parent is None else [source, parent]
    return any(owner.original.is_shadow_catcher for owner in owners)


def tell_departures(source, name: str, report, view_layer=None, parent=None) -> None:
    """Note what else an object of Blender with a surface does to pictures; parameters as of `visibility_of`."""
    if is_holdout(source, parent, view_layer):
        report.info(
            name, "the object is a holdout", "pictures are transparent there; light meets it"
        )
    elif is_catcher(source, parent):
        report.info(
            name,
            "the object is a shadow catcher",
            "pictures show what is behind everything, darker where it is shaded; light meets it, and mirrors and bodies of "
            "glass show it, as it is",
        )


def tell_linking(source, name: str, report) -> None:
    """Note that what glows lights and shades all alike."""
    linking = source.original.light_linking
    if linking.receiver_collection is not None:
        report.error(
            name,
            "light linking lets it light some objects only",
            "it lights all, as light does; unlink it, or render it in a light group of its own",
        )
    if linking.blocker_collection is not None:
        report.error(
            name,
            "shadow linking lets some objects only shade it",
            "all do; unlink the shadows, or switch off the ray visibility for light of the others",
        )


def is_dark_world(world, report) -> bool:
    """Tell whether a world lights nothing by its ray visibility; note where it would light in part."""
    rays = getattr(world, "cycles_visibility", None)
    if rays is None:
        return False
    off = [kind for kind in ("diffuse", "glossy", "transmission") if not getattr(rays, kind)]
    if len(off) == 3:
        report.info(world.name, "the world's ray visibility is off for light", "it gives none")
        return True
    if off:
        report.error(
            world.name, f"the world does not light by {_listed(off)} rays", "it lights by all"
        )
    return False


def sees_world(world) -> bool:
    """Tell whether the camera sees a world."""
    rays = getattr(world, "cycles_visibility", None)
    return rays is None or rays.camera


def _listed(words) -> str:
    return " and ".join((", ".join(words[:-1]), words[-1])) if len(words) > 1 else words[0]
