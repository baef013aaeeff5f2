"""Noise of a next event: what choosing lights and points of openings adds to the noise of the receiver's own place.

The mean illuminance of a patch is estimated from random receivers. With the exact illuminance at every receiver the
variance is that of the receivers alone, and no estimator that draws them at random has less: this is the ideal. A next
event draws a luminaire and a point of its opening besides. Two such estimates at the same receiver have as covariance
exactly the ideal's variance, whatever the distribution, so the ratio needs no second program.
"""

from collections.abc import Callable
from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...engine.luminaires.coordinates import directions
from ...engine.scene.distribution import IntensityDistribution, Opening
from ...engine.scene.light import Luminaire, Output, Quantity
from ...engine.scene.scene import Scene, SceneDelta
from ...engine.transport import backend

HEIGHT = 3.0
"""Of the luminaires over the patch. [m]"""

LANES = 1 << 18
"""Receivers of one group."""

GROUPS = 8
"""Independent groups, from which the error of the ratio follows."""

BOUND = 1.1
"""Largest ratio to the ideal that is asked for."""

OPENINGS = {
    "point": Opening(),
    "disk 0.1 m": Opening("ellipse", (0.1, 0.1, 0.0)),
    "disk 0.6 m": Opening("ellipse", (0.6, 0.6, 0.0)),
}

WIDE = 4.0
"""Side of the patch that is much larger than a beam. [m]"""


@dataclass(frozen=True)
class Case:
    """Luminaires over a square patch around the origin, of a ``side`` [m]."""

    title: str
    opening: str
    patch: str
    side: float
    lights: Callable[[], list[Luminaire]]


def run(say=None) -> list[dict]:
    """Measure all cases.

    Returns
    -------
    list of dict    ``title``, ``opening``, ``patch``, ``side``, ``ratio`` of variances to the ideal, ``error`` of the ratio,
        ``ideal``: relative variance of one sample of the ideal.
    """
    say = say or (lambda _line: None)
    rows = []
    for case in cases():
        ratio, error, ideal = measure(case.lights(), case.side, LANES, GROUPS)
        rows.append(
            {
                "title": case.title,
                "opening": case.opening,
                "patch": case.patch,
                "side": case.side,
                "ratio": ratio,
                "error": error,
                "ideal": ideal,
            }
        )
        say(f"{case.title}, {case.opening}, {case.patch}: {ratio:.3f} ± {error:.3f} of the ideal")
    return rows


def cases() -> list[Case]:
    """Beams of 2 and 6 degrees and a spiky distribution, each from three openings; several luminaires at once."""
    made = []
    for width in (2.0, 6.0):
        for name, opening in OPENINGS.items():
            spot = 2.0 * HEIGHT * np.tan(np.deg2rad(0.5 * width)) + opening.size[0]
            for patch, side in (("as wide as the beam", spot), ("much wider", WIDE)):
                made.append(_one(f"beam of {width:g}°", beam(width), name, patch, side))
    made += [
        _one("24 spikes of 1.5°", spikes(24, 1.5), name, "much wider", WIDE) for name in OPENINGS
    ]
    for name in OPENINGS:
        made.append(
            Case("8 luminaires, 6° and spikes", name, "all of them", 6.0, lambda n=name: several(n))
        )
    return made


def _one(title, distribution, name, patch, side) -> Case:
    def lights():
        return [hung("only", distribution, OPENINGS[name], (0.0, 0.0, HEIGHT), (0.0, 0.0, 0.0))]

    return Case(title, name, patch, float(side), lights)


def measure(lights: list[Luminaire], side: float, lanes: int, groups: int):
    """Variance of one-sample next events at random receivers of a patch, relative to the ideal.

    Returns
    -------
    float, float, float    Ratio, its standard error, and the ideal's variance over the squared mean.
    """
    backend.start(spectral=False)
    from ...engine.requirements.plan import make_plan
    from ...engine.transport.compiled.compile import CompiledScene
    from ...engine.transport.paths import gather
    from ...engine.transport.paths.light_learning import learn
    from ...engine.transport.paths.next_event import sample_emitter

    scene = Scene()
    scene.apply(SceneDelta(changed=tuple(lights)))
    compiled = CompiledScene(scene, make_plan(scene, transport="mono"))
    places = np.zeros((4096, 3))
    places[:, :2] = (np.random.default_rng(5).random((4096, 2)) - 0.5) * side
    learn(compiled, compiled.local(places), np.tile(np.float32([0, 0, 1]), (4096, 1)), None)
    shift = compiled.local(np.zeros((1, 3)))[0]
    up = mi.Normal3f(0.0, 0.0, 1.0)
    found = []
    for group in range(groups):
        stream = mi.PCG32(size=lanes, initstate=group + 1)

        def draw(stream=stream):
            return mi.Point2f(stream.next_float32(), stream.next_float32())

        place = draw()
        point = mi.Point3f(*(dr.opaque(mi.Float, float(x)) for x in shift))
        point += mi.Point3f((place.x - 0.5) * side, (place.y - 0.5) * side, 0.0)
        si = gather.receiver(point, up, up, None)
        pair = []
        for _ in range(2):
            ds, value = sample_emitter(compiled, si, draw(), mi.Bool(True))
            pair.append(gather.photometric(None, value, None) * dr.maximum(dr.dot(ds.d, up), 0.0))
        dr.eval(pair)
        first, second = (np.array(values, dtype=np.float64) for values in pair)
        # Sums of which variance, covariance and mean follow, for all groups but one as well.
        found.append(
            [first.sum() + second.sum(), (first**2 + second**2).sum(), (first * second).sum()]
        )
    found = np.array(found)
    total = found.sum(axis=0)
    ratio, ideal = _ratio(total, lanes * groups)
    without = [_ratio(total - row, lanes * (groups - 1))[0] for row in found]
    error = np.sqrt((groups - 1) * np.var(without))
    return float(ratio), float(error), float(ideal)


def _ratio(sums, count) -> tuple[float, float]:
    """Variance over the ideal's, and the ideal's over the squared mean."""
    mean = 0.5 * sums[0] / count
    variance = 0.5 * sums[1] / count - mean**2
    ideal = sums[2] / count - mean**2
    return variance / ideal, ideal / mean**2


# ---- luminaires ----


def beam(width: float) -> IntensityDistribution:
    """Gaussian beam with a full width between half values. [degree]"""
    polar = np.arange(0.0, 3.0 * width + 1e-9, width / 40.0)
    values = np.exp(-4.0 * np.log(2.0) * (polar / width) ** 2)
    values[-1] = 0.0
    return IntensityDistribution(np.zeros(1), np.deg2rad(polar), values[None])


def spikes(count: int, width: float) -> IntensityDistribution:
    """Narrow beams in random directions within 40 degrees of the axis, on a dim ground; width in degrees."""
    rng = np.random.default_rng(11)
    axes = directions(
        2.0 * np.pi * rng.random(count),
        np.arccos(1.0 - (1.0 - np.cos(np.deg2rad(40.0))) * rng.random(count)),
    )
    azimuth, polar = np.deg2rad(np.arange(0.0, 360.5)), np.deg2rad(np.arange(0.0, 90.1, 0.25))
    grid = directions(azimuth[:, None], polar[None, :])
    values = np.full(grid.shape[:2], 0.01)
    for axis in axes:
        chord = np.linalg.norm(grid - axis, axis=-1)
        values += np.exp(-4.0 * np.log(2.0) * (chord / np.deg2rad(width)) ** 2)
    values[-1] = values[0]
    values[:, 0] = values[:, 0].mean()
    return IntensityDistribution(azimuth, polar, values)


def several(opening: str) -> list[Luminaire]:
    """Eight luminaires in two rows, aimed at different places of the floor."""
    rng = np.random.default_rng(3)
    narrow, spiky = beam(6.0), spikes(24, 1.5)
    lights = []
    for number in range(8):
        place = (-2.25 + 1.5 * (number % 4), -1.0 + 2.0 * (number // 4), HEIGHT)
        target = (*(5.0 * (rng.random(2) - 0.5)), 0.0)
        distribution = spiky if number % 2 else narrow
        lights.append(hung(f"number {number}", distribution, OPENINGS[opening], place, target))
    return lights


def hung(name: str, distribution, opening: Opening, place, target) -> Luminaire:
    """Luminaire at a place, aimed at another one."""
    axis = np.subtract(target, place)
    axis = axis / np.linalg.norm(axis)
    side = np.cross(axis, (0.0, 1.0, 0.0))
    side /= np.linalg.norm(side)
    frame = np.eye(4)
    # Light leaves along -z.
    frame[:3, :3] = np.stack([side, np.cross(-axis, side), -axis], axis=1)
    frame[:3, 3] = place
    amount = Output(Quantity.LUMINOUS_FLUX, 1000.0)
    return Luminaire(f"light:{name}", name, amount, frame, distribution, opening)
