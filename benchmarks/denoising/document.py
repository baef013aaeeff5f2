"""The document of the benchmark of denoised pictures, and its picture."""

from pathlib import Path

import numpy as np

from ...engine.analysis.false_colour import encode_display
from ..common.bars import Bar
from ..common.chart import Picture
from ..common.document import make_table, tell_demands

HEAD = 24
"""Height of the line above a row of pictures. [pixel]"""

GAP = 6
"""Between pictures. [pixel]"""

LARGEST_SHIFT = 0.01
"""By which the mean of a block may change."""

TEXT = """# Denoised pictures

*Made by `lumenray benchmark denoising`; do not edit by hand.*

The bundled office, {width} x {height} pixels, at few samples a pixel: as computed, denoised by Open Image Denoise with kept
means ([theory](../theory.md#105-denoising)), and by Cycles with its denoiser (the same library, with its guides; no
clamping, light tree, {bounces} bounces) in equal processor time. Lamps and sky of Cycles are Blender's own, so each program
is held against its own long picture of {ours} and {theirs} samples, whose noise is taken out of the errors, and exposed
alike.

![Each row: as computed, denoised, Cycles denoised](denoising.png)

*Error*: root mean square over the pixels of the error of the luminance over the larger of the pixel's own and the
logarithmic mean, by which pictures are exposed (the mean itself is that of the windows, which are brighter beside the room
in Cycles), with its standard error, which is that of the long pictures' noise. *Shift*: largest change of the mean
luminance of a block of 32 by 32 pixels by denoising; *network*: what the network alone makes. Times are those of all
processors together, without the building of kernels; {cpu}, {cores} cores.

"""


BEFORE = """
## The filter that was here before

An edge-avoiding wavelet filter guided by the picture's own error, measured before it was removed (480 x 300 pixels, against
128 samples, those of the pictures among them, whose noise is taken out; errors over the larger of own and mean
luminance):

| samples | raw | wavelet filter | Open Image Denoise | shift, wavelet filter | shift, network |
|--:|--:|--:|--:|--:|--:|
| 8 | 21 % | 10 % | 3.6 % | 18 % | 3.7 % |
| 32 | 7.7 % | 7.9 % | 2 % | 14 % | 1.8 % |

![The wavelet filter and Open Image Denoise at 8 samples](denoising_wavelet.png)

Exitance of a small room, 24 lumels per metre, against 512 samples, by maps of 8 and 32 samples (full paths): raw 17 % and
8 %, wavelet filter 4.3 % and 2.9 %, Open Image Denoise with kept means of charts 3.2 % and 1.8 %.
"""


def write_pictures(result: dict, path: Path) -> None:
    """Write all pictures side by side."""
    width, height = result["size"]
    columns = ("raw", "denoised", "Cycles")
    rows = result["rows"]
    size = (
        len(columns) * (width + GAP) + GAP,
        len(rows) * (height + HEAD) + height + HEAD + GAP,
    )
    sheet = Picture(size)
    shown = [
        (_words(row, column), result["pictures"][f"{row['samples']} {column}"], x, y)
        for y, row in enumerate(rows)
        for x, column in enumerate(columns)
    ]
    last = len(rows)
    for x, (name, words) in enumerate(
        {"reference": "Lumenray, long", "Cycles reference": "Cycles, long"}.items()
    ):
        shown.append((words, result["pictures"][name], 1 + x, last))
    for words, colour, x, y in shown:
        left, top = GAP + x * (width + GAP), y * (height + HEAD)
        sheet.write(left, top + HEAD / 2, words, "lm")
        sheet.paste(encode_display(colour), left, top + HEAD)
    sheet.save(path)


def write_document(result: dict, path: Path) -> None:
    """Write the document beside its picture."""
    text = TEXT.format(
        width=result["size"][0],
        height=result["size"][1],
        bounces=result["bounces"],
        ours=result["reference"]["Lumenray"],
        theirs=result["reference"]["Cycles"],
        cpu=result["machine"]["cpu"],
        cores=result["machine"]["cores"],
    )
    lines = []
    for row in result["rows"]:
        cycles = row["cycles"]
        lines.append(
            f"| {row['samples']} | {_share(row['raw_error'])} | {_share(row['network_error'])} | {_told(row)} "
            f"| {_share(row['network_shift'])} | {_share(row['shift'])} | {row['seconds']:.1f} "
            f"| {row['denoising_seconds']:.1f} | {cycles['samples']} | {_share(cycles['raw_error'])} "
            f"| {_told(cycles)} | {_share(cycles['shift'])} | {cycles['seconds']:.1f} |"
        )
    head = (
        "| samples | raw | network | denoised | shift, network | shift | all [s] | of it denoising [s] "
        "| Cycles: samples | raw | denoised | shift | all [s] |"
    )
    text += make_table(head, lines, 0) + "\n" + tell_demands(check_bars(result))
    path.write_text(text + BEFORE, encoding="utf-8")


def check_bars(result: dict) -> list[Bar]:
    """Hold the numbers against what is asked for."""
    rows = result["rows"]
    worst = max(row["shift"] for row in rows)
    gains = [row["raw_error"] / max(row["error"], 1e-9) for row in rows]
    beside = [row["cycles"]["error"] / max(row["error"], 1e-9) for row in rows]
    # Within twice the doubt of both they are alike.
    is_alike = all(
        row["cycles"]["error"] + 2.0 * (row["cycles"]["doubt"] + row["doubt"]) >= row["error"]
        for row in rows
    )
    return [
        Bar(
            "means of blocks are kept",
            f"{_share(LARGEST_SHIFT)}",
            _share(worst),
            worst <= LARGEST_SHIFT,
        ),
        Bar(
            "denoising takes error out, at all numbers of samples",
            "factor 1",
            f"factor {min(gains):.1f}",
            min(gains) > 1.0,
        ),
        Bar(
            "not farther off than Cycles with its denoiser, but for doubt",
            "factor 1",
            f"factor {min(beside):.1f}",
            is_alike,
        ),
    ]


def _share(value: float) -> str:
    return f"{100.0 * value:.2g} %" if np.isfinite(value) else "–"


def _told(row: dict) -> str:
    return f"{_share(row['error'])} ± {_share(row['doubt'])}"


def _words(row: dict, column: str) -> str:
    cycles = row["cycles"]
    return {
        "raw": f"{row['samples']} samples, {_share(row['raw_error'])}",
        "denoised": f"denoised, {_told(row)}, {row['seconds']:.0f} s",
        "Cycles": f"Cycles, {cycles['samples']} samples, {_told(cycles)}, {cycles['seconds']:.0f} s",
    }[column]
