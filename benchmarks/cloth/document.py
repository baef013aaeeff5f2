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
    for name, tell in (
        ("woven", _woven),
        ("direct", _direct),
        ("presets", _presets),
        ("curtain", _curtain),
        ("sheen", _sheen),
    ):
        if name in parts:
            chapters.append(tell(parts[name]))
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
        "hue of what is reflected, so this hue is met by construction; that of what passes follows. In the "
        "tables both ways of light are averaged up to 75 degrees from the normal; between random directions up to 80 "
        "degrees they differ by what is told: noise beyond, scaling and interpolation.\n\n"
        f"A close-up of one repeat, lit from a round window 60 degrees wide at 45 degrees and seen along the normal by rays "
        f"from the eye, has {row['close_up']:.4f} of a white surface's luminance in the mean "
        f"(standard error {row['close_up_error_percent']:.2g} %), the table {row['from_afar']:.4f}.\n"
    )


def _direct(row) -> str:
    lines = [
        f"| {words} | {own['pairs']:,} | {100.0 * own['mean']:+.2f} % | {100.0 * own['rms']:.1f} % | "
        f"{100.0 * own['noise']:.1f} % |"
        for words, own in (("reflected", row["reflection"]), ("passed", row["transmission"]))
    ]
    return (
        f"## Tables against light sent anew (T5)\n\n{row['cloth']}, a draft, at 640 nm: light from directions at "
        "random, counted in round windows of 7 degrees about others, all up to 80 degrees from the normal. Differences are "
        "over the table's value, or 0.02/sr where it is less; the noise of the counts is taken out of their root mean "
        "square and stands beside it. What is left is the noise of the tables, and lobes and angles between which they are "
        "linear.\n\n"
        + make_table("| light | pairs | mean | root mean square | noise taken out |", lines, 1)
    )


def _presets(rows) -> str:
    lines = []
    for name, row in rows.items():
        lines.append(
            f"| {name} | {_share(row['transmittance'], row['transmittance_error'])} | "
            f"{_share(row['reflectance'], row['reflectance_error'])} | {100.0 * row['back_reflectance']:.1f} | "
            f"{100.0 * row['openness']:.2f} | {100.0 * row['diffuse_transmittance']:.1f} | "
            f"{100.0 * row['diffuse_reflectance']:.1f} | {row['cutoff_warp_deg']:.0f}, {row['cutoff_weft_deg']:.0f} | "
            f"{100.0 * row['table_error']:.0f} | {row['seconds']:.0f} |"
        )
    head = (
        "| cloth | Tv [%] | Rv [%] | of the back [%] | openness [%] | Tv diffuse [%] | Rv diffuse [%] | cut-off [deg] | "
        "table error [%] | s |"
    )
    return (
        "## Cloths that ship\n\nAs data sheets state them (EN 14500, D65), from tables of 120 000 rays for each direction, "
        "as they are computed unless a draft is asked for, with standard errors; the cut-off angle is told along the warp "
        "and along the weft. The time is of one that was not kept from before.\n\n"
        + make_table(head, lines, 9)
    )


def _share(value: float, error: float) -> str:
    return f"{100.0 * value:.2f} ± {100.0 * error:.1g}"


def _curtain(rows) -> str:
    lines = [
        f"| {name} | {light} | {100.0 * own['map']:.3f} ± {100.0 * own['error']:.1g} % | {100.0 * own['table']:.3f} % | "
        f"{100.0 * (own['map'] / own['table'] - 1.0):+.2f} % | {_known(own)} |"
        for name, each in rows.items()
        for light, own in each.items()
    ]
    return (
        "## Behind a curtain\n\nMean of a lux map close behind a curtain that closes a black box, over the illuminance in "
        "front of it, under an even sky and under a sun along the normal; and the transmittance that the curtain's tables "
        "state for this light. Light is followed from the map, so what it meets is the tables' values for light "
        "from everywhere else, in place of their total for light along the normal: both are the same up to the tables' "
        "noise, of which the standard error is told.\n\n"
        + make_table("| curtain | light | map | table | apart | of the table |", lines, 2)
    )


def _known(own) -> str:
    return (
        f"± {100.0 * own['table_error'] / own['table']:.2g} %"
        if own["table_error"]
        else "not known"
    )


def _sheen(row) -> str:
    lines = [
        f"| {angle:.0f} | {100.0 * own:.1f} | {100.0 * other:.1f} |"
        for angle, own, other in zip(row["angles"], row["woven"], row["sheen"], strict=True)
    ]
    lines.append(
        f"| from everywhere | {100.0 * row['diffuse'][0]:.1f} | {100.0 * row['diffuse'][1]:.1f} |"
    )
    return (
        "## A sheen in its place\n\nBlender's Principled BSDF has a sheen for cloth. A Lambertian base of "
        f"{row['base']:.3f} under a sheen of the weight {row['weight']:.3f} (roughness 0.5) reflects as much as "
        f"the draft of {row['cloth']} at {row['wavelength']:.0f} nm along the normal, and as nearly as it can of light from "
        "everywhere; between, and in what it lets through (nothing), it differs. It has no direction along yarns, and no "
        f"straight light. Reflectances in per cent, standard error of the sheen's {100.0 * row['error']:.1g}:\n\n"
        + make_table("| light from [deg] | cloth | sheen |", lines, 0)
    )
