"""Files of a bake: every map with its error as OpenEXR and in false colours, all maps on one sheet, the report."""

from pathlib import Path

import numpy as np

from ..analysis.false_colour import nice_maximum, write_false_colour
from ..atlas.sheet import compose_sheet
from . import exr
from .names import file_stem
from .report import compose, quantity_of_map, write_json


def write_lux_maps(folder, maps, file: str, conversion) -> list[Path]:
    """Write all files of a bake.

    Parameters
    ----------
    folder : str or Path
    maps : list of session.LuxMap    At least one.
    file : str    Name of the scene's file.
    conversion : list of dict    Rows of the conversion report.

    Returns
    -------
    list of Path    What was written.

    Raises
    ------
    FileFormatError    A file cannot be written.
    """
    folder = Path(folder)
    high = nice_maximum(np.concatenate([m.illuminance[m.covered] for m in maps]))
    files = []
    for made in maps:
        stem = folder / file_stem(made.name)
        attributes = {
            "unit": "lx",
            "quantity": "illuminance",
            "object": made.name,
            "sceneHash": made.provenance.scene_hash,
            "seed": str(made.provenance.seed),
            "samples": str(made.samples),
        }
        values = {"Y": made.illuminance, "standard_error.Y": made.standard_error}
        path = stem.with_name(stem.name + "_illuminance.exr")
        files.append(exr.write_channels(path, values, attributes))
        files.append(
            write_false_colour(
                path.with_suffix(".png"), made.illuminance, made.covered, made.name, high=high
            )
        )
    files += _write_sheet(folder, maps, high)
    content = compose(
        file,
        maps[0].provenance,
        sum(made.provenance.seconds for made in maps),
        [quantity_of_map(made) for made in maps],
        conversion,
    )
    files.append(write_json(folder / "report.json", content))
    return files


def _write_sheet(folder: Path, maps, high: float) -> list[Path]:
    """Write all maps on one sheet, for looking at and for tools that want one file."""
    sheet = compose_sheet(maps)
    values = {"Y": sheet.illuminance, "standard_error.Y": sheet.standard_error}
    attributes = {
        "unit": "lx",
        "quantity": "illuminance",
        "sceneHash": maps[0].provenance.scene_hash,
    }
    captions = [(name, x, y + height) for name, x, y, _, height in sheet.places]
    return [
        exr.write_channels(folder / "illuminance_atlas.exr", values, attributes),
        write_false_colour(
            folder / "illuminance_atlas.png",
            sheet.illuminance,
            sheet.covered,
            "Illuminance",
            high=high,
            captions=captions,
        ),
    ]
