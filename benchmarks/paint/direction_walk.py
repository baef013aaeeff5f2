"""Monte Carlo of one direction of light and one of the eye at a time, compiled as Mitsuba's integrators are.

Mitsuba's media scatter by phase functions of fixed shapes: none knows flakes with Gaussian slopes that reflect by the angle
at which they are met, so this walk stands for such an integrator. It is written in Dr.Jit, by which Mitsuba compiles its
own, runs on all lanes of all cores, and has no scene to intersect. As in a path tracer light goes in from one direction, and
at each collision what reaches the eye at once is counted (next-event estimation).
"""

import time
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import drjit as dr
import numpy as np
from drjit.llvm import PCG32, Bool, Float, UInt32, UInt64

from ...engine.errors import SceneError
from ...engine.paint.composition import Mirror, Paint
from ...engine.paint.flake_optics import find_shares
from ...engine.paint.fresnel import face_reflectance
from ...engine.paint.matter import find_matter
from ...engine.paint.orientation import interception

COSINES = 512
"""Cosines at which tables of flakes are kept."""

PHASES = 2048
"""Cosines at which phase functions are kept."""

MOST_EVENTS = 2000

ROULETTE = 0.1
"""Weight below which few photons go on, for all."""


@dataclass(frozen=True, eq=False)
class Estimates:
    """What walks say of pairs of directions.

    Parameters
    ----------
    values : (n,) float64 array    BRDF. [1/sr]
    variances : (n,) float64 array    Of a single walk's. [1/sr2]
    walks : int    Of each pair.
    seconds_each : float    Processors' seconds of a walk.
    """

    values: np.ndarray
    variances: np.ndarray
    walks: int
    seconds_each: float


def estimate(paint: Paint, wavelength: float, wi, wo, walks: int, seed: int = 0) -> Estimates:
    """Estimate a BRDF without polarisation.

    Parameters
    ----------
    paint : Paint    Its layers have one index, its substrate is matt, its surface smooth.
    wavelength : float    [nm]
    wi, wo : (n, 3) arrays    Directions, outside.
    walks : int    Of each pair.

    Raises
    ------
    SceneError    Its layers' indices differ.
    """
    wi, wo = np.asarray(wi, np.float64), np.asarray(wo, np.float64)
    matter = _Matter(paint, wavelength, wo)
    # The first compiles.
    _run(matter, wi, wo, 1, seed)
    start = time.process_time()
    sums, squares = _run(matter, wi, wo, walks, seed + 1)
    seconds = time.process_time() - start
    index = matter.index
    level = [np.hypot(each[:, 0], each[:, 1]) for each in (wi, wo)]
    scale = 1.0 / (index**2 * np.sqrt(1.0 - (level[1] / index) ** 2))
    for each in level:
        scale = scale * (1.0 - face_reflectance(each, 1.0, index))
    mean = sums / walks
    variance = (squares / walks - mean**2) * walks / max(walks - 1, 1)
    return Estimates(mean * scale, variance * scale**2, walks, seconds / (walks * len(wi)))


class _Flakes(NamedTuple):
    """Flakes of a layer: by the cosine, how often they are met [1/um], what they reflect and let pass."""

    layer: int
    area: float
    slope: float
    met: Float
    back: Float
    passed: Float


class _Grains(NamedTuple):
    """Grains of a layer: rates [1/um], the phase function, and its cosines by the share of light below them."""

    layer: int
    extinction: float
    scattering: float
    phase: Float
    inverse: Float


class _Matter:
    """A paint at one wavelength as tables."""

    def __init__(self, paint: Paint, wavelength: float, wo: np.ndarray):
        wavelengths = np.array([wavelength])
        layers = [find_matter(layer, wavelengths) for layer in paint.layers]
        self.index = float(layers[0].index[0])
        if any(abs(each.index[0] - self.index) > 1e-9 for each in layers):
            raise SceneError("walks by direction are for layers of one index")
        self.thicknesses = [each.thickness for each in layers]
        self.substrate = float(paint.substrate.at(wavelengths)[0])
        self.absorption = [float(each.absorption[0]) for each in layers]
        level = np.hypot(wo[:, 0], wo[:, 1]) / self.index
        self.upright = np.sqrt(1.0 - level**2)
        # Optical depth towards the eye above each layer, and the rate in it.
        rates = [each.extinction(self.upright)[0] / self.upright for each in layers]
        self.rates = [Float(each) for each in rates]
        self.above, depth = [], np.zeros(len(wo))
        for rate, thickness in zip(rates, self.thicknesses, strict=True):
            self.above.append(Float(depth))
            depth = depth + rate * thickness
        self.whole = Float(depth)
        cosines = np.linspace(0.0, 1.0, COSINES)
        self.flakes, self.grains = [], []
        for number, layer in enumerate(layers):
            for each in layer.flakes:
                back, passed = _shares(each.flakes.optics, self.index, wavelengths, cosines)
                met = each.area * interception(cosines, each.slope, 1)[:, 0]
                tables = (Float(table) for table in (met, back, passed))
                self.flakes.append(_Flakes(number, each.area, each.slope, *tables))
            for each in layer.pigments:
                rates_of = float(each.extinction[0]), float(each.scattering[0])
                self.grains.append(_Grains(number, *rates_of, *_phase(each.series[0])))


def _shares(optics, index: float, wavelengths, cosines):
    if isinstance(optics, Mirror):
        return tuple(
            np.full(len(cosines), each.at(wavelengths)[0])
            for each in (optics.reflectance, optics.transmittance)
        )
    across, within, _, passed = find_shares(
        optics, np.array([index]), wavelengths, np.maximum(cosines, 1e-6)
    )
    return 0.5 * (across + within)[0], passed[0]


def _phase(series: np.ndarray) -> tuple[Float, Float]:
    """A phase function by the cosine, and cosines by the share of light below them."""
    cosines = np.linspace(-1.0, 1.0, PHASES)
    terms = np.arange(len(series))
    phase = np.polynomial.legendre.legval(cosines, series * (2 * terms + 1))
    phase = np.maximum(phase, 0.0)
    share = np.concatenate([[0.0], np.cumsum(0.5 * (phase[1:] + phase[:-1]))])
    inverse = np.interp(np.linspace(0.0, 1.0, PHASES), share / share[-1], cosines)
    return Float(phase), Float(inverse)


def _read(table: Float, place: Float, count: int) -> Float:
    """A table at a share of its length, linear."""
    place = dr.clip(place, 0.0, 1.0) * (count - 1)
    low = dr.minimum(UInt32(place), count - 2)
    first, last = dr.gather(Float, table, low), dr.gather(Float, table, low + 1)
    return dr.lerp(first, last, place - Float(low))


def _run(matter: _Matter, wi, wo, walks: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Sums of what walks of each pair find, and of the squares. Two (n,) arrays"""
    pairs = len(wi)
    lane = dr.arange(UInt32, pairs * walks)
    pair = lane // walks
    sums, squares = dr.zeros(Float, pairs), dr.zeros(Float, pairs)
    into = [dr.gather(Float, Float(each / matter.index), pair) for each in -wi.T[:2]]
    eye = [dr.gather(Float, Float(each / matter.index), pair) for each in wo.T[:2]]
    eye.append(dr.gather(Float, Float(matter.upright), pair))
    down = -dr.sqrt(1.0 - into[0] ** 2 - into[1] ** 2)
    found = _walk(matter, pair, (*into, down), eye, PCG32(pairs * walks, UInt64(seed)))
    dr.scatter_reduce(dr.ReduceOp.Add, sums, found, pair)
    dr.scatter_reduce(dr.ReduceOp.Add, squares, found * found, pair)
    dr.eval(sums, squares)
    return sums.numpy().astype(np.float64), squares.numpy().astype(np.float64)


def _walk(matter: _Matter, pair: UInt32, direction, eye, rng: PCG32) -> Float:
    """What reaches the eye of photons of unit power that have entered, by solid angle inside."""
    count = dr.width(pair)
    zero = dr.zeros(Float, count)
    photon = _Photon(
        *direction, zero, dr.zeros(UInt32, count), zero + 1.0, zero, dr.full(Bool, True, count), rng
    )

    def go_on(photon: _Photon, events: UInt32):
        _step(matter, pair, eye, photon)
        events += 1
        return photon, events

    photon, _ = dr.while_loop(
        (photon, dr.zeros(UInt32, count)),
        lambda photon, events: photon.active & (events < MOST_EVENTS),
        go_on,
    )
    return photon.found


class _Photon:
    """Photons under way: direction, depth and layer, weight, what of them the eye has seen, whether they go on."""

    DRJIT_STRUCT: ClassVar = {
        "x": Float,
        "y": Float,
        "z": Float,
        "depth": Float,
        "layer": UInt32,
        "weight": Float,
        "found": Float,
        "active": Bool,
        "rng": PCG32,
    }

    def __init__(self, *values):
        for name, value in zip(self.DRJIT_STRUCT, values, strict=False):
            setattr(self, name, value)

    def turn(self, mask: Bool, x: Float, y: Float, z: Float) -> None:
        """Let some go elsewhere."""
        self.x = dr.select(mask, x, self.x)
        self.y = dr.select(mask, y, self.y)
        self.z = dr.select(mask, z, self.z)


def _step(matter: _Matter, pair: UInt32, eye, photon: _Photon) -> None:
    """Let photons fly to where they collide or to the end of their layer, count what is seen there, and turn them."""
    rng, last = photon.rng, len(matter.thicknesses) - 1
    bottoms = np.cumsum(matter.thicknesses)
    top, bottom, absorbed, rate, above = (Float(0.0) for _ in range(5))
    for k in range(last + 1):
        here = photon.layer == k
        top = dr.select(here, float(bottoms[k] - matter.thicknesses[k]), top)
        bottom = dr.select(here, float(bottoms[k]), bottom)
        absorbed = dr.select(here, matter.absorption[k], absorbed)
        rate = dr.select(here, dr.gather(Float, matter.rates[k], pair), rate)
        above = dr.select(here, dr.gather(Float, matter.above[k], pair), above)
    upright = dr.abs(photon.z)
    met = [
        dr.select(photon.layer == own.layer, _read(own.met, upright, COSINES), 0.0)
        for own in matter.flakes
    ]
    grains = [dr.select(photon.layer == own.layer, own.extinction, 0.0) for own in matter.grains]
    whole = dr.maximum(absorbed + sum(met) + sum(grains), 1e-12)
    free = -dr.log(1.0 - rng.next_float32()) / whole
    down = photon.z < 0.0
    edge = dr.select(down, bottom - photon.depth, photon.depth - top) / dr.maximum(upright, 1e-7)
    collides = free < edge
    photon.depth = dr.clip(photon.depth - photon.z * dr.minimum(free, edge), top, bottom)
    seen = dr.exp(-above - rate * (photon.depth - top))
    is_ground = ~collides & down & (photon.layer == last)
    is_surface = ~collides & ~down & (photon.layer == 0)
    ground = dr.exp(-dr.gather(Float, matter.whole, pair)) * matter.substrate * dr.inv_pi * eye[2]
    found = dr.select(collides, _towards(matter, photon, eye) / whole * seen, 0.0)
    photon.found += photon.weight * dr.select(is_ground, ground, found)
    choice, passed = rng.next_float32() * whole, Float(0.0)
    for own, share in zip(matter.flakes, met, strict=True):
        chosen = collides & (choice >= passed) & (choice < passed + share)
        passed = passed + share
        _meet(own, photon, chosen)
    for own, share in zip(matter.grains, grains, strict=True):
        chosen = collides & (choice >= passed) & (choice < passed + share)
        passed = passed + share
        _scatter(own, photon, chosen)
    photon.weight = dr.select(collides & (choice >= passed), 0.0, photon.weight)
    # At the ends of layers: the substrate, the surface, or the next layer.
    level = dr.sqrt(rng.next_float32())
    sine, cosine = dr.sincos(2.0 * dr.pi * rng.next_float32())
    photon.turn(
        is_ground, level * cosine, level * sine, dr.sqrt(dr.maximum(1.0 - level * level, 0.0))
    )
    photon.weight = dr.select(is_ground, photon.weight * matter.substrate, photon.weight)
    leaves = is_surface & (rng.next_float32() >= _face(matter.index, upright))
    photon.z = dr.select(is_surface, -photon.z, photon.z)
    crosses = ~collides & ~is_ground & ~is_surface
    photon.layer = dr.select(
        crosses, dr.select(down, photon.layer + 1, photon.layer - 1), photon.layer
    )
    survives = rng.next_float32() * ROULETTE < photon.weight
    photon.weight = dr.maximum(photon.weight, ROULETTE)
    photon.active &= survives & ~leaves


def _towards(matter: _Matter, photon: _Photon, eye) -> Float:
    """What is scattered to the eye, by length and solid angle. [1/um/sr]"""
    cosine = photon.x * eye[0] + photon.y * eye[1] + photon.z * eye[2]
    # By the difference itself: nearly straight on, 1 - cos would be rounding.
    across, along, upright = (
        e - p for e, p in zip(eye, (photon.x, photon.y, photon.z), strict=True)
    )
    gap = dr.maximum(dr.sqrt(across * across + along * along + upright * upright), 1e-6)
    upright = dr.clip(dr.abs(upright) / gap, 1e-6, 1.0)
    scattered = Float(0.0)
    for own in matter.flakes:
        square = own.slope * own.slope
        lobe = dr.exp((1.0 - dr.rcp(upright * upright)) / (2.0 * square))
        lobe = lobe / (2.0 * dr.pi * square * upright * upright * upright)
        share = 0.25 * own.area * _read(own.back, 0.5 * gap, COSINES) * lobe
        scattered = scattered + dr.select(photon.layer == own.layer, share, 0.0)
    for own in matter.grains:
        share = own.scattering * _read(own.phase, 0.5 + 0.5 * cosine, PHASES) / (4.0 * dr.pi)
        scattered = scattered + dr.select(photon.layer == own.layer, share, 0.0)
    return scattered


def _meet(own: _Flakes, photon: _Photon, chosen: Bool) -> None:
    """Flakes that are met by how much of their faces shows reflect, let pass, or absorb."""
    rng, x, y, z = photon.rng, photon.x, photon.y, photon.z

    def try_again(nx, ny, nz, is_open, rng):
        radius = own.slope * dr.sqrt(-2.0 * dr.log(1.0 - rng.next_float32()))
        sine, cosine = dr.sincos(2.0 * dr.pi * rng.next_float32())
        nz = dr.rsqrt(1.0 + radius * radius)
        nx, ny = radius * cosine * nz, radius * sine * nz
        is_open &= rng.next_float32() > dr.abs(nx * x + ny * y + nz * z)
        return nx, ny, nz, is_open, rng

    zero = dr.zeros(Float, dr.width(photon.found))
    nx, ny, nz, _, photon.rng = dr.while_loop(
        (zero, zero, zero + 1.0, Bool(chosen), rng),
        lambda nx, ny, nz, is_open, rng: is_open,
        try_again,
    )
    towards = nx * x + ny * y + nz * z
    back = _read(own.back, dr.abs(towards), COSINES)
    both = back + _read(own.passed, dr.abs(towards), COSINES)
    turns = chosen & (photon.rng.next_float32() * both < back)
    photon.weight = dr.select(chosen, photon.weight * both, photon.weight)
    photon.turn(turns, x - 2.0 * towards * nx, y - 2.0 * towards * ny, z - 2.0 * towards * nz)


def _scatter(own: _Grains, photon: _Photon, chosen: Bool) -> None:
    """Grains turn light by their phase function."""
    rng, x, y, z = photon.rng, photon.x, photon.y, photon.z
    along = _read(own.inverse, rng.next_float32(), PHASES)
    sine, cosine = dr.sincos(2.0 * dr.pi * rng.next_float32())
    across = dr.sqrt(dr.maximum(1.0 - along * along, 0.0))
    u, v = across * cosine, across * sine
    # A frame about the direction, after Duff and others, 2017.
    sign = dr.copysign(Float(1.0), z)
    a = -dr.rcp(sign + z)
    photon.turn(
        chosen,
        (1.0 + sign * x * x * a) * u + x * y * a * v + x * along,
        sign * x * y * a * u + (sign + y * y * a) * v + y * along,
        -sign * x * u - y * v + z * along,
    )
    photon.weight = dr.select(
        chosen, photon.weight * (own.scattering / own.extinction), photon.weight
    )


def _face(index: float, inside: Float) -> Float:
    """What the surface reflects of light from below, by its cosine."""
    squared = 1.0 - index**2 * (1.0 - inside * inside)
    outside = dr.sqrt(dr.maximum(squared, 0.0))
    first = (index * inside - outside) / (index * inside + outside)
    second = (inside - index * outside) / (inside + index * outside)
    return dr.select(squared > 0.0, 0.5 * (first * first + second * second), 1.0)
