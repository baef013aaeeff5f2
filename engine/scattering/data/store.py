"""Files of our own for scattering: ``.lumbsdf``, an archive of arrays (see `reading.array_archive`).

Its facts name the version, the material, and of every side which kind of data it has; arrays are called
``<side>.<name>``. Values are half-precision numbers times a scale, which costs 0.05 % at most. What is written of them
are the differences of their bits, taken as integers, from neighbour to neighbour, the low bytes before the high ones: a
smooth table packs to half the size so.
"""

import io
from pathlib import Path

import numpy as np

from ...errors import FileFormatError, SceneError
from ...reading.array_archive import (
    ArrayArchive,
    Schema,
    refuse_damage,
    starts_archive,
    write_archive,
)
from ...reading.remarks import Remark
from ...reading.whole_file import write_whole
from ...scene.scattering import PatchBasis, PatchMatrix, Scatter, ScatterTable, TensorTree
from .record import SIDES, ScatteringFile
from .surface import check

FORMAT = "Lumenray scattering"

VERSION = 2

SCHEMA = Schema(("|u1", "<f4", "<f8", "<i4"), largest=1 << 28, longest=1 << 16)

LONGEST_WORDS, LONGEST_REMARK, MOST_REMARKS = 4000, 500, 50
"""Characters of a name, description or source, and of a remark, and remarks; the rest is cut off."""

_ARRAYS = {
    "table": ("rotations", "incidences", "radials", "azimuths", "wavelengths", "values", "direct"),
    "matrix": ("in_bounds", "in_counts", "out_bounds", "out_counts", "wavelengths", "values"),
    "tree": ("children", "wavelengths", "values"),
}
_NEIGHBOURS = {"table": (3, 2), "matrix": (1,), "tree": (0,)}
"""Axes along which differences are taken, one after the other."""


def is_store(data: bytes) -> bool:
    """Whether a content may be a file of ours."""
    return starts_archive(data)


def pack(file: ScatteringFile) -> bytes:
    """Return the content of a file that holds what was read or computed; sides that share data are written once."""
    arrays, sides, seen = {}, {}, {}
    for side, scatter in file.sides.items():
        if id(scatter) in seen:
            sides[side] = {"same_as": seen[id(scatter)]}
            continue
        seen[id(scatter)] = side
        sides[side], own = _dismantle(scatter)
        arrays |= {f"{side}.{name}": array for name, array in own.items()}
    facts = {
        "version": VERSION,
        "name": file.name[:LONGEST_WORDS],
        "description": file.description[:LONGEST_WORDS],
        "source": file.source[:LONGEST_WORDS],
        "sides": sides,
        "remarks": [remark.text[:LONGEST_REMARK] for remark in file.remarks[:MOST_REMARKS]],
    }
    content = io.BytesIO()
    write_archive(content, SCHEMA, facts, arrays, level=9)
    return content.getvalue()


def write_store(path, file: ScatteringFile) -> None:
    """Write a file of ours.

    Raises
    ------
    FileFormatError    It cannot be written.
    """
    with write_whole(path) as stream:
        stream.write(pack(file))


def read_store(data: bytes, path) -> ScatteringFile:
    """Read a file of ours.

    Raises
    ------
    FileFormatError    It is damaged, too large, or of a later version.
    """
    try:
        with refuse_damage(path, "expected scattering data as they were written; get it anew"):
            return _read(ArrayArchive(io.BytesIO(data), SCHEMA), path)
    except SceneError as error:
        raise FileFormatError(path, str(error)) from None


def _read(archive: ArrayArchive, path) -> ScatteringFile:
    facts = archive.facts
    if facts["version"] != VERSION:
        raise FileFormatError(
            path,
            f"has the version {facts['version']!r}, expected {VERSION}; another version of Lumenray made it, "
            "make it again from its source",
        )
    arrays = archive.arrays()
    sides: dict[str, Scatter] = {}
    for side, own in facts["sides"].items():
        if side not in SIDES:
            raise ValueError(f"unknown side {side!r}")
        if "same_as" in own:
            sides[side] = sides[own["same_as"]]
        else:
            names = {name: f"{side}.{name}" for name in _ARRAYS[own["kind"]]}
            sides[side] = _assemble(
                own, {name: arrays[entry] for name, entry in names.items() if entry in arrays}
            )
            check(sides[side])
    if not sides:
        raise ValueError("no side has data")
    words = [str(facts[name]) for name in ("name", "description", "source")]
    remarks = tuple(Remark(str(text)) for text in facts["remarks"][:64])
    return ScatteringFile(Path(path), FORMAT, sides, *words, remarks=remarks)


def _dismantle(scatter: Scatter) -> tuple[dict, dict[str, np.ndarray]]:
    match scatter:
        case ScatterTable():
            axes = ("rotations", "incidences", "radials", "azimuths", "wavelengths")
            arrays = {name: getattr(scatter, name) for name in axes}
            if scatter.direct is not None:
                arrays["direct"] = scatter.direct.astype("<f4")
            facts = {
                "kind": "table",
                "error": float(scatter.error),
                "is_orthotropic": bool(scatter.is_orthotropic),
            }
        case PatchMatrix():
            arrays = {"wavelengths": scatter.wavelengths}
            for name, basis in (("in", scatter.incoming), ("out", scatter.outgoing)):
                arrays[f"{name}_bounds"] = basis.bounds
                arrays[f"{name}_counts"] = basis.counts.astype("<i4")
            facts = {"kind": "matrix"}
        case TensorTree():
            arrays = {
                "wavelengths": scatter.wavelengths,
                "children": scatter.children.astype("<i4"),
            }
            facts = {"kind": "tree", "rank": int(scatter.rank)}
    largest = float(scatter.values.max(initial=0.0))
    facts["scale"] = largest / 60000.0 if largest > 0.0 else 1.0
    arrays["values"] = _differences((scatter.values / facts["scale"]).astype("<f2"), facts["kind"])
    return facts, arrays


def _differences(values: np.ndarray, kind: str) -> np.ndarray:
    """Half-precision values (...) as planes of bytes (2, ...) of the differences between neighbours."""
    bits = values.view("<u2")
    for axis in _NEIGHBOURS[kind]:
        bits = np.diff(bits, axis=axis, prepend=np.zeros_like(np.take(bits, [0], axis=axis)))
    return np.moveaxis(np.ascontiguousarray(bits)[..., None].view("|u1"), -1, 0)


def _sums(planes: np.ndarray, kind: str) -> np.ndarray:
    """Half-precision values (...) from what `_differences` made of them."""
    bits = np.ascontiguousarray(np.moveaxis(planes, 0, -1)).view("<u2")[..., 0]
    for axis in reversed(_NEIGHBOURS[kind]):
        bits = np.cumsum(bits, axis=axis, dtype="<u2")
    return bits.view("<f2")


def _assemble(facts: dict, arrays: dict[str, np.ndarray]) -> Scatter:
    scale = float(facts["scale"])
    if not 0.0 < scale < 1e30:
        raise ValueError(f"scale {scale}")
    values = _sums(arrays["values"], facts["kind"]).astype(np.float32) * np.float32(scale)
    wavelengths = arrays["wavelengths"].astype(np.float64)
    match facts["kind"]:
        case "table":
            axes = [arrays[n].astype(np.float64) for n in _ARRAYS["table"][:4]]
            direct = arrays.get("direct")
            direct = None if direct is None else direct.astype(np.float32)
            error = float(facts["error"])
            if not 0.0 <= error < 1e6:
                raise ValueError(f"error {error}")
            is_orthotropic = facts.get("is_orthotropic", False) is True
            return ScatterTable(*axes, wavelengths, values, direct, error, is_orthotropic)
        case "matrix":
            bases = [
                PatchBasis(
                    arrays[f"{name}_bounds"].astype(np.float64),
                    arrays[f"{name}_counts"].astype(np.int32),
                )
                for name in ("in", "out")
            ]
            return PatchMatrix(*bases, wavelengths, values)
        case "tree":
            return TensorTree(
                int(facts["rank"]), arrays["children"].astype(np.int32), wavelengths, values
            )
    raise ValueError(f"unknown kind {facts['kind']!r}")
