"""Emission lines, reflection wavelength by wavelength, colours of metameric samples, a coloured room."""

from collections.abc import Sequence

import numpy as np

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.photometry.colour import chromaticity, cie_lab, colour_difference
from lumenray.engine.photometry.spectra import (
    GRID,
    efficacy,
    evaluate_emission,
    evaluate_reflectance,
    observer,
)
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Output, PointLight, Quantity, SunLight
from lumenray.engine.scene.material import Diffuse
from lumenray.engine.scene.spectrum import Constant, Illuminant, Lines, Spectrum, Tabulated

from ..bench import MARGIN, Bench, Finding, Findings
from ..reference import Group, groups_of
from ..stage import box, material, quad
from .quadrature import plane_grid
from .registry import case
from .replicates import jackknife

SODIUM = 589.3
"""Middle of sodium's doublet. [nm]"""

ILLUMINANTS = ("A", "FL2")


def lines(*wavelengths: float, powers: Sequence[float] | None = None) -> Lines:
    """Emission lines, of equal power unless it is said. [nm]"""
    given = np.ones(len(wavelengths)) if powers is None else np.array(powers, dtype=np.float64)
    return Lines(np.array(wavelengths, dtype=np.float64), given)


def watts(key: str, power: float, spectrum: Spectrum) -> PointLight:
    """Isotropic point at the origin. [W]"""
    return PointLight(key, key, Output(Quantity.RADIANT_FLUX, power, spectrum), np.zeros(3))


# ---- C32 ----


@case(
    "C32",
    "Narrow spectral lines",
    "spectral",
    quick=("C32.lines", "C32.sodium", "C32.xy"),
)
def run_lines(bench: Bench) -> Findings:
    """Lamps of one or two lines in empty space."""
    groups = bench.groups("C32")
    if group := groups.get("C32.sodium"):
        yield _measure_sodium(bench, group)
    if group := groups.get("C32.xy"):
        yield _measure_line_colours(bench, group)
    if group := groups.get("C32.lines"):
        places = [float(label.removesuffix(" nm")) for label in group.labels]
        values = np.array([efficacy(lines(nm)) for nm in places])
        yield Finding(group, values, np.zeros(len(values)))


def _measure_sodium(bench: Bench, group: Group) -> Finding:
    """Illuminance at 3 m, and what it is of the sphere's flux."""
    power, distance = 100.0, 3.0
    sphere = 4.0 * np.pi * distance**2
    place, normal = [[0.0, 0.0, -distance]], [[0.0, 0.0, 1.0]]
    found = []
    for spectrum in (lines(SODIUM), lines(588.995, 589.592, powers=(2.0, 1.0))):
        lamp = watts("lamp", power, spectrum)
        bench.show(group, [lamp], place, normal)
        allowed = (group.allowed[:2] / sphere).min()
        made = bench.measure([lamp], place, normal, allowed)
        found.append((made.values[0], made.errors[0]))
    (single, single_error), (double, double_error) = found
    factors = np.array([sphere, sphere, 1.0, sphere / power])
    return Finding(
        group,
        factors * [single, double, single, single],
        factors * [single_error, double_error, single_error, single_error],
    )


def _measure_line_colours(bench: Bench, group: Group) -> Finding:
    """Chromaticities x, y at 3 m, line by line."""
    values, errors = [], []
    for label in group.labels[::2]:
        lamp = watts("lamp", 1.0, lines(float(label.split()[0])))
        made = bench.measure(
            [lamp], [[0.0, 0.0, -3.0]], [[0.0, 0.0, 1.0]], 1e-3 * efficacy(lamp.output.spectrum),
            colour=True,
        )  # fmt: skip
        values.append(chromaticity(made.tristimulus[0]))
        # At most what the errors of X, Y and Z make together.
        total = made.tristimulus[0].sum()
        errors.append(np.full(2, made.tristimulus_errors[0].sum() / total))
    return Finding(group, np.concatenate(values), np.concatenate(errors))


# ---- cubes ----

SIDE = 4.0
"""Of the cubes, with the lamp in the middle. [m]"""

NODES = 3
"""Gauss-Legendre nodes along a quarter of a face: the mean of the direct illuminance is right to 0.05 %."""


def _lay_quarters() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points on a quarter of each face of a cube, all alike: positions, normals (6, n, 3) and weights (n,)."""
    half = 0.5 * SIDE
    positions, normals = [], []
    for axis in range(3):
        normal, u, v = np.roll(np.eye(3), -axis, axis=0)
        for side in (-half, half):
            points, weights = plane_grid(side * normal, half * u, half * v, NODES)
            positions.append(points)
            normals.append(np.tile(-np.sign(side) * normal, (len(points), 1)))
    return np.array(positions), np.array(normals), weights


def _measure_walls(bench: Bench, items, relative: float, expected: float, **more) -> np.ndarray:
    """Mean tristimulus values over a quarter of each face of a cube, (6, 3), or illuminances, (6, 1). [lx]

    ``relative`` is the largest difference of the mean over all of them that passes, ``expected`` about that mean.
    """
    positions, normals, weights = _lay_quarters()
    # Errors of independent sensors shrink in their mean.
    shrink = np.sqrt((weights**2).sum() / len(positions))
    made = bench.measure(items, positions, normals, relative * expected / shrink, **more)
    given = made.values[:, None] if made.tristimulus is None else made.tristimulus
    return np.einsum("n,qnc->qc", weights, given.reshape(len(positions), len(weights), -1))


def _cube(reflectance: Spectrum) -> list:
    """Closed room of one paint."""
    half = np.full(3, 0.5 * SIDE)
    return [
        material("paint", Diffuse(reflectance)),
        box("room", -half, half, "paint", inwards=True),
    ]


# ---- C33 ----

FURNACE = {450.0: 0.1, 546.1: 0.5, 589.3: 0.9, 650.0: 0.05}
"""Reflectance at each of the lines. [nm, -]"""

FLAT = 2.0
"""Half width within which the paint is flat about a line, as a line is spread over neighbours on a grid of 1 nm. [nm]"""


@case("C33", "Spectral furnace", "spectral", quick=("C33.furnace",))
def run_furnace(bench: Bench) -> Findings:
    """Four lines in a closed cube whose paint has another reflectance for each."""
    for group in bench.groups("C33").values():
        yield _measure_furnace(bench, group)


def _measure_furnace(bench: Bench, group: Group) -> Finding:
    paint = Tabulated(
        np.concatenate([[nm - FLAT, nm + FLAT] for nm in FURNACE]),
        np.repeat(list(FURNACE.values()), 2),
    )
    room = _cube(paint)
    # Chromaticities are ratios of values with errors of their own.
    relative = 0.5 * (group.allowed / group.values).min()
    expected = dict(zip(group.labels, group.values, strict=True))
    values, errors = [], []
    for nm in FURNACE:
        own = lines(nm)
        factor = efficacy(own)
        items = [*room, watts("lamp", 1.0, own)]
        parts = _measure_walls(
            bench, items, relative, factor * expected[f"irradiance {nm:g} nm [W/m2]"]
        )
        value, error = jackknife(lambda mean, f=factor: mean / f, parts)
        values.append(value)
        errors.append(error)
    items = [*room, watts("lamp", float(len(FURNACE)), lines(*FURNACE))]
    bench.show(group, items)
    mean, direct = (
        expected["mean illuminance [lx]"],
        expected["illuminance without reflection [lx]"],
    )
    parts = _measure_walls(bench, items, relative, mean, colour=True)
    first = _measure_walls(bench, items, relative, direct, colour=True, reflections=0)
    for given, make in (
        (parts, lambda xyz: [xyz[1], *chromaticity(xyz)]),
        (first, lambda xyz: [*chromaticity(xyz), xyz[1]]),
    ):
        value, error = jackknife(make, given)
        values.append(value)
        errors.append(error)
    return Finding(group, np.concatenate(values), np.concatenate(errors))


# ---- C34 ----

PIXELS = 8
"""Along each side of the picture of a patch."""

MOST_SAMPLES = 1 << 16
"""Per pixel; a picture that is noisier than the tolerances then is left so, and judged."""

SRGB_TO_XYZ = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)
"""CIE XYZ of linear sRGB. (IEC 61966-2-1)"""


def samples() -> tuple[Tabulated, Tabulated]:
    """Both samples of case C34, which C35 is painted with too."""
    tables = groups_of("C34")["C34.A"].tables
    start, end, step = tables["wavelength_nm"]
    wavelengths = np.arange(start, end + 0.5 * step, step, dtype=np.float64)
    return tuple(Tabulated(wavelengths, np.array(tables[key]), key) for key in ("R1", "R2"))


def in_steps(name: str, wavelengths) -> Lines:
    """Illuminant as the colorimetric sum takes it: all of each step's power at the step's own wavelength.

    Between the steps of FL2 lie the wavelengths of its mercury lines, and a metameric pair tells a table with lines in
    between from the sum: b* of the second sample differs by 0.17.
    """
    return Lines(wavelengths, evaluate_emission(Illuminant(name), wavelengths), name)


@case("C34", "Metameric pair under A and FL2", "spectral", quick=("C34.FL2",))
def run_metamers(bench: Bench) -> Findings:
    """White and two samples side by side in parallel light, seen from above."""
    groups = bench.groups("C34")
    pictures = {}
    for name in ILLUMINANTS:
        wanted = [groups[key] for key in (f"C34.{name}", "C34.lum") if key in groups]
        if wanted:
            pictures[name] = _photograph(bench, name, wanted)
        if group := groups.get(f"C34.{name}"):
            yield Finding(group, *jackknife(_colours, pictures[name]))
    if group := groups.get("C34.lum"):
        found = [jackknife(_appearance, pictures[name]) for name in ILLUMINANTS]
        yield Finding(group, *(np.concatenate(column) for column in zip(*found, strict=True)))
    if group := groups.get("C34.rgb"):
        values = np.concatenate([_three_channel_errors(name) for name in ILLUMINANTS])
        yield Finding(group, values, np.zeros(len(values)))


def _photograph(bench: Bench, name: str, groups: Sequence[Group]) -> np.ndarray:
    """Tristimulus values of white and both samples, pixel by pixel, (k, 3, 3). [cd/m2]"""
    first, second = samples()
    paints = {"white": Constant(1.0), "one": first, "two": second}
    light = Output(Quantity.ILLUMINANCE, 1000.0, in_steps(name, first.wavelengths))
    items = [SunLight("sun", "sun", light, np.array([0.0, 0.0, -1.0]))]
    for x, (key, paint) in enumerate(paints.items()):
        items.append(material(key, Diffuse(paint)))
        items.append(quad(f"{key} patch", (x, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), key))
    bench.show(groups[0], items)
    count = 1024
    while True:
        # Pictures of one seed are made of the same wavelengths, so that samples differ by what they are only.
        pictures = [
            bench.engine.render(items, _camera(x + 0.5), StopRule(samples=count), bench.seed)
            for x in range(len(paints))
        ]
        pixels = np.stack(
            [picture.tristimulus.reshape(-1, 3).astype(np.float64) for picture in pictures], axis=1
        )
        if count >= MOST_SAMPLES or all(_is_quiet(group, name, pixels) for group in groups):
            return pixels
        count *= 4


def _camera(x: float) -> Camera:
    """Camera over the middle of a patch, from which it sees nothing else."""
    frame = np.eye(4)
    frame[:3, 3] = (x, 0.5, 1.0)
    return Camera(frame, Projection.ORTHOGRAPHIC, PIXELS, PIXELS, 0.5, 0.5)


def _is_quiet(group: Group, name: str, pixels: np.ndarray) -> bool:
    """Tell whether the errors of what a group wants of a picture are a third of what is allowed."""
    make, allowed = _colours, group.allowed
    if group.id == "C34.lum":
        make, allowed = _appearance, allowed[[label.startswith(name) for label in group.labels]]
    _, errors = jackknife(make, pixels)
    return bool((MARGIN * errors <= allowed).all())


def _colours(patches: np.ndarray) -> np.ndarray:
    """Values of C34.A and C34.FL2: tristimulus values to a white of Y = 100, L*a*b*, colour difference. (16,)"""
    xyz = patches * (100.0 / patches[0, 1])
    lab = cie_lab(xyz[1:], xyz[0])
    return np.concatenate([xyz.ravel(), lab.ravel(), [colour_difference(*lab)]])


def _appearance(patches: np.ndarray) -> np.ndarray:
    """Values of C34.lum under one illuminant: x, y, luminance of both samples. (6,)"""
    return np.concatenate([[*chromaticity(xyz), xyz[1]] for xyz in patches[1:]])


def _three_channel_errors(name: str) -> np.ndarray:
    """Colour differences that a product of three channels makes for both samples, (2,). [-]"""
    first, second = samples()
    functions = observer()[np.isin(GRID, first.wavelengths)]
    light = evaluate_emission(Illuminant(name), first.wavelengths)
    white = light @ functions
    to_linear = np.linalg.inv(SRGB_TO_XYZ)
    even = to_linear @ functions.sum(axis=0)
    found = []
    for sample in (first, second):
        values = evaluate_reflectance(sample, first.wavelengths)
        reduced = (to_linear @ (values @ functions)) / even
        product = SRGB_TO_XYZ @ ((to_linear @ white) * reduced)
        labs = cie_lab([product, (light * values) @ functions], white)
        found.append(colour_difference(*labs))
    return np.array(found)


# ---- C35 ----


@case("C35", "Coloured room", "spectral")
def run_room(bench: Bench) -> Findings:
    """A closed cube of a coloured paint under two illuminants."""
    for group in bench.groups("C35").values():
        yield _measure_room(bench, group)


def _measure_room(bench: Bench, group: Group) -> Finding:
    room = _cube(samples()[0])
    relative = 0.5 * (group.allowed / group.values).min()
    # An isotropic point in the middle of a cube gives each face a sixth of its flux.
    direct = 1000.0 / (6.0 * SIDE**2)
    values, errors = [], []
    for name in ILLUMINANTS:
        output = Output(Quantity.LUMINOUS_FLUX, 1000.0, Illuminant(name))
        items = [*room, PointLight("lamp", "lamp", output, np.zeros(3))]
        bench.show(group, items)
        parts = [
            _measure_walls(bench, items, relative, direct, colour=True, reflections=most)
            for most in (None, 0)
        ]
        value, error = jackknife(
            lambda both: [*chromaticity(both[0]), both[0, 1] / both[1, 1]], np.stack(parts, axis=1)
        )
        values.append(value)
        errors.append(error)
    return Finding(group, np.concatenate(values), np.concatenate(errors))
