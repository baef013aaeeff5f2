"""Files of a bake: every page as OpenEXR and in false colours, the graph of the error, the report."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..accuracy.stopping import StopRule
from ..analysis.error_graph import draw_error_graph, to_rows
from ..analysis.false_colour import nice_maximum, write_false_colour
from ..analysis.looking import WORDS
from ..analysis.value_plan import draw_map, even_scale
from ..formats import exr
from ..formats.names import file_stem
from ..formats.report import (
    compose,
    find_remarks,
    known,
    quantity_of_map,
    write_json,
    write_table,
)
from ..reading.whole_file import write_whole
from .mixed_maps import AREA, OBJECT
from .order import AtlasPage, BakeOrder, BakeResult

LINE_SMOOTHING = 1
"""How often neighbouring lumels are averaged before isolux lines are drawn, so that noise does not fray them."""

FIRST_TILE = 1001
"""Number by which Blender and others know the first tile of a picture in several parts (UDIM)."""


def tile_of(page: int) -> int:
    """Number of the tile that a page is."""
    return FIRST_TILE + page


def write_page(
    folder: Path,
    page: AtlasPage,
    attributes: dict,
    high: float,
    has_isolux: bool = False,
    has_arrays: bool = False,
) -> AtlasPage:
    """Write a page and its layers; returns it with the names of the files.

    ``high``: top of the false colours [lx]; ``has_isolux``: whether it is drawn with isolux lines too;
    ``has_arrays``: whether it is written as arrays too.

    Raises
    ------
    FileFormatError    A file cannot be written.
    """
    tile = tile_of(page.number)
    values = {
        "Y": page.illuminance,
        "standard_error.Y": page.standard_error,
        "covered.Y": page.covered.astype(np.float32),
    }
    if page.layers:
        # So that layers can be mixed by object, see `mixed_maps`.
        values[OBJECT] = np.where(page.covered, page.object, -1).astype(np.float32)
        values[AREA] = page.area
    base = {"unit": "lx", "quantity": "illuminance", "page": str(page.number), **attributes}
    path = folder / f"illuminance.{tile}.exr"
    files = [exr.write_channels(path, values, base)]
    files.append(
        write_false_colour(
            path.with_suffix(".png"),
            page.illuminance,
            page.covered,
            f"Illuminance, page {page.number + 1}",
            high=high,
        )
    )
    if has_isolux:
        files += _draw_isolux(folder / f"illuminance.{tile}.isolux", page, high)
    if has_arrays:
        files += _write_arrays(folder, page)
    for name, layer in page.layers.items():
        path = folder / f"illuminance_{file_stem(name)}.{tile}.exr"
        files.append(exr.write_channels(path, {"Y": layer}, {**base, "layer": name}))
    if page.exitance is not None:
        channels = {axis: page.exitance[..., k] for k, axis in enumerate("XYZ")}
        path = folder / f"exitance.{tile}.exr"
        more = {**base, "unit": "lm/m2", "quantity": "luminous exitance, X Y Z with Y in lm/m2"}
        if page.is_denoised:
            more["filter"] = WORDS
        files.append(exr.write_channels(path, channels, more))
    return replace(page, files=tuple(str(file) for file in files))


def _write_arrays(folder: Path, page: AtlasPage) -> list[Path]:
    """Write a page and its layers as .npy, (h, w) float32 with row 0 at the bottom. [lx]"""
    named = {
        "illuminance": page.illuminance,
        "standard_error": page.standard_error,
        "covered": page.covered,
        **{f"illuminance_{file_stem(name)}": layer for name, layer in page.layers.items()},
    }
    files = []
    for name, values in named.items():
        path = folder / f"{name}.{tile_of(page.number)}.npy"
        with write_whole(path) as stream:
            np.save(stream, np.ascontiguousarray(values, dtype="<f4"), allow_pickle=False)
        files.append(path)
    return files


def _draw_isolux(stem: Path, page: AtlasPage, high: float) -> list[Path]:
    """Draw a page in even false colours with isolux lines, as .png and as .svg."""
    known = page.illuminance[page.covered]
    scale = even_scale(known, "lx", high)
    title = f"Illuminance, page {page.number + 1}"
    sheet = draw_map(title, page.illuminance, page.covered, scale=scale, smoothing=LINE_SMOOTHING)
    return [sheet.save(stem.with_name(f"{stem.name}.{end}")) for end in ("png", "svg")]


def scale_top(illuminance: np.ndarray) -> float:
    """Round number under which nearly all lumels lie, for false colours. [lx]"""
    return nice_maximum(illuminance) if len(illuminance) else 1.0


def absolute_error(result: BakeResult) -> float:
    """Standard error of everything: root mean square by area. Infinite where it is not known. [lx]"""
    if result.mean > 0.0:
        return result.mean * result.relative_standard_error
    # An error in lx exists where nothing arrives, too, but the relative one does not lead to it.
    area = variance = 0.0
    for page in result.pages:
        if page.standard_error is None:
            return math.inf
        own = page.area[page.covered].astype(np.float64)
        area += float(own.sum())
        variance += float((own * page.standard_error[page.covered].astype(np.float64) ** 2).sum())
    return math.sqrt(variance / area) if area > 0.0 else math.inf


def find_shortfall(rule: StopRule, result: BakeResult) -> str:
    """Say what of its rule a bake has not met, because it was stopped or samples or time ended; empty if it has."""
    if result.shortfall:
        return result.shortfall
    return rule.shortfall(result.relative_standard_error, absolute_error(result))


def write_report(folder: Path, order: BakeOrder, result: BakeResult, conversion) -> list[Path]:
    """Write the graph of the error, the table of maps and the report.

    Raises
    ------
    FileFormatError    A file cannot be written.
    """
    folder = Path(folder)
    files = []
    if result.history.marks:
        graph = folder / "error.png"
        draw_error_graph(result.history, graph)
        files.append(graph)
    first = result.maps[0].provenance
    quantities = [quantity_of_map(made) for made in result.maps]
    shortfall = find_shortfall(order.rule, result)
    remarks = find_remarks(conversion, first.notes, shortfall)
    files.append(write_table(folder / "report.csv", quantities, remarks))
    content = compose(order.file, first, first.seconds, quantities, conversion, shortfall)
    content["atlas"] = {
        "pages": [[page.width, page.height] for page in result.pages],
        "mean": result.mean,
        "unit": "lx",
        "relative_standard_error": known(result.relative_standard_error),
        "error_over_quadratic_mean": known(result.quadratic_relative_error),
        "density_factor": result.shrink,
        "seams": {
            "places": result.seams.pairs,
            "step_before": result.seams.before,
            "step_after": result.seams.after,
            "step_standard_error": result.seams.noise,
        },
        "error_over_time": to_rows(result.history),
    }
    if result.balance is not None:
        content["energy"] = result.balance
    files.append(write_json(folder / "report.json", content))
    return files
