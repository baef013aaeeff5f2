"""The command ``lumenray ink compute``: a pigment layer's colours, its table, and how good both are."""

from pathlib import Path

from ..options import real
from ..output import add_force, check_free, percent, rounded, say, say_json, table
from .job import add_job, solve


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    compute = tasks.add_parser(
        "compute", help="solve a pigment layer, tell its colour, make its table"
    )
    add_job(compute)
    compute.add_argument("-o", "--output", type=Path, metavar="OUT.lumbsdf", help="table to write")
    add_force(compute)
    compute.add_argument(
        "--wanted",
        type=real(),
        default=0.01,
        metavar="E",
        help="relative standard error for which the number of realisations is forecast (default: 0.01)",
    )
    compute.add_argument("--json", action="store_true", help="numbers as JSON")
    compute.set_defaults(run=run)


def run(options) -> int:
    """Compute a pigment layer; return the exit code."""
    from ...engine.ink.computed import further_realisations
    from ...engine.scattering.data.store import write_store

    check_free(options, options.output)
    made = solve(options)
    printed = made.printed
    back, passed = printed.hemispherical
    if options.output is not None:
        write_store(options.output, made.file(made.table()))
    enough = further_realisations(made, options.wanted)
    row = {
        "name": printed.ink.name,
        "bands_nm": printed.wavelengths,
        "reflectance_45_0": made.readings,
        "standard_errors": made.standard_errors,
        "film_reflectance_hemispherical": back,
        "film_transmittance_hemispherical": passed,
        "lab_d50_2deg": made.lab,
        "lab_standard_error": made.lab_error,
        "grid_error": made.grid_error,
        "realisations": made.plan.realisations,
        "realisations_for_wanted": enough,
        "seed": made.plan.seed,
        "iterations": made.iterations,
        "units_solved": made.solved,
        "notes": made.notes(),
    }
    if options.json:
        say_json(rounded(row))
        return 0
    rows = [("nm", "R 45:0", "standard error", "film R", "film T")]
    rows += [
        (f"{nm:.0f}", *(f"{value:.4f}" for value in values))
        for nm, *values in zip(
            printed.wavelengths, made.readings, made.standard_errors, back, passed, strict=True
        )
    ]
    say(table(rows))
    say("L* a* b* (D50, 2 degrees): " + "  ".join(f"{value:.1f}" for value in made.lab))
    for note in made.notes():
        say(note)
    say(
        f"standard error {percent(made.error, '.2g')}; {percent(options.wanted)} needs {enough} realisations; "
        f"{made.iterations:.1f} iterations a solve, {made.solved} units solved now"
    )
    if options.output is not None:
        say(f"written to {options.output} ({options.output.stat().st_size:,} bytes)")
    return 0
