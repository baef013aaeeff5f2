"""The document of what was measured of effect paints."""

from ..common.document import make_table, tell_demands

GROUPS = {
    "A1": "half spaces of isotropic scattering, Chandrasekhar's H function",
    "A2": "slabs without faces: own solver of the reference, van de Hulst's and Giovanelli's tables",
    "A2i": "the same by iadpython, which loses some light (not judged)",
    "A3": "slabs with smooth faces in air",
    "A3i": "the same by iadpython (not judged)",
    "A4": "Fresnel's law, its means, Saunderson's formula",
    "A5": "parallel flakes, as a continuum and in piles, in closed form",
    "A6": "interference stacks and aluminium by tmm",
    "A7": "concentrations of the three samples",
    "A8": "BRDF and albedo of the three samples, three bands",
    "A9": "flake media: finer adding-doubling, Monte Carlo, furnace, reciprocity",
    "A10": "explicit discs",
    "A11": "single reflection in closed form",
    "A12": "spheres by miepython",
    "A13": "sizes and sparkles",
    "A14": "mirrors at random are an isotropic medium",
    "A15": "what means of polarisation overestimate",
}


def describe(result: dict, bars) -> str:
    """Markdown of all results."""
    chapters = [
        "# Effect paints\n\nMade by `lumenray benchmark paint`; formulas are in [theory.md](../theory.md), chapter 16.\n",
        "Measured on {cpu}, {cores} cores, {system}, Python {python}.\n".format(
            **result["machine"]
        ),
        tell_demands(bars),
    ]
    parts = result["parts"]
    if "reference" in parts:
        chapters.append(_reference(parts["reference"]))
    if "walks" in parts:
        chapters.append(_walks(parts["walks"]))
    if "tables" in parts:
        chapters.append(_tables(parts["tables"]))
    if "speed" in parts:
        chapters.append(_speed(parts["speed"]))
    if "fit" in parts:
        chapters.append(_fits(parts["fit"]))
    return "\n".join(each for each in chapters if each)


def _reference(rows) -> str:
    lines = []
    for group, words in GROUPS.items():
        own = [row for row in rows if row["id"].split(".")[0] == group]
        worst = max((row["ratio"] for row in own if row["ratio"] is not None), default=0.0)
        bad = [row["id"] for row in own if row["verdict"] != "pass"]
        lines.append(
            f"| {group} | {words} | {len(own)} | {worst:.2g} | {', '.join(bad) or 'none'} |"
        )
    table = make_table(
        "| group | what | values | largest difference over allowed | apart |", lines, 2
    )
    return (
        "## Reference values\n\nAllowed is the tolerance stated with each value, of a BRDF relative to the value plus "
        "0.02/sr, and four standard errors where one of both is Monte Carlo.\n\n" + table
    )


def _walks(parts) -> str:
    lines = []
    for name, rows in parts.items():
        sigmas = sorted(row["sigmas"] for row in rows)
        square = sum(row["ring_square"] for row in rows) / max(sum(row["rings"] for row in rows), 1)
        within = sum(each <= 1.0 for each in sigmas)
        lines.append(f"| {name} | {len(rows)} | {within} | {sigmas[-1]:.2f} | {square:.2f} |")
    table = make_table(
        "| photons in | compositions | albedos within one standard error | largest difference [standard errors] "
        "| mean square over rings of exit |", lines,
    )  # fmt: skip
    return (
        "## Random compositions\n\nOne or two layers of mirrors, interference flakes and grains over matt grounds, at "
        "random angles. Discs are sown so thinly (their area is 2 to 18 % of the paint's) that hardly any light meets "
        "two: there a continuum is what they tend to. Wide opaque flakes that lie densely reflect up to a "
        "third more than a continuum (A10): that is not an error of either, but what the continuum leaves out.\n\n"
        + table
    )


def _tables(rows) -> str:
    lines = [
        f"| {k + 1} | {row['table_error']:.3f} | {row['inner_reciprocity']:.4f} | {row['reciprocity']:.4f} "
        f"| {row['clamped']:.1e} | {row['energy']:.3f} | {row['furnace']:.1e} | {row['convergence']:.4f} |"
        for k, row in enumerate(rows)
    ]
    head = (
        "| composition | table (T5) | reciprocity within 85° (T3) | anywhere | clamped (T4) | largest total (T1) "
        "| lost without absorption (T2) | change from 3/4 resolution |"
    )
    return (
        "## Tables\n\nT5 is the root mean square difference of the table from the solution at 10,000 random pairs of "
        "directions in all bands, relative to the value plus 0.02/sr. T3 is the largest difference between both ways by the "
        "largest value that was met; nearer the horizon than 5 degrees these dull paints fall so steeply that cells of a "
        "table. For T2 flakes let pass what they do not reflect, grains and "
        "substrate absorb nothing; it is the largest share that is lost at any angle and band.\n\n"
        + make_table(head, lines)
    )


def _speed(rows) -> str:
    lines = [
        f"| {name} | {row['solve_seconds']:.3f} | {row['solve_processor_seconds']:.3f} | {row['seconds']:.3f} "
        f"| {row['processor_seconds']:.3f} | {row['values']:,} |"
        for name, row in ((each, rows[each]) for each in ("spectral", "rgb"))
    ]
    head = (
        "| run | solved [s] | of processors [s] | with its table [s] | of processors [s] | values |"
    )
    walk, sphere = rows["monte_carlo"], rows["sphere"]
    return (
        "## Speed\n\nTwo layers, the least of several warm runs. Demands are judged by the seconds of processors, all cores "
        "together: they are what the clock of one free core would show, and others on the machine do not lengthen them.\n\n"
        + make_table(head, lines)
        + f"\nThe sphere of 256 x 256 pixels that panels show took {sphere['processor_seconds']:.3f} s of processors "
        f"({sphere['seconds']:.3f} s by the clock) with all sliders moved.\n\n"
        "Against Monte Carlo from direction to direction: Mitsuba's media know no flakes with Gaussian slopes that reflect "
        "by the angle, so the walk (`benchmarks/paint/direction_walk.py`) is written in Dr.Jit, by which Mitsuba compiles "
        "its own integrators, with next-event estimation to the eye, and without a scene to intersect. It agrees with the "
        f"solution (mean square of differences in its standard errors {walk['mean_square_sigmas']:.2f}). A walk takes "
        f"{1e6 * walk['walk_seconds']:.2g} µs of processors; {walk['walks_of_each']:,.0f} for each pair of directions give "
        f"the error of the table, {100.0 * walk['error']:.2g} %, and the table has {walk['directions']:,} pairs: "
        f"{walk['seconds_of_one_walk_for_all_bands']:,.0f} s if one walk served all bands at no cost, "
        f"{walk['speedup_of_one_walk_for_all_bands']:,.0f} times as long as solution and table, and "
        f"{walk['seconds']:,.0f} s, {walk['speedup']:,.0f} times as long, with four wavelengths to a walk, as renderers "
        "have.\n"
    )


def _fits(rows) -> str:
    lines = [
        f"| {k + 1} | {row['truth'][0]:.1f} | {row['found'][0]:.1f} ± {row['errors'][0]:.1f} | {row['truth'][1]:.4f} "
        f"| {row['found'][1]:.4f} ± {row['errors'][1]:.4f} | {row['truth'][2]:.2f} "
        f"| {row['found'][2]:.2f} ± {row['errors'][2]:.2f} | {row['processor_seconds']:.0f} |"
        for k, row in enumerate(rows)
    ]
    head = "| fit | core [nm] | found | area [1/µm] | found | tilt [deg] | found | processors [s] |"
    return (
        "## Fits\n\nColours at six angles, rounded to a tenth, said to be known to 0.3; every fit begins at 350 nm, "
        "0.06 /µm and 8 degrees.\n\n" + make_table(head, lines)
    )
