"""Reads folders of luminaires: photometric files in sub-folders by use, and what JSON beside them adds.

Every file ``.ies``, ``.ldt`` or ``.xml`` is a model, its category the folders above it. What the photometric file cannot
say may stand in JSON: in ``NAME.json`` for ``NAME.ldt``, or for any number of files in a ``luminaires.json``, whose other
entries hold for all files of its folder and below. What cannot be used is told and left out; nothing of it ends the reading.
The content of the photometric files is not looked at here.

Entries of a model, all optional but for the file in a list::

    {"file": "photometry/NAME.ies", "title": "…", "description": "…", "category": "Indoor/Office/Recessed",
     "maker": "…", "author": "…", "licence": "CC0-1.0", "tags": ["…"],
     "spectrum": {"illuminant": "LED-B3"} or {"blackbody_K": 2800} or {"daylight_K": 5000},
     "luminous_flux_lm": 3600, "watts": 28,
     "mount": "ceiling", "height_m": 2.5, "drop_m": 0.4,
     "thumbnail": "…png", "name": "…",
     "parts": [{"position_m": [0, 0, 0], "axis": [0, 0, 1], "share": 0.25,
                "opening": {"shape": "cylinder", "size_m": [0.026, 0.026, 0.5], "axis": "z"}}]}
"""

import os
from dataclasses import dataclass, field, replace
from pathlib import Path

from ..entries import Problem, UnusableError, path_inside
from ..plain_files import UnreadableError, read_object
from .description import describe
from .model import Library, Model

EXTENSIONS = (".ies", ".ldt", ".xml")
"""Photometric files, by the end of their name in lower case."""

LIST = "luminaires.json"
"""File that describes several models."""

THUMBNAILS = "thumbnails"
"""Folder of the pictures, beside the list."""

MOST_FILES = 20_000
"""More files of a folder are left out."""

DEEPEST = 12
"""Folders below this depth are left out."""

LARGEST_JSON = 4 << 20
"""Larger descriptions are not read. [byte]"""


@dataclass
class _Lists:
    """What the lists of all folders say: entries by file, each with the list it stands in, and what holds for folders."""

    entries: dict[Path, list[tuple[Path, dict]]] = field(default_factory=dict)
    defaults: dict[Path, dict] = field(default_factory=dict)

    def base(self, folder: Path, path: Path) -> dict:
        """Return what holds for a file by the lists of its folder and of those above, up to the library's."""
        base = {}
        for here in reversed(path.parents):
            if here.is_relative_to(folder):
                base |= self.defaults.get(here, {})
        return base


def read_library(folder) -> Library:
    """Read a folder with all below it.

    Parameters
    ----------
    folder : str or Path
    """
    folder = Path(folder)
    problems = []
    if not folder.is_dir():
        return Library(folder, (), (Problem(folder, "there is no such folder"),))
    files, descriptions = _files_below(folder, problems)
    lists = _read_lists(descriptions, problems)
    models, names = [], set()
    for path in files:
        entries = lists.entries.pop(path, [(path, {})])
        own = path.with_suffix(".json")
        added = _object(own, problems) if own in descriptions and own.name != LIST else {}
        for place, entry in entries:
            try:
                model = describe(folder, path, {**lists.base(folder, path), **entry, **added})
            except UnusableError as error:
                # Left out as a whole, so that it is never shown as something that it is not.
                where = own if added else place
                name = "" if where == path else f"{path.name}: "
                problems.append(Problem(where, f"{name}{error}"))
            else:
                models.append(_named(model, folder, names))
    for path, entries in lists.entries.items():
        problems.append(Problem(entries[0][0], f"names {path.name}, which is not there"))
    models.sort(key=lambda model: (model.category.casefold(), model.title.casefold(), model.name))
    return Library(folder, tuple(models), tuple(problems))


def _named(model: Model, folder: Path, names: set) -> Model:
    """Give a model a name that none has yet, and the place of its picture."""
    name, number = model.name, 2
    while name.casefold() in names:
        name, number = f"{model.name} {number}", number + 1
    names.add(name.casefold())
    picture = model.thumbnail or folder / THUMBNAILS / f"{name}.png"
    return replace(model, name=name, thumbnail=picture)


def _files_below(folder, problems) -> tuple[list[Path], set[Path]]:
    """Photometric files and descriptions below a folder, sorted; links to folders are not followed."""
    files, lists = [], set()
    for root, folders, names in os.walk(folder):
        here = Path(root)
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        if len(here.relative_to(folder).parts) >= DEEPEST and folders:
            problems.append(Problem(here, f"its folders lie deeper than {DEEPEST} levels"))
            folders.clear()
        for name in sorted(names):
            extension = Path(name).suffix.lower()
            if extension in EXTENSIONS:
                files.append(here / name)
            elif extension == ".json":
                lists.add(here / name)
        if len(files) > MOST_FILES:
            problems.append(Problem(here, f"more than {MOST_FILES} files; the rest is left out"))
            break
    return files[:MOST_FILES], lists


def _object(path, problems) -> dict:
    """Content of a JSON file that should be an object; nothing if it is none."""
    try:
        return read_object(path, LARGEST_JSON)
    except UnreadableError as error:
        problems.append(Problem(path, str(error)))
        return {}


def _read_lists(descriptions, problems) -> _Lists:
    lists = _Lists()
    for path in sorted(item for item in descriptions if item.name == LIST):
        content = _object(path, problems)
        models = content.pop("models", [])
        lists.defaults[path.parent] = content
        if not isinstance(models, list):
            problems.append(Problem(path, "'models' should be a list"))
            continue
        for number, entry in enumerate(models, 1):
            file = path_inside(path.parent, entry.get("file")) if isinstance(entry, dict) else None
            if file is None:
                text = f"model {number} needs a 'file' in this folder or below"
                problems.append(Problem(path, text))
            else:
                lists.entries.setdefault(file, []).append((path, entry))
    return lists
