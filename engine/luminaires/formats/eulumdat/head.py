"""The first 26 lines of an EULUMDAT: what the luminaire is, and how its intensities are laid out."""

from dataclasses import dataclass

from .fields import ANGLE, LENGTH, PERCENT, Fields
from .planes import MAXIMUM_PLANES, MAXIMUM_POLARS, MAXIMUM_VALUES

MAXIMUM_LAMP_SETS = 20
MAXIMUM_LENGTH = 1e6
"""Longest side. [mm]"""

_SPLIT_HINT = "; perhaps a text above it is broken into two lines, or a line is missing"
_LINES_OF_HEAD = 26
MANUFACTURER, REPORT, NAME, NUMBER, FILE, DATE = (
    "MANUFAC",
    "TEST",
    "LUMINAIRE",
    "LUMCAT",
    "_FILE",
    "ISSUEDATE",
)
"""Keys of the metadata: those of LM-63 that mean the same, so that files convert."""

MEASUREMENT_TILT = "_MEASUREMENT_TILT"
"""Key of the metadata for the tilt of the luminaire in the goniometer. [degree]"""


@dataclass(frozen=True)
class Head:
    """The first 26 lines; lengths in mm, 0 if not stated, fractions in percent; ``lines`` are their numbers."""

    lines: tuple[int, ...]
    isym: int
    plane_count: int
    plane_step: float
    polar_count: int
    polar_step: float
    metadata: dict[str, str]
    housing: tuple[float, float, float]
    area: tuple[float, float]
    heights: tuple[float, float, float, float]
    downward_fraction: float | None
    light_output_ratio: float | None
    factor: float
    lamp_sets: int


def read_head(fields: Fields) -> Head:
    """Read lines 1 to 26.

    Raises
    ------
    FileFormatError    A number that decides about light is missing or makes no sense; with the line.
    """
    lines = tuple(line for line, _ in fields.rest()[:_LINES_OF_HEAD])
    metadata = {MANUFACTURER: fields.text("the company (line 1)")}
    ityp = fields.whole("Ityp (the type of luminaire)", 0, 3, _SPLIT_HINT)
    isym = fields.whole("Isym (the symmetry)", 0, 4, _SPLIT_HINT)
    if ityp == 1 and isym != 1:
        fields.remark(f"Ityp 1 says symmetric about the vertical, Isym {isym} counts")
    plane_count = fields.whole("Mc (the number of C-planes)", 1, MAXIMUM_PLANES, _SPLIT_HINT)
    plane_step = fields.number("Dc (the step of the C-planes)", ANGLE, 0.0)
    polar_count = fields.whole("Ng (the number of polar angles)", 2, MAXIMUM_POLARS, _SPLIT_HINT)
    if plane_count * polar_count > MAXIMUM_VALUES:
        fields.fail(
            f"{plane_count} C-planes of {polar_count} intensities, expected at most"
            f" {MAXIMUM_VALUES} together"
        )
    polar_step = fields.number("Dg (the step of the polar angles)", ANGLE, 0.0)
    for key, name in (
        (REPORT, "the report number"),
        (NAME, "the name of the luminaire"),
        (NUMBER, "the number of the luminaire"),
        (FILE, "the name of the file"),
        (DATE, "date and user"),
    ):
        metadata[key] = fields.text(name)
    housing = tuple(_length(fields, f"{side} of the luminaire") for side in _SIDES)
    area = tuple(_length(fields, f"{side} of the luminous area") for side in _SIDES[:2])
    heights = tuple(_length(fields, f"height of the luminous area at {c}") for c in _HEIGHTS)
    downward = _percentage(fields, "the downward flux fraction DFF", 100.0)
    ratio = _percentage(fields, "the light output ratio LORL", 1000.0)
    if ratio == 0.0:
        fields.remark("a light output ratio LORL of 0 %, taken as not stated")
        ratio = None
    factor = fields.number("the conversion factor", default=1.0, assumed="1")
    if factor <= 0.0:
        fields.fail(
            f"{factor:g} as conversion factor of the intensities, expected more than 0, mostly 1"
        )
    tilt = fields.number("the tilt during measurement", ANGLE, 0.0)
    if tilt:
        metadata[MEASUREMENT_TILT] = f"{tilt:g}"
        fields.remark(
            f"measured at a tilt of {tilt:g} degrees; the intensities are taken as they are, so place the"
            " luminaire accordingly"
        )
    lamp_sets = fields.whole("the number of lamp sets", 0, MAXIMUM_LAMP_SETS)
    if lamp_sets == 0:
        fields.fail("no lamp set, so the intensities in cd per 1000 lm have no flux to refer to")
    return Head(
        lines=lines,
        isym=isym,
        plane_count=plane_count,
        plane_step=plane_step,
        polar_count=polar_count,
        polar_step=polar_step,
        metadata={key: value for key, value in metadata.items() if value},
        housing=housing,
        area=area,
        heights=heights,
        downward_fraction=downward,
        light_output_ratio=ratio,
        factor=factor,
        lamp_sets=lamp_sets,
    )


_SIDES = ("the length", "the width", "the height")
_HEIGHTS = ("C0", "C90", "C180", "C270")


def _length(fields: Fields, name: str) -> float:
    value = fields.number(name, LENGTH, 0.0)
    if not 0.0 <= value <= MAXIMUM_LENGTH:
        fields.remark(f"{value:g} mm as {name}, taken as 0")
        return 0.0
    return value


def _percentage(fields: Fields, name: str, largest: float) -> float | None:
    value = fields.number(name, PERCENT, assumed="not stated")
    if value is not None and not 0.0 <= value <= largest:
        fields.remark(f"{value:g} % as {name}, taken as not stated")
        return None
    return value
