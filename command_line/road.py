"""The command ``lumenray road``: luminances, uniformities and glare of a road with luminaires of a file (EN 13201-3)."""

import math
from pathlib import Path

from ..engine.errors import FileFormatError, LumenrayError
from ..engine.roads.installation import ARRANGEMENTS, LIMITS
from . import requirements
from .options import real, share, whole
from .output import add_force, check_free, percent, say, say_json, sheet, table

LEFT_OUT = (
    "only light straight from the luminaires, on a flat and straight road of a tabulated surface, as EN 13201-3 has it",
    "the threshold increment is of new lamps",
)
"""What the values leave out."""

EPILOG = """examples:
  lumenray road street.ldt --width 7 --lanes 2 --spacing 30 --height 8 --maintenance 0.8 --require road.m4
  lumenray road street.ldt --width 10.5 --lanes 3 --spacing 38 --height 10 --surface R3 --plan road.svg

Drivers look along the road from the middle of each lane. C0 of the file lies along the road and C90 across it, towards the
carriageway; --turn 90 is for files that have it otherwise. The exit code is 0 also where a requirement is not met.
"""


def add_command(commands) -> None:
    """Describe the command to argparse."""
    parser = commands.add_parser(
        "road",
        help="luminances, uniformities and glare of a road (EN 13201-3)",
        epilog=EPILOG,
    )
    parser.add_argument("file", type=Path, metavar="F", help="IES, EULUMDAT or TM-33 file")

    def number(name: str, words: str, default=None):
        least, most, unit = LIMITS[name]
        parser.add_argument(
            f"--{name}",
            type=whole(least, most) if name == "lanes" else real(least, most),
            required=default is None,
            default=default,
            metavar={"m": "M", "degrees": "DEG"}.get(unit, "N"),
            help=words,
        )

    number("width", "of the carriageway in metres")
    number("lanes", "number of its lanes")
    number("spacing", "of the luminaires of a row in metres")
    number("height", "of the luminaires over the road in metres")
    parser.add_argument(
        "--arrangement",
        choices=ARRANGEMENTS,
        default="right",
        help="rows at the right or left edge, at both opposite or staggered, or over the middle (default: right)",
    )
    number("overhang", "of the luminaires over the carriageway in metres, below 0 beside it", 0.0)
    number("tilt", "by which the side towards the road is lifted, in degrees", 0.0)
    number("turn", "of the luminaires about the vertical, in degrees", 0.0)
    parser.add_argument(
        "--surface",
        default="C2",
        metavar="NAME",
        help="C2, R3 or the .csv table of another surface's reduced luminance coefficients (default: C2)",
    )
    judgement = parser.add_argument_group("judgement")
    judgement.add_argument(
        "--require",
        metavar="KEY",
        help="say whether a requirement such as road.m4 is met; 'lumenray requirements road' lists them",
    )
    requirements.add_files(judgement)
    judgement.add_argument(
        "--maintenance",
        type=share(),
        default=1.0,
        metavar="F",
        help="maintenance factor on all but the threshold increment (default: 1)",
    )
    parser.add_argument("--json", action="store_true", help="JSON with all points instead of text")
    parser.add_argument(
        "--plan",
        type=Path,
        metavar="OUT.svg",
        help="also draw the luminances that the driver in the first lane sees; .svg or .png",
    )
    add_force(parser)
    parser.set_defaults(run=run)


def run(options) -> int:
    """Compute a road; return the exit code."""
    from ..engine.judgement.reader import find_requirement
    from ..engine.luminaires.formats.reader import read_luminaire
    from ..engine.roads.installation import Road
    from ..engine.roads.light import light_road
    from ..engine.roads.surface import find_surface

    if options.plan is not None and options.plan.suffix.lower() not in {".png", ".svg"}:
        raise FileFormatError(options.plan, "expected a name that ends in .png or .svg")
    check_free(options, options.plan)
    requirement = None
    if options.require is not None:
        requirement = find_requirement(options.require, options.requirements)
        if not {"road", "task"} & set(requirement.areas):
            raise LumenrayError(f"{requirement.key} asks nothing of a road")
    file = read_luminaire(options.file)
    road = Road(**{name: getattr(options, name) for name in (*LIMITS, "arrangement")})
    surface = find_surface(options.surface)
    made = light_road(file, road, surface, options.maintenance)
    judged = None if requirement is None else judge_road(made, requirement)
    warnings = [str(remark) for remark in file.remarks]
    warnings += [f"surface {surface.name}: {remark}" for remark in surface.remarks]
    if options.json:
        say_json(describe(options, road, surface, made, judged, warnings))
    else:
        say(tell(options, road, surface, made, judged, warnings))
    if options.plan is not None:
        draw(options, road, surface, made)
    return 0


def judge_road(made, requirement):
    """Judge a road by its luminances, or by its illuminances where a requirement asks for these."""
    from ..engine.judgement.assessment import assess
    from ..engine.judgement.figures import AreaFigures, find_figures
    from ..engine.judgement.verdict import Range, tail

    def known(value: float):
        return Range(value, value, value)

    light = {}
    if not math.isnan(made.increment):
        light["threshold_increment"] = known(made.increment)
    if "road" in requirement.areas:
        least = min(float(view.luminances.min()) for view in made.views)
        largest = max(float(view.luminances.max()) for view in made.views)
        worst = min(float(view.luminances.min() / view.luminances.max()) for view in made.views)
        figures = AreaFigures(
            known(made.mean), known(least), known(largest), known(made.overall), known(worst)
        )
        ratios = {"longitudinal": known(made.longitudinal), "edge": known(made.edge_ratio)}
        return assess(requirement, "road", figures, 0.0, light=light, ratios=ratios)
    values = made.illuminances.ravel()
    figures = find_figures(values, 0.0 * values, tail(1))
    return assess(requirement, "task", figures, 0.0, light=light)


def describe(options, road, surface, made, judged, warnings) -> dict:
    """JSON of a road."""
    points = road.grid()
    row = {
        "file": str(options.file),
        "road": {name: getattr(road, name) for name in (*LIMITS, "arrangement")},
        "surface": surface.name,
        "maintenance": options.maintenance,
        "mean_luminance": made.mean,
        "overall_uniformity": made.overall,
        "longitudinal_uniformity": made.longitudinal,
        "threshold_increment_percent": _known(made.increment),
        "edge_illuminance_ratio": made.edge_ratio,
        "edge_illuminance_ratios": dict(zip(("right", "left"), made.edge_ratios, strict=True)),
        "mean_illuminance": float(made.illuminances.mean()),
        "minimum_illuminance": float(made.illuminances.min()),
        "drivers": [
            {
                "across_m": float(middle),
                "mean_luminance": view.mean,
                "overall_uniformity": view.overall,
                "longitudinal_uniformity": view.longitudinal,
                "veiling_luminance_new": view.veiling,
                "threshold_increment_percent": _known(view.increment),
                "luminances": view.luminances.tolist(),
            }
            for middle, view in zip(road.lane_middles, made.views, strict=True)
        ],
        "along_m": points[:, 0, 0].tolist(),
        "across_m": points[0, :, 1].tolist(),
        "illuminances": made.illuminances.tolist(),
        "left_out": list(LEFT_OUT),
        "warnings": warnings,
    }
    if judged is not None:
        row["requirement"] = {
            "key": judged.requirement.key,
            "area": judged.area,
            "state": judged.state.value,
            "limits": [
                {
                    "name": each.name,
                    "limit": each.limit,
                    "is_most": each.is_most,
                    "value": None if each.found is None else each.found.value,
                    "state": each.state.value,
                }
                for each in judged.verdicts
            ],
        }
    return row


def tell(options, road, surface, made, judged, warnings) -> str:
    """Text for people about a road."""
    from ..engine.judgement import assessment

    illuminances = made.illuminances
    head = [
        (
            "carriageway",
            f"{road.width:g} m, {road.lanes} {'lane' if road.lanes == 1 else 'lanes'}, surface {surface.name}",
        ),
        (
            "luminaires",
            f"{road.arrangement}, {road.spacing:g} m apart, {road.height:g} m high, overhang {road.overhang:g} m, "
            f"tilt {road.tilt:g} degrees",
        ),
        ("maintenance", f"{options.maintenance:g}"),
        ("luminance", f"{made.mean:.3g} cd/m2, Uo {made.overall:.3f}, Ul {made.longitudinal:.3f}"),
        ("glare", f"TI {_increment(made.increment)}"),
        ("edge ratio", f"EIR {made.edge_ratio:.3f}"),
        (
            "illuminance",
            f"mean {illuminances.mean():.3g} lx, minimum {illuminances.min():.3g} lx, "
            f"Uo {illuminances.min() / illuminances.mean():.3f}",
        ),
        ("computed", LEFT_OUT),
        ("warnings", warnings),
    ]
    rows = [("driver", "mean cd/m2", "Uo", "Ul", "TI")]
    for number, view in enumerate(made.views, start=1):
        figures = (f"{view.mean:.3g}", f"{view.overall:.3f}", f"{view.longitudinal:.3f}")
        rows.append((f"lane {number}", *figures, _increment(view.increment)))
    lines = [sheet(str(options.file), head), table(rows)]
    if judged is not None:
        lines += assessment.tell(judged)
    return "\n".join(lines)


def draw(options, road, surface, made) -> None:
    """Draw the luminances that the first driver sees."""
    from ..engine.analysis.value_plan import draw_grid

    points = road.grid()
    view = made.views[0]
    drawn = draw_grid(
        f"Luminances of the road, {options.file.name}",
        points[:, 0, 0],
        points[0, :, 1],
        view.luminances.T,
        caption=f"driver in lane 1, surface {surface.name}, mean {view.mean:.3g} cd/m2, Uo {view.overall:.3f}",
        unit="cd/m²",
        size=(1100, 460),
    )
    say(f"written to {drawn.save(options.plan)}")


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value


def _increment(value: float) -> str:
    return "not defined below 0.05 cd/m2" if math.isnan(value) else percent(0.01 * value)
