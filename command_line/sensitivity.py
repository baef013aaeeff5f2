"""The command ``lumenray sensitivity``: what illuminance at sensors changes per 1 % of what each material reflects."""

import math
from pathlib import Path

from ..blender_addon import assumptions
from ..engine.scene.sensor import SensorKind
from .luminaire import say
from .rayset import ShareBar

SAMPLES = 4096
"""Paths per sensor and estimate, where nothing else is said."""

STRONG = 1.0
"""From here on an error of a material's reflectance shows larger in the result than it is. [-]"""


def add_command(commands):
    """Describe the command, below argparse's sub-parsers ``commands``; return its parser."""
    parser = commands.add_parser(
        "sensitivity", help="what illuminance at sensors changes per 1 %% of each material"
    )
    parser.add_argument(
        "--sensors",
        required=True,
        type=Path,
        metavar="IN.csv",
        help="x,y,z,nx,ny,nz in metres; the normal is where the sensor faces",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="OUT.json",
        help="report with the figures of every sensor",
    )
    parser.add_argument(
        "--materials", default="", metavar="A,B", help="by name (default: all that are used)"
    )
    parser.add_argument(
        "--uncertainty",
        type=float,
        default=0.05,
        metavar="U",
        help="relative uncertainty of each reflectance to tell the consequence of (default: 0.05)",
    )
    parser.add_argument(
        "--samples",
        type=int,
        default=SAMPLES,
        metavar="N",
        help=f"paths per sensor and estimate, 8 estimates a material (default: {SAMPLES})",
    )
    parser.add_argument(
        "--kind",
        choices=[kind.value for kind in SensorKind],
        default=SensorKind.PLANAR.value,
        help="which illuminance (default: planar)",
    )
    assumptions.add_option(parser)
    return parser


def run(options, depsgraph, transport: str, seed: int) -> int:
    """Find and tell the sensitivities of an open file.

    Raises
    ------
    LumenrayError    The scene cannot be computed, a file not be read or written, or a material is unknown.
    """
    from ..blender_addon.sync.scene import convert_scene
    from ..engine.accuracy.stopping import StopRule
    from ..engine.errors import SceneError
    from ..engine.formats.report import write_json
    from ..engine.formats.sensors import read_sensors
    from ..engine.sensitivity import measure_sensitivities
    from ..engine.session import Session

    if not 0.0 < options.uncertainty <= 1.0:
        raise SceneError(f"--uncertainty is {options.uncertainty:g}, expected above 0, at most 1")
    sensors = read_sensors(options.sensors)
    converted = convert_scene(depsgraph)
    assumptions.refuse_missing(converted.report, options.accept_missing)
    session = Session()
    session.apply(converted.delta)
    chosen = _ids(session.scene, options.materials)
    with ShareBar("sensitivity") as bar:
        made = measure_sensitivities(
            session,
            sensors[:, :3],
            sensors[:, 3:],
            StopRule(samples=options.samples),
            seed,
            transport,
            SensorKind(options.kind),
            chosen,
            bar,
        )
    say(
        f"{'material':32} {'change per 1 %':>15} {'error':>8} {f'with {100 * options.uncertainty:g} %':>10}"
    )
    for one in made:
        consequence = (1.0 + options.uncertainty) ** one.mean - 1.0
        say(
            f"{one.name[:32]:32} {one.mean:13.3f} % {one.mean_error:6.3f} % {100 * consequence:8.2f} %"
        )
    strong = [one.name for one in made if abs(one.mean) >= STRONG]
    if strong:
        say(f"errors grow on the way to the sensors for {', '.join(strong)}: measure these first")
    if options.output is not None:
        rows = [
            {
                "material": one.name,
                "id": one.material,
                "quantity": "relative change of illuminance over that of the reflectance",
                "unit": "1",
                "mean": one.mean,
                "standard_error": one.mean_error,
                "each": [_known(value) for value in one.each],
                "each_standard_error": [_known(value) for value in one.each_error],
            }
            for one in made
        ]
        content = {
            "scene": str(options.file),
            "seed": seed,
            "samples": options.samples,
            "sensors": len(sensors),
            "sensitivities": rows,
            "conversion": converted.report.to_dicts(),
        }
        write_json(options.output, content)
        say(f"written to {options.output}")
    assumptions.tell(converted.report)
    return assumptions.exit_code(converted.report, options.accept_missing)


def _ids(scene, names: str):
    """Ids of materials by name; None for all."""
    from ..engine.errors import SceneError

    wanted = [name.strip() for name in names.split(",") if name.strip()]
    if not wanted:
        return None
    known = {material.name: key for key, material in scene.materials.items()}
    for name in wanted:
        if name not in known:
            raise SceneError(
                f"the scene has no material '{name}', expected one of {', '.join(sorted(known))}"
            )
    return [known[name] for name in wanted]


def _known(value) -> float | None:
    return float(value) if math.isfinite(value) else None
