"""A picture of all pictures of a library of materials, with their names, by category."""

from pathlib import Path

from ...libraries.materials import by_category

COLUMNS = 8

SIDE, GAP, LINE = 160, 10, 16
"""Of a picture, between pictures, and height of a line of text. [pixel]"""

GROUND, INK, FAINT = (24, 25, 28), (235, 235, 235), (150, 152, 158)
"""Colours in sRGB."""


def write_sheet(path: Path, entries) -> Path:
    """Write a sheet of all entries whose pictures are there."""
    from PIL import Image, ImageDraw, ImageFont

    font = ImageFont.load_default(size=12)
    small = ImageFont.load_default(size=10)
    shown = [(e, group) for group, items in by_category(entries).items() for e in items]
    shown = [(entry, group) for entry, group in shown if entry.thumbnail.is_file()]
    width = COLUMNS * (SIDE + GAP) + GAP
    height = -(-len(shown) // COLUMNS) * (SIDE + 3 * LINE + GAP) + GAP
    sheet = Image.new("RGB", (width, height), GROUND)
    draw = ImageDraw.Draw(sheet)
    for number, (entry, group) in enumerate(shown):
        row, column = divmod(number, COLUMNS)
        x, y = GAP + column * (SIDE + GAP), GAP + row * (SIDE + 3 * LINE + GAP)
        with Image.open(entry.thumbnail) as picture:
            sheet.paste(picture.convert("RGB").resize((SIDE, SIDE)), (x, y))
        lines = _broken(entry.title, lambda text: draw.textlength(text, font=font))
        for line, text in enumerate(lines[:2]):
            draw.text((x, y + SIDE + 2 + line * LINE), text, INK, font)
        draw.text((x, y + SIDE + 2 + len(lines[:2]) * LINE), group, FAINT, small)
    path.parent.mkdir(parents=True, exist_ok=True)
    sheet.save(path, optimize=True)
    return path


def _broken(text: str, length) -> list[str]:
    """Words of a text in lines that fit below a picture."""
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if length(longer) <= SIDE or not lines[-1]:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines
