"""A prepared ray file kept beside it, so that it need not be prepared again: ``led.ray`` gets ``led.ray.prepared``.

The index is a zip archive of NumPy arrays without pickled objects, and a text in JSON. It names the size and date of the
ray file and how it was prepared; where any of it differs, the index is out of date. What comes from the file is checked as
if a stranger had written it.
"""

import io
import json
import math
import struct
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from ..errors import FileFormatError
from ..luminaires.record import Remark
from ..scene.distribution import IntensityDistribution
from ..scene.ray_emission import GROUP, HULL, PLANE, SPHERE, RayBody, RayEmission
from .emission import HELD, RayLight, Wish, prepare_light

SUFFIX = ".prepared"
"""Of the index, after the whole name of the ray file."""

VERSION = 1
"""Of what is prepared and how it is written; another one is out of date."""

LARGEST = 1 << 26
"""Most bytes that all arrays of an index may have together."""

_DAMAGE = (
    zipfile.BadZipFile, zlib.error, struct.error, ValueError, KeyError, IndexError, TypeError, AttributeError,
    OverflowError, NotImplementedError, RuntimeError, SyntaxError, EOFError,
)  # fmt: skip
"""What Python says of archives, texts and arrays that are not what they should be."""

_EMISSION = (
    "position",
    "direction",
    "factor",
    "threshold",
    "other",
    "wavelength",
    "axis",
    "moments",
)
_FAR = ("far_distances", "far_errors")
_NUMBERS = ("mean_weight", "size", "radius", "near", "information_error")


def index_path(path: str | Path) -> Path:
    """Where the index of a ray file lies."""
    path = Path(path)
    return path.with_name(path.name + SUFFIX)


def save_light(path: str | Path, light: RayLight, wish: Wish) -> Path:
    """Write the index of a ray file; return its path.

    Raises
    ------
    FileFormatError    It cannot be written.
    """
    target = index_path(path)
    emission, body = light.emission, light.emission.body
    arrays = {name: getattr(emission, name) for name in (*_EMISSION, *_FAR)}
    arrays |= {"slabs": body.slabs, "body_centre": body.centre, "body_normal": body.normal}
    arrays |= {
        name: getattr(light.distribution, name) for name in ("azimuth", "polar", "intensity")
    }
    arrays["centre"] = light.centre
    if light.spectrum is not None:
        arrays["wavelengths"], arrays["powers"] = light.spectrum
    facts = {
        "key": _key(path, wish),
        "numbers": {name: float(getattr(emission, name)) for name in _NUMBERS},
        "body": [body.kind, body.is_one_sided, float(body.radius), light.body],
        "luminous_flux": light.luminous_flux,
        "rays": light.rays,
        "remarks": [str(remark) for remark in light.remarks],
    }
    new = target.with_name(target.name + ".part")
    try:
        with zipfile.ZipFile(new, "w") as archive:
            archive.writestr("facts.json", json.dumps(facts))
            for name, array in arrays.items():
                if array is not None:
                    held = io.BytesIO()
                    np.save(held, np.ascontiguousarray(array), allow_pickle=False)
                    archive.writestr(f"{name}.npy", held.getvalue())
        new.replace(target)
    except OSError as error:
        raise FileFormatError(target, f"cannot be written ({error.strerror})") from None
    return target


def load_light(path: str | Path, wish: Wish) -> RayLight | None:
    """Read the index of a ray file; None where there is none, or it is out of date.

    Raises
    ------
    FileFormatError    It is damaged.
    """
    source = index_path(path)
    try:
        with zipfile.ZipFile(source) as archive:
            facts, arrays = _read(archive)
        if facts["key"] != _key(path, wish):
            return None
        return _light_of(facts, arrays)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise FileFormatError(source, f"cannot be read ({error.strerror})") from None
    except _DAMAGE as error:
        raise FileFormatError(
            source,
            f"is damaged ({error}), expected what was written beside the ray file; delete it",
        ) from None


def obtain_light(
    path: str | Path,
    wish: Wish | None = None,
    is_kept: bool = False,
    progress: Callable[[float], None] | None = None,
    cancelled: Callable[[], bool] = lambda: False,
) -> RayLight:
    """Prepare a ray file, or read its index where that is of use.

    Parameters
    ----------
    path : str or Path
    wish, progress, cancelled :    As of `prepare_light`.
    is_kept : bool    Whether an index is written where there is none of use.

    Raises
    ------
    FileFormatError    Of the ray file, or its index cannot be written; a damaged index is told and replaced.
    Cancelled
    """
    wish = wish or Wish()
    told: tuple[Remark, ...] = ()
    try:
        known = load_light(path, wish)
    except FileFormatError as error:
        known, told = None, (Remark(f"{error}; the rays were prepared anew"),)
    if known is not None:
        return known
    light = prepare_light(path, wish, progress, cancelled)
    light = replace(light, remarks=(*light.remarks, *told))
    if is_kept:
        save_light(path, light, wish)
    return light


# ---- private ----


def _key(path, wish: Wish) -> list:
    """What must be the same for an index to be of use."""
    try:
        found = Path(path).stat()
    except OSError as error:
        raise FileFormatError(path, f"cannot be opened ({error.strerror})") from None
    return [VERSION, found.st_size, found.st_mtime_ns, asdict(wish)]


def _read(archive: zipfile.ZipFile) -> tuple[dict, dict[str, np.ndarray]]:
    """Facts and arrays of an archive, which may unfold to no more than `LARGEST`."""
    entries = archive.infolist()
    if sum(entry.file_size for entry in entries) > LARGEST:
        raise ValueError(f"more than {LARGEST} bytes")
    facts, arrays = {}, {}
    for entry in entries:
        # No entry is stored compressed, so none can unfold to more than it says.
        if entry.compress_type != zipfile.ZIP_STORED:
            raise ValueError(f"'{entry.filename}' is compressed")
        data = archive.read(entry)
        if entry.filename == "facts.json":
            facts = json.loads(data)
        else:
            arrays[entry.filename.removesuffix(".npy")] = _array(data)
    return facts, arrays


def _array(data: bytes) -> np.ndarray:
    """Array of a file in NumPy's format, whose header may not promise more than there is."""
    file = io.BytesIO(data)
    if np.lib.format.read_magic(file) != (1, 0):
        raise ValueError("an array of an unknown version")
    shape, is_fortran, kind = np.lib.format.read_array_header_1_0(file)
    rest = data[file.tell() :]
    if is_fortran or kind.hasobject or math.prod(shape) * kind.itemsize != len(rest):
        raise ValueError(f"an array of {len(rest)} bytes does not have the shape {shape}")
    return np.frombuffer(rest, kind).reshape(shape)


def _light_of(facts: dict, arrays: dict[str, np.ndarray]) -> RayLight:
    count = len(arrays["threshold"])
    if not 1 <= count <= HELD:
        raise ValueError(f"{count} rays")
    groups = -(-count // GROUP)
    shapes = {
        "position": (count, 3), "direction": (count, 3), "factor": (groups, 6, 6), "threshold": (count,),
        "other": (count,), "wavelength": (count,), "axis": (2, 3), "moments": (9,), "centre": (3,),
        "body_centre": (3,), "body_normal": (3,),
    }  # fmt: skip
    optional = {"wavelength", "axis"}
    for name, shape in shapes.items():
        array = arrays.get(name)
        if array is None and name in optional:
            continue
        if arrays[name].shape != shape:
            raise ValueError(f"'{name}' has the shape {arrays[name].shape}, expected {shape}")
    for name, array in arrays.items():
        if array.dtype.kind not in "fu" or not np.isfinite(array).all():
            raise ValueError(f"'{name}' holds what is no finite number")
    slabs = arrays["slabs"]
    if slabs.ndim != 2 or slabs.shape[1] != 5:
        raise ValueError(f"'slabs' has the shape {slabs.shape}")
    if arrays["other"].dtype != np.uint32 or arrays["other"].max() >= count:
        raise ValueError("'other' names rays that there are not")
    kind, is_one_sided, radius, body_text = facts["body"]
    if kind not in {PLANE, SPHERE, HULL}:
        raise ValueError(f"a body of the kind '{kind}'")
    body = RayBody(
        kind,
        arrays["body_centre"],
        arrays["body_normal"],
        bool(is_one_sided),
        _number(radius),
        slabs,
    )
    numbers = {name: _number(facts["numbers"][name]) for name in _NUMBERS}
    emission = RayEmission(
        **{name: arrays.get(name) for name in (*_EMISSION, *_FAR)}, body=body, **numbers
    )
    azimuth, polar, intensity = (arrays[name] for name in ("azimuth", "polar", "intensity"))
    if intensity.shape != (len(azimuth), len(polar)) or (intensity < 0.0).any():
        raise ValueError("the intensities do not fit their angles")
    flux = facts["luminous_flux"]
    spectrum = (arrays["wavelengths"], arrays["powers"]) if "wavelengths" in arrays else None
    return RayLight(
        emission,
        IntensityDistribution(azimuth, polar, intensity),
        arrays["centre"],
        None if flux is None else _number(flux),
        spectrum,
        int(facts["rays"]),
        str(body_text),
        tuple(Remark(str(text)) for text in facts["remarks"]),
    )


def _number(value) -> float:
    """A finite number, of which none here is negative."""
    value = float(value)
    if not 0.0 <= value < 1e300:
        raise ValueError(f"{value}, expected a number of at least 0")
    return value
