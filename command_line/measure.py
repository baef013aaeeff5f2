"""The command ``lumenray measure``: illuminance at sensors from a list."""

from ..blender_addon import assumptions
from ..engine.scene.sensor import SensorKind
from .blend_file import open_session
from . import requirements
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

RANGE = 0.95
"""Probability of the ranges that are told of all sensors. [-]"""

FREEDOM = 15.0
"""Degrees of freedom of the errors of single sensors: they have sixteen independent groups of samples."""


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
        "--spectrum",
        action="store_true",
        help="also write melanopic and other alpha-opic equivalent daylight illuminances (CIE S 026), colour temperature, "
        "Duv, Ra, Rf and Rg of the light that arrives",
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
    requirements.add_options(measure, "by the kind of sensors")
    assumptions.add_option(measure)
    measure.set_defaults(run=run)


def run(options) -> int:
    """Measure illuminance in a file; return the exit code."""
    from ..engine.accuracy.estimate import Estimate
    from ..engine.accuracy.stopping import StopRule
    from ..engine.formats.sensors import read_sensors, write_measurements

    check_free(options, options.output)
    sensors = read_sensors(options.sensors)
    required = requirements.find(options, options.kind)
    wants_spectrum = options.spectrum or _asks_for_spectrum(required)
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
            spectrum=wants_spectrum,
        )
    found = Estimate(made.illuminance, made.standard_error, made.provenance.samples)
    shortfall = rule.shortfall(found.relative_error(), each=found.largest_error(rule.floor))
    notes = made.provenance.notes
    verdict = [] if required is None else _judge(made, options, *required)
    write_measurements(
        options.output,
        sensors,
        made.illuminance,
        made.standard_error,
        made.tristimulus if options.colour or options.spectrum else None,
        (*assumptions.lines_of(report, notes, shortfall), *verdict),
        _spectral_columns(made.spectra) if options.spectrum else None,
    )
    assumptions.tell(report, notes, shortfall)
    say(f"method: {made.method}")
    if len(sensors) > 1:
        say(_summary(made))
    for line in verdict:
        say(line)
    say(
        f"{len(sensors)} sensors, {made.provenance.samples} samples each, written to {options.output}"
    )
    return assumptions.exit_code(report, options.accept_missing, shortfall)


def _summary(made) -> str:
    """Line with the figures of all sensors, each with its range."""
    from ..engine.judgement.figures import find_figures

    tail = 0.5 * (1.0 - RANGE)
    errors = made.standard_error
    found = find_figures(made.illuminance, errors, tail, FREEDOM, made.has_common_errors)
    figures = {
        "mean": (found.mean, " lx"),
        "least": (found.minimum, " lx"),
        "largest": (found.maximum, " lx"),
        "Uo": (found.uniformity, ""),
        "Ud": (found.diversity, ""),
    }
    told = [
        f"{name} {each.value:.4g}{unit} ({each.low:.4g} to {each.high:.4g})"
        for name, (each, unit) in figures.items()
    ]
    return f"all sensors, ranges of {100.0 * RANGE:g} %: {', '.join(told)}"


def _asks_for_spectrum(required) -> bool:
    """Whether the light's colour rendering or action has to be known."""
    if required is None:
        return False
    requirement, area, _ = required
    return area == "melanopic" or "ra" in requirement.light


def _judge(made, options, requirement, area: str, limits: int) -> list[str]:
    """Lines that say whether the sensors meet a requirement."""
    from ..engine.analysis.sensor_colours import rendering_range
    from ..engine.judgement.assessment import assess, tell
    from ..engine.judgement.figures import find_figures
    from ..engine.judgement.verdict import Range, reach, tail
    from ..engine.photometry.alpha_opic import MELANOPIC

    values, errors, light = made.illuminance, made.standard_error, {}
    spectra = made.spectra
    if spectra is not None:
        if area == "melanopic":
            values = spectra.equivalent_daylight[:, MELANOPIC]
            errors = spectra.equivalent_daylight_error[:, MELANOPIC]
        share = 1.0 if made.has_common_errors else len(values) ** 0.5
        noise = (spectra.bands_error**2).mean(axis=0) ** 0.5 / share
        found = rendering_range(spectra.edges, spectra.bands.mean(axis=0), noise, reach(limits))
        if found is not None:
            light["ra"] = Range(*found)
    figures = find_figures(values, errors, tail(limits), FREEDOM, made.has_common_errors)
    seconds = made.provenance.seconds
    judged = assess(
        requirement, area, figures, seconds, options.maintenance, light, options.modified
    )
    return tell(judged)


def _spectral_columns(spectra) -> dict:
    """Further columns of the list of readings."""
    from ..engine.analysis.sensor_colours import find_colours
    from ..engine.photometry.alpha_opic import RECEPTORS

    columns = {}
    for number in reversed(range(len(RECEPTORS))):
        name = f"{RECEPTORS[number]}_edi"
        columns[f"{name}_lx"] = spectra.equivalent_daylight[:, number]
        columns[f"{name}_error_lx"] = spectra.equivalent_daylight_error[:, number]
    found = find_colours(spectra.edges, spectra.bands)
    return columns | {
        "cct_k": found.temperature,
        "duv": found.duv,
        "ra": found.rendering,
        "rf": found.fidelity,
        "rg": found.gamut,
    }
