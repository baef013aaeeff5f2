"""States of the blinds: their objects, and what an earlier run has traced of them."""

from ...blender_addon.daylight_year.job import YearJob, find_keys, meshes_of
from ...engine.errors import SceneError


def find_blinds(options, objects: dict[str, str]) -> list[tuple[str, ...]]:
    """Return the ids of the closed blinds of each group of windows; ``objects``: ids of the scene's by name."""
    import bpy

    made = []
    for name in options.blinds:
        collection = bpy.data.collections.get(name)
        if collection is None:
            raise SceneError(f"{options.file}: there is no collection named '{name}'")
        made.append(find_keys(objects, meshes_of(collection), f"{options.file}: the scene"))
    return made


def keep_states(options, job: YearJob):
    """Return what traces a state for a job, and keeps it in a file, or finds it there if ``options.resume`` is on."""
    from ...engine.daylight.kept import read_coefficients, write_coefficients
    from ...engine.formats.checkpoint import digest

    order = digest((job.order, job.places.sensors, job.transport))

    def find(number: int, scene: str, trace):
        path = options.output / f"traced_{number}.lumenray"
        if options.resume and path.exists():
            return read_coefficients(path, scene, order)
        made = trace()
        options.output.mkdir(parents=True, exist_ok=True)
        write_coefficients(path, made, scene, order)
        return made

    return find
