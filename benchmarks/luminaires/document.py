"""The document of the benchmark of luminaires, made of its numbers."""

from pathlib import Path

import numpy as np

from ..common.document import BEARABLE_LOAD, make_table, tell_demands
from . import agreement, speed, variance
from .bars import check_bars

TITLE = """# Luminaires: agreement with Radiance, speed, noise

*Made by `lumenray benchmark luminaires`; do not edit by hand.*

All of it was measured in one run; `lumenray benchmark luminaires --json out/luminaires.json` repeats it, and
`--files FOLDER` compares the photometric files of a folder instead of the library's own.
"""

AGREEMENT = """## Direct illuminance, compared with Radiance

Photometric files of {source}, read by our readers and computed by our engine on the one side, converted and computed
by Radiance on the other (`ies2rad`, `oconv` and `rtrace -I` of pyradiance {version}; 179 lm/W, Radiance's own factor;
a white lamp). EULUMDAT files go to Radiance as LM-63, written by our writer. The luminaire is a point on both sides:
Radiance gets a sphere of 1 mm, its least. It hangs {height:g} m over the floor and under the ceiling, turned by
{turn:.0f}° about its vertical and tilted by {tilt:.0f}°, so that mistaken axes show. {points} points: {rows} x {rows}
on the floor, or on the ceiling for light that mostly goes up, over the width of the beam, and {rows} x {rows} on a
wall. Points that get less than {dark:.0f} % of the largest illuminance in both programs are left out, and so is what
lies beyond the angles of a file's table: there Radiance extrapolates for one step and tapers off, while the standards
define nothing and we have darkness.

![Deviations of all points](luminaires_agreement.png)

{told}
"""

AGREEMENT_TABLE = (
    "| file | format | type, symmetry | planes x angles | points | largest % | rms % | within "
    f"{100 * agreement.BOUND:g} % | why | reason taken away: largest % |"
)

OPENINGS = """## Luminous openings, compared with Radiance

The same files with the opening that they state, at only {distance:g} diagonals of it, where a point would be off by
what the last column says. Every part of an opening gives its share of the intensity, in our engine and in Radiance
(`rtrace -ds {ds:g}`). The arbiter between the two is a plain sum over some {parts} small parts of each face in double
precision, which shares nothing with the sampling of either; with very narrow beams, and where a table ends with a
step, its own error shows, up to about 1 %. Radiance differs from it for reasons of its own: it cuts a flat source into
at most 64 parts, which is little for a narrow beam nearby; it samples a disk as a square that is squeezed to a circle,
and a sphere at its middle only; the rays to the axis of a cylinder are stopped by its end caps, so that short cylinders
lose light; and its angles of type B are others, as said above. A dash: Radiance builds another body, for instance a box
for a lying cylinder, only the lower face of a body that shines downwards, or a box for an ellipsoid.
"""

OPENINGS_TABLE = (
    "| file | opening | mm | ours: largest % | rms % | our standard error, largest % | Radiance: largest % | rms % | "
    "a point: largest % |"
)

SPEED = """## Speed of looking up

Directions to intensities, bilinear, by irregular tables of angles. *Vectorised* is the function that the engine's
kernels call, on {device}: directions are read from memory, values are written back. The others are scalar: {scalar}.
Each is the best of {rounds} timings. The kernel for one lane is the hardest of these opponents: it is the same code,
compiled by the same LLVM for the same processor, only without vectors and threads, so what remains is what vectors
and threads alone are worth; {bound}. Largest deviation from the double precision reference: {deviation:.1e} of the
peak.

![Directions looked up per second](luminaires_speed.png)
"""

NOISE = """## Noise of a next event

The mean illuminance of a square patch of floor, {height:g} m below the luminaires, is estimated from random
receivers, each by one next event: a luminaire is chosen, then a point of its opening. The ideal has the exact
illuminance at every receiver, so that only the receivers' own variance is left; it is the covariance of two
independent next events at the same receiver. The table has the variance of one next event over that of the ideal.
Beams are Gaussian and as wide as stated between half values; the spikes are 24 such lobes of 1.5° in random
directions. Single precision, photometric transport, no obstacles.
"""


def write_document(result: dict, path: Path) -> None:
    """Write the document of results of `luminaires.run`."""
    parts = [
        TITLE,
        _machine(result),
        _other_load(result["other_load"]),
        tell_demands(check_bars(result)),
        _agreement(result),
        _openings(result["agreement"]["openings"]),
        _speed(result["speed"]),
        _noise(result["noise"]),
    ]
    path.write_text("\n".join(part for part in parts if part), encoding="utf-8")


def _machine(result: dict) -> str:
    machine = result["machine"]
    return (
        f"## Machine\n\n{machine['cpu']}, {machine['cores']} cores, {machine['memory_gib']} GiB, {machine['system']}; "
        f"Python {machine['python']}, Mitsuba {machine['mitsuba']}, pyradiance {result['agreement']['pyradiance']}, "
        f"Lumenray {machine['lumenray']}.\n"
    )


def _other_load(load: dict) -> str:
    share = load.get("speed")
    if share is None or share <= BEARABLE_LOAD:
        return ""
    return f"**Speeds are not to be relied on: other processes took {100 * share:.0f} % of the processors meanwhile.**\n"


# ---- agreement ----


def _agreement(result: dict) -> str:
    made = result["agreement"]
    files = made["files"]
    told = _reasons(files)
    if made["refused"]:
        lines = "\n".join(f"- `{row['file']}`: {row['message']}" for row in made["refused"])
        told += f"\n\nNot compared:\n\n{lines}"
    text = AGREEMENT.format(
        source=result["source"],
        version=made["pyradiance"],
        height=agreement.HEIGHT,
        turn=np.rad2deg(agreement.TURN),
        tilt=np.rad2deg(agreement.TILT),
        rows=agreement.ROWS,
        points=2 * agreement.ROWS**2,
        dark=100 * agreement.DARK,
        told=told,
    )
    rows = []
    for row in files:
        cured = _percent(row["without_reason"]) if row["reason"] else ""
        words = [
            f"`{row['file']}`",
            row["format"],
            f"{row['type']}, {row['symmetry']}" + (", TILT" if row["has_tilt"] else ""),
            "{} x {}".format(*row["grid"]),
            str(row["points"]),
            _percent(row["max"]),
            _percent(row["rms"]),
            f"{100 * row['share']:.1f} %",
            row["reason"],
            cured,
        ]
        rows.append("| " + " | ".join(words) + " |")
    return text + "\n" + make_table(AGREEMENT_TABLE, rows, 3)


def _reasons(files: list[dict]) -> str:
    """Say which files differ and why."""
    alike = [row for row in files if not row["reason"]]
    worst = max((row["max"] for row in alike), default=0.0)
    beyond = sum(row["beyond"] for row in files)
    lines = [
        f"{len(alike)} of {len(files)} files agree within {100 * agreement.BOUND:g} % at every point, the worst of them to "
        f"{_percent(worst)} %; what is left is single precision and the six digits of Radiance's files. {beyond} points of "
        "all files lie beyond the tables and are bright in Radiance only."
    ]
    present = [
        reason for reason in agreement.REASONS if any(row["reason"] == reason for row in files)
    ]
    if present:
        lines.append(
            "\nWhere Radiance differs. The last column has the largest deviation once the reason is taken away: with the "
            "file as our writer writes it (planes all around, poles made one), of type B our table at Radiance's angles.\n"
        )
    for reason in present:
        names = ", ".join(f"`{Path(row['file']).name}`" for row in files if row["reason"] == reason)
        lines.append(f"- *{reason}*: {agreement.REASONS[reason]}. Files: {names}.")
    return "\n".join(lines)


def _percent(share: float) -> str:
    return f"{100 * share:.3g}"


def _openings(rows: list[dict]) -> str:
    if not rows:
        return ""
    text = OPENINGS.format(
        distance=agreement.OPENING_DISTANCE, ds=agreement.SUBDIVISION, parts=agreement.PARTS
    )
    lines = []
    for row in rows:
        theirs = row["theirs"]
        words = [
            f"`{Path(row['file']).name}`",
            row["shape"],
            " x ".join(f"{1e3 * size:g}" for size in row["size"]),
            _percent(row["ours"]["max"]),
            _percent(row["ours"]["rms"]),
            _percent(row["error"]),
            _percent(theirs["max"]) if theirs else "-",
            _percent(theirs["rms"]) if theirs else "-",
            _percent(row["point"]),
        ]
        lines.append("| " + " | ".join(words) + " |")
    return text + "\n" + make_table(OPENINGS_TABLE, lines, 3)


# ---- speed and noise ----


def _speed(rows: list[dict]) -> str:
    first = rows[0]
    device = "the graphics card"
    bound = "on a graphics card there is no such kernel"
    if first["device"] == "CPU":
        lanes = f"{first['lanes']} lanes and " if first["lanes"] else ""
        device = f"{lanes}{first['threads']} threads"
        bound = f"with {device} that is at most {(first['lanes'] or 1) * first['threads']} times"
        gains = [
            row["rates"]["one thread"] / row["rates"]["one lane"]
            for row in rows
            if row["rates"]["one lane"]
        ]
        if gains:
            bound += f", and vectors alone gave {min(gains):.1f} to {max(gains):.1f} times"
    scalar = ", ".join(
        f"*{way}* ({what})"
        for way, what in speed.WAYS.items()
        if way not in {"vectorised", "one thread"}
    )
    text = SPEED.format(
        device=device,
        scalar=scalar,
        rounds=speed.ROUNDS,
        bound=bound,
        deviation=max(row["deviation"] for row in rows),
    )
    head = "| table | values | " + " | ".join(f"{way}, M/s" for way in speed.WAYS)
    head += " | " + " | ".join(f"over {way}" for way in list(speed.WAYS)[1:]) + " |"
    lines = []
    for row in rows:
        rates = row["rates"]
        words = [row["title"], "{} x {}".format(*row["grid"])]
        words += [f"{rate / 1e6:.3g}" if rate else "-" for rate in rates.values()]
        for way in list(speed.WAYS)[1:]:
            rate = rates[way]
            words.append(f"x {speed.times(rates['vectorised'] / rate)}" if rate else "-")
        lines.append("| " + " | ".join(words) + " |")
    return text + "\n" + make_table(head, lines, 2)


def _noise(rows: list[dict]) -> str:
    head = "| luminaires | opening | patch | side m | variance over ideal | ± | ideal: variance over squared mean |"
    lines = [
        f"| {row['title']} | {row['opening']} | {row['patch']} | {row['side']:.2f} | {row['ratio']:.3f} | "
        f"{row['error']:.3f} | {row['ideal']:.3g} |"
        for row in rows
    ]
    over = [row for row in rows if row["ratio"] > variance.BOUND + 2.0 * row["error"]]
    end = f"All within {variance.BOUND:g} of the ideal.\n"
    if over:
        end = f"{len(over)} of {len(rows)} are more than {variance.BOUND:g} times the ideal: "
        end += (
            "; ".join(f"{row['title']}, {row['opening']}, {row['patch']}" for row in over) + ".\n"
        )
    return NOISE.format(height=variance.HEIGHT) + "\n" + make_table(head, lines, 3) + "\n" + end
