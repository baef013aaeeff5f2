"""Tracing of every state of the blinds, and what of it an earlier run has left."""

from ...engine.errors import SceneError
from ..progress import Bar
from .places import Places, find_keys


def trace(options, session, places: Places, order, transport: str):
    """Coefficients with all blinds open, and with those of one group closed, by group."""
    from ...engine.scene.scene import SceneDelta

    groups = [find_keys(session, _members(options, name), options.file) for name in options.blinds]
    blinds = {key: session.scene.meshes[key] for keys in groups for key in keys}
    made = []
    for number, shown in enumerate([(), *groups]):
        hidden = tuple(key for key in blinds if key not in shown)
        session.apply(
            SceneDelta(
                changed=tuple(blinds[key] for key in shown),
                removed=tuple(k for k in hidden if k in session.scene.meshes),
            )
        )
        made.append(_trace_state(options, session, places, order, transport, number))
    session.apply(SceneDelta(changed=tuple(blinds.values())))
    return made


def _members(options, collection: str) -> set[str]:
    """Names of a collection's objects."""
    import bpy

    found = bpy.data.collections.get(collection)
    if found is None:
        raise SceneError(f"{options.file}: there is no collection named '{collection}'")
    names = {item.name_full for item in found.all_objects if item.type == "MESH"}
    if not names:
        raise SceneError(
            f"{options.file}: the collection '{collection}' holds no mesh that could be a blind"
        )
    return names


def _trace_state(options, session, places: Places, order, transport: str, number: int):
    """Coefficients of one state of the blinds, of an earlier run if they are of the same scene and order."""
    from ...engine.daylight.kept import read_coefficients, write_coefficients
    from ...engine.formats.checkpoint import digest

    path = options.output / f"traced_{number}.lumenray"
    facts = {"scene": session.scene.hash(), "order": digest((order, places.sensors, transport))}
    if options.resume and path.exists():
        return read_coefficients(path, **facts)
    title = (
        "daylight"
        if not options.blinds
        else f"daylight, state {number + 1} of {len(options.blinds) + 1}"
    )
    with Bar(title) as bar:
        made = session.find_daylight(
            places.sensors[:, :3], places.sensors[:, 3:], order, transport, bar
        )
    options.output.mkdir(parents=True, exist_ok=True)
    write_coefficients(path, made, **facts)
    return made
