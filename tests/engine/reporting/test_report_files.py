"""The files of a report say the same numbers, need nothing beside them, and take names for letters."""

import csv
import html.parser
import io
import json
import re
from dataclasses import replace

import pytest
from made_up_reports import HOSTILE, new_report

from lumenray.engine.errors import FileFormatError, LumenrayError
from lumenray.engine.reporting import data, pdf_file
from lumenray.engine.reporting.composition import compose, estimate
from lumenray.engine.reporting.html_file import to_html, write_html


class Page(html.parser.HTMLParser):
    """What a browser makes of a page: elements with their attributes, rows of tables, and the text."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.rows, self.open, self.text = [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in {"meta", "img", "br", "col", "rect", "polygon", "polyline", "image"}:
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in {"td", "th"}:
            self.rows[-1].append("")

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] != "style":
            self.text.append(data)
        if self.rows and {"td", "th"} & set(self.open):
            self.rows[-1][-1] += data


@pytest.fixture(scope="module")
def report():
    return new_report()


@pytest.fixture(scope="module")
def page(report):
    return Page(to_html(compose(report)))


def words_of(page):
    return " ".join(" ".join(page.text).split())


def test_every_number_of_the_page_is_that_of_the_data(page, report):
    written = data.describe(report)
    text = words_of(page)
    for scene in written["lighting_scenes"]:
        (area,) = scene["areas"]
        mean = estimate(area["mean"], area["mean_standard_error"], "lx")
        assert re.fullmatch(r"\d+\.\d ± 2\.0 lx", mean)
        # In the table of verdicts and in the chapter.
        assert text.count(mean) == 2
        assert [scene["state"]] == [row[-1] for row in page.rows if mean in row]
        for value in area["values"]:
            assert f"{value:.0f} ±2" in text
        for limit in area["verdict"]["limits"]:
            row = next(r for r in page.rows if r[0] == limit["name"] and r[-1] == limit["state"])
            assert row[1].startswith(f"at least {limit['limit']:g}")
    assert [scene["state"] for scene in written["lighting_scenes"]] == ["met", "not met"]
    assert written["watts_per_m2"] == pytest.approx(120.0 / 20.0)
    assert "120 W, 6 W/m² over 20 m² (Floor Desk)" in text
    # The verdicts come first.
    assert text.rindex("Summary") < text.index("Required:") < text.rindex("Method and errors")


def test_the_page_needs_nothing_beside_it(page):
    for tag, attributes in page.elements:
        assert tag not in {"script", "link", "iframe", "object", "embed", "base", "form"}
        for name, value in attributes.items():
            assert not name.startswith("on")
            if name in {"src", "href"}:
                assert value.startswith(("data:image/png;base64,", "#part"))
    raw = to_html(compose(new_report()))
    assert "//" not in re.sub(r"base64,[A-Za-z0-9+/=]+", "", raw)
    assert "@import" not in raw
    assert "url(" not in raw
    assert "default-src 'none'" in raw


def test_every_link_of_the_contents_leads_to_a_heading(page):
    marks = {attributes.get("id") for _, attributes in page.elements}
    links = [a["href"] for tag, a in page.elements if tag == "a"]
    assert len(links) > 8
    assert {link.removeprefix("#") for link in links} <= marks


def test_names_of_a_file_are_letters_and_no_more():
    raw = to_html(compose(new_report(HOSTILE)))
    made = Page(raw)
    assert not any(tag == "script" for tag, _ in made.elements)
    assert "&lt;script&gt;alert(&#x27;1&#x27;)&lt;/script&gt; &amp; &quot;Büro&quot;" in raw
    assert "\x1b" not in raw
    assert "\u202e" not in raw
    assert not made.open


def test_the_pdf_says_the_same(report):
    pypdf = pytest.importorskip("pypdf")
    pytest.importorskip("reportlab")
    content = pdf_file._Pages(compose(report)).build()
    reader = pypdf.PdfReader(io.BytesIO(content))
    pages = [" ".join(each.extract_text().split()) for each in reader.pages]
    text = " ".join(pages)
    assert reader.metadata.title == "Desk"
    for scene in data.describe(report)["lighting_scenes"]:
        (area,) = scene["areas"]
        assert estimate(area["mean"], area["mean_standard_error"], "lx") in text
        for value in area["values"]:
            assert f"{value:.0f} ±2" in text
    assert "met" in pages[0]
    assert f"1 of {len(pages)}" in pages[0]
    assert f"{len(pages)} of {len(pages)}" in pages[-1]
    # Chapters begin pages and are listed beside them.
    chapters = [each.title for each in reader.outline if not isinstance(each, list)]
    assert {"Day", "Evening Desk", "Luminaires", "Glare", "Method and errors"} <= set(chapters)
    assert pages[1].startswith("Day")
    # The same report is the same file.
    assert pdf_file._Pages(compose(new_report())).build() == content


def test_the_pdf_takes_names_for_letters_and_says_which_it_lacks():
    pypdf = pytest.importorskip("pypdf")
    pytest.importorskip("reportlab")
    content = pdf_file._Pages(compose(new_report(HOSTILE + " 事務所"))).build()
    pages = pypdf.PdfReader(io.BytesIO(content)).pages
    text = " ".join(" ".join(each.extract_text().split()) for each in pages)
    assert "<script>alert('1')</script> & \"Büro\"" in text
    assert pdf_file.MISSING.split(":")[0] in text
    assert pdf_file.latin("Ørsted & 事 ±²·–ł") == "Ørsted & ? ±²·–?"


def test_what_cannot_be_written_is_said(tmp_path, monkeypatch, report):
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(FileFormatError, match="taken"):
        write_html(tmp_path / "taken" / "report.html", compose(report))
    monkeypatch.setitem(__import__("sys").modules, "reportlab", None)
    with pytest.raises(LumenrayError, match="reportlab, which is not installed"):
        pdf_file.write_pdf(tmp_path / "report.pdf", compose(report))
    assert not (tmp_path / "report.pdf").exists()


def test_values_are_written_with_their_errors(tmp_path):
    report = new_report(HOSTILE)
    lines = data.write_values(tmp_path / "r.csv", report).read_text(encoding="utf-8").splitlines()
    remarks = [line for line in lines if line.startswith("#")]
    assert len(remarks) == 1
    rows = list(csv.DictReader(io.StringIO("\n".join(lines[1:]))))
    assert len(rows) == 30
    assert {row["lighting_scene"] for row in rows} == {scene.name for scene in report.scenes}
    kept = json.loads(data.write_document(tmp_path / "r.json", report).read_text(encoding="utf-8"))
    first = kept["lighting_scenes"][0]["areas"][0]
    assert float(rows[0]["value"]) == first["values"][0]
    assert float(rows[0]["standard_error"]) == first["standard_error"][0] == 2.0


def test_a_report_says_what_errors_are_made_of_where_something_was_simplified(report):
    area = report.scenes[0].areas[0]
    simplified = replace(area, simplified=0.003)
    scene = replace(report.scenes[0], areas=(simplified,))
    made = replace(report, scenes=(scene,))
    words = words_of(Page(to_html(compose(made))))
    assert "Error of the mean sampling and the rest 0." in words
    assert "simplifications at most 0.3 %" in words
    assert data.describe(made)["lighting_scenes"][0]["areas"][0]["simplifications_at_most"] == 0.003
    assert "simplifications at most" not in words_of(Page(to_html(compose(report))))
