"""The command ``lumenray luminaire schedule``: the luminaires of a scene, and the power that they take.

It needs Blender's Python module.
"""

from pathlib import Path

from ..blend_file import open_blend
from ..options import real
from ..output import complain, name_cell, rounded, say, say_json, table


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    schedule = tasks.add_parser(
        "schedule", help="luminaires of a scene: count, flux, power, W/m2 and W/m2 per 100 lx"
    )
    schedule.add_argument("file", type=Path, metavar="F.blend", help="Blender file")
    schedule.add_argument(
        "--area", type=real(), metavar="M2", help="floor that the power is for, in square metres"
    )
    schedule.add_argument(
        "--lux",
        type=real(),
        metavar="LX",
        help="mean illuminance that W/m2 per 100 lx are of, such as 'lumenray measure' tells it; needs --area",
    )
    schedule.add_argument("--json", action="store_true", help="JSON instead of text")
    schedule.set_defaults(run=run)


def run(options) -> int:
    """Tell the schedule; 1 if luminaires could not be taken."""
    from ...blender_addon.luminaires.fittings import find_fittings
    from ...engine.errors import LumenrayError
    from ...engine.judgement.schedule import make_schedule

    if options.lux is not None and options.area is None:
        raise LumenrayError("--lux needs --area, the floor that the power is for")
    fittings, problems, others = find_fittings(open_blend(options.file))
    row = describe(make_schedule(fittings), options.area, options.lux, others)
    for problem in problems:
        complain(problem)
    if options.json:
        say_json(rounded(row))
    else:
        say(tell(row))
    return 1 if problems else 0


def describe(schedule, area: float | None, lux: float | None, others: int) -> dict:
    """Row of a schedule for JSON; None where something is not known."""
    return {
        "luminaires": [
            {
                "name": each.name,
                "count": each.count,
                "luminous_flux_lm": each.luminous_flux,
                "watts": each.watts,
            }
            for each in schedule.fittings
        ],
        "count": schedule.count,
        "luminous_flux_lm": schedule.luminous_flux,
        "watts": schedule.watts,
        "area_m2": area,
        "watts_per_m2": None if area is None else schedule.power_density(area),
        "watts_per_m2_per_100_lx": None if lux is None else schedule.relative_power(area, lux),
        "lights_without_file": others,
    }


def tell(row: dict) -> str:
    """Text for people about a row of `describe`."""
    rows = [("luminaire", "count", "lm each", "W each", "lm", "W")]
    for each in row["luminaires"]:
        count, flux, watts = each["count"], each["luminous_flux_lm"], each["watts"]
        total = None if watts is None else count * watts
        cells = (str(count), _number(flux), _number(watts), _number(count * flux), _number(total))
        rows.append((name_cell(each["name"]), *cells))
    sums = _number(row["luminous_flux_lm"]), _number(row["watts"])
    rows.append(("all", str(row["count"]), "", "", *sums))
    lines = [table(rows)]
    if row["watts"] is None:
        lines.append("files of luminaires do not state the power, so its sum is not known")
    elif row["watts_per_m2"] is not None:
        told = f"{row['watts_per_m2']:.3g} W/m2"
        if row["watts_per_m2_per_100_lx"] is not None:
            told += f", {row['watts_per_m2_per_100_lx']:.3g} W/m2 per 100 lx"
        lines.append(told)
    if row["lights_without_file"]:
        lines.append(
            f"not counted: {row['lights_without_file']} lights without a photometric file, whose power is not known"
        )
    return "\n".join(lines)


def _number(value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.0f}" if value >= 1000.0 else f"{value:.4g}"
