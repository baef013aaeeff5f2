"""What the documents of benchmarks share: tables in Markdown, and demands with what was measured."""

from .bars import Bar

BEARABLE_LOAD = 0.1
"""Largest share of the processors that others may take while speed is measured."""


def make_table(head: str, rows: list[str], words: int = 1) -> str:
    """Markdown table of lines with their bars; the first ``words`` columns are to the left."""
    columns = head.count("|") - 1
    return "\n".join([head, "|---" * words + "|--:" * (columns - words) + "|", *rows]) + "\n"


def tell_demands(bars: list[Bar]) -> str:
    """Chapter of all demands, and which of them are not met."""
    rows = [f"| {bar.demand} | {bar.limit} | {bar.measured} | {bar.verdict} |" for bar in bars]
    missed = [bar for bar in bars if bar.passed is False]
    end = "Every demand that was measured is met.\n"
    if missed:
        end = "Not met: " + "; ".join(f"{bar.demand}: {bar.measured}" for bar in missed) + ".\n"
    return f"## Demands\n\n{make_table('| demand | limit | measured | verdict |', rows, 4)}\n{end}"
