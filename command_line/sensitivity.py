"""The command ``lumenray sensitivity``: what illuminance at sensors changes per 1 % of what each material reflects."""

from pathlib import Path

from ..blender_addon import assumptions
from ..engine.scene.sensor import SensorKind
from .blend_file import open_session
from .options import add_scene, add_sensors, seed_of, share, transport_of, whole, words
from .output import add_force, check_free, name_cell, percent, rounded, say, table
from .progress import Bar

SAMPLES = 4096
"""Paths per sensor and estimate, where nothing else is said."""

STRONG = 1.0
"""From here on an error of a material's reflectance shows larger in the result than it is. [-]"""


def add_command(commands) -> None:
    """Describe the command to argparse."""
    parser = commands.add_parser(
        "sensitivity", help="what illuminance at sensors changes per 1 %% of each material"
    )
    add_scene(parser)
    add_sensors(parser)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="OUT.json",
        help="report with the figures of every sensor",
    )
    parser.add_argument(
        "--materials",
        type=words,
        default=(),
        metavar="A,B",
        help="by name (default: all that are used)",
    )
    parser.add_argument(
        "--uncertainty",
        type=share(),
        default=0.05,
        metavar="U",
        help="relative uncertainty of each reflectance to tell the consequence of (default: 5%%)",
    )
    parser.add_argument(
        "--samples",
        type=whole(),
        default=SAMPLES,
        metavar="N",
        help=f"paths per sensor and estimate, 8 estimates a material (default: {SAMPLES})",
    )
    add_force(parser)
    assumptions.add_option(parser)
    parser.set_defaults(run=run)


def run(options) -> int:
    """Find and tell the sensitivities of a file."""
    from ..engine.accuracy.stopping import StopRule
    from ..engine.formats.report import write_json
    from ..engine.formats.sensors import read_sensors
    from ..engine.sensitivity import measure_sensitivities

    check_free(options, options.output)
    sensors = read_sensors(options.sensors)
    settings, report, session = open_session(options)
    assumptions.refuse_media(report)
    seed = seed_of(options, settings)
    chosen = _ids(session.scene, options.materials)
    with Bar("sensitivity") as bar:
        made = measure_sensitivities(
            session,
            sensors[:, :3],
            sensors[:, 3:],
            StopRule(samples=options.samples),
            seed,
            transport_of(options, settings),
            SensorKind(options.kind),
            chosen,
            bar.share,
        )
    _tell(made, options.uncertainty)
    if options.output is not None:
        content = {
            "scene": str(options.file),
            "seed": seed,
            "samples": options.samples,
            "sensors": len(sensors),
            "sensitivities": [_report(one) for one in made],
            "conversion": report.to_dicts(),
        }
        write_json(options.output, content)
        say(f"written to {options.output}")
    assumptions.tell(report)
    return assumptions.exit_code(report, options.accept_missing)


def _tell(made, uncertainty: float) -> None:
    """Print a table of sensitivities, and which materials to measure first."""
    rows = [("material", "change per 1 %", "error", f"with {percent(uncertainty)}")]
    for one in made:
        consequence = percent((1.0 + uncertainty) ** one.mean - 1.0, ".2f")
        cells = (f"{one.mean:.3f} %", f"{one.mean_error:.3f} %", consequence)
        rows.append((name_cell(one.name), *cells))
    say(table(rows))
    strong = [one.name for one in made if abs(one.mean) >= STRONG]
    if strong:
        say(f"errors grow on the way to the sensors for {', '.join(strong)}: measure these first")


def _report(one) -> dict:
    """Row of a material for JSON."""
    return {
        "material": one.name,
        "id": one.material,
        "quantity": "relative change of illuminance over that of the reflectance",
        "unit": "1",
        "mean": one.mean,
        "standard_error": one.mean_error,
        "each": rounded(one.each),
        "each_standard_error": rounded(one.each_error),
    }


def _ids(scene, names: tuple[str, ...]):
    """Ids of materials by name; None for all."""
    from ..engine.errors import SceneError

    if not names:
        return None
    known: dict[str, list[str]] = {}
    for key, material in scene.materials.items():
        # What is made for several objects one by one has the name of all of them.
        known.setdefault(material.name, []).append(key)
    for name in names:
        if name not in known:
            raise SceneError(
                f"the scene has no material '{name}', expected one of {', '.join(sorted(known))}"
            )
    return [key for name in names for key in known[name]]
