"""The command ``lumenray report``: measure the sensors of a file and write what they tell as a report for a client."""

from datetime import date
from pathlib import Path

from ..blender_addon import assumptions
from . import requirements
from .blend_file import open_blend
from .modelling import overrule
from .options import (
    add_rule,
    add_scene,
    add_witness,
    rule_of,
    seed_of,
    share,
    size,
    transport_of,
    whole,
)
from .output import add_output, check_free, say, table
from .progress import Bar


def add_command(commands) -> None:
    """Describe the command to argparse."""
    report = commands.add_parser(
        "report",
        help="measure the sensors of a file and write a report: verdicts, plans, tables, luminaires, pictures, errors",
        epilog=assumptions.CODES,
    )
    add_scene(report)
    add_output(
        report,
        "OUT.html",
        "one file that opens without network; OUT.csv and OUT.json with all values beside it",
    )
    report.add_argument("--pdf", type=Path, metavar="OUT.pdf", help="also as PDF pages")
    report.add_argument(
        "--kept",
        action="store_true",
        help="tell what the file has kept of the last measurement in Blender, without measuring",
    )
    report.add_argument("--title", metavar="TEXT", help="of the cover (default: the scene's)")
    report.add_argument("--client", metavar="TEXT", help="whom it is for (default: the scene's)")
    report.add_argument(
        "--author", metavar="TEXT", help="who made the design (default: the scene's)"
    )
    report.add_argument(
        "--date", metavar="TEXT", help="of the cover (default: today, as YYYY-MM-DD)"
    )
    report.add_argument(
        "--light-groups",
        choices=("none", "groups", "each"),
        help="keep light groups apart (default: as the scene says; groups where it has lighting scenes)",
    )
    report.add_argument(
        "--maintenance",
        type=share(),
        metavar="F",
        help="maintenance factor on illuminances in verdicts (default: the scene's)",
    )
    report.add_argument("--no-picture", action="store_true", help="render no picture")
    report.add_argument(
        "--size",
        # What Blender takes.
        type=size(4, 65536),
        metavar="WxH",
        help="of the picture in pixels (default: the scene's)",
    )
    report.add_argument(
        "--picture-samples",
        type=whole(),
        metavar="N",
        help="of a pixel of the picture (default: as the scene's renders)",
    )
    requirements.add_files(report)
    add_witness(report)
    add_rule(report, "sensor")
    assumptions.add_option(report)
    report.set_defaults(run=run)


def run(options) -> int:
    """Write the report of a file; return the exit code."""
    from ..blender_addon.reporting import files, gathering
    from ..engine.reporting.pdf_file import require_reportlab

    files.check_name(options.output)
    check_free(options, options.output, *files.value_paths(options.output))
    if options.pdf is not None:
        files.check_name(options.pdf, (".pdf",))
        check_free(options, options.pdf)
        require_reportlab()
    depsgraph = open_blend(options.file)
    overrule(depsgraph.scene, options)
    _set(options, depsgraph.scene)
    conversion, notes, goals = _measure(options, depsgraph)
    picture = None
    if not options.no_picture and depsgraph.scene.camera is not None:
        picture, seen, goal = _render(options, depsgraph)
        conversion.include_new(seen)
        notes |= dict.fromkeys(picture.provenance.notes)
        goals.append(goal)
    shortfall = "; ".join(filter(None, goals))
    day = date.today().isoformat() if options.date is None else options.date
    report = gathering.gather(
        depsgraph, picture, conversion.to_dicts(), notes, goals, day, options.requirements
    )
    paths = files.write_report(report, options.output, options.pdf)
    assumptions.tell(conversion, tuple(notes), shortfall)
    _tell(report)
    for path in paths:
        say(f"written to {path}")
    return assumptions.exit_code(conversion, options.accept_missing, shortfall)


def _set(options, scene) -> None:
    """Let the open scene say what the options ask for."""
    settings = scene.lumenray
    for name in ("title", "client", "author"):
        if getattr(options, name) is not None:
            setattr(settings.report, name, getattr(options, name))
    if options.light_groups:
        settings.light_mix.groups = options.light_groups.upper()
    elif settings.light_mix.scenes and settings.light_mix.groups == "NONE":
        settings.light_mix.groups = "GROUPS"
    if options.maintenance is not None:
        settings.sensors.maintenance = options.maintenance
    if options.size:
        scene.render.resolution_x, scene.render.resolution_y = options.size
        scene.render.resolution_percentage = 100


def _measure(options, depsgraph):
    """Measure all sensors of the open file and keep what they tell; return the conversion report, notes and shortfalls."""
    from ..blender_addon.reporting import gathering
    from ..blender_addon.sensors import asked, results
    from ..blender_addon.sync.scene import convert_scene
    from ..engine.session import Session

    if options.kept:
        return convert_scene(depsgraph).report, {gathering.KEPT: None}, []
    scene = depsgraph.scene
    settings = scene.lumenray
    rule = rule_of(options, lambda: asked.rule_of(settings.sensors))
    job, conversion = asked.prepare(
        depsgraph, None, rule, options.accept_missing, options.requirements
    )
    job.seed, job.transport = seed_of(options, settings), transport_of(options, settings)
    job.witness = options.witness
    with Bar("measure") as bar:
        job.run(Session(), bar)
    results.store(job)
    return conversion, dict.fromkeys(job.notes), [job.shortfall]


def _render(options, depsgraph):
    """Render the picture; return it, what could not be taken over, and what of its rule was not reached."""
    from dataclasses import replace

    from ..blender_addon.reporting import picture
    from ..engine.accuracy.stopping import StopRule
    from ..engine.session import Session

    rule = None if options.picture_samples is None else StopRule(samples=options.picture_samples)
    job, conversion = picture.prepare(depsgraph, rule)
    assumptions.refuse_missing(conversion, options.accept_missing)
    settings = depsgraph.scene.lumenray
    job.view = replace(
        job.view, seed=seed_of(options, settings), transport=transport_of(options, settings)
    )
    with Bar("render") as bar:
        job.run(Session(), bar)
    return job.picture, conversion, job.shortfall


def _tell(report) -> None:
    """Say the verdicts on the terminal."""
    from ..engine.reporting.composition import tell_mean

    rows = [("scene", "area", "mean", "U0", "verdict")]
    for scene in report.scenes:
        for area in scene.areas:
            figures = area.figures
            verdict = "-" if area.state is None else area.state.value
            mean = tell_mean(area)
            uniformity = "-" if area.is_rating else f"{figures.overall.value:.2f}"
            rows.append((scene.name or "-", area.name, mean, uniformity, verdict))
    say(table(rows))
