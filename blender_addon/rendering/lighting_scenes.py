"""Lighting scenes: levels of the light groups under a name, kept in the file; light adds up, so nothing is computed anew."""

from dataclasses import dataclass

from ...engine.errors import SceneError
from ...engine.light_mix import LightMix
from . import light_mix

LEVEL = ("is_on", "factor", "colour")
"""What a lighting scene keeps of a group."""

MOST = 32
"""Most lighting scenes of a file."""

FIRST_NAMES = ("Day", "Evening", "Emergency")
"""Names of the first lighting scenes, where none is stated."""


@dataclass(frozen=True)
class Chosen:
    """A lighting scene as readings and pictures are mixed by it.

    Parameters
    ----------
    name : str    Empty: the file has none, and the light mix is as its sliders stand.
    levels : LightMix
    """

    name: str
    levels: LightMix


def choose_all(scene) -> tuple[Chosen, ...]:
    """Return the lighting scenes of a Blender scene; where there are none, what its sliders say as the only one."""
    settings = scene.lumenray.light_mix
    if settings.groups == "NONE" or not settings.scenes:
        return (Chosen("", light_mix.levels_of(scene)),)
    return tuple(choose(row) for row in settings.scenes)


def choose(row) -> Chosen:
    """Return what a lighting scene of the settings says."""
    return Chosen(row.name, light_mix.levels_of_rows(row.rows))


def find(scene, name: str) -> Chosen:
    """Return a lighting scene by its name.

    Raises
    ------
    SceneError    There is none, or no light groups are kept apart; the sentence says which there are.
    """
    settings = scene.lumenray.light_mix
    there = ", ".join(f"'{row.name}'" for row in settings.scenes) or "none"
    if name not in settings.scenes:
        raise SceneError(f"there is no lighting scene '{name}'; there are {there}")
    if settings.groups == "NONE":
        raise SceneError(f"lighting scene '{name}': no light groups are kept apart")
    return choose(settings.scenes[name])


def add(scene, name: str = ""):
    """Keep the sliders as they stand as a new lighting scene, and return it.

    Raises
    ------
    SceneError    There are as many as a file may have.
    """
    settings = scene.lumenray.light_mix
    if len(settings.scenes) >= MOST:
        raise SceneError(f"a file has at most {MOST} lighting scenes; remove one first")
    wanted = name.strip() or next(
        (each for each in FIRST_NAMES if each not in settings.scenes), "Lighting Scene"
    )
    row = settings.scenes.add()
    row.name = _free_name(settings.scenes, wanted)
    settings.scene_index = len(settings.scenes) - 1
    store(scene, row)
    return row


def store(scene, row) -> None:
    """Let a lighting scene have the levels at which the sliders stand."""
    row.rows.clear()
    for slider in scene.lumenray.light_mix.rows:
        kept = row.rows.add()
        kept.name = slider.name
        _copy(slider, kept)


def apply(scene, row) -> list[str]:
    """Set the sliders as a lighting scene says; return the groups that it says nothing of, which shine as they are."""
    unknown = []
    for slider in scene.lumenray.light_mix.rows:
        if slider.name in row.rows:
            _copy(row.rows[slider.name], slider)
            continue
        unknown.append(slider.name)
        for name in LEVEL:
            slider.property_unset(name)
    light_mix.mix_soon(scene)
    return unknown


def remove(scene, number: int) -> None:
    """Forget a lighting scene."""
    settings = scene.lumenray.light_mix
    settings.scenes.remove(number)
    settings.scene_index = max(min(settings.scene_index, len(settings.scenes) - 1), 0)


def is_applied(scene, row) -> bool:
    """Whether the sliders stand as a lighting scene says."""
    now = {level.name: level for level in light_mix.levels_of(scene).levels}
    kept = {level.name: level for level in light_mix.levels_of_rows(row.rows).levels}
    return all(kept.get(name) == level for name, level in now.items())


def remarks_of(chosen: Chosen, groups) -> list[str]:
    """Say which light groups a lighting scene says nothing of, so that they were taken as they are."""
    known = {level.name for level in chosen.levels.levels}
    return [
        f"lighting scene '{chosen.name}' says nothing of the light group '{light_mix.label_of(name)}', which shines with "
        "its own flux in it"
        for name in groups
        if chosen.name and name and name not in known
    ]


def _copy(source, target) -> None:
    for name in LEVEL:
        value = getattr(source, name)
        setattr(target, name, tuple(value) if name == "colour" else value)


def _free_name(scenes, wanted: str) -> str:
    taken = [row.name for row in scenes]
    name, number = wanted, 1
    while name in taken:
        number += 1
        name = f"{wanted} {number}"
    return name
