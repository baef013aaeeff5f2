"""The document of what was measured of cloths."""

from ..common.document import make_table, tell_demands

GROUPS = {
    "B1": "light that does not scatter in a matched thread, by Struve's and Bessel's functions",
    "B2": "mean way of light from everywhere: 2 n^2 R whatever scatters",
    "B3": "lobes R, TT and TRT of a clear cylinder; TT with a dye",
    "B4": "thick threads, a pencil on their middle: another program's walk",
    "B5": "albedo of facets that reflect all, at 0, 45 and 75 degrees",
    "B6": "Peirce's jammed weave, crimp of a cosine",
    "B7": "cover of two nets on each other",
    "B8": "touching Lambert cylinders, light that met one: shadows, what is hidden, areas",
}


def describe(result: dict, bars) -> str:
    """Markdown of all results."""
    parts = result["parts"]
    chapters = [
        "# Cloth\n\nMade by `lumenray benchmark cloth`; formulas are in [theory.md](../theory.md), chapter 17. Seconds are "
        "of the processor, all threads together.\n",
        "Measured on {cpu}, {cores} cores, {system}, Python {python}.\n".format(
            **result["machine"]
        ),
        tell_demands(bars),
    ]
    if "reference" in parts:
        chapters.append(_reference(parts["reference"]))
    if "photons" in parts:
        chapters.append(_photons(parts["photons"]))
    if "woven" in parts:
        chapters.append(_woven(parts["woven"]))
    return "\n".join(chapters)


def _reference(rows) -> str:
    lines = []
    for group, words in GROUPS.items():
        own = [row for row in rows if row["id"].startswith(group)]
        worst = max(row["ratio"] for row in own)
        bad = [row["id"] for row in own if row["verdict"] != "pass"]
        lines.append(
            f"| {group} | {words} | {len(own)} | {worst:.2g} | {', '.join(bad) or 'none'} |"
        )
    head = "| group | what | values | largest difference over allowed | apart |"
    return (
        "## Reference values\n\nAllowed are four standard errors of what is found by chance, and a few thousandths for "
        "drawn bodies with corners and windows of directions.\n\n" + make_table(head, lines, 2)
    )


def _photons(row) -> str:
    return (
        "## Photons in a thread\n\n10^6 photons, scattering 20 times in a radius (mean cosine 0.8, index 1.557): "
        f"{row['seconds']:.2f} s. The same walk by NumPy, all photons a step at a time, takes {row['numpy_seconds']:.0f} s "
        f"(from fewer photons), {row['ratio']:.1f} times as long; both mean ways are {row['sigmas_apart']:.1f} standard "
        "errors apart.\n"
    )


def _woven(row) -> str:
    sheet = row["sheet"]
    lines = [
        f"| {name} | {hsv[0]:.3f} | {hsv[1]:.3f} | {100.0 * row['reciprocity'][side]:.1f} % |"
        for side, hsv, name in (
            (side, row["hsv"][side], name)
            for side, name in (
                ("reflection", "reflected"),
                ("transmission", "passed, without openings"),
            )
        )
    ]
    return (
        f"## {row['cloth']}\n\n{row['rays']:,} rays, {row['bands']} bands, seed {row['seed']}: {row['seconds']:.0f} s; "
        f"values within {100.0 * row['table_error']:.2g} % (standard error). Openness {100.0 * sheet['openness']:.2f} %, "
        f"transmittance {100.0 * sheet['transmittance']:.2f} %, reflectance {100.0 * sheet['reflectance']:.2f} %.\n\n"
        + make_table("| light | hue | saturation | both ways differ |", lines, 1)
        + "\nHue and saturation of light along the normal under D65; the reference states 0.97 to 0.99 and 0.99 (its RGB is "
        "not told; gloss, which has the colour of the light, may take saturation here). The preset's dye was chosen by the "
        "hue of what is reflected, so this hue is met by construction; that of what passes follows. Both ways "
        "of light between random directions differ by the noise of the tables and what is left of bends.\n\n"
        f"A close-up of one repeat, lit from a round window 60 degrees wide at 45 degrees and seen along the normal by rays "
        f"from the eye, has {row['close_up']:.4f} of a white surface's luminance in the mean "
        f"(standard error {row['close_up_error_percent']:.2g} %), the table {row['from_afar']:.4f}.\n"
    )
