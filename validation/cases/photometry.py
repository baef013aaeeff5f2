"""Photometric files: planes of types C, B and A, every symmetry, flux, turned luminaires."""

import numpy as np

from lumenray.engine.luminaires.coordinates import FRAMES, angles
from lumenray.engine.luminaires.distribution import flux, intensity_at
from lumenray.engine.luminaires.formats.reader import read_luminaire
from lumenray.engine.luminaires.formats.record import LuminaireFile
from lumenray.engine.scene.light import Luminaire, Output, Quantity

from ..bench import Bench, Finding, Findings
from ..reference import FOLDER
from ..stage import EVEN
from .direct_points import turn_about
from .registry import case

FILES = FOLDER / "ies"

AIM = np.stack(
    [
        (0.0, -1.0, 0.0),
        (np.sin(np.radians(30.0)), 0.0, np.cos(np.radians(30.0))),
        (-np.cos(np.radians(30.0)), 0.0, np.sin(np.radians(30.0))),
    ],
    axis=1,
)
"""Axes of the floodlight as columns: right, up, and against the beam, as luminaires shine along their -z."""

MAST = np.array([0.0, 0.0, 8.0])
"""Place of the floodlight. [m]"""


def read(name: str) -> LuminaireFile:
    """Read one of the photometric files."""
    return read_luminaire(FILES / f"{name}.ies")


def luminaire(file: LuminaireFile, position, turn=None) -> Luminaire:
    """Luminaire of a file with its own flux; ``turn`` (3, 3) has its axes as columns."""
    place = np.eye(4)
    place[:3, 3] = position
    if turn is not None:
        place[:3, :3] = turn
    output = Output(Quantity.LUMINOUS_FLUX, flux(file.distribution), EVEN)
    return Luminaire("lamp", "lamp", output, place, file.distribution, file.opening)


@case(
    "C02",
    "Goniometric source, type C, asymmetric (0-360)",
    "photometry",
    quick=("C02.level", "C02.tilted", "C02.flux"),
)
def run_asymmetric(bench: Bench) -> Findings:
    """A distribution without any symmetry, level and turned."""
    groups = bench.groups("C02")
    file = read("C02_asym_360")
    place = (0.0, 0.0, 3.0)
    if group := groups.get("C02.level"):
        yield bench.measure_group([luminaire(file, place)], group)
    if group := groups.get("C02.tilted"):
        turn = turn_about(2, 40.0) @ turn_about(0, 30.0)
        yield bench.measure_group([luminaire(file, place, turn)], group)
    if group := groups.get("C02.flux"):
        yield Finding(group, np.array([flux(file.distribution)]), np.zeros(1))


SYMMETRIES = {
    "C03.quad": ("C03_quad_0_90", "C03_quad_as_0_180", "C03_quad_as_0_360", "C03_quad_as_90_270"),
    "C03.bilateral": ("C03_bilat_0_180", "C03_bilat_as_0_360"),
    "C03.bilateral90": ("C03_bilat_90_270",),
    "C03.axial": ("C03_axial_0",),
    "C03.updown": ("C03_axial_updown",),
}
"""Files of each group; those of one group say the same in different ways."""


@case(
    "C03",
    "Goniometric source, symmetry classes",
    "photometry",
    quick=tuple(SYMMETRIES),
)
def run_symmetries(bench: Bench) -> Findings:
    """Files that store a part of the planes."""
    for key, group in bench.groups("C03").items():
        place = (0.0, 0.0, 2.5 if key == "C03.updown" else 3.0)
        found = [
            bench.measure_group([luminaire(read(name), place)], group) for name in SYMMETRIES[key]
        ]
        values, errors = (
            np.array([getattr(one, name) for one in found]) for name in ("values", "errors")
        )
        # Of files that must give the same, the one that is farthest off speaks at each point.
        worst = np.abs(values - group.values).argmax(axis=0), np.arange(len(group.values))
        yield Finding(group, values[worst], errors[worst])


@case(
    "C04",
    "Type B and type A goniometry",
    "photometry",
    quick=("C04.B", "C04.A", "C04.angles", "C04.flux"),
)
def run_floodlight(bench: Bench) -> Findings:
    """A floodlight on a mast."""
    groups = bench.groups("C04")
    files = {"B": read("C04_typeB"), "A": read("C04_typeA")}
    for kind in ("B", "A"):
        if group := groups.get(f"C04.{kind}"):
            yield bench.measure_group([luminaire(files[kind], MAST, AIM)], group)
    if group := groups.get("C04.Bproj"):
        values = _projected_illuminance(files["B"], group.positions, group.normals)
        yield Finding(group, values, np.zeros(len(values)))
    if group := groups.get("C04.flux"):
        values = np.array([flux(files[kind].distribution) for kind in ("B", "A")])
        yield Finding(group, values, np.zeros(2))
    if group := groups.get("C04.angles"):
        targets = np.array([(10.0, 4.0, 0.0), (10.0, -4.0, 0.0), (14.0, 8.0, 0.0), (14.0, -8.0, 0.0)])  # fmt: skip
        yield Finding(group, _goniometer_angles(targets), np.zeros(len(group.values)))


def _goniometer_angles(targets) -> np.ndarray:
    """H and V of types B and A towards each target, in this order. [degree]"""
    towards = (targets - MAST) @ AIM
    columns = []
    for kind in ("B", "A"):
        azimuth, polar = angles(towards, FRAMES[kind])
        around = np.degrees(np.angle(np.exp(1j * azimuth)))
        along = np.degrees(polar) - 90.0
        # Type B turns V about its horizontal axis, type A turns H about its vertical one.
        columns += [along, around] if kind == "B" else [around, along]
    return np.stack(columns, axis=1).ravel()


def _projected_illuminance(file: LuminaireFile, positions, normals) -> np.ndarray:
    """Illuminance if the table is entered with both angles in projection, which is Radiance's reading and not ours."""
    towards = positions - MAST
    right, up, beam = (towards @ AIM * (1.0, 1.0, -1.0)).T
    polar = np.arctan2(right, beam) + 0.5 * np.pi
    intensity = intensity_at(file.distribution, np.arctan2(up, beam), polar)
    distance = np.linalg.norm(towards, axis=1)
    return intensity * -(towards * normals).sum(axis=1) / distance**3
