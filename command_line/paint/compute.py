"""The command ``lumenray paint compute``: a paint's table, how good it is, and its colours."""

from pathlib import Path

from ..output import add_force, check_free, percent, rounded, say, say_json
from .file import add_file, lab_table, open_paint


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    compute = tasks.add_parser("compute", help="make the table of a paint, and tell its colours")
    add_file(compute)
    compute.add_argument("-o", "--output", type=Path, metavar="OUT.lumbsdf", help="table to write")
    add_force(compute)
    compute.add_argument("--fine", action="store_true", help="a table with half the steps")
    compute.add_argument(
        "--unpolarised",
        action="store_true",
        help="leave out polarisation, as plain adding-doubling does",
    )
    compute.add_argument("--json", action="store_true", help="numbers as JSON")
    compute.set_defaults(run=run)


def run(options) -> int:
    """Compute a paint; return the exit code."""
    import numpy as np

    from ...engine.paint.readings import SIX, read_lab
    from ...engine.paint.tabulation import FINE, STANDARD, compute
    from ...engine.scattering.data.store import write_store

    check_free(options, options.output)
    paint = open_paint(options)
    made = compute(
        paint, step=FINE if options.fine else STANDARD, is_polarised=not options.unpolarised
    )
    solution, size = made.solution, made.solution.resolution
    lab = read_lab(solution, SIX)
    normal = float((solution.albedo([0.0]) + solution.mirror([0.0])).mean())
    row = {
        "name": paint.name,
        "directions": size.directions,
        "modes": size.modes,
        "bands_nm": solution.wavelengths,
        "total_reflectance_normal": normal,
        "largest_total_reflectance": made.energy,
        "convergence": made.convergence,
        "table_error": made.table.error,
        "table_reciprocity": made.reciprocity,
        "clamped": made.clamped,
        "aspecular_deg": SIX,
        "lab_d65_10deg": lab,
        "assumptions": [remark.text for remark in made.file().remarks],
    }
    if options.output is not None:
        write_store(options.output, made.file())
    if options.json:
        say_json(rounded(row))
        return 0
    say(
        f"{paint.name}: {size.directions} directions, {size.modes} modes, {len(np.atleast_1d(solution.wavelengths))} bands"
    )
    say(lab_table(SIX, lab))
    say(
        f"total reflectance along the normal {percent(normal)}, largest at any angle {percent(made.energy)}; "
        f"change from three quarters of the resolution {percent(made.convergence, '.2g')}, table within "
        f"{percent(made.table.error, '.2g')}, reciprocal to {percent(made.reciprocity, '.2g')}"
    )
    for remark in made.file().remarks[1:]:
        say(f"assumed: {remark}")
    if options.output is not None:
        say(f"written to {options.output} ({options.output.stat().st_size:,} bytes)")
    return 0
