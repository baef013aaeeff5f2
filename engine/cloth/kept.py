"""Computed cloths, kept in a folder by the hash of all that they follow from."""

import hashlib
import json
from dataclasses import asdict
from pathlib import Path

import numpy as np

from ..errors import FileFormatError
from ..reading.content import read_bytes, read_json
from ..reading.kept_folder import kept_folder
from ..reading.whole_file import write_whole
from ..scattering.data.record import SIDES, ScatteringFile
from ..scattering.data.store import read_store, write_store
from ..scene.material import Measured
from .composition import Cloth
from .reader import whole_content
from .surface import Sheet, WovenSurface

METHOD = 1
"""Version of how tables are computed; those of another one are computed anew."""

KEPT = 64
"""Cloths; one more, and the one that was used longest ago goes."""

LARGEST_FACTS = 1 << 20
"""[byte]"""


def key_of(cloth: Cloth, rays: int, seed: int) -> str:
    """SHA-256 of all that a cloth's tables follow from, in hexadecimal."""
    words = {"name", "description", "source"}
    content = {name: value for name, value in whole_content(cloth).items() if name not in words}
    text = json.dumps([METHOD, content, rays, seed], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def default_folder() -> Path:
    """Where computed cloths are kept for this user."""
    return kept_folder("cloth")


def save_woven(woven: WovenSurface, folder: Path) -> None:
    """Keep a cloth.

    Raises
    ------
    FileFormatError    The folder cannot be written.
    """
    tables, facts = _places(folder, woven.key)
    sides = {side: getattr(woven.surface, side) for side in SIDES}
    write_store(tables, ScatteringFile(tables, "Lumenray scattering", sides))
    content = {
        "sheet": asdict(woven.sheet),
        "reflected": list(map(float, woven.reflected)),
        "passed": list(map(float, woven.passed)),
        "rays": woven.rays,
        "seed": woven.seed,
        "notes": list(woven.notes),
    }
    # Last, as it tells that the tables are there.
    with write_whole(facts) as file:
        file.write(json.dumps(content).encode())
    kept = sorted(folder.glob("*.json"), key=lambda path: path.stat().st_mtime)
    for path in kept[:-KEPT]:
        for own in _places(folder, path.stem):
            own.unlink(missing_ok=True)


def load_woven(key: str, folder: Path) -> WovenSurface | None:
    """Return a cloth that was kept; None where there is none, or what is there is damaged and to be computed anew."""
    tables, facts = _places(folder, key)
    if not facts.is_file():
        return None
    try:
        content = read_json(facts, LARGEST_FACTS)
        sides = read_store(read_bytes(tables), tables).sides
        made = WovenSurface(
            Measured(**sides),
            Sheet(**content["sheet"]),
            np.array(content["reflected"]),
            np.array(content["passed"]),
            max(side.error for side in sides.values()),
            content["rays"],
            content["seed"],
            key,
            tuple(content["notes"]),
        )
    except (FileFormatError, KeyError, TypeError):
        return None
    # What is used is not the oldest.
    facts.touch()
    return made


def _places(folder: Path, key: str) -> tuple[Path, Path]:
    return folder / f"{key}.lumbsdf", folder / f"{key}.json"
