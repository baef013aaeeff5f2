"""The command ``lumenray measure``: illuminance at the sensors that stand in a file, or at those of a list."""

import math
from dataclasses import replace
from pathlib import Path

from ..blender_addon import assumptions
from ..engine.errors import FileFormatError, LumenrayError
from ..engine.scene.sensor import SensorKind
from . import requirements, sensor_judgement
from .blend_file import open_blend, read_scene
from .cluster_options import add_cluster, open_engine
from .modelling import overrule
from .options import (
    add_rule,
    add_scene,
    add_sensors,
    add_witness,
    level,
    rule_of,
    seed_of,
    share,
    transport_of,
    whole,
    words,
)
from .output import add_output, check_free, name_cell, say, table
from .progress import Bar

RANGE = 0.95
"""Probability of the ranges that are told of all sensors. [-]"""

FREEDOM = 15.0
"""Degrees of freedom of the errors of single sensors: they have sixteen independent groups of samples."""


def add_command(commands) -> None:
    """Describe the command to argparse."""
    measure = commands.add_parser(
        "measure",
        help="illuminance at the sensors of a file, or at those of a list",
        epilog=assumptions.CODES,
    )
    add_scene(measure)
    add_sensors(measure, is_required=False)
    written = (
        "of a list the same columns and illuminance_lx, standard_error_lx; of the sensors in the file a row for each with "
        "its object, or with the name OUT.json the figures of each object and all readings"
    )
    add_output(measure, "OUT.csv", written)
    measure.add_argument(
        "--objects",
        type=words,
        default=(),
        metavar="A,B",
        help="sensors of the file by the names of their objects (default: all)",
    )
    measure.add_argument(
        "--plans",
        type=Path,
        metavar="DIR",
        help="also draw every grid of the file in false colours with isolux lines into this folder, as .png and .svg",
    )
    measure.add_argument(
        "--photometric",
        type=Path,
        metavar="DIR",
        help="also write what every goniometer of the file has measured as .ldt and .ies into this folder",
    )
    measure.add_argument(
        "--light-groups",
        choices=("none", "groups", "each"),
        help="keep what each light group, or each luminaire, gives to the sensors of the file apart (default: as the "
        "scene says)",
    )
    measure.add_argument(
        "--lighting-scene",
        metavar="NAME",
        help="levels of the light groups as a lighting scene of the file says (default: as the sliders stand)",
    )
    measure.add_argument(
        "--mix",
        type=level,
        action="append",
        default=[],
        metavar="NAME=FACTOR",
        help="factor on the flux of a light group, such as Ceiling=0.5 or Ceiling=off; may be repeated (default: as the "
        "scene says)",
    )
    measure.add_argument(
        "--reflections",
        type=whole(0),
        metavar="N",
        help="count only light that was reflected at most N times; 0 is the direct part",
    )
    measure.add_argument(
        "--colour",
        action="store_true",
        help="also write the chromaticity x, y of the light that arrives at the sensors of a list",
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
    add_cluster(measure)
    measure.set_defaults(run=run)


def run(options) -> int:
    """Measure illuminance in a file; return the exit code."""
    check_free(options, options.output)
    return run_list(options) if options.sensors is not None else run_scene(options)


def run_list(options) -> int:
    """Measure at the sensors of a list."""
    from ..engine.accuracy.estimate import Estimate
    from ..engine.accuracy.stopping import StopRule
    from ..engine.analysis.sensor_colours import tell_columns
    from ..engine.formats.sensors import read_sensors, write_measurements
    from ..engine.requirements.budget import tell_parts

    for name in ("objects", "plans", "photometric", "light_groups", "lighting_scene", "mix"):
        if getattr(options, name):
            raise LumenrayError(
                f"--{name.replace('_', '-')} is for sensors that stand in the file, not for those of a list"
            )
    sensors = read_sensors(options.sensors)
    kind = SensorKind(options.kind or SensorKind.PLANAR.value)
    required = requirements.find(options, kind.value)
    wants_spectrum = options.spectrum or _asks_for_spectrum(required)
    settings, report, delta = read_scene(options)
    assumptions.refuse_media(report)
    # As of lux maps, but never fewer.
    samples = max(settings.bake.samples, 1024)
    rule = rule_of(options, lambda: StopRule(samples=samples))
    with open_engine(options) as session, Bar("measure") as bar:
        session.apply(delta)
        made = session.measure(
            sensors[:, :3],
            sensors[:, 3:],
            rule,
            seed_of(options, settings),
            transport_of(options, settings),
            bar,
            kind=kind,
            reflections=options.reflections,
            colour=options.colour,
            method=options.method or settings.bake.method.lower(),
            witness=options.witness,
            spectrum=wants_spectrum,
        )
    found = Estimate(made.illuminance, made.standard_error, made.provenance.samples)
    parts = tell_parts(found.relative_error(), made.provenance.simplified)
    parts = [f"errors of the sensors together: {parts}"] if parts else []
    shortfall = rule.shortfall(found.relative_error(), each=found.largest_error(rule.floor))
    notes = made.provenance.notes
    verdict = [] if required is None else _judge(made, options, *required)
    write_measurements(
        options.output,
        sensors,
        made.illuminance,
        made.standard_error,
        made.tristimulus if options.colour or options.spectrum else None,
        (*assumptions.lines_of(report, notes, shortfall), *parts, *verdict),
        tell_columns(made.spectra) if options.spectrum else None,
    )
    assumptions.tell(report, notes, shortfall)
    say(f"method: {made.method}")
    if len(sensors) > 1:
        say(_summary(made))
    for line in (*parts, *verdict):
        say(line)
    say(
        f"{len(sensors)} sensors, {made.provenance.samples} samples a sensor, written to {options.output}"
    )
    return assumptions.exit_code(report, options.accept_missing, shortfall)


def run_scene(options) -> int:
    """Measure at the sensors that stand in the file."""
    from ..blender_addon.rendering import light_mix, lighting_scenes
    from ..blender_addon.sensors import asked, judging

    for name in ("kind", "colour"):
        if getattr(options, name):
            raise LumenrayError(
                f"--{name} is for sensors of a list; those of the file say what they are"
            )
    if options.output.suffix.lower() not in {".csv", ".json"}:
        raise FileFormatError(options.output, "expected a name that ends in .csv or .json")
    depsgraph = open_blend(options.file)
    scene = depsgraph.scene
    overrule(scene, options)
    if options.light_groups:
        scene.lumenray.light_mix.groups = options.light_groups.upper()
    own_levels = light_mix.levels_of(scene)
    if options.lighting_scene is not None:
        own_levels = lighting_scenes.find(scene, options.lighting_scene).levels
    empties = _chosen(options, scene)
    requirement = sensor_judgement.find(options, scene)
    rule = rule_of(options, lambda: asked.rule_of(scene.lumenray.sensors))
    job, report = asked.prepare(
        depsgraph, empties, rule, options.accept_missing, options.requirements
    )
    settings = scene.lumenray
    job.seed, job.transport = seed_of(options, settings), transport_of(options, settings)
    job.method = options.method or settings.bake.method.lower()
    job.witness, job.reflections = options.witness, options.reflections
    known = [group.name for group in job.groups] + (["rest"] if job.groups else [])
    levels = _levels(options, own_levels, known)
    job.mixes = (*job.mixes, levels)
    if options.spectrum:
        job.places = [replace(placed, wants_spectrum=True) for placed in job.places]
    if options.plans is not None:
        _check_files(options, job, options.plans, (".png", ".svg"))
    if options.photometric is not None:
        if not any(placed.sphere is not None for placed in job.places):
            raise LumenrayError(f"--photometric: {options.file} has no goniometer that is measured")
        _check_files(options, job, options.photometric, PHOTOMETRIC)
    with open_engine(options) as session, Bar("measure") as bar:
        job.run(session, bar)
    judged = None
    if requirement is not None:
        judged = sensor_judgement.judge(options, scene, job, levels, requirement)
    _write(options, job, report, levels, judged)
    assumptions.tell(report, job.notes, job.shortfall)
    _tell(job, levels)
    for line in [] if judged is None else judging.tell(judged):
        say(line)
    say(f"written to {options.output}")
    return assumptions.exit_code(report, options.accept_missing, job.shortfall)


def _chosen(options, scene):
    """Empties that were named, None: all."""
    from ..blender_addon.sensors.settings import is_sensor

    for name in options.objects:
        if name not in scene.objects or not is_sensor(scene.objects[name]):
            raise LumenrayError(f"{options.file}: the scene has no sensors named {name}")
    return [scene.objects[name] for name in options.objects] or None


def _levels(options, own, known):
    """Return the `LightMix` that was asked for, on top of the scene's."""
    from ..engine.light_mix import Level, LightMix

    kept = {each.name: each for each in own.levels}
    for name, factor in options.mix:
        if name not in known:
            there = ", ".join(f"'{each}'" for each in known)
            remedy = f"those of the scene are {there}" if known else NO_GROUPS
            raise LumenrayError(f"--mix: no light group is called '{name}'; {remedy}")
        kept[name] = replace(kept.get(name, Level(name)), factor=factor, is_on=factor > 0.0)
    return LightMix(tuple(kept.values()))


NO_GROUPS = "none are kept apart: say --light-groups groups, and name groups in the scene"


PHOTOMETRIC = (".ldt", ".ies")
"""Ends of the names of photometric files."""


def _check_files(options, job, folder: Path, ends) -> None:
    """Refuse to write over files of sensors that are there."""
    from ..engine.formats.names import file_stem

    for placed in job.places:
        check_free(options, *(folder / f"{file_stem(placed.name)}{end}" for end in ends))


def _write(options, job, report, levels, judged) -> None:
    """Write readings with verdicts, and plans where they are asked for."""
    from ..blender_addon.sensors import files, judging, pictures

    named = [(placed.name, job.answer[placed.uid]) for placed in job.places]
    if options.output.suffix.lower() == ".json":
        files.write_document(
            options.output,
            options.file.name,
            named,
            levels,
            report.to_dicts(),
            job.notes,
            job.shortfall,
            None if judged is None else judging.describe(judged),
            job.decisions,
        )
    else:
        remarks = list(assumptions.lines_of(report, job.notes, job.shortfall))
        remarks += _parts(named, levels)
        remarks += [] if judged is None else judging.tell(judged)
        files.write_rows(options.output, named, levels, remarks)
    if options.plans is not None:
        plans = [
            (name, pictures.draw_plan(name, readings, levels))
            for name, readings in named
            if pictures.has_plan(readings)
        ]
        for path in pictures.write_plans(options.plans, plans):
            say(f"written to {path}")
    if options.photometric is not None:
        _write_photometric(options.photometric, named)


def _write_photometric(folder: Path, named) -> None:
    """Write the file of every goniometer in all formats that can hold it."""
    from ..blender_addon.sensors.goniometers import write_intensities
    from ..engine.formats.names import file_stem

    for name, readings in named:
        for end in PHOTOMETRIC if readings.is_distribution else ():
            path = folder / f"{file_stem(name)}{end}"
            for remark in write_intensities(readings, name, path):
                say(f"{path.name}: {remark}")
            say(f"written to {path}")


def _tell(job, levels) -> None:
    from ..blender_addon.sensors.goniometers import describe_intensities

    rows = [("sensors", "count", "mean", "error", "min", "max", "unit", "U0", "Ud")]
    for placed in job.places:
        readings = job.answer[placed.uid]
        figures = readings.figures(levels)
        if math.isnan(figures.mean) or readings.is_distribution:
            rows.append(
                (placed.name, str(len(readings.positions)), *["-"] * 4, readings.unit, "-", "-")
            )
            continue
        ratios = [f"{x.value:.3f}" for x in (figures.overall, figures.diversity)]
        numbers = [figures.mean, figures.least.value, figures.largest.value]
        mean, least, largest = (f"{value:.4g}" for value in numbers)
        error = f"{figures.mean_error:.2g}"
        count = str(len(readings.positions))
        rows.append((placed.name, count, mean, error, least, largest, readings.unit, *ratios))
    say(table(rows))
    for placed in job.places:
        readings = job.answer[placed.uid]
        if readings.is_distribution:
            lines = "; ".join(f"{label} {words}" for label, words in describe_intensities(readings))
            say(f"{placed.name}: {lines}")
    for line in _parts([(placed.name, job.answer[placed.uid]) for placed in job.places], levels):
        say(line)


def _parts(named, levels) -> list[str]:
    """Lines that say what the errors of means are made of, of sensors in a scene that was simplified."""
    from ..engine.requirements.budget import tell_parts

    told = [
        (name_cell(name), tell_parts(readings.mean_error(levels), readings.simplified))
        for name, readings in named
    ]
    return [f"error of the mean of {name}: {parts}" for name, parts in told if parts]


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
