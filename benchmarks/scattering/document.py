"""The document of the benchmark of measured materials, made of its numbers."""

from pathlib import Path

from ..common.bars import Bar
from ..common.document import BEARABLE_LOAD, tell_demands

VECTOR_BAR = 20.0
"""Look-ups in kernels over those one by one."""

MEASURED_BAR = 1.5
"""Time of our table over that of Mitsuba's `measured`."""

SIZE_BAR, TYPICAL_TOLERANCE = 2_000_000, 0.02
"""Bytes of a typical material's file, at a tolerance."""

WHOLE_BAR = 0.005
"""Difference of the mean of pictures, beyond the stated error."""

SENSITIVITY_BAR = 0.1
"""By which the change that was foretold may differ from the one computed, of the change."""

TITLE = """# Measured materials: storage over error, sampling, speed, pictures, a back-light

*Made by `lumenray benchmark scattering`; do not edit by hand.*

`lumenray benchmark scattering --json out/scattering.json` repeats it. Materials that are known in closed form (Lambert, GGX
mirrors with Fresnel's law, paints of a pigment under a coat, a brushed metal) are made tables of, as files of other formats
are that have to be resampled.
"""

STORAGE = """## Storage over error

*Wanted*: the error that the table was made for. *Stated*: what it says of itself. *Measured*: over other random pairs of
directions. Errors are root mean squares, relative to the value plus a twentieth of the largest albedo over pi. *Albedo*:
largest relative error of the reflectance at 0, 15, 30, 45, 60 and 75 degrees. *Reciprocity*: residual of the table.
Grids are rotations x incidences x radial angles x azimuths x bands.

![Size over error](scattering_storage.png)
"""

SAMPLING = """## Sampling

Directions drawn from tables (wanted error 2 %): the mean of their weights against the albedo, with its standard error; their
spread over the mean; the largest over the mean. A spread of 0 would be a sampling exactly as the table times the cosine.
"""

SPEED = """## Speed

A spectral table of {shape} values, or the same weighed by the eye to one band. *Values* are those at four wavelengths, or
the one; *evaluations* give the density of sampling too; a *sample* draws a direction and evaluates it. *One by one*: in
Python with NumPy; compiled (`benchmarks/scattering/scalar.c`, `cc -O2` without vector instructions, one processor). Kernels
run on all processors of {device}.
"""

PICTURES = """## Pictures

A ball on a floor of the same stuff under a lamp and a grey sky, by Mitsuba's path tracer; means of blocks of 8 x 8 pixels
are compared. The RGL file was written from a red paint, read, and resampled to our table with a wanted error of 2 %.

![Mitsuba's own, ours, difference times ten](scattering_pictures.png)
"""

BACKLIGHT = """## A back-light with an error made on purpose

A tray of 300 x 200 x 40 mm of a measured white, two lamps of 150 lm in it, an opal sheet above (R 0.55, T 0.40). Mean
luminance of the sheet: {luminance:.0f} cd/m2. `lumenray sensitivity` says what that changes per 1 % of each material:
"""


def write_document(result: dict, path: Path) -> None:
    """Write the document."""
    parts = [
        TITLE,
        tell_demands(check_bars(result)),
        _storage(result["storage"]),
        _sampling(result["sampling"]),
    ]
    parts += [_speed(result), _pictures(result["pictures"]), _backlight(result["backlight"])]
    parts.append(_machine(result))
    path.write_text("\n".join(parts), encoding="utf-8")


def _kernel(result, surface: str, spectral: bool = True) -> dict:
    return next(
        row
        for row in result["speed"]["kernels"]
        if row["surface"] == surface and row["spectral"] == spectral
    )


def check_bars(result: dict) -> list[Bar]:
    """What is demanded, and whether it is met."""
    speed = result["speed"]
    ours, theirs = _kernel(result, "table"), _kernel(result, "Mitsuba's measured")
    bars = []

    def add(what, bar, told, is_met):
        bars.append(Bar(what, bar, told, bool(is_met)))

    ratio = ours["values"] / speed["python"]
    add(
        "look-ups in kernels over one by one in Python",
        f"{VECTOR_BAR:g} x",
        f"{ratio:,.0f} x",
        ratio >= VECTOR_BAR,
    )
    for name, kernel in (
        ("compiled", ours),
        ("compiled photometric", _kernel(result, "table", False)),
    ):
        if speed[name] is not None:
            ratio = kernel["values"] / speed[name]
            kind = "spectral" if kernel["spectral"] else "photometric"
            add(
                f"{kind} look-ups in kernels over one by one, compiled",
                f"{VECTOR_BAR:g} x",
                f"{ratio:.1f} x",
                ratio >= VECTOR_BAR,
            )
    for kind in ("evaluations", "samples"):
        cost = theirs[kind] / ours[kind]
        add(
            f"cost of {kind} over Mitsuba's measured",
            f"{MEASURED_BAR:g} x",
            f"{cost:.2f} x",
            cost <= MEASURED_BAR,
        )
    typical = [row for row in result["storage"] if row["tolerance"] == TYPICAL_TOLERANCE]
    largest = max(typical, key=lambda row: row["bytes"])
    add(
        "largest file at 2 %", f"{SIZE_BAR / 1e6:g} MB",
        f"{largest['bytes'] / 1e6:.2f} MB ({largest['material']})", largest["bytes"] <= SIZE_BAR,
    )  # fmt: skip
    for kind in ("stated", "measured"):
        worst = max(row[kind] for row in typical)
        add(
            f"{kind} error within the wanted one",
            "2 %",
            f"{100 * worst:.2f} % at most",
            worst <= TYPICAL_TOLERANCE,
        )
    for row in result["pictures"]:
        add(
            f"pictures, {row['case']}: difference without chance",
            f"stated error {100 * max(row['stated'], WHOLE_BAR):.2f} %",
            f"{100 * row['without_chance']:.2f} %, mean {100 * row['whole']:+.2f} %",
            row["without_chance"] <= max(row["stated"], WHOLE_BAR),
        )  # fmt: skip
    for row in result["backlight"]["rows"]:
        apart = abs(row["foretold"] / row["computed"] - 1.0)
        add(
            f"back-light, reflector {100 * row['error']:+g} %: change foretold",
            f"computed within {100 * SENSITIVITY_BAR:g} %",
            f"{100 * row['foretold']:+.2f} % for {100 * row['computed']:+.2f} %", apart <= SENSITIVITY_BAR,
        )  # fmt: skip
    return bars


def _storage(rows) -> str:
    lines = [
        STORAGE,
        "| material | wanted | stated | measured | albedo | reciprocity | grid | file |",
        "|" + "---|" * 8,
    ]
    for row in rows:
        grid = " x ".join(map(str, row["shape"]))
        numbers = " | ".join(
            f"{100 * row[key]:.2f} %"
            for key in ("tolerance", "stated", "measured", "albedo", "reciprocity")
        )
        lines.append(f"| {row['material']} | {numbers} | {grid} | {row['bytes'] / 1e3:.1f} kB |")
    return "\n".join([*lines, ""])


def _sampling(rows) -> str:
    lines = [
        SAMPLING,
        "| material | incidence | mean weight | albedo | spread | largest |",
        "|" + "---|" * 6,
    ]
    for row in rows:
        lines.append(
            f"| {row['material']} | {row['incidence']:g} deg | {row['mean']:.4f} +- {row['error']:.4f} | "
            f"{row['albedo']:.4f} | {row['spread']:.2f} | {row['largest']:.1f} |"
        )
    return "\n".join([*lines, ""])


def _speed(result) -> str:
    speed = result["speed"]
    shape = " x ".join(map(str, speed["table"]))
    device = result["machine"].get("processor", "this machine")
    lines = [
        SPEED.format(shape=shape, device=device),
        "| | values | evaluations | samples |",
        "|---|---|---|---|",
        f"| table, one by one in Python (all bands) | {speed['python'] / 1e6:.4f} M/s | | |",
        f"| table, NumPy (all bands) | {speed['numpy'] / 1e6:.2f} M/s | | |",
    ]
    for name, kind in (("compiled", "spectral"), ("compiled photometric", "photometric")):
        if speed[name] is not None:
            lines.append(
                f"| table, one by one, compiled, {kind} | {speed[name] / 1e6:.2f} M/s | | |"
            )
    for row in speed["kernels"]:
        kind = "spectral" if row["spectral"] else "photometric"
        lines.append(
            f"| {row['surface']}, {kind} kernels | "
            + " | ".join(
                f"{row[what] / 1e6:.1f} M/s" for what in ("values", "evaluations", "samples")
            )
            + " |"
        )
    return "\n".join([*lines, ""])


def _pictures(rows) -> str:
    lines = [
        PICTURES,
        "| case | stated error of the table | difference of blocks | of it chance | without chance | of the whole picture |",
        "|" + "---|" * 6,
    ]
    for row in rows:
        numbers = " | ".join(
            f"{100 * row[key]:.2f} %"
            for key in ("stated", "difference", "chance", "without_chance")
        )
        lines.append(f"| {row['case']} | {numbers} | {100 * row['whole']:+.3f} % |")
    return "\n".join([*lines, ""])


def _backlight(made) -> str:
    lines = [
        BACKLIGHT.format(luminance=made["luminance"]),
        "| material | change per 1 % | standard error |",
        "|---|---|---|",
    ]
    for row in made["figures"]:
        lines.append(f"| {row['material']} | {row['mean']:.3f} % | {row['error']:.3f} % |")
    lines += [
        "",
        "Then the reflector's table is wrong on purpose. The box is computed with and without the error, with "
        "the same random numbers, other ones than those of the figures:",
        "",
        "| error of the reflectance | change foretold | computed |",
        "|---|---|---|",
    ]
    for row in made["rows"]:
        lines.append(
            f"| {100 * row['error']:+g} % | {100 * row['foretold']:+.2f} % | {100 * row['computed']:+.2f} % |"
        )
    return "\n".join([*lines, ""])


def _machine(result) -> str:
    lines = ["## Machine", ""]
    lines += [f"- {key}: {value}" for key, value in result["machine"].items()]
    loads = {name: share for name, share in result["other_load"].items() if share is not None}
    told = ", ".join(f"{name} {100 * share:.0f} %" for name, share in loads.items())
    lines.append(f"- processors taken by others meanwhile: {told}")
    if loads.get("speed", 0.0) > BEARABLE_LOAD:
        lines.append("- **others were busy while speed was measured: its figures are too low**")
    return "\n".join([*lines, ""])
