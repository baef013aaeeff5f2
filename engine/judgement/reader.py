"""Files of requirements: TOML with a table for each activity."""

import math
import tomllib
from dataclasses import replace
from pathlib import Path

from ...libraries import requirements
from ..errors import FileFormatError, SceneError
from .requirement import AREAS, LIGHT, LIMITS, RATIOS, Requirement

LARGEST_FILE = 1 << 20
"""[byte]"""

LARGEST = 1e6
"""Largest value that may be asked for. [lx, cd/m2]"""

TEXTS = ("title", "source")


def read_requirements(path) -> dict[str, Requirement]:
    """Read a file of requirements.

    Parameters
    ----------
    path : str or Path
        ``standard`` and tables such as ``[office.writing]`` with ``title``, ``source``, and what is asked of areas
        (``task = { mean = 500, uniformity = 0.6 }``) and of the light (``light = { ugr = 19, ra = 80 }``). With
        ``direct = true`` before them only light counts that was not reflected.

    Returns
    -------
    dict of str to Requirement    By key.

    Raises
    ------
    FileFormatError    It says what was found and what was expected.
    """
    path = Path(path)
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise FileFormatError(path, f"is longer than {LARGEST_FILE} bytes")
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise FileFormatError(path, f"cannot be read ({error.strerror})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise FileFormatError(path, f"is no TOML ({error})") from None
    standard = content.pop("standard", "")
    if not isinstance(standard, str):
        raise FileFormatError(path, "expected a text for 'standard'")
    is_direct = content.pop("direct", False)
    if not isinstance(is_direct, bool):
        raise FileFormatError(path, "expected true or false for 'direct'")
    found = dict(_activities(path, standard, content, ()))
    if is_direct:
        found = {key: replace(each, is_direct=True) for key, each in found.items()}
    if not found:
        raise FileFormatError(path, "holds no activity, expected tables such as [office.writing]")
    return found


def known_requirements(paths=()) -> dict[str, Requirement]:
    """Requirements that ship, and those of users' files, which count where both have a key.

    Raises
    ------
    FileFormatError    As of `read_requirements`.
    """
    known = {}
    for path in (*requirements.files(), *paths):
        known |= read_requirements(path)
    return known


def find_requirement(key: str, paths=()) -> Requirement:
    """Requirement of a key, of the files that ship or of others.

    Raises
    ------
    SceneError    There is none of this key; the text names some.
    FileFormatError    As of `read_requirements`.
    """
    known = known_requirements(paths)
    if key in known:
        return known[key]
    group = key.partition(".")[0]
    near = [each for each in known if each.partition(".")[0] == group]
    near = near or sorted({each.partition(".")[0] for each in known})
    raise SceneError(f"there is no requirement '{key}'; there are {', '.join(near)}")


def _activities(path: Path, standard: str, table: dict, names: tuple[str, ...]):
    """Yield keys and requirements of tables in tables."""
    for name, entry in table.items():
        here = (*names, name)
        key = ".".join(here)
        if not isinstance(entry, dict):
            raise FileFormatError(path, f"expected a table for '{key}'")
        if "title" in entry:
            yield key, _requirement(path, standard, key, entry)
        else:
            yield from _activities(path, standard, entry, here)


def _requirement(path: Path, standard: str, key: str, entry: dict) -> Requirement:
    unknown = [name for name in entry if name not in {*TEXTS, *AREAS, "light"}]
    if unknown:
        expected = ", ".join([*TEXTS, *AREAS, "light"])
        raise FileFormatError(path, f"{key} has '{unknown[0]}', expected {expected}")
    for name in TEXTS:
        if not isinstance(entry.get(name, ""), str):
            raise FileFormatError(path, f"{key} needs a text for '{name}'")
    areas = {
        name: _limits(path, f"{key}, {name}", entry[name], LIMITS)
        for name in AREAS
        if name in entry
    }
    light = _limits(path, f"{key}, light", entry["light"], LIGHT) if "light" in entry else {}
    if not areas and not light:
        raise FileFormatError(path, f"{key} asks for nothing")
    return Requirement(key, entry["title"], standard, entry.get("source", ""), areas, light, path)


def _limits(path: Path, owner: str, table, known: dict) -> dict[str, float]:
    if not isinstance(table, dict) or not table:
        raise FileFormatError(
            path, f"{owner}: expected values such as {{ {next(iter(known))} = 1 }}"
        )
    for name, value in table.items():
        if name not in known:
            raise FileFormatError(path, f"{owner} has '{name}', expected {', '.join(known)}")
        most = 1.0 if name in RATIOS else LARGEST
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not is_number or not (math.isfinite(value) and 0.0 < value <= most):
            raise FileFormatError(
                path, f"{owner}: {name} is {value!r}, expected a number above 0 up to {most:g}"
            )
    return {name: float(value) for name, value in table.items()}
