"""From what JSON says about a luminaire to its `Model`; what it can say stands in `catalogue`."""

import math
from pathlib import Path

from .. import spectra
from ..entries import UnusableError, is_number, path_inside, text_of
from .model import MOUNTS, SHAPES, Light, Model, Part

SHARE_TOLERANCE = 1e-4
"""By how much the sum of the shares may differ from 1."""

HANGING = 0.5
"""Of pendants below the ceiling, if not stated. [m]"""


def describe(folder: Path, path: Path, entry: dict) -> Model:
    """Make the model of a photometric file.

    Parameters
    ----------
    folder : Path    Of the library.
    path : Path    Of the file, below it.
    entry : dict    What the descriptions say, put together.

    Raises
    ------
    UnusableError    Something in the entry cannot be.
    """
    where = "/".join(path.parent.relative_to(folder).parts)
    mount = text_of(entry, "mount", "ceiling")
    if mount not in MOUNTS:
        raise UnusableError(f"'mount' is '{mount}', expected one of {', '.join(MOUNTS)}")
    tags = entry.get("tags", [])
    if not isinstance(tags, list) or not all(isinstance(tag, str) for tag in tags):
        raise UnusableError("'tags' should be a list of texts")
    picture = path_inside(folder, entry["thumbnail"]) if "thumbnail" in entry else None
    if picture is None and "thumbnail" in entry:
        raise UnusableError("'thumbnail' should lie in the library's folder")
    return Model(
        name=text_of(entry, "name", path.stem),
        file=path,
        title=text_of(entry, "title", path.stem),
        description=text_of(entry, "description"),
        category="/".join(part.strip() for part in text_of(entry, "category", where).split("/")),
        maker=text_of(entry, "maker"),
        author=text_of(entry, "author"),
        licence=text_of(entry, "licence"),
        tags=tuple(tags),
        light=_light(entry.get("spectrum")),
        luminous_flux=_number(entry, "luminous_flux_lm", None),
        watts=_number(entry, "watts", None),
        mount=mount,
        height=_number(entry, "height_m", 2.5),
        drop=_number(entry, "drop_m", HANGING if mount == "pendant" else 0.0),
        thumbnail=picture,
        parts=_parts(entry.get("parts", [])),
    )


def _number(entry, key, default) -> float | None:
    value = entry.get(key, default)
    if value is None:
        return None
    if not is_number(value, 0.0, 1e9):
        raise UnusableError(f"'{key}' should be a number that is not negative")
    return float(value)


def _light(entry) -> Light | None:
    if entry is None:
        return None
    if not isinstance(entry, dict) or len(entry) != 1:
        raise UnusableError(
            "'spectrum' should hold one of 'illuminant', 'blackbody_K', 'daylight_K'"
        )
    (kind, value), *_ = entry.items()
    if kind == "illuminant":
        if value not in spectra.illuminant_names():
            raise UnusableError(f"there is no illuminant '{value}'")
        return Light("illuminant", name=value)
    ranges = {"blackbody_K": (500.0, 40000.0), "daylight_K": (4000.0, 25000.0)}
    if kind not in ranges:
        raise UnusableError(f"'spectrum' does not know '{kind}'")
    low, high = ranges[kind]
    if not is_number(value, low, high):
        raise UnusableError(f"'{kind}' should be from {low:g} to {high:g}")
    return Light(kind.removesuffix("_K"), temperature=float(value))


def _parts(entries) -> tuple[Part, ...]:
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise UnusableError("'parts' should be a list of objects")
    parts = tuple(_part(entry) for entry in entries)
    total = sum(part.share for part in parts)
    if parts and abs(total - 1.0) > SHARE_TOLERANCE:
        raise UnusableError(f"the shares of the parts add up to {total:.6g}, expected 1")
    return parts


def _part(entry) -> Part:
    opening = entry.get("opening", {})
    if not isinstance(opening, dict):
        raise UnusableError("'opening' should be an object")
    shape, own = opening.get("shape", "point"), opening.get("axis", "z")
    if shape not in SHAPES or own not in ("x", "y", "z"):
        raise UnusableError(
            f"an opening needs a 'shape' of {', '.join(SHAPES)} and an 'axis' x, y or z"
        )
    size = _vector(opening, "size_m", [0.0, 0.0, 0.0])
    axis = _vector(entry, "axis", [0.0, 0.0, 1.0])
    length = math.sqrt(sum(value * value for value in axis))
    if length < 1e-9 or min(size) < 0.0:
        raise UnusableError("an 'axis' must not be 0, a 'size_m' not negative")
    share = entry.get("share")
    if not is_number(share, 0.0):
        raise UnusableError("every part needs a 'share' of the flux")
    return Part(
        position=_vector(entry, "position_m", [0.0, 0.0, 0.0]),
        share=float(share),
        axis=tuple(value / length for value in axis),
        shape=shape,
        size=size,
        opening_axis=own,
    )


def _vector(entry, key, default) -> tuple[float, float, float]:
    value = entry.get(key, default)
    if not isinstance(value, list) or len(value) != 3 or not all(map(is_number, value)):
        raise UnusableError(f"'{key}' should be a list of three numbers")
    return tuple(map(float, value))
