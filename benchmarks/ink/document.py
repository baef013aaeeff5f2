"""The document of what was measured of dense pigment layers."""

from ...engine.analysis.ink_picture import draw_amounts, draw_patches
from ..common.document import make_table, tell_demands
from .series import WRONG, find_departures

GROUPS = {
    "C1": "scalar spheres, sums of partial waves",
    "C2": "films and a stack by tmm; the stack on 20, 40, 80 cells, and what the finer two extrapolate to",
    "C3": "energy and reciprocity of a random layer",
    "C4": "one sphere: its forward amplitude in closed form, and on a grid",
    "C5": "molecules: films of the mean permittivity",
    "C6": "films on paper, and the white furnace",
    "C7": "volumes of chains of spheres",
    "C9": "dense layers of spheres: reflected, transmitted, absorbed, diffusely transmitted",
    "C10": "a dilute layer against spheres one by one",
    "C11": "films in both polarisations",
}


def describe(result: dict, bars) -> str:
    """Markdown of all results."""
    parts = result["parts"]
    chapters = [
        "# Dense pigment layers\n\nMade by `lumenray benchmark ink`; formulas are in [theory.md](../theory.md), "
        "chapter 18.\n",
        "Measured on {cpu}, {cores} cores, {system}, Python {python}.\n".format(
            **result["machine"]
        ),
        tell_demands(bars),
    ]
    rows = [*parts.get("reference", {}).get("rows", []), *parts.get("dense", [])]
    if rows:
        chapters.append(_reference(rows))
    if "trend" in parts:
        chapters.append(_trend(parts["trend"]))
    if "series" in parts:
        chapters.append(_series(parts["series"]))
    if "presets" in parts:
        chapters.append(_presets(parts["presets"]))
    if "processes" in parts:
        timed = parts["processes"]
        clock = ", ".join(f"{one:.1f} s and {two:.1f} s" for one, two in timed["clock_seconds"])
        used = timed["processor_seconds"]
        chapters.append(
            "## Processes\n\n"
            f"The same job takes {used['one']:.1f} processor seconds with one process, {used['two']:.1f} in two together, "
            f"and {used['twice']:.1f} with one and twice the realisations. By the clock, in turns, their start included: "
            f"{clock}; two are {timed['gain']:.2f} times as fast as one (median). By processor "
            f"seconds they would be {timed['gain_of_processors']:.2f} times as fast: what is missing to 2 is what both "
            "do, or do slower side by side.\n"
        )
    return "\n".join(chapters)


def draw_trend(rows):
    """Patches of all colours by the size of particles."""
    colours = list(dict.fromkeys(row["colour"] for row in rows))
    patches = [
        (name, [(_size(row), row["reflectance"]) for row in rows if row["colour"] == name])
        for name in colours
    ]
    return draw_patches(patches, rows[0]["wavelengths_nm"])


def draw_series(rows):
    """Reflectances over the amount of pigment, by all models."""
    curves = []
    for pigment, nm in _kinds(rows):
        own = [row for row in rows if (row["pigment"], row["wavelength_nm"]) == (pigment, nm)]
        names = ("share", "waves", "standard_error", "transfer", "kubelka_munk")
        curves.append((f"{pigment}, {nm:.0f} nm", *([row[name] for row in own] for name in names)))
    return draw_amounts(curves)


def _kinds(rows) -> list[tuple[str, float]]:
    return list(dict.fromkeys((row["pigment"], row["wavelength_nm"]) for row in rows))


def _series(rows) -> str:
    lines = [
        f"| {row['pigment']} | {row['wavelength_nm']:.0f} | {100 * row['share']:.0f} % | {row['waves']:.4f} | "
        f"{row['standard_error']:.1g} | {row['grid_error']:.1g} | {row['transfer']:.4f} | {row['transfer_mie']:.4f} | "
        f"{row['kubelka_munk']:.4f} |"
        for row in rows
    ]
    table = make_table(
        "| pigment | nm | volume | waves | error | grid | transfer, same spheres | transfer, Mie | Kubelka-Munk |",
        lines,
        1,
    )
    lines = []
    for entry in find_departures(rows):
        amounts = (
            ", ".join(f"{100 * share:.0f} %" for share in entry[name]) or "none"
            for name in ("transfer", "transfer_mie", "kubelka_munk")
        )
        lines.append(
            f"| {entry['pigment']} | {entry['wavelength_nm']:.0f} | {' | '.join(amounts)} |"
        )
    departures = make_table(
        "| pigment | nm | transfer, same spheres | transfer, Mie | Kubelka-Munk |", lines, 1
    )
    return (
        "## Concentrations\n\nReflectance factors at 45:0 of a layer of 1 um that wets a white of 0.9. Radiative transfer "
        "by adding and doubling lets spheres scatter one by one: once the spheres of the scalar equation, so that only "
        "crowding and interference differ, once those of Mie. Kubelka's and Munk's K and S are 2 and 3/4 (1 - g) times the "
        "spheres' absorption and scattering, times one factor by which the weakest print is that of waves.\n\n"
        + table
        + "\n\n![Reflectance over the amount of pigment](ink_series.png)\n\nAt these amounts they are apart from "
        f"waves, by more than {WRONG:g} or the grid's error and two standard errors:\n\n"
        + departures
        + "\n"
    )


def _reference(rows) -> str:
    lines = []
    for group, words in GROUPS.items():
        own = [row for row in rows if row["id"].split(".")[0] == group]
        if not own:
            continue
        worst = max((row["ratio"] for row in own if row["ratio"] is not None), default=0.0)
        bad = [row["id"] for row in own if row["verdict"] != "pass"]
        lines.append(
            f"| {group} | {words} | {len(own)} | {worst:.2g} | {', '.join(bad) or 'none'} |"
        )
    table = make_table(
        "| group | what | values | largest difference over allowed | apart |", lines, 2
    )
    return (
        "## Reference values\n\nAllowed is the tolerance stated with each value and, of layers with particles by chance, "
        "four standard errors of both.\n\n" + table
    )


def _trend(rows) -> str:
    lines = []
    for row in rows:
        lab = " | ".join(f"{value:.1f}" for value in row["lab"])
        lines.append(
            f"| {row['colour']} | {_size(row)} | {lab} | {row['chroma']:.1f} | {row['lab_error']:.1g} | "
            f"{row['absorbed']:.3f} | {row['grid_error']:.1g} | {row['iterations']:.1f} |"
        )
    table = make_table(
        "| pigment | particles | L* | a* | b* | chroma | error | absorbed at the band's peak | grid | iterations |",
        lines,
        2,
    )
    return (
        "## Colours by the size of particles\n\n30 % of pigment in 1 um on paper of 0.9, light at 45 degrees seen along the "
        "normal, D50; drafts. Small particles absorb more: the same amount of pigment is deeper in colour.\n\n"
        + table
        + "\n\n![Printed patches by the size of particles](ink_sizes.png)\n"
    )


def _presets(rows) -> str:
    lines = []
    for row in rows:
        begin = f"| {row['name']} | {row['memory_bytes'] / 2**20:.0f} |"
        if row["problem"]:
            lines.append(f"{begin} {row['problem']} | | | | | |")
            continue
        lab = " | ".join(f"{value:.1f}" for value in row["lab"])
        lines.append(
            f"{begin} {lab} | {row['lab_error']:.1g} | {row['grid_error']:.1g} | {row['iterations']:.1f} |"
        )
    table = make_table("| preset | MB | L* | a* | b* | error | grid | iterations |", lines, 1)
    return (
        "## Presets\n\nAs drafts: memory of one process, colours at 45:0 under D50.\n\n"
        + table
        + "\n"
    )


def _size(row) -> str:
    return f"{row['size_um']:g} um" if row["size_um"] else "molecules"
