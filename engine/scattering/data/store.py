"""Files of our own for scattering: ``.lumbsdf``, a zip archive of NumPy arrays without pickled objects, and a text in JSON.

``facts.json`` names the version, the material, and of every side which kind of data it has; arrays are called
``<side>.<name>.npy``. Values are half-precision numbers times a scale, which costs 0.05 % at most. What is written of them
are the differences of their bits, taken as integers, from neighbour to neighbour, the low bytes before the high ones: a
smooth table packs to half the size so.
What comes from a file is checked as if a stranger had written it.
"""

import io
import json
import math
import struct
import zipfile
import zlib
from pathlib import Path

import numpy as np

from ...errors import FileFormatError, SceneError
from ...reading.remarks import Remark
from ...scene.scattering import PatchBasis, PatchMatrix, Scatter, ScatterTable, TensorTree
from .record import SIDES, ScatteringFile
from .surface import check

SUFFIX = ".lumbsdf"

FORMAT = "Lumenray scattering"

VERSION = 2

LARGEST = 1 << 28
"""Most bytes that all arrays of a file may have together."""

LONGEST_TEXT = 1 << 16
"""Of the facts. [byte]"""

LONGEST_WORDS, LONGEST_REMARK, MOST_REMARKS = 4000, 500, 50
"""Characters of a name, description or source, and of a remark, and remarks; the rest is cut off."""

_PACKINGS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_KINDS = tuple(np.dtype(kind) for kind in ("|u1", "<f4", "<f8", "<i4"))
_ARRAYS = {
    "table": ("rotations", "incidences", "radials", "azimuths", "wavelengths", "values", "direct"),
    "matrix": ("in_bounds", "in_counts", "out_bounds", "out_counts", "wavelengths", "values"),
    "tree": ("children", "wavelengths", "values"),
}
_NEIGHBOURS = {"table": (3, 2), "matrix": (1,), "tree": (0,)}
"""Axes along which differences are taken, one after the other."""

_DAMAGE = (
    zipfile.BadZipFile, zlib.error, struct.error, ValueError, KeyError, IndexError, TypeError, AttributeError,
    OverflowError, NotImplementedError, RuntimeError, SyntaxError, EOFError,
)  # fmt: skip
"""What Python says of archives, texts and arrays that are not what they should be."""


def is_store(data: bytes) -> bool:
    """Whether a content may be a file of ours."""
    return data[:4] == b"PK\x03\x04" and b"facts.json" in data[:64]


def pack(file: ScatteringFile) -> bytes:
    """Return the content of a file that holds what was read or computed; sides that share data are written once."""
    held, sides, seen = io.BytesIO(), {}, {}
    with zipfile.ZipFile(held, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        arrays = {}
        for side, scatter in file.sides.items():
            if id(scatter) in seen:
                sides[side] = {"same_as": seen[id(scatter)]}
                continue
            seen[id(scatter)] = side
            facts, own = _dismantle(scatter)
            sides[side] = facts
            arrays |= {f"{side}.{name}": array for name, array in own.items()}
        facts = {
            "version": VERSION,
            "name": file.name[:LONGEST_WORDS],
            "description": file.description[:LONGEST_WORDS],
            "source": file.source[:LONGEST_WORDS],
            "sides": sides,
            "remarks": [remark.text[:LONGEST_REMARK] for remark in file.remarks[:MOST_REMARKS]],
        }
        _add(archive, "facts.json", json.dumps(facts, ensure_ascii=False).encode())
        for name, array in arrays.items():
            content = io.BytesIO()
            np.save(content, np.ascontiguousarray(array), allow_pickle=False)
            _add(archive, f"{name}.npy", content.getvalue())
    return held.getvalue()


def _add(archive: zipfile.ZipFile, name: str, content: bytes) -> None:
    # A date of its own would make every writing another content.
    entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
    entry.compress_type = zipfile.ZIP_DEFLATED
    archive.writestr(entry, content, compresslevel=9)


def write_store(path, file: ScatteringFile) -> None:
    """Write a file of ours.

    Raises
    ------
    FileFormatError    It cannot be written.
    """
    path = Path(path)
    new = path.with_name(path.name + ".part")
    try:
        new.write_bytes(pack(file))
        new.replace(path)
    except OSError as error:
        raise FileFormatError(path, f"cannot be written ({error.strerror})") from None
    finally:
        new.unlink(missing_ok=True)


def read_store(data: bytes, path) -> ScatteringFile:
    """Read a file of ours.

    Raises
    ------
    FileFormatError    It is damaged, too large, or of a later version.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return _read(archive, path)
    except SceneError as error:
        raise FileFormatError(path, str(error)) from None
    except _DAMAGE as error:
        raise FileFormatError(
            path,
            f"is damaged ({error}), expected scattering data as they were written; get it anew",
        ) from None


def _read(archive: zipfile.ZipFile, path) -> ScatteringFile:
    entries = archive.infolist()
    if any(entry.compress_type not in _PACKINGS for entry in entries):
        raise ValueError("entries packed in an unusual way")
    if len({entry.filename for entry in entries}) < len(entries):
        raise ValueError("two entries of the same name")
    if sum(entry.file_size for entry in entries) > LARGEST or len(entries) > 64:
        raise FileFormatError(
            path,
            f"holds more than {LARGEST >> 20} MiB of arrays, expected less; resample it coarser",
        )
    facts = json.loads(_read_entry(archive, "facts.json", LONGEST_TEXT))
    if facts["version"] != VERSION:
        raise FileFormatError(
            path,
            f"has the version {facts['version']!r}, expected {VERSION}; another version of Lumenray made it, "
            "make it again from its source",
        )
    sides: dict[str, Scatter] = {}
    for side, own in facts["sides"].items():
        if side not in SIDES:
            raise ValueError(f"unknown side {side!r}")
        if "same_as" in own:
            sides[side] = sides[own["same_as"]]
        else:
            sides[side] = _assemble(own, _load(archive, side, own["kind"]))
            check(sides[side])
    if not sides:
        raise ValueError("no side has data")
    words = [str(facts[name])[:LONGEST_TEXT] for name in ("name", "description", "source")]
    remarks = tuple(Remark(str(text)) for text in facts["remarks"][:64])
    return ScatteringFile(Path(path), FORMAT, sides, *words, remarks=remarks)


def _read_entry(archive: zipfile.ZipFile, name: str, most: int) -> bytes:
    """Content of an entry, no more of it than its stated size, whatever is packed in it."""
    size = archive.getinfo(name).file_size
    if size > most:
        raise ValueError(f"entry {name} has {size} bytes, expected at most {most}")
    with archive.open(name) as entry:
        return entry.read(size)


def _load(archive: zipfile.ZipFile, side: str, kind: str) -> dict[str, np.ndarray]:
    """Arrays of one side, each as large as its entry says."""
    made = {}
    names = set(archive.namelist())
    for name in _ARRAYS[kind]:
        entry = f"{side}.{name}.npy"
        if entry not in names:
            continue
        content = io.BytesIO(_read_entry(archive, entry, LARGEST))
        version = np.lib.format.read_magic(content)
        if version != (1, 0):
            raise ValueError(f"array {entry} has the version {version}")
        shape, is_fortran, dtype = np.lib.format.read_array_header_1_0(content)
        size = math.prod(shape) * dtype.itemsize
        left = len(content.getbuffer()) - content.tell()
        if dtype not in _KINDS or is_fortran or size != left or len(shape) > 6:
            raise ValueError(f"array {entry} has {left} bytes for shape {shape} of {dtype}")
        made[name] = np.frombuffer(content.getbuffer()[content.tell() :], dtype).reshape(shape)
    return made


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
