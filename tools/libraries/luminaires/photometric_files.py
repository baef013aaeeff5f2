"""Writers of the library's photometric files: LM-63-2002 and EULUMDAT, the same bytes each time."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from .distributions import directions, grid_flux

DATE = "2026-01-15"
"""Date of issue of every file; one that changes would change the bytes."""

TYPES = {"C": 1, "B": 2, "A": 3}
"""Photometric types as LM-63 numbers them."""

STORED = {"rotational": 1, "C0-C180": 2, "C90-C270": 3, "quadrant": 4}
"""Symmetries as EULUMDAT numbers them."""

SYMMETRIES = (*STORED, "none", "right")
"""All symmetries."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Photometry:
    """What a file says.

    Parameters
    ----------
    formula : callable    Directions (..., 3) to intensity in proportion.
    kind : str    Photometric type, ``A``, ``B`` or ``C``.
    symmetry : str    ``rotational``, ``quadrant``, ``C0-C180``, ``C90-C270``; of types A and B ``none`` or ``right``: the
        same to the left as to the right.
    horizontal, vertical : (n,), (m,) array    All angles, before any are left out by symmetry. [degree]
    flux : float    Of the luminaire. [lm]
    watts : float
    opening : (shape, (x, y, z))    As `engine/scene/distribution.py` names shapes; sides along the luminaire's axes. [m] The
        axis of a cylinder is the one whose side differs from the other two.
    lamp : str
    lamp_flux : float or None    Of the lamps, where the intensities are to refer to them. [lm]
    colour, rendering : str    Colour temperature and rendering index as text.
    """

    formula: Callable
    vertical: np.ndarray
    flux: float
    watts: float
    opening: tuple[str, tuple[float, float, float]]
    kind: str = "C"
    symmetry: str = "rotational"
    horizontal: np.ndarray = field(default_factory=lambda: np.zeros(1))
    lamp: str = "LED"
    lamp_flux: float | None = None
    colour: str = ""
    rendering: str = ""

    def table(self) -> np.ndarray:
        """Intensities at all angles (n, m), scaled so that their bilinear interpolant has the flux. [cd]"""
        values = self.formula(directions(self.kind, self.horizontal, self.vertical))
        if self.symmetry == "rotational":
            values = values[:1]
            flux = grid_flux(self.kind, np.zeros(1), self.vertical, values)
        else:
            flux = grid_flux(self.kind, self.horizontal, self.vertical, values)
        return values * (self.flux / flux)


def number(value: float) -> str:
    """Return a number with five digits that count, without an exponent."""
    if value < 1e-4:
        return "0"
    decimals = max(0, 4 - int(np.floor(np.log10(value))))
    text = f"{value:.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def wrapped(words, width: int = 120) -> list[str]:
    """Break a list of words into lines."""
    lines, line = [], ""
    for word in words:
        if line and len(line) + 1 + len(word) > width:
            lines.append(line)
            line = ""
        line = f"{line} {word}" if line else word
    return [*lines, line]


def join(lines) -> bytes:
    """Return the lines as both formats want them: ended by carriage return and line feed."""
    return "".join(f"{line}\r\n" for line in lines).encode("ascii")


# ---- LM-63-2002 ----


def _signed_sides(kind: str, opening) -> tuple[float, float, float]:
    """Width, length and height with the signs that tell the shapes apart.

    The width lies along y and the length along x; of types A and B the width lies across the beam, the length upright.
    """
    shape, (x, y, z) = opening
    if kind != "C":
        x, y = y, x
    if shape in {"point", "rectangle", "box"}:
        return y, x, z
    if shape == "ellipse":
        return -y, -x, 0.0
    if shape == "ellipsoid":
        return -y, -x, -z
    if z not in {x, y}:
        return -y, -x, z
    return (-y, x, -z) if y == z else (y, -x, -z)


def _stored_horizontal(photometry) -> np.ndarray:
    """Which of the horizontal angles a file of LM-63 holds."""
    h = photometry.horizontal
    last = {"rotational": 0.0, "quadrant": 90.0, "C0-C180": 180.0}.get(photometry.symmetry, 360.0)
    first = 0.0 if photometry.symmetry == "right" else -360.0
    return (h >= first) & (h <= last)


def write_ies(photometry: Photometry, name: str, title: str) -> bytes:
    """Return a file by LM-63-2002."""
    table = photometry.table()
    keep = _stored_horizontal(photometry)
    horizontal = photometry.horizontal[keep]
    rows = table if photometry.symmetry == "rotational" else table[keep]
    lumens = "-1" if photometry.lamp_flux is None else number(photometry.lamp_flux)
    sides = " ".join(f"{side:g}" for side in _signed_sides(photometry.kind, photometry.opening))
    lines = [
        "IESNA:LM-63-2002",
        f"[TEST] Computed {name}",
        "[TESTLAB] None: computed from a formula",
        f"[ISSUEDATE] {DATE}",
        "[MANUFAC] Lumenray synthetic",
        f"[LUMCAT] {name}",
        f"[LUMINAIRE] {title}",
        f"[LAMP] {photometry.lamp}",
    ]
    if photometry.colour:
        lines.append(f"[_COLORTEMP] {photometry.colour}")
    lines += [
        "TILT=NONE",
        f"1 {lumens} 1 {len(photometry.vertical)} {len(horizontal)} {TYPES[photometry.kind]} 2 {sides}",
        f"1 1 {photometry.watts:g}",
        *wrapped([f"{angle + 0.0:g}" for angle in photometry.vertical]),
        *wrapped([f"{angle + 0.0:g}" for angle in horizontal]),
    ]
    for row in rows:
        lines += wrapped([number(value) for value in row])
    return join(lines)


# ---- EULUMDAT ----


def _stored_planes(symmetry: str, table: np.ndarray) -> np.ndarray:
    """Rows that a file of EULUMDAT holds, of planes 0 <= C < 360."""
    count = len(table)
    if symmetry == "rotational":
        return table[:1]
    if symmetry == "quadrant":
        return table[: count // 4 + 1]
    if symmetry == "C0-C180":
        return table[: count // 2 + 1]
    return table[(3 * count // 4 + np.arange(count // 2 + 1)) % count]


def write_ldt(photometry: Photometry, name: str, title: str) -> bytes:
    """Return a EULUMDAT file; the luminaire's length lies along +y, which is C90."""
    symmetry = photometry.symmetry
    planes = photometry.horizontal[photometry.horizontal < 360.0]
    table = photometry.table()[: len(planes)]
    if symmetry == "rotational":
        planes = planes[:1]
    reference = photometry.lamp_flux or photometry.flux
    shape, (x, y, z) = photometry.opening
    is_round = shape in {"ellipse", "cylinder"}
    sides = [f"{1000.0 * y:g}", "0" if is_round else f"{1000.0 * x:g}"]
    down = photometry.vertical <= 90.0
    whole = photometry.horizontal if symmetry != "rotational" else np.zeros(1)
    below = grid_flux("C", whole, photometry.vertical[down], photometry.table()[:, down])
    is_long = not is_round and max(x, y) > 2.5 * min(x, y)
    lines = [
        "Lumenray synthetic",
        "1" if symmetry == "rotational" else "2" if is_long else "3",
        str(STORED[symmetry]),
        str(len(planes)),
        "0" if symmetry == "rotational" else f"{planes[1] - planes[0]:g}",
        str(len(photometry.vertical)),
        f"{_step(photometry.vertical):g}",
        f"Computed {name}",
        title,
        name,
        f"{name}.ldt",
        f"{DATE} Lumenray",
        # Housing as large as the opening; only what shines is known of a formula.
        *sides,
        f"{max(1000.0 * z, 20.0):g}",
        *sides,
        *[f"{1000.0 * z:g}"] * 4,
        f"{100.0 * below / photometry.flux:.2f}",
        f"{100.0 * photometry.flux / reference:.2f}",
        "1",
        "0",
        "1",
        "-1" if photometry.lamp_flux is None else "1",
        photometry.lamp,
        number(reference),
        photometry.colour,
        photometry.rendering,
        f"{photometry.watts:g}",
        *["0"] * 10,
        *(f"{angle:g}" for angle in planes),
        *(f"{angle:g}" for angle in photometry.vertical),
    ]
    stored = _stored_planes(symmetry, table) * (1000.0 / reference)
    return join([*lines, *(number(value) for value in stored.ravel())])


def _step(angles: np.ndarray) -> float:
    """Distance of the angles, 0 if it varies."""
    steps = np.diff(angles)
    return float(steps[0]) if np.ptp(steps) < 1e-9 else 0.0
