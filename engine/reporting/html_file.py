"""A document as one HTML file that needs nothing beside it: no scripts, no fonts, no addresses."""

import base64
import io
import re
from html import escape
from pathlib import Path

from PIL import Image

from ..analysis.sheet import Sheet
from ..judgement.verdict import State
from ..reading.printable import printable
from ..reading.whole_file import write_whole
from .blocks import Beside, Cell, Document, Facts, Figure, Heading, Points, Table, Text

CLASSES = {
    State.MET: "met",
    State.NOT_MET: "missed",
    State.UNDECIDED: "open",
    State.UNKNOWN: "unknown",
}
"""How verdicts look."""

STYLE = """
@page { size: A4; margin: 18mm 16mm; }
* { box-sizing: border-box; }
body { font: 15px/1.5 "Segoe UI", "Helvetica Neue", Helvetica, Arial, sans-serif; color: #20252c; background: #eef0f3;
  margin: 0; }
main { max-width: 960px; margin: 0 auto; background: #fff; padding: 40px 56px 56px; }
header { border-top: 6px solid #1d4f78; padding-top: 20px; margin-bottom: 28px; }
header .kind { color: #66707c; letter-spacing: .08em; text-transform: uppercase; font-size: 12px; margin: 0; }
h1 { font-size: 30px; line-height: 1.2; font-weight: 600; margin: 4px 0 18px; }
h2 { font-size: 23px; font-weight: 600; border-bottom: 1px solid #b4bbc4; padding-bottom: 6px; margin: 48px 0 14px; }
h3 { font-size: 17px; font-weight: 600; margin: 30px 0 8px; }
h4 { font-size: 14px; font-weight: 600; margin: 18px 0 6px; }
h1, h2, h3, h4, td, dd, li, p { overflow-wrap: anywhere; }
p { margin: 6px 0; } .note { color: #66707c; font-size: 13px; }
nav { columns: 2; font-size: 14px; margin: 0 0 24px; } nav a { color: #1d4f78; text-decoration: none; display: block; }
nav a.below { padding-left: 16px; color: #66707c; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 3px 20px; margin: 8px 0 14px; }
dt { color: #66707c; } dd { margin: 0; font-variant-numeric: tabular-nums; }
table { border-collapse: collapse; width: 100%; margin: 8px 0 14px; font-variant-numeric: tabular-nums; font-size: 14px; }
th { text-align: left; font-weight: 600; border-bottom: 1.5px solid #20252c; padding: 5px 16px 5px 0;
  vertical-align: bottom; }
td { border-bottom: 1px solid #dfe3e8; padding: 5px 16px 5px 0; vertical-align: top; }
th.number, td.number { text-align: right; } table.small { font-size: 11.5px; width: auto; }
table.small th, table.small td { padding: 2px 8px 2px 0; white-space: nowrap; }
thead { display: table-header-group; } tr { break-inside: avoid; }
.state { font-weight: 600; } .met { color: #1a6e3c; } .missed { color: #b3261e; } .open { color: #8a5a00; }
.unknown { color: #66707c; }
.state::before { display: inline-block; width: 1.2em; }
.met::before { content: "\\2713"; } .missed::before { content: "\\2717"; }
.open::before { content: "?"; } .unknown::before { content: "\\2013"; }
figure { margin: 14px 0; break-inside: avoid; } figure svg, figure img { display: block; max-width: 100%; height: auto; }
figcaption { color: #66707c; font-size: 13px; margin-top: 4px; }
.beside { display: flex; gap: 28px; align-items: flex-start; break-inside: avoid; } .beside > div { min-width: 0; }
footer { color: #66707c; font-size: 12px; border-top: 1px solid #dfe3e8; margin-top: 40px; padding-top: 10px; }
@media print { body { background: #fff; font-size: 10pt; } main { max-width: none; padding: 0; } nav { display: none; }
  h2.chapter { break-before: page; margin-top: 0; } h2, h3, h4 { break-after: avoid; } }
@media (max-width: 640px) { main { padding: 20px; } .beside { display: block; } .beside > div { width: auto !important; } }
"""

POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
"""What a browser may load: nothing."""


def write_html(path, document: Document) -> Path:
    """Write a document.

    Raises
    ------
    FileFormatError    The file cannot be written.
    """
    with write_whole(path, "utf-8") as file:
        file.write(to_html(document))
    return Path(path)


def to_html(document: Document) -> str:
    """Return a document as the text of an HTML file."""
    body = "\n".join(_WRITERS[type(block)](block) for block in _numbered(document.blocks))
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{POLICY}">
<meta name="generator" content="Lumenray">
<title>{_text(document.title)}</title>
<style>{STYLE}</style>
</head>
<body>
<main>
<header>
<p class="kind">{_text(document.kind)}</p>
<h1>{_text(document.title)}</h1>
{_write_facts(Facts(document.facts))}
</header>
{_write_contents(document.blocks)}
{body}
<footer>{_text(document.footer)}</footer>
</main>
</body>
</html>
"""


def _text(text: str) -> str:
    """A text with nothing in it that a browser would take for more than letters."""
    return escape(printable(text), quote=True)


class _Numbered:
    """A heading with the number that links find it by."""

    def __init__(self, heading: Heading, number: int):
        self.heading, self.number = heading, number


def _numbered(blocks):
    number = 0
    for block in blocks:
        if isinstance(block, Heading):
            number += 1
            yield _Numbered(block, number)
        else:
            yield block


def _write_contents(blocks) -> str:
    links = [
        f'<a{"" if each.heading.level == 1 else " class=below"} href="#part{each.number}">{_text(each.heading.text)}</a>'
        for each in _numbered(blocks)
        if isinstance(each, _Numbered) and each.heading.level < 3
    ]
    return f"<nav>{''.join(links)}</nav>"


def _write_heading(each: _Numbered) -> str:
    level = each.heading.level + 1
    kind = ' class="chapter"' if each.heading.level == 1 else ""
    return f'<h{level} id="part{each.number}"{kind}>{_text(each.heading.text)}</h{level}>'


def _write_text(block: Text) -> str:
    return f"<p{' class=note' if block.is_note else ''}>{_text(block.text)}</p>"


def _write_points(block: Points) -> str:
    return f"<ul>{''.join(f'<li>{_text(line)}</li>' for line in block.lines)}</ul>"


def _write_facts(block: Facts) -> str:
    lines = (f"<dt>{_text(label)}</dt><dd>{_text(value)}</dd>" for label, value in block.lines)
    return f"<dl>{''.join(lines)}</dl>"


def _write_table(block: Table) -> str:
    kinds = [" class=number" if is_number else "" for is_number in block.numbers]
    columns = "".join(f'<col style="width:{100.0 * share:.4g}%">' for share in block.widths)
    head = "".join(
        f"<th{kind}>{_text(cell)}</th>" for kind, cell in zip(kinds, block.head, strict=True)
    )
    rows = (
        f"<tr>{''.join(_write_cell(cell, kind) for cell, kind in zip(row, kinds, strict=True))}</tr>"
        for row in block.rows
    )
    small = ' class="small"' if block.is_small else ""
    columns = "" if block.is_small else f"<colgroup>{columns}</colgroup>"
    return f"<table{small}>{columns}<thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"


def _write_cell(cell: str | Cell, kind: str) -> str:
    if isinstance(cell, Cell):
        if cell.state is None:
            return f"<td>{_text(cell.text)}</td>"
        words = f'<span class="state {CLASSES[cell.state]}">{_text(cell.text)}</span>'
        return f"<td>{words}</td>"
    return f"<td{kind}>{_text(cell)}</td>"


def _write_figure(block: Figure) -> str:
    width = f' style="width:{100.0 * block.width:g}%"'
    shown = (
        _inline_svg(block.picture)
        if isinstance(block.picture, Sheet)
        else f'<img alt="{_text(block.caption)}" src="{data_address(block.picture)}">'
    )
    return f"<figure{width}>{shown}<figcaption>{_text(block.caption)}</figcaption></figure>"


def _inline_svg(sheet: Sheet) -> str:
    # Inside HTML the name of the language needs not be stated, and nothing looks like an address.
    return re.sub(r' xmlns="[^"]*"', "", sheet.to_svg(), count=1)


def data_address(picture: Image.Image) -> str:
    """A picture as an address that holds all of it."""
    stream = io.BytesIO()
    picture.save(stream, "PNG", optimize=True)
    return f"data:image/png;base64,{base64.b64encode(stream.getvalue()).decode()}"


def _write_beside(block: Beside) -> str:
    sides = zip((block.left, block.right), (block.share, 1.0 - block.share), strict=True)
    made = (
        f'<div style="width:{100.0 * share:g}%">{"".join(_WRITERS[type(b)](b) for b in side)}</div>'
        for side, share in sides
    )
    return f'<div class="beside">{"".join(made)}</div>'


_WRITERS = {
    _Numbered: _write_heading,
    Text: _write_text,
    Points: _write_points,
    Facts: _write_facts,
    Table: _write_table,
    Figure: _write_figure,
    Beside: _write_beside,
}
