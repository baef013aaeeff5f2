"""The command ``lumenray observe``: glare that observers in a scene are exposed to."""

import csv
from pathlib import Path

import numpy as np

from ..blender_addon import assumptions
from ..engine.observers import FREEDOM, PARTS, SAMPLES, SIZE, find_unseen, rate_observers
from .blend_file import open_session
from .options import add_scene, real, seed_of, transport_of, whole
from .output import add_output, check_free, say
from .progress import Bar
from .requirements import add_files

COLUMNS = {
    "ugr": "ugr",
    "dgp": "dgp",
    "dgi": "dgi",
    "illuminance": "vertical_illuminance_lx",
    "background": "background_luminance_cd_per_m2",
    "veiling": "veiling_luminance_cd_per_m2",
}
"""Names of the figures of an observer."""


def add_command(commands) -> None:
    """Describe the command to argparse."""
    observe = commands.add_parser(
        "observe",
        help="glare that observers in a scene are exposed to: UGR, DGP, DGI, veiling luminance",
        epilog=assumptions.CODES,
    )
    add_scene(observe)
    observe.add_argument(
        "--observers",
        required=True,
        type=Path,
        metavar="IN.csv",
        help="x,y,z,nx,ny,nz in metres: places of the eyes and where they look",
    )
    add_output(observe, "OUT.csv", "the same columns and the figures with their standard errors")
    observe.add_argument(
        "--size",
        type=whole(64, 4096),
        default=SIZE,
        metavar="N",
        help=f"width of the fisheye that is rendered for each observer, in pixels (default: {SIZE})",
    )
    observe.add_argument(
        "--samples",
        type=whole(PARTS),
        default=SAMPLES,
        metavar="N",
        help=f"of a pixel (default: {SAMPLES})",
    )
    observe.add_argument(
        "--threshold",
        type=real(),
        default=2000.0,
        metavar="CD",
        help="luminance above which pixels are part of glare sources, in cd/m2 (default: 2000)",
    )
    judgement = observe.add_argument_group("judgement")
    judgement.add_argument(
        "--require",
        metavar="KEY",
        help="say whether the UGR of a requirement such as office.writing is met; 'lumenray requirements' lists them",
    )
    add_files(judgement)
    assumptions.add_option(observe)
    observe.set_defaults(run=run)


def run(options) -> int:
    """Rate what observers see; return the exit code."""
    from ..engine.formats.sensors import read_sensors

    check_free(options, options.output)
    observers = read_sensors(options.observers)
    requirement = _requirement(options)
    settings, report, session = open_session(options)
    with Bar("observe") as bar:
        table, notes = rate_observers(
            session,
            observers[:, :3],
            observers[:, 3:],
            options.size,
            options.samples,
            options.threshold,
            seed_of(options, settings),
            transport_of(options, settings),
            bar,
        )
    unseen = find_unseen(session.scene)
    if unseen:
        notes = (
            *notes,
            f"lights without a size are not seen, so their glare is not rated: {', '.join(unseen)}",
        )
    rows = [{name: values[k] for name, values in table.items()} for k in range(len(observers))]
    judged = [] if requirement is None else _judge(requirement, rows, bool(unseen))
    remarks = (*assumptions.lines_of(report, notes), *judged)
    _write(options.output, observers, rows, remarks)
    assumptions.tell(report, notes)
    for number, row in enumerate(rows, start=1):
        say(f"observer {number}: {_words(row)}")
    for line in judged:
        say(line)
    say(f"{len(observers)} observers, written to {options.output}")
    return assumptions.exit_code(report, options.accept_missing)


def _requirement(options):
    """The requirement that was asked for, before anything is computed; None without one."""
    if options.require is None:
        return None
    from ..engine.judgement.observers import glare_limit
    from ..engine.judgement.reader import find_requirement

    requirement = find_requirement(options.require, options.requirements)
    glare_limit(requirement)
    return requirement


def _judge(requirement, rows: list[dict], is_partial: bool) -> list[str]:
    """Lines of verdicts: of all observers, and of each; ``is_partial``: whether some glare is not seen."""
    from dataclasses import replace

    from ..engine.judgement.observers import glare_limit, judge_observers
    from ..engine.judgement.verdict import State, overall

    limit = glare_limit(requirement)
    verdicts = judge_observers(limit, [row["ugr"] for row in rows], FREEDOM)
    if is_partial:
        # More glare could only be worse.
        verdicts = [
            each if each.state is State.NOT_MET else replace(each, state=State.UNKNOWN)
            for each in verdicts
        ]
    words = overall(verdicts).value
    if overall(verdicts) is State.UNDECIDED:
        words += ": more --samples and a larger --size lower the errors"
    title = f"{requirement.key} ({requirement.standard}: {requirement.title})"
    lines = [f"{title}: UGR at most {limit:g} is {words}"]
    for number, verdict in enumerate(verdicts, start=1):
        found = verdict.found
        held = "no glare source"
        if np.isfinite(found.value):
            held = f"{found.value:.1f} ({found.low:.1f} to {found.high:.1f})"
        lines.append(f"  observer {number}: {verdict.state.value}, {held}")
    return lines


def _words(row: dict) -> str:
    from ..blender_addon.readout import format_estimate

    names = {"ugr": "UGR", "dgp": "DGP", "dgi": "DGI"}
    told = []
    for name, word in names.items():
        value, error = row[name]
        if np.isnan(value):
            told.append(f"{word} none (no glare source)")
        elif np.isfinite(error) and error > 0.0:
            told.append(f"{word} {format_estimate(value, error)}")
        else:
            told.append(f"{word} {value:.3g}")
    return ", ".join(told).replace("\u2009", "")


def _write(path: Path, observers, rows: list[dict], remarks) -> None:
    from ..engine.formats.sensors import COLUMNS as PLACES
    from ..engine.reading.whole_file import write_whole

    with write_whole(path, "utf-8") as file:
        file.writelines(f"# {remark}\n" for remark in remarks)
        writer = csv.writer(file, lineterminator="\n")
        names = [end for name in COLUMNS.values() for end in (name, f"{name}_error")]
        writer.writerow([*PLACES, *names])
        for observer, row in zip(observers, rows, strict=True):
            cells = [each for name in COLUMNS for each in row[name]]
            told = ["" if np.isnan(each) else f"{each:.5g}" for each in cells]
            writer.writerow([*(f"{each:.9g}" for each in observer), *told])
