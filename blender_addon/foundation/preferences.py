"""What the user prefers in all files, as the extension's preferences have it, or as they have it at first."""

from pathlib import Path

import bpy

PACKAGE = __package__.rpartition(".")[0].rpartition(".")[0]
"""Name of the extension, by which Blender knows its preferences."""

SOLID_RADIUS = 0.5
"""Size of the solids of luminaires before anybody has changed it. [m]"""


def own():
    """Return the extension's preferences, None where Blender has none of it."""
    addon = bpy.context.preferences.addons.get(PACKAGE)
    return addon.preferences if addon is not None else None


def shows_steps() -> bool:
    """Whether the sidebar shows the first steps that are left to do."""
    preferences = own()
    return preferences is None or preferences.show_steps


def solid_radius() -> float:
    """Return how far the largest intensity reaches in the solids of luminaires. [m]"""
    preferences = own()
    return preferences.solid_radius if preferences is not None else SOLID_RADIUS


def luminaire_folder() -> Path | None:
    """Return the folder of the user's own luminaires, None if there is none."""
    preferences = own()
    name = preferences.luminaire_folder if preferences is not None else ""
    folder = Path(bpy.path.abspath(name)) if name else None
    return folder if folder is not None and folder.is_dir() else None


def city_list() -> Path | None:
    """Return the path of the user's own list of cities, None if there is none."""
    preferences = own()
    name = preferences.city_list if preferences is not None else ""
    return Path(bpy.path.abspath(name)) if name else None


def constituents() -> Path | None:
    """Return the path of the user's own constituents of paints, None if there is none."""
    preferences = own()
    name = preferences.constituents if preferences is not None else ""
    return Path(bpy.path.abspath(name)) if name else None


def cluster() -> tuple[str, str, str, str]:
    """Return the address of the user's cluster and the files that prove who is who, each empty where there is none."""
    preferences = own()
    if preferences is None:
        return "", "", "", ""
    files = (
        preferences.cluster_authority,
        preferences.cluster_certificate,
        preferences.cluster_key,
    )
    return preferences.cluster_address.strip(), *(bpy.path.abspath(name) for name in files)


def device() -> str:
    """Return the key of the device that the user has chosen, empty for the first that works."""
    preferences = own()
    choice = preferences.device if preferences is not None else "AUTO"
    return "" if choice == "AUTO" else choice.lower()


def memory_limit() -> int | None:
    """Return the limit, None without one. [byte]"""
    preferences = own()
    limit = preferences.memory_limit if preferences is not None else 0.0
    return int(limit * (1 << 30)) or None
