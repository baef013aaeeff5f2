"""Which layout a goniometer's text has, and its columns."""

import re

from ...errors import FileFormatError
from ...reading.columns import Columns, name_columns, parse_columns, read_keyword, wavelength_of
from ...reading.text import decode, decode_text, parse_number

SIGNATURE = "lumenray goniometer"

LAYOUTS = "Lumenray goniometer", "in-plane table", "ASTM E1392 text"
"""For people."""

LONGEST_HEAD = 300
"""Lines before the first row, at most."""

LONGEST_LINE = 1 << 16
"""Of a head. [character]"""

HEAD = 1 << 16
"""First bytes by which a file is known. [byte]"""

ABOUT_NORMAL = (
    ("theta_i", "thetai", "theta_in", "incident_angle", "incidence_angle", "angle_of_incidence", "incidence", "aoi"),
    ("phi_i", "phii", "phi_in", "rotation", "azimuth_of_incidence"),
    ("theta_o", "thetao", "theta_out", "theta_r", "theta_s", "theta_v", "measure_angle", "measured_angle",
     "measurement_angle", "receiving_angle", "detector_angle", "viewing_angle", "observation_angle"),
    ("phi_o", "phio", "phi_out", "phi_r", "phi_s", "phi_v"),
)  # fmt: skip
"""Names of columns of the four angles about the normal."""

ABOUT_MIRROR = (("sigma", *ABOUT_NORMAL[0]), ("psi", *ABOUT_NORMAL[1]), ("theta",), ("phi",))
"""Names of columns of the four angles about the mirror direction."""

_SIGNED = re.compile(r"^[#\s]*lumenray goniometer\s+(\S+)\s*$", re.IGNORECASE)

_KEY = re.compile(r"^[#\s]*([A-Za-z_0-9]{1,40})\s+(\S.*)$")


def is_goniometer(data: bytes) -> bool:
    """Whether a text is a measurement in one of the layouts."""
    if b"\0" in data[:HEAD]:
        return False
    lines = decode_text(data, HEAD).split("\n")[:LONGEST_HEAD]
    if lines and SIGNATURE in lines[0].lower():
        return True
    return any(_is_vars(line) or _names_columns(line) for line in lines)


def _is_vars(line: str) -> bool:
    return line.lstrip("# \t").upper().startswith("VARS ") and "theta" in line.lower()


def _names_columns(line: str) -> bool:
    """Whether a line names a column of angles of incidence and one of outgoing angles."""
    if len(line) > LONGEST_LINE or not any(letter.isalpha() for letter in line[:200]):
        return False
    names = name_columns(line)[1][:8]
    return any(
        not {*names}.isdisjoint(sets[0]) and not {*names}.isdisjoint(sets[2])
        for sets in (ABOUT_NORMAL, ABOUT_MIRROR)
    )


def parse_goniometer(data: bytes, path) -> tuple[str, "GoniometerColumns"]:
    """Read head and rows.

    Returns
    -------
    str    Of `LAYOUTS`.
    GoniometerColumns

    Raises
    ------
    FileFormatError    It is none of the layouts, of a version that is unknown, or its rows are wrong.
    """
    lines = decode(path, data).split("\n")
    head: dict[str, str] = {}
    signed = _SIGNED.match(lines[0][:200])
    if signed and signed[1] != "1":
        raise FileFormatError(path, f"is of version {signed[1][:20]}, expected 1", 1)
    for number, line in enumerate(lines[:LONGEST_HEAD]):
        short = line[:LONGEST_LINE]
        if _is_vars(short):
            return LAYOUTS[2], _parse_e1392(lines, number, path, head)
        if _names_columns(short):
            mark, names = name_columns(short)
            columns = parse_columns(lines, number + 1, path, head, mark, names)
            return LAYOUTS[0 if signed else 1], GoniometerColumns(**vars(columns))
        found = read_keyword(short[:1000])
        if found is None and (key := _KEY.match(short[:1000])):
            found = key[1].lower().replace("_", " "), key[2].strip()
        if found is not None:
            head[found[0]] = found[1]
    raise FileFormatError(
        path,
        "has no line that names its columns, such as 'theta_i phi_i theta_o phi_o 450 550 650', "
        f"in its first {LONGEST_HEAD} lines",
    )


def _parse_e1392(lines, number: int, path, head) -> "GoniometerColumns":
    names = name_columns(lines[number].strip("# \t")[4:])[1]
    rows = number + 1
    while rows < min(len(lines), number + LONGEST_HEAD) and not _starts_with_number(lines[rows]):
        found = _KEY.match(lines[rows][:1000])
        if found:
            head[found[1].lower().replace("_", " ")] = found[2].strip()
        rows += 1
    first = next((line for line in lines[rows : rows + 1]), "")
    columns = parse_columns(lines, rows, path, head, "," if "," in first else None, names)
    stated = parse_number(head.get("num points", ""))
    if stated is not None and stated != len(columns.values):
        raise FileFormatError(path, f"states {stated:.12g} points, but holds {len(columns.values)}")
    return GoniometerColumns(**vars(columns))


def _starts_with_number(line: str) -> bool:
    return bool(re.match(r"^\s*[-+.]?\d", line[:40]))


class GoniometerColumns(Columns):
    """Columns, some of which are wavelengths."""

    def wavelengths(self) -> dict[str, float]:
        """Names of the columns of wavelengths, and what they state. [nm]"""
        found = {name: wavelength_of(name) for name in self.names}
        return {name: value for name, value in found.items() if value}
