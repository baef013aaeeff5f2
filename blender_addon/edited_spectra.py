"""Spectra that edits give to lights: illuminants by their names, and files of spectra, which come whole within the edits."""

import hashlib
import re
from functools import lru_cache
from pathlib import Path

from ..engine.errors import FileFormatError, SceneError
from ..libraries.spectra import illuminant_names

LONGEST_TEXT = 256 << 10
"""Of a file of a spectrum; one by the nanometre has 10 kB. [byte]"""

LONGEST_NAME = 100
"""Of such a file. [character]"""

MOST_COLUMNS = 1000
"""Of which one may be chosen."""

_NEEDED, _ALL = {"file", "text"}, {"file", "text", "column"}

_UNUSUAL = re.compile(r"[^\w .,()+&-]")
"""In a file's name: some systems have no such files."""


@lru_cache
def library_spectra() -> tuple[dict, ...]:
    """Illuminants with what tells them apart: ``name``, ``temperature`` [K] and ``rendering`` (Ra), None without meaning."""
    from ..engine.analysis.spectrum_figures import find_figures
    from ..engine.photometry.spectra import GRID, illuminant
    from ..engine.scene.spectrum import Tabulated

    figures = {
        name: find_figures(Tabulated(GRID, illuminant(GRID, name), name=name))
        for name in illuminant_names()
    }
    return tuple(
        {"name": name, "temperature": each.temperature, "rendering": each.rendering}
        for name, each in figures.items()
    )


def check_spectrum(told: str, value) -> None:
    """Refuse what is no spectrum of a light.

    Parameters
    ----------
    told : str    Whose it is, for messages.
    value
        Data of JSON, from anywhere: the name of an illuminant, or ``{"file": NAME, "text": TEXT, "column": N}``, the content
        of a file that `engine.formats.spd` reads, and which of its columns counts if that is not the first.

    Raises
    ------
    SceneError    It is none, cannot be read, or holds no light that is seen.
    """
    if isinstance(value, str):
        if value not in illuminant_names():
            known = ", ".join(illuminant_names())
            raise SceneError(f"{told}: there is no illuminant {value[:80]!r}; there are {known}")
        return
    if not isinstance(value, dict) or not _NEEDED <= set(value) <= _ALL:
        raise SceneError(
            f"{told}: expected the name of an illuminant, or an object with file, text and, if need be, column"
        )
    _check_name(told, value["file"])
    column = value.get("column", 1)
    if not isinstance(column, int) or isinstance(column, bool) or not 1 <= column <= MOST_COLUMNS:
        raise SceneError(
            f"{told}: 'column' is expected to be a whole number from 1 to {MOST_COLUMNS}"
        )
    _check_light(told, value)


def choose_spectrum(settings, value, saved: Path) -> None:
    """Let something luminous shine as `check_spectrum` has allowed.

    Parameters
    ----------
    settings : SpectrumSettings
    value
        As above.
    saved : Path
        Where the open file will be saved: a file of a spectrum is written into a folder beside it, which belongs to it.
    """
    if isinstance(value, str):
        settings.spectrum, settings.illuminant = "ILLUMINANT", value
        return
    folder = saved.with_name(f"{saved.stem}.spectra")
    folder.mkdir(exist_ok=True)
    content = value["text"].encode("utf-8")
    # Files of equal names and other contents stand side by side.
    name = f"{hashlib.sha256(content).hexdigest()[:12]} {_UNUSUAL.sub('_', value['file'])}"
    (folder / name).write_bytes(content)
    settings.spectrum, settings.spectrum_file = "FILE", f"//{folder.name}/{name}"
    settings.spectrum_column = value.get("column", 0)


def _check_name(told: str, name) -> None:
    if not isinstance(name, str) or not (0 < len(name) <= LONGEST_NAME and name.isprintable()):
        raise SceneError(
            f"{told}: 'file' is expected to be a name of 1 to {LONGEST_NAME} printable characters"
        )


def _check_light(told: str, value: dict) -> None:
    from ..engine.formats.spd import parse_spectrum
    from ..engine.photometry.spectra import luminous_weight

    text = value["text"]
    if not isinstance(text, str):
        raise SceneError(f"{told}: 'text' is expected to be the content of the file")
    try:
        content = text.encode("utf-8")
    except UnicodeEncodeError:
        raise SceneError(f"{told}: 'text' has characters that no text can have") from None
    if len(content) > LONGEST_TEXT:
        raise SceneError(
            f"{told}: {value['file']} has {len(content)} bytes, expected at most {LONGEST_TEXT}"
        )
    try:
        table = parse_spectrum(Path(value["file"]), content, value.get("column")).table
    except FileFormatError as error:
        raise SceneError(f"{told}: {error}") from None
    if not luminous_weight(table) > 0.0:
        raise SceneError(f"{told}: {value['file']} holds no visible light")
