"""Where bakes are written: a folder of each file's own, and nothing in it replaced that another bake has left.

A bake of the same file, scene, objects and settings takes the place of the one before. Any other one finds the folder taken
and goes to the next one: ``lux_office``, ``lux_office_2`` and so on.
"""

from pathlib import Path

import bpy

from ...engine.baking.order import BakeOrder
from ...engine.formats.checkpoint import digest
from ...engine.formats.report import write_json
from ...libraries.plain_files import UnreadableError, read_object

CHECKPOINT = "bake.checkpoint"
"""Name of the file, in the bake's folder, that an interrupted bake goes on from."""

CLAIM = "bake.json"
"""Name of the file that says whose results a folder holds."""

LARGEST_CLAIM = 1 << 16
"""Longest such file that is read. [byte]"""

RESULTS = ("illuminance*.exr", "report.json", CHECKPOINT)
"""Files that a folder holds if there is something to lose in it."""

ELSEWHERE = ("folder", "isolux", "arrays", "keep_pages", "checkpoint", "conversion")
"""Fields of an order that do not tell one bake from another."""


def checkpoint_path(folder) -> Path:
    """Return where an interrupted bake of a folder has its state."""
    return Path(folder) / CHECKPOINT


def default_folder() -> str:
    """Return the folder of a file's bakes as Blender writes it, beside the file and with its name."""
    return f"//lux_{Path(bpy.data.filepath).stem}" if bpy.data.filepath else "//lux"


def folder_of(settings, wanted: str = "") -> Path:
    """Return the folder of a scene's bakes, or the one that is wanted instead.

    A file that was never saved has no place of its own: its bakes go to Blender's temporary folder, and with it.
    """
    text = wanted or settings.folder or default_folder()
    if text.startswith("//") and not bpy.data.filepath:
        return Path(bpy.app.tempdir) / text[2:]
    path = Path(bpy.path.abspath(text))
    if path.is_absolute():
        return path
    beside = Path(bpy.data.filepath).parent if bpy.data.filepath else Path(bpy.app.tempdir)
    return beside / path


def is_temporary(folder) -> bool:
    """Whether a folder goes when Blender ends."""
    return Path(folder).is_relative_to(bpy.app.tempdir)


def find_interrupted(wanted: Path, is_exact: bool = False) -> Path | None:
    """Return the folder with the newest interrupted bake: the wanted one, or (unless ``is_exact``) one numbered after it."""
    folders = [wanted] if is_exact else _numbered(wanted)
    found = [folder for folder in folders if checkpoint_path(folder).is_file()]
    return max(found, key=lambda each: checkpoint_path(each).stat().st_mtime, default=None)


def find_free(wanted: Path, order: BakeOrder) -> Path:
    """Return the first folder, of the one that is wanted and those numbered after it, that may take a bake."""
    known = list(_numbered(wanted))
    own = _identity(order)
    # Its own first: a free one may have come since.
    for folder in known:
        if _read_claim(folder) == own:
            return folder
    for folder in known:
        if not _holds_results(folder):
            return folder
    return _number(wanted, len(known) + 1)


def claim(folder, order: BakeOrder) -> None:
    """Write down whose the results in a folder are.

    Raises
    ------
    FileFormatError    Nothing can be written there.
    """
    content = {"file": order.file, "scene": order.scene, "settings": _identity(order)}
    write_json(Path(folder) / CLAIM, content)


def _number(wanted: Path, number: int) -> Path:
    return wanted if number == 1 else wanted.with_name(f"{wanted.name}_{number}")


def _numbered(wanted: Path):
    """Folders of a name that are there, with numbers in a row."""
    number = 1
    while (folder := _number(wanted, number)).is_dir():
        yield folder
        number += 1


def _holds_results(folder: Path) -> bool:
    return any(next(folder.glob(pattern), None) is not None for pattern in RESULTS)


def _identity(order: BakeOrder) -> str:
    return digest(order, ELSEWHERE)


def _read_claim(folder: Path) -> str | None:
    """Identity of the bake that a folder holds; None where it is not known."""
    try:
        return read_object(folder / CLAIM, LARGEST_CLAIM).get("settings")
    except UnreadableError:
        return None
