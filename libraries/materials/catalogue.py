"""Reads folders of materials: a ``materials.json`` that lists them, and the scattering files that it names.

A folder of a user's may have one too; its entries look like those of the library that ships::

    {"author": "…", "licence": "CC0-1.0",
     "materials": [
       {"name": "my_paint", "title": "My paint", "category": "Paint/Wall", "description": "…", "source": "…",
        "tags": ["…"], "luminous_reflectance": 0.8, "luminous_transmittance": 0.0, "thumbnail": "thumbnails/my_paint.png",
        "settings": {"model": "MEASURED", "measured": {"filepath": "files/my_paint.lumbsdf", "rotation": 0.0}}}]}

``name``, ``title``, ``category`` and ``settings`` must be there. ``settings`` are those of the physical override of a
material, by the names that they have in Blender; a scattering file, of any format that is read, is named by its path in the
folder, one that ships as ``library:NAME``. What stands beside ``materials`` holds for all. What cannot be used is told and
left out; nothing of it ends the reading. The content of scattering files is not looked at here.
"""

import math
from dataclasses import dataclass
from pathlib import Path

from .. import spectra
from ..entries import Problem, UnusableError, is_number, path_inside, text_of
from ..plain_files import UnreadableError, read_object

LIST = "materials.json"
"""File that lists the materials of a folder."""

THUMBNAILS = "thumbnails"
"""Folder of the pictures, beside the list."""

PREFIX = "library:"
"""How a material names a file of ours, with the file's stem after it: its folder differs from machine to machine."""

LARGEST_LIST = 4 << 20
"""Larger lists are not read. [byte]"""

MOST_ENTRIES = 10_000
"""More materials of a list are left out."""

SETTINGS = {
    "DIFFUSE": {
        "reflectance_source": ("VALUE", "COLOR"),
        "reflectance": (0.0, 1.0),
        "reflectance_color": (0.0, 1.0, 3),
        "transmittance": (0.0, 1.0),
    },
    "COATED": {
        "reflectance_source": ("VALUE", "COLOR"),
        "reflectance": (0.0, 1.0),
        "reflectance_color": (0.0, 1.0, 3),
        "roughness": (0.0, 1.0),
        "ior_source": ("CONSTANT",),
        "ior": (1.0, 4.0),
    },
    "CONDUCTOR": {"metal": spectra.conductor_names(), "roughness": (0.0, 1.0)},
    "DIELECTRIC": {
        "ior_source": ("CONSTANT", "CAUCHY"),
        "ior": (1.0, 4.0),
        "cauchy_b": (0.0, 0.1),
        "roughness": (0.0, 1.0),
    },
    "THIN_GLASS": {
        "ior_source": ("CONSTANT", "CAUCHY"),
        "ior": (1.0, 4.0),
        "cauchy_b": (0.0, 0.1),
        "transmittance": (0.0, 1.0),
    },
    "MEASURED": {"measured": {"filepath": str, "rotation": (-2.0 * math.pi, 2.0 * math.pi)}},
}
"""Settings of each model: the words or the bounds of a number, with how many there are; those of a group in braces."""


@dataclass(frozen=True, eq=False)
class Entry:
    """A material of a library.

    Parameters
    ----------
    name : str    Unlike all others of its library.
    title, description : str    For people.
    category : str    From the general to the special, with slashes.
    source : str    What it was made from, or who measured it.
    settings : dict    Of the physical override; a scattering file of the folder with its whole path.
    tags : tuple of str
    reflectance, transmittance : float or None    Luminous, stated for comparison. [-]
    author, licence : str    Empty if not stated.
    thumbnail : Path    Picture; need not exist.
    """

    name: str
    title: str
    category: str
    description: str
    source: str
    settings: dict
    tags: tuple[str, ...]
    reflectance: float | None
    transmittance: float | None
    author: str
    licence: str
    thumbnail: Path

    @property
    def model(self) -> str:
        """Name of the override's model."""
        return self.settings["model"]

    @property
    def file(self) -> Path | None:
        """Its scattering file; None: it has none."""
        path = self.settings.get("measured", {}).get("filepath")
        if path is None:
            return None
        if path.startswith(PREFIX):
            return Path(__file__).parent / "files" / f"{path.removeprefix(PREFIX)}.lumbsdf"
        return Path(path)


@dataclass(frozen=True)
class Library:
    """Materials of a folder, by category and title, and what could not be used."""

    folder: Path
    entries: tuple[Entry, ...]
    problems: tuple[Problem, ...] = ()


def by_category(entries) -> dict[str, tuple[Entry, ...]]:
    """Materials by their category, in order."""
    groups = {}
    for entry in entries:
        groups.setdefault(entry.category, []).append(entry)
    return {name: tuple(groups[name]) for name in sorted(groups)}


def read_library(folder) -> Library:
    """Read the list of a folder.

    Parameters
    ----------
    folder : str or Path
    """
    folder = Path(folder)
    path = folder / LIST
    try:
        content = read_object(path, LARGEST_LIST)
    except UnreadableError as error:
        return Library(folder, (), (Problem(path, str(error)),))
    found, problems, names = [], [], set()
    listed = content.pop("materials", None)
    if not isinstance(listed, list):
        return Library(folder, (), (Problem(path, "'materials' should be a list"),))
    if len(listed) > MOST_ENTRIES:
        problems.append(Problem(path, f"more than {MOST_ENTRIES} materials; the rest is left out"))
    for number, item in enumerate(listed[:MOST_ENTRIES], 1):
        try:
            entry = _describe(folder, content, item, names)
        except UnusableError as error:
            problems.append(Problem(path, f"material {number}: {error}"))
        else:
            names.add(entry.name.casefold())
            found.append(entry)
    found.sort(key=lambda entry: (entry.category.casefold(), entry.title.casefold(), entry.name))
    return Library(folder, tuple(found), tuple(problems))


def _describe(folder: Path, defaults: dict, item, taken: set[str]) -> Entry:
    """Make an entry of what a list says; ``taken``: names of others, in lower case.

    Raises
    ------
    UnusableError    Something in it cannot be.
    """
    if not isinstance(item, dict):
        raise UnusableError("expected an object in braces")
    item = {**defaults, **item}
    name = text_of(item, "name")
    if not name or Path(name).name != name or name.startswith("."):
        raise UnusableError("needs a 'name' that is the name of a file too")
    if name.casefold() in taken:
        raise UnusableError(f"there are two materials of the name '{name}'")
    tags = item.get("tags", [])
    if not isinstance(tags, list) or not all(isinstance(tag, str) for tag in tags):
        raise UnusableError(f"'tags' of {name} should be a list of texts")
    picture = folder / THUMBNAILS / f"{name}.png"
    if "thumbnail" in item:
        picture = path_inside(folder, item["thumbnail"])
    if picture is None:
        raise UnusableError(f"'thumbnail' of {name} should lie in the library's folder")
    category = "/".join(p.strip() for p in text_of(item, "category").split("/") if p.strip())
    title = text_of(item, "title")
    if not category or not title:
        raise UnusableError(f"{name} needs a 'title' and a 'category'")
    return Entry(
        name=name,
        title=title,
        category=category,
        description=text_of(item, "description"),
        source=text_of(item, "source"),
        settings=_settings(folder, name, item.get("settings")),
        tags=tuple(tags),
        reflectance=_share(item, "luminous_reflectance"),
        transmittance=_share(item, "luminous_transmittance"),
        author=text_of(item, "author"),
        licence=text_of(item, "licence"),
        thumbnail=picture,
    )


def _share(item, key) -> float | None:
    value = item.get(key)
    if value is not None and not is_number(value, 0.0, 1.0):
        raise UnusableError(f"'{key}' should be a number from 0 to 1")
    return None if value is None else float(value)


def _settings(folder: Path, name: str, settings) -> dict:
    """Settings of the override, checked, with whole paths."""
    if not isinstance(settings, dict) or settings.get("model") not in SETTINGS:
        words = ", ".join(SETTINGS)
        raise UnusableError(f"'settings' of {name} should be an object with a 'model' of {words}")
    model = settings["model"]
    own = {key: value for key, value in settings.items() if key != "model"}
    made = {"model": model, **_group(own, SETTINGS[model], f"{name}, {model}")}
    if model == "MEASURED":
        measured = made.get("measured", {})
        made["measured"] = {**measured, "filepath": _file(folder, name, measured)}
    return made


def _group(settings: dict, known: dict, where: str) -> dict:
    made = {}
    for key, value in settings.items():
        if key not in known:
            raise UnusableError(f"{where} has no setting '{key}'")
        made[key] = _value(value, known[key], f"'{key}' of {where}")
    return made


def _value(value, rule, where: str):
    if isinstance(rule, dict):
        if not isinstance(value, dict):
            raise UnusableError(f"{where} should be an object in braces")
        return _group(value, rule, where)
    if rule is str:
        if not isinstance(value, str):
            raise UnusableError(f"{where} should be a text")
        return value
    if isinstance(rule[0], str):
        if value not in rule:
            raise UnusableError(f"{where} should be one of {', '.join(rule)}")
        return value
    low, high, *count = rule
    values = value if count else [value]
    if (
        not isinstance(values, list)
        or len(values) != (count[0] if count else 1)
        or not all(is_number(each, low, high) for each in values)
    ):
        many = f"{count[0]} numbers" if count else "a number"
        raise UnusableError(f"{where} should be {many} from {low:g} to {high:g}")
    return value


def _file(folder: Path, name: str, measured: dict) -> str:
    """Whole path of a scattering file of the folder; one that ships keeps its name."""
    place = measured.get("filepath")
    if place is not None and place.startswith(PREFIX):
        stem = place.removeprefix(PREFIX)
        if stem and Path(stem).name == stem:
            return place
        raise UnusableError(f"{name} names no file of the library in '{place}'")
    path = path_inside(folder, place)
    if path is None:
        raise UnusableError(f"{name} needs a 'filepath' in this folder or below")
    if not path.is_file():
        raise UnusableError(f"{name} names {place}, which is not there")
    return str(path)
