"""What is in a file, and what may be changed of it from outside Blender, as plain data: lights, visibility and materials.

Edits are an object of JSON::

    {"lights": {"Spot": {"flux": 900, "dimming": 0.5, "spectrum": "LED-B3", "is_on": true}, "Lamp": {"temperature": 3000}},
     "hidden": ["Chair"], "materials": {"Wall Paint": "wall_white_matt", "Door": {"scene": "Oak"}}}
"""

from pathlib import Path

from ..engine import VERSION
from ..engine.errors import SceneError
from .edited_spectra import check_spectrum, choose_spectrum

MOST = 10_000
"""Names of one kind, in edits and in what is told of a file."""

NUMBERS = {"flux": (0.0, 1e9), "dimming": (0.0, 1.0), "temperature": (500.0, 40000.0)}
"""What can be stated of a light, with its bounds: its flux [lm], the share of it that it is set to, and the temperature of
the blackbody that it shines like [K]."""

LIGHT = (*NUMBERS, "spectrum", "is_on")
"""All that can be changed of a light: also its spectrum, see `edited_spectra`, and whether it shines."""

PARTS = ("lights", "hidden", "materials")


def describe(bpy) -> dict:
    """What is in the open file: the names by which edits and jobs speak of it."""
    from .bake.job import bakeable
    from .light_list import find_lights, gives_light
    from .sensors.settings import is_sensor

    scene = bpy.context.scene
    found = find_lights(bpy.context.evaluated_depsgraph_get())
    names = {
        "objects": [each.name for each in scene.objects],
        "surfaces": [each.name for each in bakeable(scene.objects)],
        "sensors": [each.name for each in scene.objects if is_sensor(each)],
        "materials": [each.name for each in bpy.data.materials if each.users],
    }
    lights = {
        row.name: {"amount": row.amount, "unit": row.unit, "count": row.count, "is_on": True}
        for row in found.rows
    }
    for each in filter(gives_light, scene.objects):
        # Off, or of no amount: they can be switched on, and stated.
        unit = "lx" if each.type == "LIGHT" and each.data.type == "SUN" else "lm"
        off = {"amount": 0.0, "unit": unit, "count": 1, "is_on": not each.hide_render}
        lights.setdefault(each.name, off)
    return {
        "lumenray": VERSION,
        "lights": [{"name": name} | lights[name] for name in sorted(lights)][:MOST],
        "problems": list(found.problems)[:MOST],
        "has_camera": scene.camera is not None,
        **{kind: sorted(each)[:MOST] for kind, each in names.items()},
    }


def check_edits(edits, content: dict, library) -> dict:
    """Return edits without parts that change nothing.

    Parameters
    ----------
    edits
        Data of JSON, from anywhere.
    content : dict    As `describe` gives it.
    library : collection of str    Names of materials that may be put in place of the file's.

    Raises
    ------
    SceneError    They are not understood, or of something that the file has not.
    """
    if not isinstance(edits, dict) or not set(edits) <= set(PARTS):
        raise SceneError(f"edits: expected an object with {', '.join(PARTS)} and nothing else")
    lights, materials = _object(edits, "lights"), _object(edits, "materials")
    hidden = edits.get("hidden", [])
    if not isinstance(hidden, list) or len(hidden) > MOST:
        raise SceneError(f"edits: 'hidden' is expected to be a list of at most {MOST} names")
    units = {each["name"]: each["unit"] for each in content["lights"]}
    for name, changes in lights.items():
        _check_name("light", name, units)
        _check_light(name, changes, units[name])
    for name in hidden:
        _check_name("object", name, content["objects"])
    for name, wanted in materials.items():
        _check_name("material", name, content["materials"])
        _check_material(name, wanted, content["materials"], library)
    lights = {name: changes for name, changes in lights.items() if changes}
    made = {"lights": lights, "hidden": sorted(set(hidden)), "materials": materials}
    return {part: value for part, value in made.items() if value}


def apply_edits(bpy, edits: dict, saved: Path) -> None:
    """Change the open file as `check_edits` has allowed; it is to be saved as ``saved``, beside which it may get files."""
    scene = bpy.context.scene
    for name, changes in edits.get("lights", {}).items():
        _change_light(_find(scene.objects, "object", name), changes, saved)
    for name in edits.get("hidden", ()):
        _find(scene.objects, "object", name).hide_render = True
    _change_materials(bpy, edits.get("materials", {}))


def library_materials() -> dict[str, str]:
    """Titles of the materials that ship, by their names."""
    from ..libraries import materials

    return {entry.name: entry.title for entry in materials.entries()}


def _object(edits: dict, part: str) -> dict:
    value = edits.get(part, {})
    if not isinstance(value, dict) or len(value) > MOST:
        raise SceneError(f"edits: '{part}' is expected to be an object of at most {MOST} entries")
    return value


def _check_name(kind: str, name, known) -> None:
    if not isinstance(name, str) or name not in known:
        raise SceneError(f"edits: there is no {kind} {str(name)[:80]!r}")


def _check_material(name: str, wanted, own, library) -> None:
    if not isinstance(wanted, dict):
        _check_name("material of the library", wanted, library)
        return
    if set(wanted) != {"scene"}:
        raise SceneError(
            f"edits: material '{name}': expected a name of the library, or an object with 'scene', a material of the file"
        )
    _check_name("material", wanted["scene"], own)


def _check_light(name: str, changes, unit: str) -> None:
    if not isinstance(changes, dict) or not set(changes) <= set(LIGHT):
        raise SceneError(f"edits: light '{name}': expected {', '.join(LIGHT)} and nothing else")
    for key, value in changes.items():
        told = f"edits: '{key}' of light '{name}'"
        if key == "spectrum":
            check_spectrum(told, value)
        elif key == "is_on":
            if not isinstance(value, bool):
                raise SceneError(f"{told}: expected true or false")
        else:
            _check_number(told, value, *NUMBERS[key])
    if "flux" in changes and unit != "lm":
        raise SceneError(
            f"edits: light '{name}' is stated in {unit} and has no flux; dim it instead"
        )
    if {"spectrum", "temperature"} <= set(changes):
        raise SceneError(f"edits: light '{name}' has a spectrum or a temperature, not both")


def _check_number(told: str, value, least: float, most: float) -> None:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not (is_number and least <= value <= most):
        raise SceneError(
            f"{told}: expected a number from {least:g} to {most:g}, found {str(value)[:40]}"
        )


def _find(collection, kind: str, name: str):
    found = collection.get(name)
    if found is None:
        raise SceneError(f"the file has no {kind} '{name}'")
    return found


def _change_light(thing, changes: dict, saved: Path) -> None:
    from .luminaires.settings import is_luminaire, settings_of
    from .raysets.settings import is_rayset, rays_of

    if "is_on" in changes:
        thing.hide_render = not changes["is_on"]
    if not set(changes) - {"is_on"}:
        return
    if thing.type == "LIGHT" and thing.data.users > 1:
        # Another light that shares these settings was not asked for.
        thing.data = thing.data.copy()
    if is_luminaire(thing) or is_rayset(thing):
        settings = settings_of(thing) if is_luminaire(thing) else rays_of(thing)
        _change_file_light(settings, changes)
    elif thing.type == "LIGHT":
        _change_plain_light(thing.data.lumenray, changes)
    else:
        raise SceneError(f"'{thing.name}' makes lights of other objects: change these")
    # An empty that is a luminaire has its own spectrum.
    own = thing.data.lumenray if thing.type == "LIGHT" else thing.lumenray.luminaire
    if "temperature" in changes:
        own.spectrum, own.colour_temperature = "BLACKBODY", changes["temperature"]
    if "spectrum" in changes:
        choose_spectrum(own, changes["spectrum"], saved)


def _change_file_light(settings, changes: dict) -> None:
    if "flux" in changes:
        settings.amount, settings.luminous_flux = "LUMENS", changes["flux"]
    if "dimming" in changes:
        settings.dimming = changes["dimming"]
    if {"temperature", "spectrum"} & set(changes):
        settings.spectrum_source = "LIGHT"


def _change_plain_light(settings, changes: dict) -> None:
    if not settings.use_physical:
        # It starts with what the light gives.
        settings.use_physical = True
    if "flux" in changes:
        settings.quantity, settings.value = "LUMINOUS_FLUX", changes["flux"]
    if "dimming" in changes:
        settings.value *= changes["dimming"]


def _change_materials(bpy, materials: dict) -> None:
    """Put materials in place of others, all at once: what is asked for is what the file had."""
    found = {name: _find(bpy.data.materials, "material", name) for name in materials}
    wanted = {
        name: _load_material(bpy, each)
        if isinstance(each, str)
        else _find(bpy.data.materials, "material", each["scene"])
        for name, each in materials.items()
    }
    # Of what gives its own place to another a copy is put in, which is not replaced in turn.
    placed = {
        name: each.copy() if each in found.values() else each for name, each in wanted.items()
    }
    for name, each in found.items():
        each.user_remap(placed[name])


def _load_material(bpy, name: str):
    """Bring a material of the library into the open file."""
    from ..libraries import materials

    title = materials.find_entry(name).title
    path = materials.LIBRARY / "materials.blend"
    with bpy.data.libraries.load(str(path), link=False, assets_only=True) as (there, wanted):
        if title not in there.materials:
            raise SceneError(f"the library of materials lacks '{title}'")
        wanted.materials = [title]
    return wanted.materials[0]
