"""Monte Carlo of light in a paint, photon by photon: what checks the solution, and what knows flakes as wide as they are.

Of flakes as a continuum each encounter is with one of its own; `explicit_flakes` puts discs in their places instead, so that
light which one of them turned back finds the hole by which it came. All else is the same: grains by their phase functions,
binders, faces by Fresnel's law without polarisation, a matt substrate. It uses none of the modes, of the series and of the
sums that solutions are made of.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..errors import SceneError
from ..scene.scattering import ScatterTable
from .composition import Flakes, Mirror, Paint
from .flake_optics import find_shares
from .fresnel import face_reflectance
from .matter import LayerMatter, find_matter
from .orientation import interception

ANGLES = 1801
"""Angles at which a flake's shares are kept."""

COSINES = 2001
"""Cosines at which the interception of a spread of flakes is kept."""

MOST_EVENTS = 20_000
"""Events of a photon, after which it counts as absorbed."""

BATCH = 1 << 17
"""Photons that go at a time."""

BLOCKS = 16
"""Groups of photons of which the error is found."""

RINGS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
"""Sines between which photons are counted, forward and backward."""


@dataclass(frozen=True, eq=False)
class Walked:
    """What became of light.

    Parameters
    ----------
    albedo, absorbed, mirrored : float    Shares that were scattered, absorbed, and reflected by the surface at once. [-]
    error : float    Standard error of the albedo. [-]
    shares : (8,) float64 array    Of the scattered, by `RINGS` forward, then backward. [-]
    errors : (8,) float64 array    Of these.
    photons, seed : int
    """

    albedo: float
    absorbed: float
    mirrored: float
    error: float
    shares: np.ndarray
    errors: np.ndarray
    photons: int
    seed: int


class FlakeField(Protocol):
    """Where light meets flakes."""

    def enter(self, count: int, rng) -> np.ndarray:
        """Places over the paint where photons come in, x and y. (n, 2) [um]"""
        ...

    def meet(self, position, direction, layer, rng) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Distances to the next flakes, their kinds, counted through all layers, and their normals. (n,), (n,), (n, 3)"""
        ...


class Continuum:
    """Flakes that are everywhere, each encounter with one of its own."""

    def __init__(self, layers: tuple[LayerMatter, ...]):
        self.cosines = np.linspace(0.0, 1.0, COSINES)
        self.rates, self.slopes, self.owners = [], [], []
        for number, layer in enumerate(layers):
            for each in layer.flakes:
                mean = interception(self.cosines, each.slope, 1)[:, 0]
                self.rates.append(each.area * mean)
                self.slopes.append(each.slope)
                self.owners.append(number)

    def enter(self, count: int, rng) -> np.ndarray:
        """As of `FlakeField`: one place is as good as any."""
        return np.zeros((count, 2))

    def meet(self, position, direction, layer, rng):
        """As of `FlakeField`."""
        distance = np.full(len(layer), np.inf)
        kind = np.zeros(len(layer), np.int64)
        for k, (rate, owner) in enumerate(zip(self.rates, self.owners, strict=True)):
            here = np.flatnonzero(layer == owner)
            own = np.interp(np.abs(direction[here, 2]), self.cosines, rate)
            way = rng.exponential(size=len(here)) / np.maximum(own, 1e-300)
            nearer = way < distance[here]
            distance[here[nearer]], kind[here[nearer]] = way[nearer], k
        return distance, kind, self._normals(direction, kind, rng)

    def _normals(self, direction, kind, rng) -> np.ndarray:
        """Normals as they are met: by how much of their faces shows."""
        normal = np.zeros_like(direction)
        if not self.slopes:
            return normal
        left = np.arange(len(kind))
        slopes = np.array(self.slopes)[kind]
        while len(left):
            tilt = rng.normal(size=(2, len(left))) * slopes[left]
            upright = 1.0 / np.sqrt(1.0 + (tilt**2).sum(axis=0))
            made = np.stack([-tilt[0] * upright, -tilt[1] * upright, upright], axis=1)
            taken = rng.random(len(left)) < np.abs((made * direction[left]).sum(axis=1))
            normal[left[taken]] = made[taken]
            left = left[~taken]
        return normal


def walk(
    paint: Paint,
    wavelength: float,
    incidence: float,
    photons: int,
    seed: int = 0,
    field: FlakeField | None = None,
) -> Walked:
    """Send photons into a paint.

    Parameters
    ----------
    wavelength : float    [nm]
    incidence : float    [rad]
    field : FlakeField or None    None: a continuum.

    Raises
    ------
    SceneError    The substrate is a table, or the surface has waves: neither is followed.
    """
    if isinstance(paint.substrate, ScatterTable) or paint.orange_peel:
        raise SceneError("photons are followed in smooth paints on matt substrates alone")
    walker = _Walker(paint, wavelength, field)
    counts, done = np.zeros((BLOCKS, 10)), 0
    for block in range(BLOCKS):
        rng = np.random.default_rng((seed, block))
        left = photons * (block + 1) // BLOCKS - done
        own, done = left, done + left
        while left > 0:
            batch = min(left, BATCH)
            counts[block] += walker.run(batch, incidence, rng)
            left -= batch
        counts[block] /= max(own, 1)
    mirrored = float(face_reflectance(np.sin(incidence), 1.0, walker.indices[0]))
    counts *= 1.0 - mirrored
    shares, absorbed = counts[:, :8], counts[:, 8]
    albedo = shares.sum(axis=1)
    scale = 1.0 / np.sqrt(BLOCKS)
    return Walked(
        float(albedo.mean()),
        float(absorbed.mean()),
        mirrored,
        float(albedo.std(ddof=1) * scale),
        shares.mean(axis=0),
        shares.std(axis=0, ddof=1) * scale,
        photons,
        seed,
    )


class _Walker:
    """A paint at one wavelength, as photons see it."""

    def __init__(self, paint: Paint, wavelength: float, field: FlakeField | None):
        wavelengths = np.array([wavelength])
        matters = tuple(find_matter(layer, wavelengths) for layer in paint.layers)
        self.field = field or Continuum(matters)
        self.indices = np.array([each.index[0] for each in matters])
        self.thicknesses = np.array([each.thickness for each in matters])
        # Depths of the upper ends of the layers, from the surface downwards.
        self.tops = np.concatenate([[0.0], np.cumsum(self.thicknesses)])
        self.substrate = float(paint.substrate.at(wavelengths)[0])
        self.flakes = [
            _shares_of(each.flakes, float(layer.index[0]), wavelengths)
            for layer in matters
            for each in layer.flakes
        ]
        self.absorption = np.array([each.absorption[0] for each in matters])
        self.pigments = [
            [
                (each.extinction[0], each.scattering[0], _inverse_of(each.series[0]))
                for each in layer.pigments
            ]
            for layer in matters
        ]
        self.continuous = np.array(
            [
                self.absorption[k] + sum(each[0] for each in own)
                for k, own in enumerate(self.pigments)
            ]
        )

    def run(self, count: int, incidence: float, rng) -> np.ndarray:
        """Numbers of photons by where they left, then absorbed, then left over."""
        sine = np.sin(incidence) / self.indices[0]
        direction = np.tile([sine, 0.0, -np.sqrt(1.0 - sine**2)], (count, 1))
        position = np.column_stack([self.field.enter(count, rng), np.zeros(count)])
        layer = np.zeros(count, np.int64)
        found = np.zeros(10)
        for _ in range(MOST_EVENTS):
            if not len(layer):
                return found
            way, kind, normal = self.field.meet(position, direction, layer, rng)
            rate = self.continuous[layer]
            free = rng.exponential(size=len(layer)) / np.maximum(rate, 1e-300)
            down = direction[:, 2] < 0.0
            end = np.where(down, -self.tops[layer + 1], -self.tops[layer])
            speed = np.where(direction[:, 2] == 0.0, -1e-12, direction[:, 2])
            edge = np.maximum((end - position[:, 2]) / speed, 0.0)
            step = np.minimum(np.minimum(way, free), edge)
            position += step[:, None] * direction
            event = np.where(edge <= step, 0, np.where(free <= step, 1, 2))
            alive = np.ones(len(layer), bool)
            self._leave(np.flatnonzero(event == 0), position, direction, layer, alive, found, rng)
            self._scatter(np.flatnonzero(event == 1), direction, layer, alive, found, rng)
            self._reflect(np.flatnonzero(event == 2), direction, kind, normal, alive, found, rng)
            position, direction, layer = position[alive], direction[alive], layer[alive]
        found[9] += len(layer)
        return found

    def _leave(self, here, position, direction, layer, alive, found, rng) -> None:
        """Photons at the end of their layer: face, surface or substrate."""
        down = direction[here, 2] < 0.0
        last = len(self.indices) - 1
        ground = here[down & (layer[here] == last)]
        if len(ground):
            position[ground, 2] = -self.tops[-1]
            lost = rng.random(len(ground)) >= self.substrate
            found[8] += lost.sum()
            alive[ground[lost]] = False
            square, turn = rng.random(len(ground)), 2.0 * np.pi * rng.random(len(ground))
            level = np.sqrt(square)
            direction[ground] = np.stack(
                [level * np.cos(turn), level * np.sin(turn), np.sqrt(1.0 - square)], axis=1
            )
        rest = here[~(down & (layer[here] == last))]
        if not len(rest):
            return
        down = direction[rest, 2] < 0.0
        own = layer[rest]
        other = np.where(down, own + 1, own - 1)
        inside = self.indices[own]
        outside = np.where(other < 0, 1.0, self.indices[np.clip(other, 0, last)])
        position[rest, 2] = -self.tops[np.where(down, own + 1, own)]
        level = np.hypot(direction[rest, 0], direction[rest, 1])
        share = face_reflectance(inside * level, inside, outside)
        back = rng.random(len(rest)) < np.where(np.abs(inside - outside) < 1e-9, 0.0, share)
        direction[rest[back], 2] *= -1.0
        through = rest[~back]
        scale = (inside / outside)[~back]
        direction[through, :2] *= scale[:, None]
        upright = np.sqrt(np.maximum(1.0 - (direction[through, :2] ** 2).sum(axis=1), 0.0))
        direction[through, 2] = np.where(down[~back], -upright, upright)
        layer[through] = other[~back]
        out = through[layer[through] < 0]
        sine = np.hypot(direction[out, 0], direction[out, 1])
        ring = np.clip(np.searchsorted(RINGS, sine, side="right") - 1, 0, 3)
        ring += np.where(direction[out, 0] < 0.0, 4, 0)
        found[:8] += np.bincount(ring, minlength=8)
        alive[out] = False

    def _scatter(self, here, direction, layer, alive, found, rng) -> None:
        """Photons at a grain, or absorbed by the binder."""
        for number, pigments in enumerate(self.pigments):
            own = here[layer[here] == number]
            if not len(own):
                continue
            place = rng.random(len(own)) * self.continuous[number]
            low = 0.0
            scattered = np.zeros(len(own), bool)
            for _, scattering, inverse in pigments:
                met = (place >= low) & (place < low + scattering)
                low += scattering
                scattered |= met
                cosine = np.interp(rng.random(met.sum()), *inverse)
                direction[own[met]] = _turned(direction[own[met]], cosine, rng)
            found[8] += (~scattered).sum()
            alive[own[~scattered]] = False

    def _reflect(self, here, direction, kind, normal, alive, found, rng) -> None:
        """Photons at a flake."""
        met = (direction[here] * normal[here]).sum(axis=1)
        chance = rng.random(len(here))
        for number, (angles, reflected, passed) in enumerate(self.flakes):
            own = kind[here] == number
            angle = np.arccos(np.minimum(np.abs(met[own]), 1.0))
            back = np.interp(angle, angles, reflected)
            on = np.interp(angle, angles, passed)
            mirrored = chance[own] < back
            lost = chance[own] >= back + on
            those = here[own]
            turned = those[mirrored]
            direction[turned] -= 2.0 * met[own][mirrored][:, None] * normal[turned]
            found[8] += lost.sum()
            alive[those[lost]] = False


def _shares_of(
    flakes: Flakes, index: float, wavelengths
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    angles = np.linspace(0.0, 0.5 * np.pi, ANGLES)
    if isinstance(flakes.optics, Mirror):
        shares = (flakes.optics.reflectance, flakes.optics.transmittance)
        return angles, *(np.full(ANGLES, each.at(wavelengths)[0]) for each in shares)
    cosines = np.maximum(np.cos(angles), 1e-6)
    across, within, _, passed = find_shares(flakes.optics, np.array([index]), wavelengths, cosines)
    return angles, 0.5 * (across + within)[0], passed[0]


def _inverse_of(series: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cosines of scattering by the share of light that is below them."""
    cosines = np.cos(np.linspace(np.pi, 0.0, 4001))
    terms = np.arange(len(series))
    phase = np.maximum(np.polynomial.legendre.legval(cosines, series * (2 * terms + 1)), 0.0)
    share = np.concatenate([[0.0], np.cumsum(0.5 * (phase[1:] + phase[:-1]) * np.diff(cosines))])
    return share / share[-1], cosines


def _turned(direction, cosine, rng) -> np.ndarray:
    """Directions at angles to others, at random azimuths."""
    helper = np.where(np.abs(direction[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(direction, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(direction, first)
    turn = 2.0 * np.pi * rng.random(len(direction))
    sine = np.sqrt(np.maximum(1.0 - cosine**2, 0.0))
    return (
        cosine[:, None] * direction
        + (sine * np.cos(turn))[:, None] * first
        + (sine * np.sin(turn))[:, None] * second
    )
