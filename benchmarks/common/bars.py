"""Demands on what benchmarks measure, and whether they are met."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Bar:
    """One demand and what was measured; ``passed`` None: there is nothing to judge by."""

    demand: str
    limit: str
    measured: str
    passed: bool | None

    @property
    def verdict(self) -> str:
        """One word."""
        return {True: "pass", False: "FAIL", None: "not measured"}[self.passed]


def tell_bars(bars: list[Bar], columns=("demand", "limit", "measured", "verdict")) -> str:
    """Return a table for a terminal."""
    table = [columns, *([getattr(bar, name) for name in columns] for bar in bars)]
    widths = [max(len(row[i]) for row in table) for i in range(len(columns))]
    return "\n".join(
        "  ".join(word.ljust(width) for word, width in zip(row, widths, strict=True)).rstrip()
        for row in table
    )
