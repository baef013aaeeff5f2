"""Lux maps of light groups added up at other levels: from the files of a bake with layers, exactly and without computing."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import FileFormatError, SceneError
from ..formats import exr
from ..formats.names import file_stem
from ..formats.report import write_json
from ..light_mix import LightMix
from ..reading.content import read_bytes

LARGEST_REPORT = 1 << 28
"""[byte]"""

SAME = 1e-3
"""Share of the mean by which the sum of the layers may differ from the whole; more: a layer is missing. [-]"""

OBJECT, AREA = "object.Y", "area.Y"
"""Channels with the number of the object of each lumel, from 0, and the surface in it. [m2]"""

NOTE = (
    "noise is at most that of the whole times the largest factor, as that of single groups is not kept; extremes are those "
    "of the lumels, to which noise adds"
)
"""What a reader of mixed maps has to know."""


@dataclass(frozen=True)
class MixedMap:
    """Illuminance of an object with its light groups at other levels.

    Parameters
    ----------
    name : str
    mean, mean_error : float    Area-weighted, and the bound of its standard error; NaN where the bake did not know it. [lx]
    least, largest : float    Of its lumels. [lx]
    before : float    Mean of the bake. [lx]
    """

    name: str
    mean: float
    mean_error: float
    least: float
    largest: float
    before: float

    @property
    def uniformity(self) -> float:
        """Least over mean, 0 in the dark. [-]"""
        return self.least / self.mean if self.mean > 0.0 else 0.0


def groups_of(folder) -> list[str]:
    """Return the light groups whose layers lie in the folder of a bake, as names of files have them.

    Raises
    ------
    FileFormatError    There are none.
    """
    folder = Path(folder)
    stems = {path.name.split(".")[0].removeprefix("illuminance_") for path in _layers(folder)}
    if not stems:
        raise FileFormatError(
            folder,
            "holds no lux maps of light groups, illuminance_GROUP.1001.exr; bake with layers",
        )
    return sorted(stems)


def mix_maps(folder, levels: LightMix, target) -> tuple[list[MixedMap], list[Path]]:
    """Add up the layers of a bake and write the sum as pages and as mix.json.

    Parameters
    ----------
    folder : str or Path    Of a bake with layers.
    levels : LightMix    Of its groups by name; others shine as they are. Colours are left out, as these are lux.
    target : str or Path    Folder to write into.

    Returns
    -------
    list of MixedMap, list of Path    Of the objects, and the files that were written.

    Raises
    ------
    FileFormatError    A file of the bake is missing, damaged or of another bake, or one cannot be written.
    SceneError    A level is of no group.
    """
    folder, target = Path(folder), Path(target)
    stems = groups_of(folder)
    factors = dict.fromkeys(stems, 1.0)
    for level in levels.levels:
        stem = file_stem(level.name)
        if stem not in stems:
            raise SceneError(
                f"the bake has no light group '{level.name}'; it has {', '.join(stems)}"
            )
        factors[stem] = level.flux
    rows = _rows(folder)
    sums = _Sums(len(rows))
    files = []
    for whole in sorted(folder.glob("illuminance.*.exr")):
        tile = whole.name.split(".")[1]
        channels = exr.read_channels(whole)
        if OBJECT not in channels or "Y" not in channels:
            raise FileFormatError(
                whole, f"has no channel {OBJECT}, as bakes with layers have; bake again"
            )
        total, plain = np.zeros(channels["Y"].shape), np.zeros(channels["Y"].shape)
        for stem, factor in factors.items():
            path = folder / f"illuminance_{stem}.{tile}.exr"
            layer = exr.read_channels(path)["Y"].astype(np.float64)
            if layer.shape != total.shape:
                raise FileFormatError(path, f"has another size than {whole.name}")
            total += factor * layer
            plain += layer
        shown = channels["covered.Y"] > 0.5
        _check_sum(whole, channels["Y"], plain, shown)
        error = max(factors.values()) * channels["standard_error.Y"]
        sums.add(total, channels, shown)
        files.append(
            exr.write_channels(
                target / whole.name,
                {**channels, "Y": total.astype(np.float32), "standard_error.Y": error},
                {"unit": "lx", "quantity": "illuminance", "mix": _text(factors)},
            )
        )
    made = sums.maps(rows, max(factors.values()))
    content = {
        "bake": str(folder),
        "light_groups": factors,
        "quantities": [
            {
                "name": each.name,
                "quantity": "illuminance",
                "unit": "lx",
                "mean": each.mean,
                "mean_standard_error_at_most": None
                if np.isnan(each.mean_error)
                else each.mean_error,
                "minimum": each.least,
                "maximum": each.largest,
                "uniformity": each.uniformity,
                "mean_of_bake": each.before,
            }
            for each in made
        ],
        "notes": [NOTE],
    }
    files.append(write_json(target / "mix.json", content))
    return made, files


class _Sums:
    """Sums over the lumels of each object."""

    def __init__(self, count: int):
        self._area, self._light = np.zeros(count), np.zeros(count)
        self._least, self._largest = np.full(count, np.inf), np.full(count, -np.inf)

    def add(self, values, channels, shown) -> None:
        """Take in a page."""
        numbers = channels[OBJECT][shown].astype(np.int64)
        values, area = values[shown], channels[AREA][shown].astype(np.float64)
        known = (numbers >= 0) & (numbers < len(self._area))
        numbers, values, area = numbers[known], values[known], area[known]
        np.add.at(self._area, numbers, area)
        np.add.at(self._light, numbers, area * values)
        np.minimum.at(self._least, numbers, values)
        np.maximum.at(self._largest, numbers, values)

    def maps(self, rows, factor: float) -> list[MixedMap]:
        """Figures of every object that has lumels."""
        made = []
        for number, row in enumerate(rows):
            if not self._area[number] > 0.0:
                continue
            error = row.get("mean_standard_error")
            made.append(
                MixedMap(
                    row["name"],
                    float(self._light[number] / self._area[number]),
                    float("nan") if error is None else factor * float(error),
                    float(self._least[number]),
                    float(self._largest[number]),
                    float(row["mean"]),
                )
            )
        return made


def _layers(folder: Path):
    return [path for path in folder.glob("illuminance_*.exr") if path.is_file()]


def _rows(folder: Path) -> list[dict]:
    """Rows of the report's objects, in the order of their numbers."""
    path = folder / "report.json"
    try:
        rows = json.loads(read_bytes(path, LARGEST_REPORT))["quantities"]
        for row in rows:
            float(row["mean"]), str(row["name"])
    except (ValueError, KeyError, TypeError) as error:
        raise FileFormatError(path, f"is no report of a bake ({error})") from None
    return rows


def _check_sum(path: Path, whole, plain, shown) -> None:
    """See that the layers that are there are all."""
    apart, mean = float(np.abs(whole - plain)[shown].mean()), float(np.abs(whole)[shown].mean())
    if shown.any() and apart > SAME * mean:
        raise FileFormatError(
            path,
            f"differs by {100.0 * apart / mean:.2g} % from the sum of its light groups, so one is missing",
        )


def _text(factors: dict[str, float]) -> str:
    return ", ".join(f"{stem} {factor:g}" for stem, factor in factors.items())
