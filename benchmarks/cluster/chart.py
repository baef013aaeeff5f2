"""Chart of the benchmark of clusters: efficiency over the number of workers."""

import math
from pathlib import Path

from ..common.chart import INK, Picture

PANEL, LEFT, TOP, GAP, BELOW = (360, 260), 64, 40, 40, 92
"""Size of a panel's axes, and free space about them. [pixel]"""

CURVES = (
    ("sensors", "#1f77b4", "disk"),
    ("lux maps", "#d62728", "square"),
    ("picture", "#2ca02c", "triangle"),
    ("daylight", "#9467bd", "diamond"),
)

GREY = "#dddddd"


def draw_curves(rows: list[dict], path: Path) -> None:
    """Draw a panel for every size of job."""
    sizes = sorted({row["hours"] for row in rows})
    counts = sorted({row["workers"] for row in rows})
    width = LEFT + len(sizes) * (PANEL[0] + GAP)
    sheet = Picture((width, TOP + PANEL[1] + BELOW))
    low, high = math.log(counts[0]), math.log(counts[-1])

    def place(number: int, workers: float, efficiency: float) -> tuple[float, float]:
        share = (math.log(workers) - low) / (high - low)
        left = LEFT + number * (PANEL[0] + GAP)
        return left + share * PANEL[0], TOP + (1.0 - min(efficiency, 1.0)) * PANEL[1]

    for number, hours in enumerate(sizes):
        for tenths in range(0, 11, 2):
            ends = [place(number, count, 0.1 * tenths) for count in (counts[0], counts[-1])]
            sheet.line(ends, GREY)
            if number == 0:
                sheet.write(ends[0][0] - 8, ends[0][1], f"{10 * tenths} %", "rm")
        for count in counts:
            ends = [place(number, count, share) for share in (0.0, 1.0)]
            sheet.line(ends, GREY)
            sheet.write(ends[0][0], ends[0][1] + 14, f"{count}", "mm")
        title = f"job of {hours} hour{'s' if hours > 1 else ''} of one worker"
        sheet.write(place(number, counts[0], 1.0)[0], TOP - 18, title, "lm", INK)
        middle = place(number, math.sqrt(counts[0] * counts[-1]), 0.0)
        sheet.write(middle[0], middle[1] + 36, "workers", "mm")
        for name, colour, shape in CURVES:
            own = [row for row in rows if (row["kind"], row["hours"]) == (name, hours)]
            places = [place(number, row["workers"], row["efficiency"]) for row in own]
            if not places:
                continue
            sheet.line(places, colour, 2)
            for x, y in places:
                sheet.mark(x, y, colour, shape)
    sheet.write_upwards(16, TOP + PANEL[1] / 2, "efficiency")
    entries = [(name, colour, shape) for name, colour, shape in CURVES]
    sheet.legend(LEFT, TOP + PANEL[1] + 70, entries)
    sheet.save(path)
