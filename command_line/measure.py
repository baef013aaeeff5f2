"""The command ``lumenray measure``: illuminance at sensors from a list."""

from ..blender_addon import assumptions
from ..engine.scene.sensor import SensorKind
from .blend_file import open_session
from .options import (
    add_rule,
    add_scene,
    add_sensors,
    add_witness,
    rule_of,
    seed_of,
    share,
    transport_of,
    whole,
)
from .output import add_output, check_free, say
from .progress import Bar


def add_command(commands) -> None:
    """Describe the command to argparse."""
    measure = commands.add_parser(
        "measure", help="illuminance at sensors from a list", epilog=assumptions.CODES
    )
    add_scene(measure)
    add_sensors(measure)
    words = "the same columns and illuminance_lx, standard_error_lx"
    add_output(measure, "OUT.csv", words)
    measure.add_argument(
        "--reflections",
        type=whole(0),
        metavar="N",
        help="count only light that was reflected at most N times; 0 is the direct part",
    )
    measure.add_argument(
        "--colour",
        action="store_true",
        help="also write the chromaticity x, y of the light that arrives",
    )
    measure.add_argument(
        "--each",
        type=share(),
        metavar="E",
        help="go on until the relative standard error of every sensor is below E",
    )
    measure.add_argument(
        "--method",
        choices=("auto", "cells", "paths"),
        help="what stands for the light of matt surfaces: cells are fast where many sensors or samples are asked for "
        "(default: as the scene's lux maps have it)",
    )
    add_witness(measure)
    add_rule(measure, "sensor")
    assumptions.add_option(measure)
    measure.set_defaults(run=run)


def run(options) -> int:
    """Measure illuminance in a file; return the exit code."""
    from ..engine.accuracy.estimate import Estimate
    from ..engine.accuracy.stopping import StopRule
    from ..engine.formats.sensors import read_sensors, write_measurements

    check_free(options, options.output)
    sensors = read_sensors(options.sensors)
    settings, report, session = open_session(options)
    assumptions.refuse_media(report)
    # As of lux maps, but never fewer.
    samples = max(settings.bake.samples, 1024)
    rule = rule_of(options, lambda: StopRule(samples=samples))
    with Bar("measure") as bar:
        made = session.measure(
            sensors[:, :3],
            sensors[:, 3:],
            rule,
            seed_of(options, settings),
            transport_of(options, settings),
            bar,
            kind=SensorKind(options.kind),
            reflections=options.reflections,
            colour=options.colour,
            method=options.method or settings.bake.method.lower(),
            witness=options.witness,
        )
    found = Estimate(made.illuminance, made.standard_error, made.provenance.samples)
    shortfall = rule.shortfall(found.relative_error(), each=found.largest_error(rule.floor))
    notes = made.provenance.notes
    write_measurements(
        options.output,
        sensors,
        made.illuminance,
        made.standard_error,
        made.tristimulus,
        assumptions.lines_of(report, notes, shortfall),
    )
    assumptions.tell(report, notes, shortfall)
    say(f"method: {made.method}")
    say(
        f"{len(sensors)} sensors, {made.provenance.samples} samples each, written to {options.output}"
    )
    return assumptions.exit_code(report, options.accept_missing, shortfall)
