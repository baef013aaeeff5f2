"""The files of a report: HTML, PDF where it is asked for, and all values as CSV and JSON beside them."""

from pathlib import Path

from ...engine.errors import FileFormatError
from ...engine.reporting.composition import compose
from ...engine.reporting.data import write_document, write_values
from ...engine.reporting.html_file import write_html
from ...engine.reporting.pdf_file import write_pdf
from ...engine.reporting.results import Report

ENDINGS = (".html", ".htm")


def check_name(path: Path, endings=ENDINGS) -> None:
    """Refuse a name that ends in nothing that is written.

    Raises
    ------
    FileFormatError    It says what is expected.
    """
    if path.suffix.lower() not in endings:
        raise FileFormatError(path, f"expected a name that ends in {' or '.join(endings)}")


def value_paths(path: Path) -> tuple[Path, Path]:
    """Return where the values of a report are written."""
    return path.with_suffix(".csv"), path.with_suffix(".json")


def write_report(report: Report, path: Path, pdf: Path | None = None) -> list[Path]:
    """Write all files of a report; return their paths.

    Raises
    ------
    LumenrayError    A file cannot be written, or the package for PDF is not installed.
    """
    document = compose(report)
    rows, values = value_paths(path)
    made = [write_html(path, document)]
    if pdf is not None:
        made.append(write_pdf(pdf, document))
    return [*made, write_values(rows, report), write_document(values, report)]
