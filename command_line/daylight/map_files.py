"""Maps of a year as files: a picture of numbers and one in false colours of every figure and page."""

from pathlib import Path

import numpy as np

from ...engine.baking.files import tile_of
from ...engine.baking.year_figures import KINDS, Kind
from ...engine.baking.year_maps import YearMaps


def first_map(folder: Path) -> Path:
    """Return the path of the first map in a folder."""
    return _path(folder, KINDS[0], 0)


def _path(folder: Path, kind: Kind, page: int) -> Path:
    return folder / f"{kind.name}.{tile_of(page)}.exr"


def write_maps(folder: Path, maps: YearMaps, facts: dict[str, str]) -> list[Path]:
    """Write all maps; ``facts``: attributes of the files.

    Raises
    ------
    FileFormatError    A file cannot be written.
    """
    from ...engine.analysis.false_colour import nice_maximum, write_false_colour
    from ...engine.formats import exr

    files = []
    for kind in KINDS:
        shown = [kind.factor * page.values[kind.name][page.covered] for page in maps.pages]
        high = kind.high or nice_maximum(np.concatenate(shown))
        for page in maps.pages:
            path = _path(folder, kind, page.number)
            values = page.values[kind.name]
            channels = {
                "Y": values,
                "standard_error.Y": page.errors[kind.name],
                "covered.Y": page.covered.astype(np.float32),
            }
            unit = "1" if kind.unit == "%" else kind.unit
            about = {"unit": unit, "quantity": kind.title, "page": str(page.number), **facts}
            files.append(exr.write_channels(path, channels, about))
            files.append(
                write_false_colour(
                    path.with_suffix(".png"),
                    kind.factor * values,
                    page.covered,
                    f"{kind.title}, page {page.number + 1}",
                    kind.unit,
                    high,
                )
            )
    return files


def summarise_maps(maps: YearMaps) -> list[dict]:
    """Return what is stated of the objects as plain data: their lumels, and figures of their area with errors."""
    from ...engine.daylight.tables import summarise

    return [
        {
            "object": each.surface.name,
            "lumels": each.lumels,
            "filled": each.filled,
            "lumels_per_metre": each.surface.density,
            "figures": {} if each.figures is None else summarise(each.figures),
        }
        for each in maps.objects
    ]
