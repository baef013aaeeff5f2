"""Points of light: inverse square, cosine, flux, spatial quantities, places far from the origin, a thousand sources."""

import numpy as np

from lumenray.engine.luminaires.distribution import flux
from lumenray.engine.scene.distribution import IntensityDistribution
from lumenray.engine.scene.light import Luminaire, Output, Quantity, SpotLight
from lumenray.engine.scene.sensor import SensorKind

from ..bench import Bench, Finding, Findings
from ..stage import EVEN, candela
from .quadrature import sphere_grid
from .registry import case

HEIGHT = 3.0
"""Of the source above the floor. [m]"""

INTENSITY = 1000.0
"""On the axis. [cd]"""

EXPONENT = 8
"""Of the cosine in the narrow distribution."""

CONE = np.radians(25.0)
"""Half angle of the cone. [rad]"""

STEP = 0.25
"""Of tables of polar angles: linear interpolation of a cosine is within 2.4e-6 of it. [degree]"""

FAR = np.array([1e5, -2e5, 3e4])
"""Where the origin goes in the group of places far away. [m]"""


def power_of_cosine(key: str, exponent: int, position) -> Luminaire:
    """Point that shines down with the intensity ``INTENSITY cos(gamma)^exponent``."""
    polar = np.radians(np.arange(0.0, 90.0 + STEP, STEP))
    intensity = INTENSITY * np.maximum(np.cos(polar), 0.0) ** exponent
    distribution = IntensityDistribution(np.zeros(1), polar, intensity[None])
    place = np.eye(4)
    place[:3, 3] = position
    output = Output(Quantity.LUMINOUS_FLUX, flux(distribution), EVEN)
    return Luminaire(key, key, output, place, distribution)


def turn_about(axis: int, degrees: float) -> np.ndarray:
    """Rotation matrix about a coordinate axis, 0 to 2, counter-clockwise seen from its tip."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, -s, s, c
    return turn


@case(
    "C01",
    "Point source: inverse square and cosine law",
    "direct",
    quick=("C01.iso", "C01.lambert", "C01.tilt", "C01.invsq", "C01.flux", "C01.spatial"),
)
def run_points(bench: Bench) -> Findings:
    """One point in empty space."""
    groups = bench.groups("C01")
    above = (0.0, 0.0, HEIGHT)
    lamp = candela("lamp", above, INTENSITY)
    for key in ("C01.iso", "C01.tilt"):
        if key in groups:
            yield bench.measure_group([lamp], groups[key])
    if group := groups.get("C01.invsq"):
        yield bench.measure_group([candela("lamp", (0.0, 0.0, 0.0), 1.0)], group)
    if group := groups.get("C01.frame"):
        place = turn_about(2, 37.0) @ turn_about(0, 22.0) @ above + FAR
        yield bench.measure_group([candela("lamp", place, INTENSITY)], group)
    if group := groups.get("C01.lambert"):
        yield bench.measure_group([power_of_cosine("lamp", 1, above)], group)
    if group := groups.get("C01.flux"):
        yield _measure_flux(bench, group)
    if group := groups.get("C01.spatial"):
        yield _measure_spatial(bench, group, [lamp])


def _measure_flux(bench: Bench, group) -> Finding:
    """Flux of each kind of source, from illuminances all around it."""
    centre = (0.0, 0.0, 0.0)
    down = np.array([0.0, 0.0, -1.0])
    output = Output(Quantity.LUMINOUS_INTENSITY, INTENSITY, EVEN)
    lamps = (
        candela("lamp", centre, INTENSITY),
        power_of_cosine("lamp", 1, centre),
        power_of_cosine("lamp", EXPONENT, centre),
        SpotLight("lamp", "lamp", output, np.zeros(3), down, CONE),
    )
    # Panels end where an intensity has a kink or a jump: at the horizon and at the edge of the cone.
    towards, weights = sphere_grid((-1.0, -np.cos(CONE), 0.0, 1.0), rings=8, around=4)
    values, errors = [], []
    for lamp, allowed in zip(lamps, group.allowed, strict=True):
        # The errors of single values add up like squares.
        each = allowed / np.sqrt((weights**2).sum())
        made = bench.measure([lamp], towards, -towards, each)
        values.append(weights @ made.values)
        errors.append(np.sqrt(weights**2 @ made.errors**2))
    return Finding(group, np.array(values), np.array(errors))


def _measure_spatial(bench: Bench, group, items) -> Finding:
    """Mean spherical, cylindrical, and semicylindrical illuminances facing three ways."""
    up = (0.0, 0.0, 1.0)
    asked = (
        (SensorKind.SPHERICAL, up),
        (SensorKind.CYLINDRICAL, up),
        (SensorKind.SEMICYLINDRICAL, (-1.0, 0.0, 0.0)),
        (SensorKind.SEMICYLINDRICAL, (-1.0, -1.0, 0.0)),
        (SensorKind.SEMICYLINDRICAL, (1.0, 1.0, 0.0)),
    )
    made = [
        bench.measure(items, position, normal, allowed, kind=kind)
        for (kind, normal), position, allowed in zip(
            asked, group.positions, group.allowed, strict=True
        )
    ]
    return Finding(
        group,
        np.concatenate([one.values for one in made]),
        np.concatenate([one.errors for one in made]),
    )


@case("C28", "One thousand sources", "direct")
def run_thousand(bench: Bench) -> Findings:
    """A field of lamps 40 m by 24 m, none quite in line with the others."""
    groups = bench.groups("C28")
    if group := groups.get("C28.thousand"):
        k = np.arange(1000)
        x = -20.0 + (k % 40) * 40.0 / 39.0 + 0.2 * np.sin(1.7 * k)
        y = -12.0 + k // 40 + 0.2 * np.cos(2.3 * k)
        z = 3.0 + 0.5 * np.sin(0.9 * k)
        places = np.stack([x, y, z], axis=1)
        items = [candela(f"lamp {i}", places[i], 100.0 + 50.0 * (i % 7)) for i in k]
        yield bench.measure_group(items, group)
