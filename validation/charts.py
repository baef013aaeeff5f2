"""Plots of a run: errors of a case's values, shares of values by error, and published results."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image

from .bench import Finding
from .canvas import INK, RULE, SOFT, Canvas
from .published import Result
from .verdict import BANDS, Verdict, is_nought

OURS, BAD, BAND, GREY = "#1f5fa8", "#c8102e", "#e3eef8", "#9a9a9a"
"""Colours of values inside their tolerance, outside, of the tolerance itself, and of informative values."""

SERIES = ("#1f5fa8", "#7fb0dd", "#a8a8a8", "#d08a2e", "#5a9a5a", "#8a6ab0")
"""Colours of programs beside each other."""

ERROR_SIZE = (900, 296)
"""Of a case's plot. [pixel]"""

EVEN_RATIO = 8.0
"""Tolerances in a case that differ by more than this factor get an axis that is logarithmic away from 0."""

LINEAR_PART = 0.01
"""Where such an axis turns from linear to logarithmic. [%]"""


def family_of(key: str) -> str:
    """Name of the groups that differ in the sky type only: ``C12.1x1.sky3`` belongs to ``C12.1x1.sky*``."""
    return re.sub(r"(\.sky|\.lum)\d+$", r"\1*", key)


def draw_errors(rows: Sequence[tuple[Finding, Verdict]]) -> Image.Image:
    """Relative error of every value of a case, its tolerance shaded, its standard error as a bar.

    A reference that is nought has no relative error: the difference is drawn in parts of its tolerance, as a ring.
    """
    families: dict[str, list[tuple[Finding, Verdict]]] = {}
    for finding, verdict in rows:
        families.setdefault(family_of(finding.group.id), []).append((finding, verdict))
    return _ErrorPlot(families).draw()


@dataclass
class _Points:
    """Values of a family in percent: errors, standard errors, tolerances; and what they are."""

    error: np.ndarray
    spread: np.ndarray
    allowed: np.ndarray
    inside: np.ndarray
    is_zero: np.ndarray
    is_scored: bool

    @classmethod
    def gather(cls, members: Sequence[tuple[Finding, Verdict]]) -> "_Points":
        """Join the values of groups; those of many skies point by point, so that a point's skies stand together."""

        def join(parts):
            parts = [np.asarray(part) for part in parts]
            even = len({part.size for part in parts}) == 1
            return np.stack(parts, axis=1).ravel() if even else np.concatenate(parts)

        reference = join([f.group.values for f, _ in members])
        values = join([f.values for f, _ in members])
        errors = join([f.errors for f, _ in members])
        allowed = join([f.group.allowed for f, _ in members])
        is_zero = join([is_nought(f.group) for f, _ in members])
        share = allowed / np.where(is_zero, 1.0, np.abs(reference))
        typical = float(np.median(share[~is_zero])) if (~is_zero).any() else 0.01
        # Nought is drawn by the part of the tolerance that it takes, at the scale of the others.
        size = np.where(is_zero, np.maximum(allowed, 1e-300) / typical, np.abs(reference))
        return cls(
            error=100.0 * (values - reference) / size,
            spread=100.0 * errors / size,
            allowed=100.0 * np.where(is_zero, typical, share),
            inside=join([v.inside for _, v in members]),
            is_zero=is_zero,
            is_scored=all(v.is_scored for _, v in members),
        )


class _ErrorPlot:
    """Axes and what is drawn in them."""

    def __init__(self, families: dict[str, list[tuple[Finding, Verdict]]]):
        self.canvas = Canvas(ERROR_SIZE)
        self.names = [name.partition(".")[2] for name in families]
        self.points = [_Points.gather(members) for members in families.values()]
        self.left, self.right, self.top, self.bottom = 64.0, ERROR_SIZE[0] - 16.0, 34.0, 250.0
        allowed = np.concatenate([points.allowed for points in self.points])
        scored = np.concatenate([p.allowed for p in self.points if p.is_scored] or [allowed])
        self.is_bent = scored.max() > EVEN_RATIO * max(scored.min(), 1e-12)
        shown = np.concatenate(
            [np.abs(p.error) + p.spread for p in self.points if p.is_scored] or [scored]
        )
        largest = np.max(shown[np.isfinite(shown)], initial=0.0)
        # Errors far beyond the tolerance are told at the rim.
        self.limit = float(min(max(1.2 * scored.max(), 1.1 * largest), 6.0 * scored.max()))
        self.spans = self._share_width()

    def draw(self) -> Image.Image:
        self._draw_axes()
        for points, span, name in zip(self.points, self.spans, self.names, strict=True):
            self._draw_family(points, span, name)
        self.canvas.line([(self.left, self.y(0.0)), (self.right, self.y(0.0))], SOFT, 0.75)
        self.canvas.box((self.left, self.top), (self.right, self.bottom), None, "#999999")
        return self.canvas.finish()

    def y(self, percent: float) -> float:
        """Height at which an error is drawn. [pixel]"""
        middle, half = 0.5 * (self.top + self.bottom), 0.5 * (self.bottom - self.top)
        if not np.isfinite(percent):
            percent = self.limit
        share = self._bend(percent) / self._bend(self.limit)
        return middle - half * float(np.clip(share, -1.0, 1.0))

    def _bend(self, percent: float) -> float:
        return float(np.arcsinh(percent / LINEAR_PART)) if self.is_bent else percent

    def _share_width(self) -> list[tuple[float, float]]:
        """Ends of each family along x: room for its name, and what is left by the number of values."""
        counts = np.array([p.error.size for p in self.points], dtype=np.float64)
        wide = np.array([self.canvas.measure(name, 11) + 10.0 for name in self.names])
        room = self.right - self.left
        if wide.sum() > 0.9 * room:
            wide *= 0.5 * room / wide.sum()
        widths = wide + (room - wide.sum()) * counts / counts.sum()
        ends = self.left + np.concatenate([[0.0], np.cumsum(widths)])
        return list(zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True))

    def _draw_axes(self) -> None:
        write = self.canvas.write
        write((self.left - 4, 14), "relative error [%]", 12, "lm", SOFT)
        x = self.right
        for text, mark in (
            ("outside", "bad"),
            ("inside tolerance", "good"),
            ("tolerance", "band"),
            ("bar: one standard error either way", ""),
        ):
            width = self.canvas.measure(text, 11)
            write((x - width, 14), text, 11, "lm", SOFT)
            x -= width + 9
            if mark == "band":
                self.canvas.box((x - 10, 9), (x + 2, 19), BAND, "#b8cfe6")
            elif mark:
                self.canvas.dot((x - 2, 14), BAD if mark == "bad" else OURS, 3.0)
            x -= 24
        for tick in self._ticks():
            y = self.y(tick)
            self.canvas.line([(self.left, y), (self.right, y)], RULE, 0.75)
            write((self.left - 6, y), f"{tick:+g}" if tick else "0", 11, "rm", SOFT)

    def _ticks(self) -> list[float]:
        if self.is_bent:
            powers = [10.0**k for k in range(-2, 4) if 10.0**k <= self.limit]
            return [-power for power in powers[::-1]] + [0.0, *powers]
        step = 10.0 ** np.floor(np.log10(self.limit))
        step = next(s for s in (0.5 * step, step, 2 * step, 5 * step) if self.limit / s <= 4.0)
        count = int(self.limit / step)
        return [round(k * step, 10) for k in range(-count, count + 1)]

    def _draw_family(self, points: _Points, span: tuple[float, float], name: str) -> None:
        left, right = span
        count = points.error.size
        step = (right - left) / count
        centres = left + step * (np.arange(count) + 0.5)
        for x, allowed in zip(centres, points.allowed, strict=True):
            low, high = (x - 0.5 * step, self.y(allowed)), (x + 0.5 * step, self.y(-allowed))
            self.canvas.box(low, high, BAND)
        for tick in self._ticks():
            self.canvas.line([(left, self.y(tick)), (right, self.y(tick))], RULE, 0.5)
        self.canvas.line([(right, self.top), (right, self.bottom)], "#bbbbbb", 0.75)
        radius = 2.6 if step >= 6.0 else 1.5
        for k, x in enumerate(centres):
            colour = OURS if points.inside[k] else BAD
            colour = colour if points.is_scored else GREY
            error, spread = points.error[k], points.spread[k]
            if spread > 0.0:
                self.canvas.line(
                    [(x, self.y(error - spread)), (x, self.y(error + spread))], colour, 0.75
                )
            self._mark(x, error, colour, radius, bool(points.is_zero[k]))
        room = right - left - 4
        size = next((s for s in (11, 10, 9) if self.canvas.measure(name, s) <= room), None)
        if size is not None:
            self.canvas.write((0.5 * (left + right), self.bottom + 14), name, size, "mm", INK)
        else:
            # Names without room hang below in a second and a third row.
            row = 1 + self.names.index(name) % 2
            self.canvas.write(
                (0.5 * (left + right), self.bottom + 14 + 14 * row), name, 9, "mm", INK
            )

    def _mark(self, x: float, error: float, colour: str, radius: float, is_zero: bool) -> None:
        y = self.y(error)
        if not abs(error) <= self.limit:
            way = -1.0 if error < 0.0 else 1.0
            self.canvas.shape([(x - 4, y + 6 * way), (x + 4, y + 6 * way), (x, y)], colour)
        elif is_zero:
            self.canvas.dot((x, y), "white", radius + 0.6, colour)
        else:
            self.canvas.dot((x, y), colour, radius)


def draw_bands(series: dict[str, dict[int, float]]) -> Image.Image:
    """Share of the values below each error, one bar per program.

    Parameters
    ----------
    series : dict    From names to shares by band, 0 to 1.
    """
    canvas = Canvas((900, 330 + 20 * ((len(series) - 1) // 2)))
    left, right, top, bottom = 56.0, 884.0, 24.0, 270.0
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        y = bottom - share * (bottom - top)
        canvas.line([(left, y), (right, y)], RULE, 0.75)
        canvas.write((left - 6, y), f"{100 * share:.0f} %", 11, "rm", SOFT)
    group = (right - left) / len(BANDS)
    width = min(0.82 * group / max(len(series), 1), 44.0)
    for i, band in enumerate(BANDS):
        middle = left + (i + 0.5) * group
        for k, (colour, shares) in enumerate(zip(_colours(series), series.values(), strict=True)):
            x = middle + (k - 0.5 * len(series)) * width
            y = bottom - shares[band] * (bottom - top)
            canvas.box((x + 1, y), (x + width - 1, bottom), colour)
            # Cut and not rounded: 100 means all.
            text = f"{np.floor(shares[band] * 1e4 + 1e-7) / 100.0:.4g}"
            canvas.write((x + 0.5 * width, y - 7), text, 10, "mm", INK)
        canvas.write((middle, bottom + 14), f"less than {band} % off", 12, "mm", INK)
    for k, (colour, name) in enumerate(zip(_colours(series), series, strict=True)):
        x, y = left + 414.0 * (k % 2), bottom + 40 + 20 * (k // 2)
        canvas.box((x, y - 5), (x + 14, y + 5), colour)
        canvas.write((x + 20, y), name, 12, "lm", INK)
    return canvas.finish()


def draw_published(ours: dict[str, float], results: Sequence[Result]) -> Image.Image:
    """Largest relative error on each CIE test: ours as a bar's end, published programs' as dots.

    Parameters
    ----------
    ours : dict of float    By section of the CIE report, in the order to draw. [-]
    results : sequence of Result
    """
    tests = list(ours)
    shown = [r for r in results if r.test in ours and r.largest is not None]
    programs = list(dict.fromkeys(result.program for result in shown))
    canvas = Canvas((900, 86 + 26 * len(tests)))
    left, right, top = 60.0, 884.0, 20.0
    bottom = top + 26.0 * len(tests)

    def place(share: float) -> float:
        percent = min(max(100.0 * share, 0.001), 100.0)
        return left + (np.log10(percent) + 3.0) / 5.0 * (right - left)

    for percent in (0.001, 0.01, 0.1, 1.0, 10.0, 100.0):
        x = place(percent / 100.0)
        canvas.line([(x, top), (x, bottom)], RULE, 0.75)
        text = "0.001 % or less" if percent == 0.001 else f"{percent:g} %"
        canvas.write(
            (x, bottom + 12), text, 11, {0.001: "lm", 100.0: "rm"}.get(percent, "mm"), SOFT
        )
    colours = dict(zip(programs, (*SERIES[2:], "#b04a7a", "#3a9a9a"), strict=False))
    for row, test in enumerate(tests):
        y = top + 26.0 * (row + 0.5)
        canvas.write((left - 8, y), test, 12, "rm", INK)
        canvas.box((left, y - 4), (place(ours[test]), y + 4), OURS)
        for result in shown:
            if result.test == test:
                canvas.dot((place(result.largest), y), colours[result.program], 5.7, "#ffffff")
    x = left
    for name, colour in {"Lumenray, this run": OURS, **colours}.items():
        canvas.dot((x + 5, bottom + 40), colour, 5.0)
        canvas.write((x + 15, bottom + 40), name, 12, "lm", INK)
        x += canvas.measure(name, 12) + 36
    return canvas.finish()


def _colours(series) -> tuple[str, ...]:
    return tuple(SERIES[i % len(SERIES)] for i in range(len(series)))
