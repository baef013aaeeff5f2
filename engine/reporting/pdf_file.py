"""A document as a PDF of A4 pages, by reportlab; drawings stay lines and letters."""

import io
import unicodedata
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np
from PIL import Image

from ..analysis.sheet import Area, Line, Raster, Sheet
from ..errors import LumenrayError
from ..judgement.verdict import State
from ..reading.printable import printable
from ..reading.whole_file import write_whole
from .blocks import Beside, Cell, Document, Facts, Figure, Heading, Points, Table, Text

COLOURS = {
    State.MET: "#1a6e3c",
    State.NOT_MET: "#b3261e",
    State.UNDECIDED: "#8a5a00",
    State.UNKNOWN: "#66707c",
}
"""Of verdicts."""

INK, FAINT, RULE, ACCENT = "#20252c", "#66707c", "#b4bbc4", "#1d4f78"

MARGIN, HEAD = 48.0, 54.0
"""Left and right, top and bottom. [pt]"""

TALLEST = 0.82
"""Share of the height of a page that a figure takes at most."""

MISSING = "Letters of some names are replaced here: the fonts have Latin ones alone. The HTML file has them all."


def require_reportlab() -> None:
    """Refuse where PDF files cannot be written.

    Raises
    ------
    LumenrayError    reportlab is not installed.
    """
    try:
        import reportlab  # noqa: F401 - whether it is there
    except ImportError:
        raise LumenrayError(
            "PDF files need the Python package reportlab, which is not installed; 'pip install reportlab', or write HTML"
        ) from None


def write_pdf(path, document: Document) -> Path:
    """Write a document.

    Raises
    ------
    LumenrayError    reportlab is not installed, or the file cannot be written.
    """
    require_reportlab()
    content = _Pages(document).build()
    with write_whole(path) as file:
        file.write(content)
    return Path(path)


def latin(text: str) -> str:
    """A text in the letters that PDF readers have (Windows-1252): others lose their accents or become ?."""
    text = printable(text).replace("\N{REPLACEMENT CHARACTER}", "?")
    return "".join(_latin_letter(letter) for letter in text)


def _latin_letter(letter: str) -> str:
    for form in (letter, unicodedata.normalize("NFKD", letter)):
        plain = "".join(sign for sign in form if not unicodedata.combining(sign))
        try:
            plain.encode("cp1252")
        except UnicodeEncodeError:
            continue
        if plain:
            return plain
    return "?"


class _Pages:
    """The pages under way."""

    def __init__(self, document: Document):
        from reportlab.lib.pagesizes import A4

        self.document, self.size = document, A4
        self.width, self.height = A4[0] - 2.0 * MARGIN, A4[1] - 2.0 * HEAD
        self.has_replaced, self.listed = False, 0
        self.styles = self._make_styles()
        self.writers = {
            Heading: self._heading,
            Text: self._text,
            Points: self._points,
            Facts: self._facts,
            Table: self._table,
            Figure: self._figure,
            Beside: self._beside,
        }

    def build(self) -> bytes:
        """Return the file."""
        from reportlab.platypus import SimpleDocTemplate

        stream = io.BytesIO()
        story = self._cover()
        for block in self.document.blocks:
            story += self.writers[type(block)](block, self.width)
        if self.has_replaced:
            story += self._text(Text(MISSING, is_note=True), self.width)
        template = SimpleDocTemplate(
            stream,
            pagesize=self.size,
            leftMargin=MARGIN,
            rightMargin=MARGIN,
            topMargin=HEAD,
            bottomMargin=HEAD,
            title=self._letters(self.document.title),
            author="Lumenray",
            subject=self.document.kind,
            invariant=1,
        )
        template.build(story, canvasmaker=_numbering_canvas(self._letters(self.document.footer)))
        return stream.getvalue()

    def _letters(self, text: str) -> str:
        made = latin(text)
        self.has_replaced |= "?" in made and made.count("?") > text.count("?")
        return made

    def _markup(self, text: str) -> str:
        return escape(self._letters(text)).replace("\n", "<br/>")

    # ---- styles ----

    def _make_styles(self) -> dict:
        from reportlab.lib.styles import ParagraphStyle

        plain = ParagraphStyle(
            "plain", fontName="Helvetica", fontSize=9.5, leading=13, textColor=INK, spaceAfter=4
        )

        def style(name: str, **settings):
            return ParagraphStyle(name, parent=plain, **settings)

        bold = "Helvetica-Bold"
        return {
            "plain": plain,
            "note": style("note", fontSize=8, leading=10.5, textColor=FAINT),
            "cell": style("cell", fontSize=8.5, leading=11, spaceAfter=0, splitLongWords=1),
            "number": style("number", fontSize=8.5, leading=11, spaceAfter=0, alignment=2),
            "head": style("head", fontName=bold, fontSize=8.5, leading=11, spaceAfter=0),
            "head number": style(
                "head number", fontName=bold, fontSize=8.5, leading=11, spaceAfter=0, alignment=2
            ),
            "label": style("label", fontSize=8.5, leading=11, textColor=FAINT, spaceAfter=0),
            "caption": style(
                "caption", fontSize=8, leading=10.5, textColor=FAINT, spaceBefore=3, spaceAfter=10
            ),
            "kind": style("kind", fontSize=9, textColor=FAINT, spaceAfter=2),
            "title": style(
                "title", fontName=bold, fontSize=22, leading=27, spaceAfter=12, splitLongWords=1
            ),
            1: style("chapter", fontName=bold, fontSize=17, leading=21, spaceAfter=10, keepWithNext=1),
            2: style("section", fontName=bold, fontSize=12.5, leading=16, spaceBefore=14, spaceAfter=5, keepWithNext=1),
            3: style("part", fontName=bold, fontSize=10, leading=13, spaceBefore=8, spaceAfter=3, keepWithNext=1),
        }  # fmt: skip

    # ---- blocks, as flowables ----

    def _cover(self) -> list:
        from reportlab.platypus import HRFlowable, Paragraph

        return [
            HRFlowable(width="100%", thickness=4, color=ACCENT, spaceAfter=12),
            Paragraph(self._markup(self.document.kind.upper()), self.styles["kind"]),
            self._listed(self.document.title, 1, self.styles["title"]),
            *self._facts(Facts(self.document.facts), self.width),
        ]

    def _heading(self, block: Heading, width: float) -> list:
        from reportlab.platypus import PageBreak

        made = self._listed(block.text, block.level, self.styles[block.level])
        return [PageBreak(), made] if block.level == 1 else [made]

    def _listed(self, text: str, level: int, style):
        """Title that readers list beside the pages; parts of sections would be too many."""
        from reportlab.platypus import Paragraph

        kind = Paragraph
        if level < 3:
            self.listed += 1
            kind = _outlined(Paragraph, f"part{self.listed}", self._letters(text), level)
        return kind(self._markup(text), style)

    def _text(self, block: Text, width: float) -> list:
        from reportlab.platypus import Paragraph

        return [
            Paragraph(self._markup(block.text), self.styles["note" if block.is_note else "plain"])
        ]

    def _points(self, block: Points, width: float) -> list:
        from reportlab.platypus import ListFlowable, ListItem, Paragraph

        items = [
            ListItem(Paragraph(self._markup(line), self.styles["plain"])) for line in block.lines
        ]
        return [
            ListFlowable(items, bulletType="bullet", start="•", bulletFontSize=7, leftIndent=12)
        ]

    def _facts(self, block: Facts, width: float) -> list:
        rows = [
            (self._paragraph(label, "label"), self._paragraph(value, "cell"))
            for label, value in block.lines
        ]
        if not rows:
            return []
        first = min(0.36 * width, 160.0)
        return [self._grid(rows, (first, width - first), [])]

    def _table(self, block: Table, width: float) -> list:
        size = 6.6 if block.is_small else 8.5
        kinds = ["number" if is_number else "cell" for is_number in block.numbers]
        heads = ["head" if kind == "cell" else "head number" for kind in kinds]
        rows = [tuple(self._cell(*pair, size) for pair in zip(block.head, heads, strict=True))]
        rows += [
            tuple(self._cell(cell, kind, size) for cell, kind in zip(row, kinds, strict=True))
            for row in block.rows
        ]
        lines = [("LINEBELOW", (0, 0), (-1, 0), 0.8, INK), ("LINEBELOW", (0, 1), (-1, -1), 0.3, RULE)]  # fmt: skip
        return [self._grid(rows, [share * width for share in block.widths], lines, heads=1)]

    def _grid(self, rows, widths, lines, heads: int = 0):
        from reportlab.platypus import Table as Grid

        pads = [
            ("VALIGN", (0, 0), (-1, -1), "TOP"),
            ("LEFTPADDING", (0, 0), (-1, -1), 0),
            ("RIGHTPADDING", (0, 0), (-1, -1), 9),
            ("TOPPADDING", (0, 0), (-1, -1), 2),
            ("BOTTOMPADDING", (0, 0), (-1, -1), 2.5),
        ]
        made = Grid(rows, widths, repeatRows=heads, hAlign="LEFT", style=pads + lines)
        made.spaceAfter = 8
        return made

    def _cell(self, cell: str | Cell, kind: str, size: float):
        if isinstance(cell, Cell):
            words = self._markup(cell.text)
            if cell.state is not None:
                words = f'<font color="{COLOURS[cell.state]}"><b>{words}</b></font>'
            return self._sized(words, "cell", size)
        return self._sized(self._markup(cell), kind, size)

    def _sized(self, markup: str, kind: str, size: float):
        from reportlab.lib.styles import ParagraphStyle
        from reportlab.platypus import Paragraph

        style = self.styles[kind]
        if size != style.fontSize:
            name = f"{kind} {size:g}"
            if name not in self.styles:
                self.styles[name] = ParagraphStyle(
                    name, parent=style, fontSize=size, leading=1.3 * size
                )
            style = self.styles[name]
        return Paragraph(markup, style)

    def _paragraph(self, text: str, kind: str):
        from reportlab.platypus import Paragraph

        return Paragraph(self._markup(text), self.styles[kind])

    def _figure(self, block: Figure, width: float) -> list:
        from reportlab.platypus import KeepTogether

        picture = block.picture
        size = np.array(picture.size, dtype=np.float64)
        scale = min(block.width * width / size[0], TALLEST * self.height / size[1])
        if isinstance(picture, Sheet):
            shown = _drawing(picture, scale, self._letters)
        else:
            shown = _picture(picture, scale * size)
        return [KeepTogether([shown, self._paragraph(block.caption, "caption")])]

    def _beside(self, block: Beside, width: float) -> list:
        gap = 14.0
        left = block.share * width
        sides = [
            [made for each in side for made in self.writers[type(each)](each, room - gap)]
            for side, room in ((block.left, left), (block.right, width - left))
        ]
        # A cell of a table takes what is in a group that is kept together only one by one.
        plain = [[each for made in side for each in _parts(made)] for side in sides]
        return [self._grid([plain], (left, width - left), [])]


def _parts(flowable) -> list:
    """What is in a group that is kept together, or the flowable itself."""
    from reportlab.platypus import KeepTogether

    return list(flowable._content) if isinstance(flowable, KeepTogether) else [flowable]


def _picture(picture: Image.Image, size):
    from reportlab.platypus import Image as Picture

    stream = io.BytesIO()
    picture.convert("RGB").save(stream, "PNG")
    stream.seek(0)
    made = Picture(stream, *map(float, size))
    made.hAlign = "LEFT"
    return made


def _outlined(kind, key: str, title: str, level: int):
    """Kind of paragraph that readers list beside the pages."""

    class Outlined(kind):
        def draw(self):
            self.canv.bookmarkPage(key)
            self.canv.addOutlineEntry(title, key, min(level - 1, 1), closed=level == 1)
            super().draw()

    return Outlined


def _drawing(sheet: Sheet, scale: float, letters):
    """Drawing of a sheet as a flowable, [pt] for a pixel."""
    from reportlab.platypus import Flowable

    class Drawing(Flowable):
        def __init__(self):
            super().__init__()
            self.width, self.height = (scale * side for side in sheet.size)
            self.hAlign = "LEFT"

        def draw(self):
            pen = self.canv
            pen.saveState()
            pen.scale(scale, scale)
            for shape in sheet.shapes:
                _draw_shape(pen, shape, sheet.size[1], letters)
            pen.restoreState()

    return Drawing()


def _draw_shape(pen, shape, height: float, letters) -> None:
    """Draw a shape of a sheet, whose y points down from the top."""
    if isinstance(shape, Area):
        pen.setFillColor(shape.colour)
        pen.drawPath(_path(pen, shape.corners, height, is_closed=True), stroke=0, fill=1)
    elif isinstance(shape, Line):
        pen.setStrokeColor(shape.colour)
        pen.setLineWidth(shape.width)
        pen.setLineJoin(1)
        pen.drawPath(_path(pen, shape.path, height), stroke=1, fill=0)
    elif isinstance(shape, Raster):
        from reportlab.lib.utils import ImageReader

        (x, y), (width, tall) = shape.corner, shape.size
        pen.drawImage(ImageReader(Image.fromarray(shape.pixels)), x, height - y - tall, width, tall)
    else:
        _draw_text(pen, shape, height, letters)


def _path(pen, points, height: float, is_closed: bool = False):
    made = pen.beginPath()
    for k, (x, y) in enumerate(points):
        (made.lineTo if k else made.moveTo)(float(x), height - float(y))
    if is_closed:
        made.close()
    return made


def _draw_text(pen, shape, height: float, letters) -> None:
    from reportlab.pdfbase.pdfmetrics import stringWidth

    text = letters(shape.text)
    width = stringWidth(text, "Helvetica", shape.size)
    x = shape.place[0] - {"l": 0.0, "m": 0.5, "r": 1.0}[shape.anchor] * width
    y = height - shape.place[1] - 0.35 * shape.size
    if shape.halo:
        pen.setStrokeColor(shape.halo)
        pen.setLineWidth(3.0)
        pen.setLineJoin(1)
        _show(pen, x, y, text, shape.size, mode=1)
    pen.setFillColor(shape.colour)
    _show(pen, x, y, text, shape.size, mode=0)


def _show(pen, x: float, y: float, text: str, size: float, mode: int) -> None:
    """Write letters filled (mode 0) or as their outlines (1)."""
    made = pen.beginText(x, y)
    made.setFont("Helvetica", size)
    made.setTextRenderMode(mode)
    made.textOut(text)
    # What is written next is filled.
    made.setTextRenderMode(0)
    pen.drawText(made)


def _numbering_canvas(footer: str):
    """Kind of canvas that writes the footer and "3 of 12" on every page, once all of them are known."""
    from reportlab.pdfgen.canvas import Canvas

    class Numbering(Canvas):
        def __init__(self, *settings, **named):
            super().__init__(*settings, **named)
            self._kept = []

        def showPage(self):  # noqa: N802 - of reportlab
            self._kept.append(dict(self.__dict__))
            self._startPage()

        def save(self):
            for state in self._kept:
                self.__dict__.update(state)
                self.setFont("Helvetica", 7.5)
                self.setFillColor(FAINT)
                self.drawString(MARGIN, 0.55 * HEAD, footer[:110])
                words = f"{self._pageNumber} of {len(self._kept)}"
                self.drawRightString(self._pagesize[0] - MARGIN, 0.55 * HEAD, words)
                super().showPage()
            super().save()

    return Numbering
