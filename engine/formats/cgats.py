"""Spectra in CGATS text, as software of instruments writes it; ``.sp``, ``.ti3`` and ``.ccss`` of ArgyllCMS are such texts.

A text is words: keywords with a value; names of fields between ``BEGIN_DATA_FORMAT`` and ``END_DATA_FORMAT``; sets of as
many values between ``BEGIN_DATA`` and ``END_DATA``, each a sample. A word with blanks is in quotes, ``#`` begins a comment,
and a long set goes on in the next line. Further tables may follow; they keep the keywords and fields that they do not state
anew.

Spectral fields are named by their wavelength (``SPEC_380``, ``SPECTRAL_NM380``, ``SPECTRAL_NM_380``, ``nm380``, ``R_380``),
or come in pairs of ``SPECTRAL_NM`` and ``SPECTRAL_PCT`` (per cent) or ``SPECTRAL_DEC``. ArgyllCMS rounds the wavelengths in
its names; ``SPECTRAL_BANDS``, ``SPECTRAL_START_NM`` and ``SPECTRAL_END_NM`` tell them, ``SPECTRAL_NORM`` what stands for 1.

References
----------
ANSI/CGATS.17, Exchange format for color and process control data using XML or ASCII text
ArgyllCMS, File formats, https://www.argyllcms.com/doc/File_Formats.html
"""

import re
from dataclasses import dataclass

from ..errors import FileFormatError
from ..reading.columns import wavelength_of
from ..reading.remarks import Remark
from ..reading.text import decode, parse_number
from .spectrum_rows import SpectrumRows, check_column

MOST_FIELDS = 2000
"""Fields that a set may have."""

MOST_SAMPLES = 200_000

LONGEST_LINE = 1 << 17
"""[character]"""

SHOWN = 40
"""Characters of a word that messages quote, and of a name that is kept."""

ROUNDING = 1.0
"""How far the wavelength in a field's name may be from the one that the keywords tell. [nm]"""

NORMS = (1e-6, 1e9)
"""Range of ``SPECTRAL_NORM``."""

NAMES = ("SAMPLE_NAME", "SAMPLENAME", "SAMPLE_LOC", "SAMPLE_ID", "SAMPLEID")
"""Fields by which people know a sample, the best first."""

RANGE = ("SPECTRAL_BANDS", "SPECTRAL_START_NM", "SPECTRAL_END_NM")

EXPECTED = "expected fields such as SPEC_380, SPECTRAL_NM380 or nm380"

_DATA = re.compile(rb"(?:^|[\r\n])[ \t]*BEGIN_DATA", re.IGNORECASE)

_WORD = re.compile(r'"(?:[^"]|"")*"|\S+')

_PREFIX = re.compile(r"^spec(?:tral)?_(?:(?:pct|dec)_?)?")


def is_cgats(data: bytes) -> bool:
    """Whether a text has data as CGATS has them."""
    return _DATA.search(data) is not None


def read_cgats(path, data: bytes, column: int | None = None) -> SpectrumRows:
    """Read one sample of the first table that has spectral values.

    Parameters
    ----------
    path : str or Path    For messages.
    data : bytes
    column : int or None    Number of the sample, from 1; None: the first one.

    Returns
    -------
    SpectrumRows    Values that are stated in per cent, or with a norm, are shares.

    Raises
    ------
    FileFormatError    It has no spectral values, no such sample, is cut short, or something is wrong; names the line.
    """
    reader = _Reader(path, column or 1)
    for number, line in enumerate(decode(path, data).split("\n"), start=1):
        if len(line) > LONGEST_LINE:
            raise FileFormatError(path, f"has more than {LONGEST_LINE} characters", number)
        words = _split(line)
        if words:
            reader.take(number, words)
    held = reader.finish()
    if held.count:
        check_column(path, column, held.count, held.spectra)
    return held


def _split(line: str) -> list[str]:
    """Words of a line, with their quotes, without a comment."""
    words = _WORD.findall(line)
    comment = next((k for k, word in enumerate(words) if word.startswith("#")), None)
    return words[:comment]


def _unquoted(word: str) -> str:
    if len(word) > 1 and word[0] == word[-1] == '"':
        return word[1:-1].replace('""', '"').strip()
    return word


@dataclass(frozen=True)
class _Layout:
    """Where spectral values stand in a set.

    Parameters
    ----------
    places : list of int    From 0.
    wavelengths : list of float or None    Of each place [nm]; None: they stand in the place before.
    norm : float    What stands for 1.
    name : int or None    Place of the sample's name.
    """

    places: list[int]
    wavelengths: list[float] | None
    norm: float
    name: int | None

    @property
    def is_upright(self) -> bool:
        """Whether every set has one wavelength, so that all of them are one spectrum."""
        return self.wavelengths is None and len(self.places) == 1


class _Reader:
    """Takes the lines of a text one after the other."""

    def __init__(self, path, wanted: int):
        self.path, self.wanted = path, wanted
        self.line = 0
        self.state = self._take_head
        self.first = ""
        self.head: dict[str, tuple[int, str]] = {}
        self.fields: list[str] = []
        self.layout: _Layout | None = None
        self.is_done = False
        self.further = 0
        # Of the set that is being read: where it began, its words, and their lines.
        self.began, self.words, self.lines = 0, [], []
        self.count = 0
        self.names: list[str] = []
        self.rows: list[tuple[int, float, float]] = []
        self.remarks: list[Remark] = []

    def fail(self, message: str, line: int | None = None):
        """Refuse the file, because of the line that was read last if no other one is told."""
        raise FileFormatError(self.path, message, self.line if line is None else line or None)

    def take(self, number: int, words: list[str]) -> None:
        """Go on with the words of a line."""
        self.line = number
        while words:
            words = self.state(words)

    def finish(self) -> SpectrumRows:
        """Hand over what was read."""
        if self.state == self._take_fields:
            self.fail("ends before END_DATA_FORMAT; it is cut short")
        if self.state in {self._take_sets, self._pass_sets}:
            self.fail("ends before END_DATA; it is cut short")
        if not self.is_done:
            self.fail(f"is a CGATS text without spectral values, {EXPECTED}", 0)
        if self.further:
            text = f"has {self.further + 1} tables of data, of which the first one with spectral values is read"
            self.remarks.append(Remark(text))
        words = "ArgyllCMS spectrum (CGATS)" if self.first == "SPECT" else "CGATS"
        count = 1 if self.layout.is_upright else self.count
        return SpectrumRows(
            words, self.rows, tuple(self.names), count, "samples", tuple(self.remarks)
        )

    # ---- states, each of which returns the words that it leaves to the next one ----

    def _take_head(self, words):
        key = words[0].upper()
        self.first = self.first or key
        if key == "BEGIN_DATA_FORMAT":
            self.fields, self.state = [], self._take_fields
            return words[1:]
        if key == "BEGIN_DATA":
            self._begin_sets()
            return words[1:]
        self.head[key] = (self.line, _unquoted(words[1]) if len(words) > 1 else "")
        return []

    def _take_fields(self, words):
        for k, word in enumerate(words):
            if word.upper() == "END_DATA_FORMAT":
                self._check_count("NUMBER_OF_FIELDS", len(self.fields), "fields")
                self.state = self._take_head
                return words[k + 1 :]
            self.fields.append(_unquoted(word))
            if len(self.fields) > MOST_FIELDS:
                self.fail(f"has more than {MOST_FIELDS} fields")
        return []

    def _begin_sets(self):
        layout = None if self.is_done else self._find_layout()
        self.further += self.is_done
        if layout is None:
            self.state = self._pass_sets
            return
        self.layout, self.state = layout, self._take_sets

    def _pass_sets(self, words):
        """Of a table that is not read."""
        for k, word in enumerate(words):
            if word.upper() == "END_DATA":
                self.state = self._take_head
                return words[k + 1 :]
        return []

    def _take_sets(self, words):
        end = next((k for k, word in enumerate(words) if word.upper() == "END_DATA"), len(words))
        self._take_values(words[:end])
        if end < len(words):
            if self.words:
                self._refuse_set()
            self._check_count("NUMBER_OF_SETS", self.count, "sets")
            self.is_done, self.state = True, self._take_head
        return words[end + 1 :]

    def _take_values(self, words):
        """Words of a set; it begins and ends with a line, and may go over several."""
        if not words:
            return
        if not self.words:
            self.began = self.line
        self.words += words
        self.lines += [self.line] * len(words)
        if len(self.words) > len(self.fields):
            self._refuse_set()
        if len(self.words) == len(self.fields):
            self._take_set()
            self.words, self.lines = [], []

    def _refuse_set(self):
        self.fail(
            f"has {len(self.words)} values for the {len(self.fields)} fields of a set", self.began
        )

    def _take_set(self):
        self.count += 1
        if self.count > MOST_SAMPLES:
            self.fail(f"has more than {MOST_SAMPLES} samples")
        layout = self.layout
        if layout.name is not None and not layout.is_upright:
            self.names.append(_unquoted(self.words[layout.name])[:SHOWN])
        if not layout.is_upright and self.count != self.wanted:
            return
        for k, place in enumerate(layout.places):
            if layout.wavelengths is None:
                wavelength = self._number(place - 1)
            else:
                wavelength = layout.wavelengths[k]
            self.rows.append((self.lines[place], wavelength, self._number(place) / layout.norm))

    def _number(self, place: int) -> float:
        # Words are parted by blanks, so that a comma is a decimal sign.
        word = _unquoted(self.words[place])
        value = parse_number(word.replace(",", "."))
        if value is None:
            field = self.fields[place][:SHOWN]
            self.fail(f"has '{word[:SHOWN]}' as {field}, expected a number", self.lines[place])
        return value

    # ---- what head and fields tell ----

    def _check_count(self, key: str, count: int, what: str):
        """Remark on a number of fields or sets that is not the stated one."""
        line, text = self.head.get(key, (0, ""))
        if text and parse_number(text) != count and not self.is_done:
            self.remarks.append(Remark(f"states {text[:SHOWN]} {what}, but has {count}", line))

    def _stated(self, key: str, low: float, high: float) -> float:
        """A number of the head."""
        line, text = self.head[key]
        value = parse_number(text)
        if value is None or not low <= value <= high:
            self.fail(f"states '{text[:SHOWN]}' as {key}, expected {low:g} to {high:g}", line)
        return value

    def _find_layout(self) -> _Layout | None:
        """Where spectral values stand; None: there are none."""
        upper = [field.upper() for field in self.fields]
        name = next((upper.index(each) for each in NAMES if each in upper), None)
        named = [(k, wavelength_of(_PREFIX.sub("", s.lower()))) for k, s in enumerate(self.fields)]
        named = [(k, wavelength) for k, wavelength in named if wavelength is not None]
        if named:
            places = [k for k, _ in named]
            is_percent = any(upper[k].startswith("SPECTRAL_PCT") for k in places)
            wavelengths = self._exact([wavelength for _, wavelength in named], places)
            return _Layout(places, wavelengths, self._norm(is_percent), name)
        places = [
            k
            for k in range(1, len(upper))
            if upper[k - 1] == "SPECTRAL_NM" and upper[k] in {"SPECTRAL_PCT", "SPECTRAL_DEC"}
        ]
        if not places:
            return None
        kinds = {upper[k] for k in places}
        if len(kinds) > 1:
            self.fail("has both SPECTRAL_PCT and SPECTRAL_DEC, expected one of them")
        return _Layout(places, None, self._norm(kinds == {"SPECTRAL_PCT"}), name)

    def _exact(self, rounded: list[float], places: list[int]) -> list[float]:
        """Wavelengths as the keywords tell them, as the fields' names do where there are none. [nm]"""
        if not all(key in self.head for key in RANGE):
            return rounded
        bands = self._stated(RANGE[0], 1, MOST_FIELDS)
        first, last = (self._stated(key, 1.0, 1e6) for key in RANGE[1:])
        if bands != len(rounded):
            line = self.head[RANGE[0]][0]
            self.fail(f"states {bands:g} SPECTRAL_BANDS, but has {len(rounded)} such fields", line)
        step = (last - first) / max(len(rounded) - 1, 1)
        exact = [first + k * step for k in range(len(rounded))]
        for nm, name, place in zip(exact, rounded, places, strict=True):
            if abs(nm - name) > ROUNDING:
                self.fail(
                    f"has a field {self.fields[place][:SHOWN]} that SPECTRAL_START_NM and SPECTRAL_END_NM put at {nm:g} nm",
                    self.head[RANGE[1]][0],
                )
        return exact

    def _norm(self, is_percent: bool) -> float:
        """What stands for 1, with a remark if it is another number."""
        if "SPECTRAL_NORM" in self.head:
            norm = self._stated("SPECTRAL_NORM", *NORMS)
            told = f"states SPECTRAL_NORM {norm:g}, by which its values are divided"
        elif is_percent or self.first == "CTI3":
            norm, told = 100.0, "holds its values in per cent; they are read as shares"
        else:
            return 1.0
        if norm != 1.0:
            self.remarks.append(Remark(told, self.head.get("SPECTRAL_NORM", (0, ""))[0]))
        return norm
