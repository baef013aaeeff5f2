"""Measures what light is judged by and writes the document."""

from importlib import import_module, util
from pathlib import Path

from ...engine.reading.whole_file import write_whole
from ..common.bars import Bar
from ..common.document import make_table, tell_demands
from ..common.machine import describe_machine
from ..common.output import write_numbers
from . import eye_light, glare_pictures, glare_tables, indices, verdicts

MOST_TABLE, MOST_TABLE_MEAN = 0.6, 0.2
"""Differences from the table that CIE 190 prints: of one value, and of the mean."""

MOST_PICTURE, MOST_MELANOPIC = 1.0, 1.0
"""[%]"""

MOST_INDEX = 0.3
"""Difference of Ra, Rf and Rg from colour-science."""

MOST_WRONG, MOST_TIME = 0.05, 0.2
"""Share of wrong verdicts, and how far the time is off within which half are decided. [-]"""

MOST_LUMELS, MOST_SLIDER = 1.0, 50.0
"""Distance of isolux lines from exact curves [lumel], and time of a slider of light groups. [ms]"""

TEXT = """# Judgement

*Made by `lumenray benchmark judgement`; do not edit by hand.*

What light is judged by, against standards, closed forms and other programs: tables of unified glare ratings (UGR), glare of
pictures, action on the eye, colour indices, isolux lines, verdicts. {cpu}, {cores} cores.

"""


def run(tables: Path | None = None, say=None) -> dict:
    """Measure.

    Parameters
    ----------
    tables : Path or None    Folder of luminaires with tables of glare ratings, see `glare_tables.measure`; None: left out.

    Returns
    -------
    dict    Plain data for JSON; None where something could not be measured.
    """
    say = say or (lambda line: None)
    made = {
        "machine": describe_machine(),
        "ugr_cie190_max": None,
        "ugr_cie190_mean": None,
        "evalglare_max_percent": None,
        "melanopic_max_percent": None,
        "isolux_lumels": None,
        "wrong_verdicts": None,
        "slider_ms": None,
        "tables": None,
        "pictures": None,
        "indices": None,
    }
    if tables is not None:
        made["tables"] = glare_tables.measure(tables, say)
        printed = made["tables"].get("cie190")
        if printed is not None:
            made["ugr_cie190_max"], made["ugr_cie190_mean"] = printed["max"], abs(printed["mean"])
    made["verdicts"] = verdicts.measure(say)
    made["wrong_verdicts"] = made["verdicts"]["worst_wrong"]
    if indices.is_possible():
        made["indices"] = indices.measure(say)
    made["eye"] = eye_light.measure(say)
    made["melanopic_max_percent"] = eye_light.largest_difference(made["eye"])
    if util.find_spec(f"{__package__}.isolux") is not None:
        made |= import_module(f"{__package__}.isolux").measure()
    if glare_pictures.is_possible():
        made["pictures"] = glare_pictures.measure(say)
        made["evalglare_max_percent"] = glare_pictures.largest_difference(made["pictures"])
    return made


def check_bars(result: dict) -> list[Bar]:
    """Judge by the demands."""
    indices_apart = _largest_index(result["indices"])
    time = abs(result["verdicts"]["time_ratio"] - 1.0)
    return [
        _bar("table of CIE 190, of 190 values the worst", MOST_TABLE, result["ugr_cie190_max"]),
        _bar("table of CIE 190, on the mean", MOST_TABLE_MEAN, result["ugr_cie190_mean"]),
        _bar("five pictures beside evalglare", MOST_PICTURE, result["evalglare_max_percent"], "%"),
        _bar("melanopic light", MOST_MELANOPIC, result["melanopic_max_percent"], "%"),
        _bar("Ra, Rf, Rg beside colour-science", MOST_INDEX, indices_apart),
        _bar("isolux lines of an exact field", MOST_LUMELS, result["isolux_lumels"], "lumels"),
        _bar("slider of 20 groups on 4 M lumels", MOST_SLIDER, result["slider_ms"], "ms"),
        _bar("wrong verdicts", 100.0 * MOST_WRONG, 100.0 * result["wrong_verdicts"], "%"),
        _bar("time that an open verdict foretells", 100.0 * MOST_TIME, 100.0 * time, "%"),
    ]


def _bar(demand: str, limit: float, value: float | None, unit: str = "") -> Bar:
    end = f" {unit}" if unit else ""
    if value is None:
        return Bar(demand, f"{limit:g}{end}", "", None)
    return Bar(demand, f"{limit:g}{end}", f"{value:.3g}{end}", value <= limit)


def _largest_index(rows) -> float | None:
    if rows is None:
        return None
    return max(abs(row[name][0] - row[name][1]) for row in rows for name in ("ra", "rf", "rg"))


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document to a folder, and all numbers to a JSON file if one is named."""
    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    machine = result["machine"]
    text = TEXT.format(cpu=machine["cpu"], cores=machine["cores"])
    text += "".join(_chapters(result)) + tell_demands(check_bars(result))
    with write_whole(folder / "judgement.md", "utf-8") as file:
        file.write(text)


def _chapters(result: dict):
    if result["tables"] is not None:
        yield _tell_tables(result["tables"])
    if result["pictures"] is not None:
        yield _tell_pictures(result["pictures"])
    yield _tell_eye(result["eye"])
    if result["indices"] is not None:
        yield _tell_indices(result["indices"])
    yield _tell_verdicts(result["verdicts"])


def _tell_tables(tables: dict) -> str:
    rows = [
        f"| {number} | {made['Dialux']['max']:.2f} | {made['Dialux']['mean']:+.2f} | {made['Relux']['max']:.2f} | "
        f"{made['Relux']['mean']:+.2f} | {tables['between'][number]['max']:.2f} |"
        for number, made in tables["programs"].items()
    ]
    head = "| luminaire | DIALux, worst | mean | Relux, worst | mean | DIALux - Relux, worst |"
    text = (
        "## Tables of UGR\n\nSix luminaires at a spacing of 0.25 H: differences of our 190 values from the tables of two "
        f"programs, and of these from each other.\n\n{make_table(head, rows)}\n"
    )
    printed = tables.get("cie190")
    if printed is not None:
        text += (
            f"From the table that CIE 190 prints for its example, at a spacing of 1 H, our {printed['values']} values "
            f"differ by {printed['max']:.2f} at most and by {printed['mean']:+.3f} on the mean.\n\n"
        )
    return text


def _tell_pictures(pictures: list) -> str:
    rows = []
    for row in pictures:
        cells = [f"{row[name][0]:.4g} / {row[name][1]:.4g}" for name in glare_pictures.FIGURES]
        rows.append(
            f"| {row['name']} | {row['degrees']:g}° | {row['sources']} | {' | '.join(cells)} |"
        )
    head = "| picture | angle | sources | DGP | DGI | UGR | veiling luminance [cd/m²] |"
    side = glare_pictures.SIZE * glare_pictures.REPEAT
    return f"## Pictures\n\nRendered pictures of {side} x {side} pixels, ours / evalglare's.\n\n{make_table(head, rows)}\n"


def _tell_eye(eye: dict) -> str:
    rows = [
        f"| {row['lamp']} | {row['paint']} | {row['sensor']:.2f} ± {row['error']:.2g} | {row['quadrature']:.2f} | "
        f"{100.0 * (row['sensor'] / row['quadrature'] - 1.0):+.2f} % |"
        for row in eye["rooms"]
    ]
    head = "| lamp | paint | sensor [lx] | quadrature [lx] | difference |"
    return (
        "## Action on the eye\n\nThe alpha-opic efficacies of daylight and the melanopic equivalent of the CIE's toolbox "
        f"are met within {eye['toolbox_percent']:.3f} %. Melanopic equivalent daylight illuminance at a sensor in closed "
        f"rooms of coloured paint, whose light is known at every wavelength:\n\n{make_table(head, rows, 2)}\n"
    )


def _tell_indices(rows: list) -> str:
    lines = []
    for row in rows:
        pairs = [f"{row[name][0]:.2f} / {row[name][1]:.2f}" for name in ("ra", "rf", "rg")]
        cct = f"{row['cct'][0]:.0f} / {row['cct'][1]:.0f}"
        duv = f"{row['duv'][0]:+.4f} / {row['duv'][1]:+.4f}"
        lines.append(f"| {row['lamp']} | {' | '.join(pairs)} | {cct} | {duv} |")
    head = "| lamp | Ra | Rf | Rg | colour temperature [K] | Duv |"
    return f"## Colour indices\n\nOurs / those of colour-science.\n\n{make_table(head, lines)}\n"


def _tell_verdicts(made: dict) -> str:
    return (
        f"## Verdicts\n\n{made['runs']} simulated areas of {made['kinds']} kinds (1 to 49 sensors, means within 3 % of the "
        f"limit, uniformities about theirs), each looked at until it is decided, up to {made['looks']} times, always after "
        f"the time that was foretold: {made['wrong']} verdicts are wrong, of the worst kind "
        f"{100.0 * made['worst_wrong']:.1f} %; {made['open']} stay open. Half of what is open is decided within "
        f"{made['time_ratio']:.2f} of the time foretold.\n\n"
    )
