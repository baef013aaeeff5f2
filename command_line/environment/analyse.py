"""The command ``lumenray environment analyse``: what a picture of the surroundings holds as light."""

from dataclasses import asdict
from pathlib import Path

from ..output import add_force, check_free, rounded, say, say_json, sheet
from .picture import add_map, find_coefficients, find_per_unit, sun_chooser


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    analyse = tasks.add_parser("analyse", help="range, illuminance of sun and sky, bright sources")
    add_map(analyse)
    analyse.add_argument(
        "-o", "--output", type=Path, metavar="OUT.png", help="picture with the sources marked"
    )
    add_force(analyse)
    analyse.add_argument("--dark", action="store_true", help="light letters on a dark ground")
    analyse.add_argument("--json", action="store_true", help="JSON instead of text")
    analyse.set_defaults(run=run)


def run(options) -> int:
    """Analyse a picture; return the exit code."""
    from ...engine.analysis.canvas import save_picture as write
    from ...engine.environment.analysis import analyse
    from ...engine.environment.map_file import read_map
    from ...engine.environment.marked_picture import draw_marked

    check_free(options, options.output)
    image, remarks = read_map(options.file)
    per_unit = find_per_unit(options, image)
    made = analyse(image, per_unit, find_coefficients(options), sun_chooser(options))
    row = describe(made, remarks)
    if options.json:
        say_json(rounded(row))
    else:
        say(tell(options.file.name, made, row["remarks"]))
    if options.output is not None:
        picture = draw_marked(image, made, options.file.name, dark=options.dark)
        write(picture, options.output)
    return 0


UNITS = {
    "elevation": "elevation_deg",
    "azimuth": "azimuth_deg",
    "row": "row_px",
    "column": "column_px",
    "diameter": "diameter_deg",
    "luminance": "luminance_cd_m2",
    "illuminance": "illuminance_lx",
    "horizontal": "horizontal_lx",
    "is_sun": "is_sun",
}
"""Names of the numbers of a source with their units."""


def describe_source(row) -> dict:
    """Return a source's row for JSON."""
    return {UNITS[key]: value for key, value in asdict(row).items()}


def describe(made, remarks) -> dict:
    """Row for JSON: numbers with their unit in the key, None where there is none."""
    nan, infinite, negative = made.faults
    faults = ((nan, "NaN"), (infinite, "infinite"), (negative, "negative"))
    told = [f"it has {count} {kind} pixels" for count, kind in faults if count]
    return {
        "width_px": made.width,
        "height_px": made.height,
        "luminance_per_unit_cd_m2": made.per_unit,
        "largest_luminance_cd_m2": made.largest,
        "range": made.range,
        "horizontal_lx": made.horizontal,
        "downward_lx": made.below,
        "horizontal_without_sources_lx": made.rest,
        "clipped_and_lights_over_whole": made.conserved,
        "sun_over_all_else": made.ratio,
        "mean_luminance_cd_m2": made.mean,
        "edge_luminance_cd_m2": made.edge,
        "wide_places": made.wide,
        "small_places": made.small,
        "sources": [describe_source(row) for row in made.sources],
        "verdict": list(made.verdict),
        "sun_doubts": list(made.doubts),
        "remarks": [*remarks, *told],
    }


def tell(name: str, made, remarks) -> str:
    """Text for people."""
    from ...engine.environment.analysis import format_range, format_ratio

    def lines():
        yield "pixels", f"{made.width} x {made.height}, a value of 1 is {made.per_unit:.4g} cd/m²"
        yield "range", f"{format_range(made.range)}, up to {made.largest:.3g} cd/m²"
        yield "horizontal", f"{made.horizontal:.4g} lx, facing down {made.below:.4g} lx"
        if made.sources:
            yield "without sources", f"{made.rest:.4g} lx"
        if made.ratio is not None:
            yield "sun : all else", format_ratio(made.ratio)
        yield "sources", [tell_source(row) for row in made.sources] or "none"
        yield "verdict", list(made.verdict)
        yield "remarks", list(remarks)

    return sheet(name, lines())


def tell_source(row) -> str:
    """Return a line about a source."""
    return (
        f"{'sun' if row.is_sun else 'lamp'} {row.elevation:.2f}° high, azimuth {row.azimuth:.2f}°, "
        f"{row.diameter:.2f}° wide, pixel {row.column:.0f},{row.row:.0f}: {row.illuminance:.4g} lx facing it, "
        f"{row.horizontal:.4g} lx horizontal"
    )
