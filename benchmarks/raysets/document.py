"""The document of the benchmark of ray sets, made of its numbers."""

from pathlib import Path

import numpy as np

from ..common.bars import Bar
from ..common.document import BEARABLE_LOAD, tell_demands

GENERATED_BAR, REPEATED_BAR, LEAST_DISTANCE, COUNT = 0.02, 0.1, 2.0, 10_000
"""Generated rays shall be within the first where those of the file repeated are beyond the second, from so many sizes on."""

MEMORY_BAR = 40.0
"""Bytes that a ray may take."""

VARIANCE_BAR = 0.1
"""How far the variance times the number of rays may be from even, beyond the file's own number."""

TITLE = """# Ray sets: error over the size of the file, convergence, lux maps, speed

*Made by `lumenray benchmark raysets`; do not edit by hand.*

`lumenray benchmark raysets --json out/raysets.json` repeats it. Three sources whose light is known in closed form are
written as ray sets: a Lambertian disk, a Lambertian sphere, and a coiled filament of Lambertian wire (five turns, one
does not shade another), each 2 mm across. Illuminance is compared in 10 x 10 cells of square planes, 1.5 times as wide as
they are high over the source's middle, at distances from its surface in sizes of the source; errors are root mean squares
over cells, relative to the mean. *Even* sets are made of Sobol's low-discrepancy numbers, as programs that write ray
files use them; *random* ones of random numbers, of which every plane catches a number that is uncertain by itself.
"""

ERRORS = """## Error over the size of the file

*Repeated*: the rays of the file and nothing else. *Generated*: {drawn} million rays made from them; what is due to that
number is taken off. Files of 1000 and 10 000 rays are four each.

![Errors over the size of the file](raysets_errors.png)
"""

CONVERGENCE = """## Beyond the number of rays in the file

A sphere of {rays} even rays; the plane at two sizes; {replicates} repetitions. The variance of generated light falls as one
over the number of rays, however often that is the number in the file: the column *variance x rays* is even. The error
against the exact light falls with it down to what the set knows; the set states {stated:.1f} % (for 192 parts of the
sphere with as much light each, estimated from its own halves). Rays repeated end at the pattern of the file.

![Convergence](raysets_convergence.png)
"""

MAPS = """## Lux maps close by

Maps of {side} x {side} lumels under the disk, from its file of 10 000 even rays: traced from the rays where that counts,
and as a point with the file's distribution of intensity (`--caustics off`). {samples} samples a lumel, the error without
the part of chance.
"""

SPEED = """## Speed and memory

Sets of {rays} rays. *Host*: NumPy on one processor. *Kernels*: as light is traced, drawing alone, on {device}.
"""


def write_document(result: dict, path: Path) -> None:
    """Write the document."""
    parts = [
        TITLE,
        tell_demands(check_bars(result)),
        _errors(result["errors"]),
        _convergence(result["convergence"]),
    ]
    parts += [_maps(result["maps"]), _speed(result), _machine(result)]
    path.write_text("\n".join(parts), encoding="utf-8")


def check_bars(result: dict) -> list[Bar]:
    """What is demanded, and whether it is met."""
    bars = []
    for kind in ("even", "random"):
        asked = [
            row
            for row in result["errors"]
            if row["rays"] == COUNT
            and row["numbers"] == kind
            and row["distance"] >= LEAST_DISTANCE
            and row["repeated"] > REPEATED_BAR
        ]
        worst = max(asked, key=lambda row: row["generated"])
        told = f"{100 * worst['generated']:.2f} % ({worst['source']}, {worst['distance']:g} sizes)"
        bars.append(
            Bar(
                f"largest error of 10 000 {kind} rays from two sizes on, where repeated ones are beyond 10 %",
                f"{100 * GENERATED_BAR:g} %",
                told,
                worst["generated"] <= GENERATED_BAR,
            )
        )
    products = [row["generated_variance"] * row["rays"] for row in result["convergence"]["rows"]]
    apart = max(abs(p / np.mean(products) - 1.0) for p in products)
    bars.append(
        Bar(
            "variance times rays, largest deviation from its mean",
            f"{100 * VARIANCE_BAR:g} %",
            f"{100 * apart:.1f} %",
            bool(apart <= VARIANCE_BAR),
        )
    )
    held = max(row["bytes_per_ray"] for row in result["speed"]["rows"])
    bars.append(Bar("bytes held for a ray", f"{MEMORY_BAR:g}", f"{held:.1f}", held <= MEMORY_BAR))
    return bars


def _errors(rows) -> str:
    from .sizes import DISTANCES, DRAWN

    heads = " | ".join(f"{d:g} sizes" for d in DISTANCES)
    lines = [
        f"| source | numbers | rays | | {heads} | stated |",
        "|" + "---|" * (5 + len(DISTANCES)),
    ]
    keys = list(dict.fromkeys((r["source"], r["numbers"], r["rays"]) for r in rows))
    for source, kind, count in keys:
        own = [r for r in rows if (r["source"], r["numbers"], r["rays"]) == (source, kind, count)]
        for name in ("repeated", "generated"):
            cells = " | ".join(f"{100 * r[name]:.2f} %" for r in own)
            stated = f"{100 * own[0]['stated']:.1f} %" if name == "generated" else ""
            number = f"{count:,}".replace(",", " ")
            lines.append(f"| {source} | {kind} | {number} | {name} | {cells} | {stated} |")
    return "\n".join([ERRORS.format(drawn=DRAWN >> 20), *lines, ""])


def _convergence(result) -> str:
    from .sizes import REPLICATES

    head = CONVERGENCE.format(
        rays=result["rays"], replicates=REPLICATES, stated=100 * result["stated"]
    )
    lines = [
        "| rays | times the file | variance x rays | error | repeated: error |",
        "|---|---|---|---|---|",
    ]
    for row in result["rows"]:
        lines.append(
            f"| {row['rays']} | {row['factor']} | {row['generated_variance'] * row['rays']:.0f} | "
            f"{100 * row['generated_error']:.2f} % | {100 * row['repeated_error']:.2f} % |"
        )
    return "\n".join([head, *lines, ""])


def _maps(rows) -> str:
    from .sizes import MAP_SAMPLES, MAP_SIDE

    lines = [
        "| distance | rays: error | seconds | point: error | seconds |",
        "|---|---|---|---|---|",
    ]
    for row in rows:
        lines.append(
            f"| {row['distance']:g} sizes | {100 * row['rays_error']:.2f} % | {row['rays_seconds']:.1f} | "
            f"{100 * row['point_error']:.2f} % | {row['point_seconds']:.1f} |"
        )
    return "\n".join([MAPS.format(side=MAP_SIDE, samples=MAP_SAMPLES), *lines, ""])


def _speed(result) -> str:
    speed = result["speed"]
    machine = result["machine"]
    head = SPEED.format(rays=speed["rays"], device=machine.get("processor", "this processor"))
    lines = [
        "| source | starts from | preparation | host | kernels | bytes a ray |",
        "|---|---|---|---|---|---|",
    ]
    for row in speed["rows"]:
        lines.append(
            f"| {row['source']} | {row['body']} | {row['prepare_seconds']:.1f} s | "
            f"{row['host_rays_per_second'] / 1e6:.2f} M/s | {row['kernel_rays_per_second'] / 1e6:.1f} M/s | "
            f"{row['bytes_per_ray']:.1f} |"
        )
    return "\n".join([head, *lines, ""])


def _machine(result) -> str:
    facts = ", ".join(f"{key}: {value}" for key, value in result["machine"].items())
    loads = {k: v for k, v in result["other_load"].items() if v is not None}
    worst = max(loads.values(), default=0.0)
    told = f"Other work took at most {100 * worst:.0f} % of the processors."
    if worst > BEARABLE_LOAD:
        told += " Speeds are too low by about as much."
    return f"*{facts}. {told}*\n"
