"""The command ``lumenray cloth compute``: a cloth's tables, how good they are, and what its data sheet would state."""

from dataclasses import asdict
from pathlib import Path

from ..output import add_force, check_free, percent, rounded, say, say_json, table
from .file import add_file, compute_cloth


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    compute = tasks.add_parser(
        "compute", help="make the tables of a cloth, and tell what its data sheet would state"
    )
    add_file(compute)
    compute.add_argument("-o", "--output", type=Path, metavar="OUT.lumbsdf", help="tables to write")
    add_force(compute)
    compute.add_argument("--json", action="store_true", help="numbers as JSON")
    compute.set_defaults(run=run)


def run(options) -> int:
    """Compute a cloth; return the exit code."""
    from ...engine.scattering.data.store import write_store

    check_free(options, options.output)
    woven = compute_cloth(options)
    # After the engine has chosen a library of LLVM, which Dr.Jit looks for once.
    from ...engine.cloth.readings import read_sheet

    sheet = read_sheet(woven)
    worst = max(each.error for each in woven.sides.values())
    if options.output is not None:
        write_store(options.output, woven.file())
    if options.json:
        row = {
            "name": woven.cloth.name,
            **asdict(sheet),
            "table_error": worst,
            "rays": woven.rays,
            "lost": woven.lost,
            "seed": woven.seed,
            "assumptions": woven.notes(),
        }
        say_json(rounded(row))
        return 0
    say(f"{woven.cloth.name}: {woven.rays:,} rays, seed {woven.seed}")
    rows = [("visible share (D65)", "value", "standard error")]
    rows += [
        ("openness", percent(sheet.openness), ""),
        (
            "transmittance, normal",
            percent(sheet.transmittance),
            percent(sheet.transmittance_error, ".1g"),
        ),
        ("  of which diffused", percent(sheet.diffused), ""),
        ("transmittance, diffuse", percent(sheet.diffuse_transmittance), ""),
        (
            "reflectance, normal",
            percent(sheet.reflectance),
            percent(sheet.reflectance_error, ".1g"),
        ),
        ("reflectance of the back", percent(sheet.back_reflectance), ""),
        ("reflectance, diffuse", percent(sheet.diffuse_reflectance), ""),
    ]
    say(table(rows))
    if sheet.openness > 0.0:
        say(
            f"cut-off angle {sheet.cutoff_warp_deg:.0f} deg along the warp, {sheet.cutoff_weft_deg:.0f} deg along the weft"
        )
    for note in woven.notes():
        say(f"assumed: {note}")
    if options.output is not None:
        say(f"written to {options.output} ({options.output.stat().st_size:,} bytes)")
    return 0
