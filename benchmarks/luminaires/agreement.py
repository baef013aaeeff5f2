"""Direct illuminance from photometric files: Lumenray against Radiance, point by point in one run."""

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.errors import LumenrayError
from ...engine.luminaires.amount import tilt_factor
from ...engine.luminaires.coordinates import angles
from ...engine.luminaires.distribution import flux, intensity, intensity_at
from ...engine.luminaires.formats.lm63.writer import write_lm63
from ...engine.luminaires.formats.reader import read_luminaire
from ...engine.luminaires.formats.record import LuminaireFile
from ...engine.scene.distribution import Opening
from ...engine.scene.light import Luminaire, Output, Quantity
from ...engine.scene.scene import SceneDelta
from ...engine.session import Session
from ..common import radiance
from .opening_sum import FINENESS, sum_over_opening

LIBRARY = Path(__file__).resolve().parents[2] / "libraries" / "luminaires"
"""Where the files lie that are compared if no others are named."""

SUFFIXES = (".ies", ".ldt", ".xml")

TILT, TURN = np.deg2rad(20.0), np.deg2rad(30.0)
"""How the luminaire hangs: turned about its vertical, then tilted about x, so that mistaken axes show. [rad]"""

HEIGHT = 3.0
"""Of the luminaire's point over the floor and under the ceiling. [m]"""

ROWS = 10
"""Points along each side of a plane; there are two planes."""

BOUND = 0.005
"""Largest relative deviation of the agreement that is asked for."""

DARK = 0.01
"""Points that get less than this share of the largest illuminance are not compared."""

OPENING_DISTANCE = 2.0
"""Distance of the planes from an extended opening, in diagonals of it."""

POINT_RULE, OPENING_RULE = StopRule(samples=64), StopRule(samples=1 << 14)
"""A point in empty space has no noise, so its samples are all the same."""

SUBDIVISION = 0.02
"""Size of Radiance's parts of an opening over their distance."""

PARTS = FINENESS**2
"""Of each face of an opening in the arbiter's sum."""

ALIKE = {
    "rectangle or box": ("rectangle", "box"),
    "disk or cylinder": ("ellipse", "cylinder"),
    "sphere": ("ellipsoid",),
}
"""Shapes of ours that Radiance has too, by the names of its own."""

REASONS = {
    "type B": "Radiance takes the angles of type B from projections on two planes, atan2(d·r, d·f) and atan2(d·u, d·f); "
    "LM-75 measures the first one from the plane, asin(d·r). They agree in the two principal planes only",
    "90 to 270": "Radiance turns files with planes from 90 to 270 degrees by half a turn; with us the plane 90 is at 90",
    "pole or seam": "the planes of the file differ where they meet (straight down, straight up, or at 0 and 360 degrees); "
    "we take one value there, Radiance keeps each plane's",
}
"""Why Radiance differs."""


@dataclass(frozen=True)
class Planes:
    """Points to be compared. ``positions``, ``normals``: (200, 3). [m]"""

    positions: np.ndarray
    normals: np.ndarray


def find_files(folder: Path | None = None) -> list[Path]:
    """Return photometric files of a folder and those below it; None: of the library.

    Raises
    ------
    LumenrayError    There are none.
    """
    root = LIBRARY if folder is None else Path(folder)
    found = sorted(path for path in root.rglob("*") if path.suffix.lower() in SUFFIXES)
    if not found:
        raise LumenrayError(f"{root}: no photometric files ({', '.join(SUFFIXES)})")
    return found


def run(folder: Path | None = None, say=None) -> dict:
    """Compare all files of a folder.

    Returns
    -------
    dict    Plain data: ``files`` (rows of `compare_points`), ``openings`` (rows of `compare_opening`), ``refused``.
    """
    if not radiance.is_installed():
        raise LumenrayError(
            "Radiance is not installed; run 'make setup', or pip install pyradiance"
        )
    say = say or (lambda _line: None)
    root = LIBRARY if folder is None else Path(folder)
    result = {"pyradiance": radiance.version(), "files": [], "openings": [], "refused": []}
    bench = Bench()
    for path in find_files(folder):
        name = path.relative_to(root).as_posix()
        try:
            file = read_luminaire(path)
            row = bench.compare_points(path, file)
            opening = bench.compare_opening(path, file)
        except LumenrayError as error:
            result["refused"].append({"file": name, "message": str(error).replace(str(path), name)})
            say(f"{name}: {error}")
            continue
        result["files"].append({"file": name, **row})
        if opening is not None:
            result["openings"].append({"file": name, **opening})
        say(f"{name}: largest deviation {100 * row['max']:.3f} %")
    return result


class Bench:
    """Our engine with one luminaire, and the two programs' answers about it."""

    def __init__(self):
        self.session = Session(witness=False)

    def compare_points(self, path: Path, file: LuminaireFile) -> dict:
        """Compare both programs with the luminaire as a point.

        Returns
        -------
        dict    ``points`` compared, ``beyond``: points that Radiance lights beyond the angles of the table, ``max``,
            ``rms`` and ``share`` (within `BOUND`) of the deviations, ``deviations`` themselves, ``reason`` (a key of
            `REASONS` or empty), ``without_reason``: the largest deviation once the reason is taken away.
        """
        rotation = hanging()
        place = np.array([0.0, 0.0, HEIGHT])
        planes = lay_planes(file, rotation, place, HEIGHT)
        ours = self._measure(file, rotation, place, planes, Opening(), POINT_RULE)[0]
        with _AsLm63(path, file) as files:
            theirs = self._ask(files.given, file, rotation, place, planes.positions, planes.normals)
            rewritten = self._ask(
                files.written, file, rotation, place, planes.positions, planes.normals
            )
        inside = is_inside(file, (planes.positions - place) @ rotation)
        row = describe(file) | compare(ours, theirs, inside)
        row["reason"] = _reason(file, row["max"])
        if row["reason"]:
            expected = ours
            if row["reason"] == "type B":
                expected = projected(file, rotation, planes.positions - place, planes.normals)
            row["without_reason"] = compare(expected, rewritten, inside)["max"]
        return row

    def compare_opening(self, path: Path, file: LuminaireFile) -> dict | None:
        """Compare both programs with the luminous opening of the file, close to it; None where it is a point.

        Returns
        -------
        dict    ``shape``, ``size`` [m], ``built``: what Radiance makes of it; ``ours`` and ``theirs``: deviations from
            `sum_over_opening` as of `compare`, None where Radiance builds another body; ``error``: our largest standard
            error; ``point``: how far off a point would be.
        """
        if file.opening.shape == "point":
            return None
        rotation = hanging()
        distance = OPENING_DISTANCE * float(np.linalg.norm(file.opening.size))
        place = np.array([0.0, 0.0, distance])
        planes = lay_planes(file, rotation, place, distance)
        ours, error = self._measure(file, rotation, place, planes, file.opening, OPENING_RULE)
        point = self._measure(file, rotation, place, planes, Opening(), POINT_RULE)[0]
        exact = sum_over_opening(file, rotation, place, planes.positions, planes.normals)
        exact *= tilt_factor(file.tilt, np.rad2deg(TILT))
        with _AsLm63(path, file) as files:
            answer = radiance.measure(
                files.written,
                radiance_axes(file, rotation),
                place,
                planes.positions,
                planes.normals,
                is_point=False,
                subdivision=SUBDIVISION,
            )
        everywhere = np.ones(len(planes.positions), dtype=bool)
        is_alike = _is_alike(file, answer)
        made = {"ours": compare(ours, exact, everywhere), "theirs": None}
        if is_alike:
            made["theirs"] = compare(answer.illuminance, exact, everywhere)
        bright = exact > DARK * exact.max()
        return made | {
            "shape": file.opening.shape,
            "size": list(file.opening.size),
            "built": answer.shape,
            "error": float(np.max(error[bright] / exact[bright])),
            "point": float(np.max(np.abs(point[bright] / exact[bright] - 1.0))),
        }

    def _measure(self, file, rotation, place, planes: Planes, opening: Opening, rule: StopRule):
        """Illuminance by our engine and its standard error. [lx]"""
        frame = np.eye(4)
        frame[:3, :3], frame[:3, 3] = rotation, place
        amount = flux(file.distribution) * tilt_factor(file.tilt, np.rad2deg(TILT))
        light = Luminaire(
            "light:compared", "compared", Output(Quantity.LUMINOUS_FLUX, amount),
            frame, file.distribution, opening,
        )  # fmt: skip
        self.session.apply(SceneDelta(changed=(light,)))
        made = self.session.measure(planes.positions, planes.normals, rule, transport="mono")
        return made.illuminance, made.standard_error

    @staticmethod
    def _ask(path, file, rotation, place, positions, normals) -> np.ndarray:
        axes = radiance_axes(file, rotation)
        return radiance.measure(path, axes, place, positions, normals).illuminance


class _AsLm63:
    """The file itself if it is LM-63, and as our writer writes it; both only while the context lasts."""

    def __init__(self, path: Path, file: LuminaireFile):
        self._folder = tempfile.TemporaryDirectory()
        self.written = Path(self._folder.name) / "written.ies"
        self.written.write_bytes(write_lm63(file))
        self.given = path if path.suffix.lower() == ".ies" else self.written

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._folder.cleanup()


# ---- geometry ----


def hanging() -> np.ndarray:
    """Rotation of the luminaire. (3, 3)"""
    c, s = np.cos(TURN), np.sin(TURN)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    c, s = np.cos(TILT), np.sin(TILT)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]) @ turn


def radiance_axes(file: LuminaireFile, rotation: np.ndarray) -> np.ndarray:
    """As ``rotation``, for the axes of ies2rad: of type B it has up along x and right along -y."""
    if file.photometric_type != "B":
        return rotation
    return rotation @ np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def lay_planes(file: LuminaireFile, rotation, place, distance: float) -> Planes:
    """Points on the plane that the luminaire mostly shines on, floor or ceiling, as wide as its beam, and on a wall."""
    distribution = file.distribution
    azimuth, polar = np.meshgrid(
        np.deg2rad(np.arange(0.0, 360.0, 5.0)), np.deg2rad(np.arange(1.0, 180.0))
    )
    local = np.stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), -np.cos(polar)], axis=-1
    ).reshape(-1, 3)
    value = intensity(distribution, local)
    weight = value * np.sin(polar).ravel()
    side = 1.0 if weight[local[:, 2] < 0.0].sum() >= weight[local[:, 2] > 0.0].sum() else -1.0
    # Wide enough for what gives a tenth of the peak.
    facing = side * -local[:, 2] > np.cos(np.deg2rad(60.0))
    bright = facing & (value > 0.1 * value[facing].max(initial=0.0))
    spread = np.arccos(np.clip(side * -local[bright, 2], -1.0, 1.0)).max(initial=np.deg2rad(2.0))
    reach = distance * np.tan(spread)
    axis = rotation @ np.array([0.0, 0.0, -side])
    foot = place + axis * (distance / abs(axis[2]))
    across = reach * (2.0 * (np.arange(ROWS) + 0.5) / ROWS - 1.0)
    x, y = (grid.ravel() for grid in np.meshgrid(across, across))
    flat = np.stack([foot[0] + x, foot[1] + y, np.full(x.shape, foot[2])], axis=1)
    along = distance * (2.0 * (np.arange(ROWS) + 0.5) / ROWS - 1.0)
    y, z = (grid.ravel() for grid in np.meshgrid(along, along))
    wall = np.stack([np.full(y.shape, place[0] - distance), place[1] + y, place[2] + z], axis=1)
    normals = np.repeat([[0.0, 0.0, side], [1.0, 0.0, 0.0]], ROWS * ROWS, axis=0)
    return Planes(np.concatenate([flat, wall]), normals)


def is_inside(file: LuminaireFile, away: np.ndarray) -> np.ndarray:
    """Whether directions (n, 3) in the luminaire's axes lie within the angles of the table."""
    distribution = file.distribution
    azimuth, polar = angles(away, distribution.frame)
    inside = (polar >= distribution.polar[0] - 1e-9) & (polar <= distribution.polar[-1] + 1e-9)
    if len(distribution.azimuth) > 1:
        start, end = distribution.azimuth[0], distribution.azimuth[-1]
        inside &= np.mod(azimuth - start, 2.0 * np.pi) <= end - start + 1e-9
    return inside


def projected(file: LuminaireFile, rotation, away: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Illuminance from a point of type B by Radiance's angles. [lx]"""
    distance = np.linalg.norm(away, axis=1)
    right, up, back = ((away / distance[:, None]) @ rotation).T
    across, over = np.arctan2(right, -back), np.arctan2(up, -back)
    value = intensity_at(file.distribution, over, 0.5 * np.pi + across)
    cosine = -(away * normals).sum(axis=1) / distance
    return value * np.maximum(cosine, 0.0) / distance**2


# ---- judgement ----


def compare(ours: np.ndarray, theirs: np.ndarray, inside: np.ndarray) -> dict:
    """Return relative deviations where either program sees more than `DARK` of the largest illuminance."""
    level = DARK * max(ours.max(), theirs[inside].max(initial=0.0))
    bright = inside & (np.maximum(ours, theirs) > level)
    deviation = ours[bright] / np.maximum(theirs[bright], 1e-30) - 1.0
    size = np.abs(deviation)
    return {
        "points": int(bright.sum()),
        "beyond": int((~inside & (theirs > level)).sum()),
        "max": float(size.max(initial=0.0)),
        "rms": float(np.sqrt(np.mean(size**2))) if len(size) else 0.0,
        "share": float(np.mean(size <= BOUND)) if len(size) else 1.0,
        "deviations": [float(f"{value:.3e}") for value in deviation],
    }


def describe(file: LuminaireFile) -> dict:
    """What a file is, in a few words."""
    return {
        "format": file.format,
        "type": file.photometric_type,
        "symmetry": file.symmetry,
        "grid": [len(file.stored_azimuths), len(file.stored_polars)],
        "has_tilt": file.tilt is not None,
    }


def _reason(file: LuminaireFile, deviation: float) -> str:
    """Return why Radiance differs, as a key of `REASONS`; empty if it does not."""
    if deviation <= BOUND:
        return ""
    if file.photometric_type == "B":
        return "type B"
    first, last = file.stored_azimuths[0], file.stored_azimuths[-1]
    if abs(first - 90.0) < 1e-6 and abs(last - 270.0) < 1e-6:
        return "90 to 270"
    return "pole or seam"


def _is_alike(file: LuminaireFile, answer: radiance.Answer) -> bool:
    """Whether Radiance builds the body that we do: not another shape, and not only its lower face."""
    opening = file.opening
    if opening.shape not in ALIKE[answer.shape]:
        return False
    if opening.shape in {"ellipse", "cylinder", "ellipsoid"} and len(set(_wide(opening))) > 1:
        return False
    if opening.shape in {"rectangle", "ellipse"}:
        return opening.axis == "z"
    return answer.emits_sideways and (opening.shape != "cylinder" or opening.axis == "z")


def _wide(opening: Opening) -> tuple[float, ...]:
    """Sizes of an opening that have to be the same for it to be round. [mm]"""
    sizes = opening.size if opening.shape == "ellipsoid" else opening.size[:2]
    return tuple(round(1e3 * size, 3) for size in sizes)
