"""Panes of glass and a sheet that scatters: what passes, at which angle, and of which colour."""

import numpy as np

from lumenray.engine.scene.light import Output, Quantity, SunLight, UniformWorld
from lumenray.engine.scene.material import Cauchy, Dielectric, Diffuse, TabulatedPane, ThinGlass
from lumenray.engine.scene.spectrum import Constant, Illuminant

from ..bench import MARGIN, Bench, CannotStateError, Finding, Findings
from ..reference import Group
from ..stage import BLACK, candela, material, quad
from .registry import case

IOR = 1.52
"""Refractive index of the panes. [-]"""

INTERNAL = 0.95841544
"""Transmittance of the glass body at normal incidence that gives a pane of 0.88. [-]"""

CLEAR = ThinGlass(IOR, Constant(1.0))
PANE = ThinGlass(IOR, Constant(INTERNAL))
BOUNDARY = Dielectric(Cauchy(IOR))


@case(
    "C07",
    "Clear glass",
    "glass",
    quick=("C07.beam", "C07.schlick", "C07.interface", "C07.slab88", "C07.slab88R", "C07.hemi"),
)
def run_glass(bench: Bench) -> Findings:
    """Panes in a beam, on a goniometer, in even light, and their colour."""
    groups = bench.groups("C07")
    if group := groups.get("C07.beam"):
        yield _measure_beam(bench, group)
    if group := groups.get("C07.schlick"):
        yield _measure_schlick(bench, group)
    for key, surface, quantity in (
        ("C07.interface", BOUNDARY, "transmittance"),
        ("C07.slab", CLEAR, "transmittance"),
        ("C07.slab88", PANE, "transmittance"),
        ("C07.slab88R", PANE, "reflectance"),
    ):
        if group := groups.get(key):
            yield Finding(group, *probe(bench, surface, angles_of(group), group.allowed, quantity))
    if group := groups.get("C07.hemi"):
        made = [
            probe(bench, surface, None, group.allowed[[place]])
            for place, surface in enumerate((CLEAR, PANE, BOUNDARY))
        ]
        values, errors = np.concatenate(made, axis=1)
        yield Finding(group, values, errors)
    if group := groups.get("C07.nodisp"):
        yield _measure_colour(bench, group)


def angles_of(group: Group) -> np.ndarray:
    """Angles of incidence that a group's labels state, (n,). [deg]"""
    return np.array([float(label.removesuffix("deg")) for label in group.labels])


def probe(bench: Bench, surface, angles, allowed, quantity="transmittance"):
    """Probe a surface until every standard error is below a third of what is allowed.

    Returns
    -------
    ((n,) array, (n,) array)    Values and standard errors. [-]
    """
    samples = 1 << 16
    while True:
        made = bench.engine.session.probe(surface, angles, samples, bench.seed)
        values, errors = getattr(made, quantity), getattr(made, f"{quantity}_error")
        if (errors <= allowed / MARGIN).all() or samples >= 1 << 26:
            return values, errors
        samples *= 4


def _measure_beam(bench: Bench, group: Group) -> Finding:
    """A point source behind a large pane, seen from 20 m at several angles."""
    pane = quad("pane", (-20.0, -20.0, 0.0), (40.0, 0.0, 0.0), (0.0, 40.0, 0.0), "glass")
    glass = material("glass", PANE)
    values, errors = np.zeros((2, len(group.values)))
    for place, sensor in enumerate(group.positions):
        items = [pane, glass, candela("lamp", -sensor, 1000.0)]
        made = bench.measure(items, sensor, group.normals[place], group.allowed[place])
        values[place], errors[place] = made.values[0], made.errors[0]
        bench.show(group, items)
    return Finding(group, values, errors)


def _measure_schlick(bench: Bench, group: Group) -> Finding:
    """Panes known by a table, each turned to its angle, between one sun and a sensor that faces it."""
    table = np.linspace(0.0, 90.0, 361)
    single = 0.04 + 0.96 * (1.0 - np.cos(np.radians(table))) ** 5
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1000.0), np.array([0.0, 0.0, -1.0]))
    items = [material("sheet", TabulatedPane(table, 1.0 - single, single)), sun]
    sensors = np.zeros((len(group.values), 3))
    for place, angle in enumerate(np.radians(angles_of(group))):
        # They turn about x and stand in a row along it, so that none mirrors light to another's sensor.
        edge = np.array([0.0, np.cos(angle), np.sin(angle)])
        centre = np.array([2.0 * place, 0.0, 1.0])
        corner = centre - 0.5 * edge - (0.5, 0.0, 0.0)
        items.append(quad(f"pane {place}", corner, (1.0, 0.0, 0.0), edge, "sheet"))
        sensors[place] = centre - (0.0, 0.0, 1.0)
    up = np.tile([0.0, 0.0, 1.0], (len(sensors), 1))
    made = bench.measure(items, sensors, up, 1000.0 * group.allowed)
    return Finding(group, made.values / 1000.0, made.errors / 1000.0)


def _measure_colour(bench: Bench, group: Group) -> Finding:
    """Chromaticity of daylight behind a grey pane less that without it, at 0 and 60 degrees."""
    glass = material("glass", PANE)
    pane = quad("pane", (-20.0, -20.0, 0.0), (40.0, 0.0, 0.0), (0.0, 40.0, 0.0), "glass")
    changes, errors = [], []
    for angle in np.radians([0.0, 60.0]):
        sensor = 10.0 * np.array([np.sin(angle), 0.0, -np.cos(angle)])
        lamp = candela("lamp", -sensor, 1000.0, Illuminant("D65"))
        behind = _chromaticity(bench, [glass, pane, lamp], sensor, group.allowed[0])
        alone = _chromaticity(bench, [lamp], sensor, group.allowed[0])
        changes.append(behind[0] - alone[0])
        errors.append(np.hypot(behind[1], alone[1]))
    return Finding(group, np.concatenate(changes), np.concatenate(errors))


def _chromaticity(bench: Bench, items, sensor, allowed: float):
    """Chromaticity (2,) at a sensor that faces the origin, with standard errors."""
    # A tenth of what is allowed for chromaticities, relative to the illuminance of at most 2.5 lx.
    made = bench.measure(items, sensor, -sensor, 0.1 * allowed, colour=True)
    if made.tristimulus is None:
        raise CannotStateError("the case asks for colours at points")
    values, errors = made.tristimulus[0], made.tristimulus_errors[0]
    total = values.sum()
    share = values[:2] / total
    # d(X / S) = (dX - (X / S) dS) / S, the three being independent at worst.
    slopes = (np.eye(3)[:2] - share[:, None]) / total
    return share, np.sqrt((slopes**2) @ errors**2)


@case("C31", "Diffusely transmitting panel", "glass", quick=("C31.panel",))
def run_panel(bench: Bench) -> Findings:
    """A sheet that scatters what passes it, under an even sky."""
    if group := bench.groups("C31").get("C31.panel"):
        items = [
            UniformWorld(1000.0),
            material("sheet", Diffuse(Constant(0.0), Constant(0.4))),
            quad("panel", (-1.0, -1.0, 2.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0), "sheet"),
            BLACK,
            quad("ground", (-50.0, -50.0, 0.0), (100.0, 0.0, 0.0), (0.0, 100.0, 0.0), BLACK.id),
        ]
        yield bench.measure_group(items, group)
