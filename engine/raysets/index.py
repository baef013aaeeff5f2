"""A prepared ray file kept beside it, so that it need not be prepared again: ``led.ray`` gets ``led.ray.prepared``.

The index is an archive of arrays (see `reading.array_archive`). It names the size and date of the ray file and how it was
prepared; where any of it differs, the index is out of date.
"""

import io
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from ..errors import FileFormatError
from ..reading.array_archive import ArrayArchive, Schema, refuse_damage, write_archive
from ..reading.content import read_bytes
from ..reading.remarks import Remark
from ..reading.whole_file import write_whole
from ..scene.distribution import IntensityDistribution
from ..scene.ray_emission import (
    BANDS,
    GROUP,
    HULL,
    PLANE,
    SPHERE,
    DirectionWeight,
    RayBody,
    RayEmission,
)
from .emission import HELD, RayLight, Wish, prepare_light

SUFFIX = ".prepared"
"""Of the index, after the whole name of the ray file."""

VERSION = 3
"""Of what is prepared and how it is written; another one is out of date."""

LARGEST = 1 << 26
"""Most bytes that all arrays of an index may have together."""

SCHEMA = Schema(("<f4", "<f8", "<u4"), LARGEST, longest=1 << 20)

_EMISSION = (
    "position",
    "direction",
    "factor",
    "threshold",
    "other",
    "wavelength",
    "axis",
    "half",
)
_WEIGHT = {"band_axis": "axis", "bands": "bands", "moments": "moments"}
"""Arrays of the weight by direction."""
_FAR = ("far_distances", "far_errors")
_NUMBERS = ("size", "near", "information_error")


def index_path(path: str | Path) -> Path:
    """Where the index of a ray file lies."""
    path = Path(path)
    return path.with_name(path.name + SUFFIX)


def save_light(path: str | Path, light: RayLight, wish: Wish, key: list | None = None) -> Path:
    """Write the index of a ray file; return its path. ``key``: `state_of` the file when it was read; None: as it is now.

    Raises
    ------
    FileFormatError    It cannot be written.
    """
    target = index_path(path)
    emission, body = light.emission, light.emission.body
    arrays = {name: getattr(emission, name) for name in (*_EMISSION, *_FAR)}
    arrays |= {name: getattr(emission.weight, own) for name, own in _WEIGHT.items()}
    arrays |= {"slabs": body.slabs, "body_centre": body.centre, "body_normal": body.normal}
    arrays |= {
        name: getattr(light.distribution, name) for name in ("azimuth", "polar", "intensity")
    }
    arrays["centre"] = light.centre
    if light.spectrum is not None:
        arrays["wavelengths"], arrays["powers"] = light.spectrum
    facts = {
        "key": key or state_of(path, wish),
        "numbers": {name: float(getattr(emission, name)) for name in _NUMBERS},
        "weight": [float(emission.weight.middle), float(emission.weight.mean)],
        "body": [body.kind, body.is_one_sided, float(body.radius), light.body],
        "luminous_flux": light.luminous_flux,
        "rays": light.rays,
        "remarks": [str(remark) for remark in light.remarks],
    }
    with write_whole(target) as file:
        write_archive(file, SCHEMA, facts, {name: a for name, a in arrays.items() if a is not None})
    return target


def load_light(path: str | Path, wish: Wish) -> RayLight | None:
    """Read the index of a ray file; None where there is none, or it is out of date.

    Raises
    ------
    FileFormatError    It is damaged.
    """
    source = index_path(path)
    if not source.exists():
        return None
    with refuse_damage(source, "expected what was written beside the ray file; delete it"):
        archive = ArrayArchive(io.BytesIO(read_bytes(source, LARGEST)), SCHEMA)
        if archive.facts["key"] != state_of(path, wish):
            return None
        return _light_of(archive.facts, archive.arrays())


def obtain_light(
    path: str | Path,
    wish: Wish | None = None,
    is_kept: bool = False,
    is_fresh: bool = False,
    progress: Callable[[float], None] | None = None,
    cancelled: Callable[[], bool] = lambda: False,
) -> RayLight:
    """Prepare a ray file, or read its index where that is of use.

    Parameters
    ----------
    path : str or Path
    wish, progress, cancelled :    As of `prepare_light`.
    is_kept : bool    Whether an index is written where there is none of use; if it cannot be, a remark says so.
    is_fresh : bool    Whether the rays are prepared even if there is an index.

    Raises
    ------
    FileFormatError    Of the ray file; a damaged index is told and replaced.
    Cancelled
    """
    wish = wish or Wish()
    told: tuple[Remark, ...] = ()
    try:
        known = None if is_fresh else load_light(path, wish)
    except FileFormatError as error:
        known, told = None, (Remark(f"{error}; the rays were prepared anew"),)
    if known is not None:
        return known
    key = state_of(path, wish)
    light = prepare_light(path, wish, progress, cancelled)
    light = replace(light, remarks=(*light.remarks, *told))
    if is_kept:
        try:
            save_light(path, light, wish, key)
        except FileFormatError as error:
            light = replace(light, remarks=(*light.remarks, Remark(f"{error}; it is not kept")))
    return light


# ---- private ----


def state_of(path: str | Path, wish: Wish) -> list:
    """What must be the same for an index to be of use: date and size of the file, and what is asked for.

    Raises
    ------
    FileFormatError    There is no such file.
    """
    try:
        found = Path(path).stat()
    except OSError as error:
        raise FileFormatError(path, f"cannot be opened ({error.strerror})") from None
    return [VERSION, found.st_size, found.st_mtime_ns, asdict(wish)]


def _light_of(facts: dict, arrays: dict[str, np.ndarray]) -> RayLight:
    count = len(arrays["threshold"])
    if not 1 <= count <= HELD:
        raise ValueError(f"{count} rays")
    _check(arrays, count)
    kind, is_one_sided, radius, body_text = facts["body"]
    if kind not in {PLANE, SPHERE, HULL}:
        raise ValueError(f"a body of the kind '{kind}'")
    body = RayBody(
        kind,
        arrays["body_centre"],
        arrays["body_normal"],
        bool(is_one_sided),
        _number(radius),
        arrays["slabs"],
    )
    numbers = {name: _number(facts["numbers"][name]) for name in _NUMBERS}
    middle, mean = (_number(value) for value in facts["weight"])
    if not min(numbers["size"], middle, mean) > 0.0:
        raise ValueError("a source without a size")
    weight = DirectionWeight(
        **{own: arrays[name] for name, own in _WEIGHT.items()}, middle=middle, mean=mean
    )
    columns = {name: arrays.get(name) for name in (*_EMISSION, *_FAR)}
    emission = RayEmission(**columns, body=body, weight=weight, **numbers)
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


def _check(arrays: dict[str, np.ndarray], count: int) -> None:
    """Refuse arrays that do not fit each other, or hold what is no number."""
    groups = -(-count // GROUP)
    shapes = {
        "position": (count, 3), "direction": (count, 3), "factor": (groups, 6, 6), "threshold": (count,),
        "other": (count,), "wavelength": (count,), "axis": (2, 3), "band_axis": (3,), "bands": (BANDS + 1,),
        "moments": (9,), "centre": (3,), "half": (3,),
        "body_centre": (3,), "body_normal": (3,),
    }  # fmt: skip
    optional = {"wavelength", "axis"}
    for name, shape in shapes.items():
        array = arrays.get(name)
        if array is None and name in optional:
            continue
        if arrays[name].shape != shape:
            raise ValueError(f"'{name}' has the shape {arrays[name].shape}, expected {shape}")
    for name in ("far_distances", "azimuth", "polar", "wavelengths"):
        grid = arrays.get(name, np.zeros(0))
        if grid.ndim != 1 or (np.diff(grid) <= 0.0).any():
            raise ValueError(f"'{name}' does not rise")
    pairs = (("far_distances", "far_errors"), ("wavelengths", "powers"))
    if any(arrays.get(a, np.zeros(0)).shape != arrays.get(b, np.zeros(0)).shape for a, b in pairs):
        raise ValueError("two tables that belong together differ in length")
    if not (arrays["far_distances"] > 0.0).all():
        raise ValueError("a distance is not above 0")
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            raise ValueError(f"'{name}' holds what is no finite number")
    slabs = arrays["slabs"]
    if slabs.ndim != 2 or slabs.shape[1] != 5:
        raise ValueError(f"'slabs' has the shape {slabs.shape}")
    if arrays["other"].dtype != np.uint32 or arrays["other"].max() >= count:
        raise ValueError("'other' names rays that there are not")


def _number(value) -> float:
    """A finite number, of which none here is negative."""
    value = float(value)
    if not 0.0 <= value < 1e300:
        raise ValueError(f"{value}, expected a number of at least 0")
    return value
