"""The command ``lumenray environment extract``: a picture without its bright sources, and these as lights."""

import json
from pathlib import Path

from ...engine.errors import SceneError
from ..output import add_output, check_free, rounded, say
from .analyse import describe_source, tell_source
from .picture import add_map, find_coefficients, find_per_unit, sun_chooser


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    extract = tasks.add_parser("extract", help="write the clipped picture, and its lights")
    add_map(extract)
    add_output(extract, "OUT.exr", "clipped picture to write")
    extract.add_argument(
        "--lights",
        type=Path,
        metavar="OUT.json",
        help="lights to write: directions, sizes, illuminances, colours",
    )
    extract.set_defaults(run=run)


def run(options) -> int:
    """Take a picture apart; return the exit code."""
    from ...engine.environment.analysis import analyse
    from ...engine.environment.extraction import clip_sources
    from ...engine.environment.map_file import read_map, write_map
    from ...engine.environment.sources import find_sources
    from ...engine.reading.whole_file import write_whole

    check_free(options, options.output, options.lights)
    image, _ = read_map(options.file)
    coefficients = find_coefficients(options)
    search = find_sources(image, coefficients)
    if not search.sources:
        raise SceneError(
            f"{options.file} holds no bright source; lower --source, or raise --radius for wide ones"
        )
    per_unit = find_per_unit(options, image)
    made = analyse(image, per_unit, coefficients, sun_chooser(options))
    path = write_map(options.output, clip_sources(image, coefficients).pixels)
    rows = []
    for row, source in zip(made.sources, search.sources, strict=True):
        say(tell_source(row))
        colour = source.irradiance / source.illuminance
        rows.append({**describe_source(row), "towards": source.towards, "colour_rec709": colour})
    if options.lights is not None:
        content = {"luminance_per_unit_cd_m2": per_unit, "lights": rows}
        with write_whole(options.lights, "utf-8") as file:
            json.dump(rounded(content), file, indent=2)
        say(f"written to {options.lights}")
    say(
        f"horizontal {made.horizontal:.5g} lx before, {made.conserved * made.horizontal:.5g} lx with the lights"
    )
    say(f"written to {path}")
    return 0
