"""A paint solved: its scattering between any directions, by adding of layers in Fourier modes of the azimuth."""

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import SceneError
from ..scattering.data.table import evaluate_table
from ..scene.scattering import ScatterTable
from .composition import Paint
from .directions import Directions, place_directions
from .first_order import Pairs, pairs_of, single_reflection
from .fresnel import face_reflectance
from .matter import LayerMatter, find_matter, scattering
from .slab import add_below, find_rates, find_slab, under_face

WAVELENGTHS = np.arange(390.0, 711.0, 10.0)
"""Bands of the reference's instrument, which interference needs. [nm]"""

DIRECTIONS_PER_SLOPE, MODES_PER_SLOPE = 60.0, 72.0
"""Directions and modes that are enough, times the smallest slope in degrees."""

FEWEST_DIRECTIONS, FEWEST_MODES = 24, 16

MOST_DIRECTIONS, MOST_MODES = 96, 144
"""Where these are not enough, the paint is refused."""

TRIED = 2000
"""Pairs of directions by which it is seen how much is clamped."""

HELD_LOSS = 1e-10
"""Share of light that is lost at each total reflection."""

CHUNK = 1 << 22
"""Values that are made in one go."""


@dataclass(frozen=True)
class Resolution:
    """How finely light is followed.

    Parameters
    ----------
    directions : int    Half of them leave the paint.
    modes : int    Of the azimuth.
    """

    directions: int
    modes: int


def resolution_for(paint: Paint) -> Resolution:
    """Resolution that a paint's flakes need, from the smallest spread of their normals.

    Light reflected once is exact; that of two flakes has lobes wider by the root of 2, which the rule counts on.
    """
    slopes = [each.slope for layer in paint.layers for each in layer.flakes]
    if not slopes:
        return Resolution(FEWEST_DIRECTIONS, FEWEST_MODES)
    degrees = np.degrees(min(slopes))
    directions = max(FEWEST_DIRECTIONS, 2 * int(np.ceil(0.5 * DIRECTIONS_PER_SLOPE / degrees)))
    modes = max(FEWEST_MODES, int(np.ceil(MODES_PER_SLOPE / degrees)))
    if directions > MOST_DIRECTIONS or modes > MOST_MODES:
        raise SceneError(
            f"flakes that tilt by {degrees:.2g} degrees are too even for the modes, expected at least "
            f"{max(DIRECTIONS_PER_SLOPE / MOST_DIRECTIONS, MODES_PER_SLOPE / MOST_MODES):.2g}"
        )
    return Resolution(directions, modes)


@dataclass(frozen=True, eq=False)
class Solution:
    """Scattering of a paint.

    Parameters
    ----------
    paint : Paint
    wavelengths : (w,) float64 array    [nm]
    layers : tuple of LayerMatter    The outermost first.
    directions : Directions
    kernels : (w, m, l, l) float64 array
        Modes of pi f / ((1 - F_i) (1 - F_o)) between the directions that leave, without what single flakes reflect.
    single : (w, l, l) float64 array    Mode 0 of what single flakes reflect, likewise.
    extinctions : list of (w, l) float64 arrays    Exact, for each layer. [1/um]
    resolution : Resolution
    is_polarised : bool
    """

    paint: Paint
    wavelengths: np.ndarray
    layers: tuple[LayerMatter, ...]
    directions: Directions
    kernels: np.ndarray
    single: np.ndarray
    extinctions: list
    resolution: Resolution
    is_polarised: bool = True

    def evaluate(self, wi, wo) -> np.ndarray:
        """BRDF without what is reflected as by mirrors; 0 below the horizon. (n, 3), (n, 3) -> (n, w) [1/sr]"""
        wi, wo = np.asarray(wi, np.float64), np.asarray(wo, np.float64)
        values = np.zeros((len(wi), len(self.wavelengths)))
        above = (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)
        if above.any():
            pairs = pairs_of(wi[above], wo[above])
            values[above] = np.maximum(self.rest(pairs) + self.first_order(pairs), 0.0)
        return values

    def first_order(self, pairs: Pairs) -> np.ndarray:
        """The part that single flakes reflect. (n, w) [1/sr]"""
        return single_reflection(self.layers, self.extinction, pairs, self.is_polarised)

    def extinction(self, number: int, sines) -> np.ndarray:
        """Extinction in a layer. (n,) -> (n, w) [1/um]"""
        return self.directions.interpolation(sines) @ self.extinctions[number].T

    def entering(self, sines) -> np.ndarray:
        """Share of light that enters the paint, or leaves it. (n,) -> (n, w)"""
        return 1.0 - face_reflectance(np.asarray(sines)[:, None], 1.0, self.layers[0].index)

    def mirror(self, sines) -> np.ndarray:
        """Share of light that is reflected as by a mirror, by the surface and by faces below it. (n,) -> (n, w)"""
        sines = np.asarray(sines, np.float64)
        straight = np.zeros((len(sines), len(self.wavelengths)))
        for k in range(len(self.layers) - 1, -1, -1):
            layer = self.layers[k]
            cosine = np.sqrt(1.0 - (sines / layer.mean_index) ** 2)[:, None]
            straight = straight * np.exp(
                -2.0 * layer.thickness * self.extinction(k, sines) / cosine
            )
            upper = 1.0 if k == 0 else self.layers[k - 1].index
            face = face_reflectance(sines[:, None], upper, layer.index)
            straight = face + (1.0 - face) ** 2 * straight / (1.0 - face * straight)
        return straight

    def albedo(self, sines) -> np.ndarray:
        """Share of light that is scattered, of unpolarised means. (n,) -> (n, w)"""
        inside = self.directions.interpolation(sines)
        leaving = self.entering(self.directions.sines[: self.directions.leaving])  # (l, w)
        weights = self.directions.weights[: self.directions.leaving]
        spread = np.einsum("wij,nj->nwi", self.kernels[:, 0] + self.single, inside)
        return self.entering(sines) * np.einsum("nwi,iw,i->nw", spread, leaving, weights)

    def rest(self, pairs: Pairs) -> np.ndarray:
        """All but `first_order`, what the modes hold: below 0 where series are cut short. (n, w) [1/sr]"""
        sines, place = np.unique(np.round(pairs.incident, 12), return_inverse=True)
        bands, modes = self.kernels.shape[:2]
        waves = self._waves(pairs.turn, modes)
        parity = np.arange(modes) % 2
        out = self.directions.interpolations(pairs.leaving)
        values = np.empty((len(pairs.turn), bands))
        if len(sines) * 4 <= len(values):
            inside = self.directions.interpolations(sines)[parity]  # (m, k, l)
            columns = self.kernels @ np.swapaxes(inside, 1, 2)  # (w, m, l, k)
            for k in range(len(sines)):
                here = np.flatnonzero(place == k)
                basis = waves[here, :, None] * out[:, here][parity].transpose(1, 0, 2)
                values[here] = basis.reshape(len(here), -1) @ columns[..., k].reshape(bands, -1).T
        else:
            step = max(CHUNK // (modes * out.shape[2]), 1)
            for k in range(0, len(values), step):
                part = slice(k, k + step)
                inside = self.directions.interpolations(pairs.incident[part])[parity]  # (m, n, l)
                basis = np.swapaxes(waves[part].T[..., None] * out[:, part][parity], 1, 2)
                for band, kernel in enumerate(self.kernels):
                    columns = kernel @ np.swapaxes(inside, 1, 2)  # (m, l, n)
                    values[part, band] = np.einsum("mln,mln->n", columns, basis)
        share = self.entering(pairs.incident) * self.entering(pairs.leaving)
        return values * share / np.pi

    @staticmethod
    def _waves(turn, modes: int) -> np.ndarray:
        """1, 2 cos(phi), 2 cos(2 phi) … (n,) -> (n, m)"""
        made = np.cos(np.arccos(turn)[:, None] * np.arange(modes))
        made[:, 1:] *= 2.0
        return made

    @cached_property
    def clamped(self) -> float:
        """Share of light from everywhere that is below 0 as series are cut short, and counts as none: in the worst band."""
        rng = np.random.default_rng(3)
        places = np.sqrt(rng.random((2, TRIED)))
        pairs = Pairs(*places, np.cos(np.pi * rng.random(TRIED)))
        values = self.rest(pairs) + self.first_order(pairs)
        return float((np.pi * np.maximum(-values, 0.0)).mean(axis=0).max())


def solve(
    paint: Paint,
    wavelengths=WAVELENGTHS,
    *,
    resolution: Resolution | None = None,
    is_polarised: bool = True,
) -> Solution:
    """Solve a paint.

    Parameters
    ----------
    wavelengths : sequence of float    [nm]
    resolution : Resolution or None    None: what `resolution_for` says.
    is_polarised : bool    Whether light that one flake reflects counts by its polarisation.

    Raises
    ------
    SceneError    Its flakes are too even, too thick, or its grains too large.
    """
    wavelengths = np.asarray(wavelengths, np.float64)
    resolution = resolution or resolution_for(paint)
    layers = tuple(find_matter(layer, wavelengths) for layer in paint.layers)
    directions = place_directions([each.mean_index for each in layers], resolution.directions)
    sizes = [directions.count(each.mean_index) for each in layers]
    cosines = [directions.cosines(each.mean_index) for each in layers]
    scattered = [
        scattering(layer, cosine, resolution.modes) if layer.has_particles else None
        for layer, cosine in zip(layers, cosines, strict=True)
    ]
    substrate = _substrate(paint, layers[-1], directions, resolution.modes, wavelengths)
    adder = _Adder(layers, directions, cosines, sizes, scattered, substrate)
    parts = _shares_of_bands(len(wavelengths))
    if len(parts) == 1:
        solved = [adder.solve(parts[0])]
    else:
        with ThreadPoolExecutor(len(parts)) as pool:
            solved = list(pool.map(adder.solve, parts))
    kernels, single = (np.concatenate(each) for each in zip(*solved, strict=True))
    leaving = directions.leaving
    exact = [
        layer.extinction(cosine[:leaving]) for layer, cosine in zip(layers, cosines, strict=True)
    ]
    return Solution(
        paint, wavelengths, layers, directions, kernels, single, exact, resolution, is_polarised
    )


def _shares_of_bands(bands: int) -> list[slice]:
    count = max(
        1,
        min(
            len(os.sched_getaffinity(0))
            if hasattr(os, "sched_getaffinity")
            else os.cpu_count() or 1,
            bands,
        ),
    )
    ends = np.linspace(0, bands, count + 1).round().astype(int)
    return [slice(a, b) for a, b in zip(ends[:-1], ends[1:], strict=True)]


def _substrate(
    paint: Paint, layer: LayerMatter, directions: Directions, modes: int, wavelengths
) -> np.ndarray:
    """Modes of the reflection of the substrate, (w, 1 or m, n, n); one where it is matt."""
    count = directions.count(layer.mean_index)
    flux = directions.weights[:count] / layer.mean_index**2
    root = np.sqrt(np.outer(flux, flux))
    if not isinstance(paint.substrate, ScatterTable):
        return (paint.substrate.at(wavelengths)[:, None, None] * root)[:, None]
    table = paint.substrate
    cosines = directions.cosines(layer.mean_index)
    turns = (np.arange(2 * modes) + 0.5) * np.pi / (2 * modes)
    i, j, k = (each.ravel() for each in np.indices((count, count, len(turns))))
    sine = np.sqrt(1.0 - cosines**2)
    wi = np.stack([sine[i], np.zeros(len(i)), cosines[i]], axis=1)
    wo = np.stack([-sine[j] * np.cos(turns[k]), sine[j] * np.sin(turns[k]), cosines[j]], axis=1)
    values = evaluate_table(table, wi, wo).reshape(count, count, len(turns), -1)
    waves = np.cos(np.outer(np.arange(modes), turns)) / len(turns)
    made = np.pi * np.einsum("ijkw,mk->wmij", values, waves)
    made = 0.5 * (made + np.swapaxes(made, -1, -2)) * root
    if len(table.wavelengths) == 1:
        return np.repeat(made, len(wavelengths), axis=0)
    flat = made.reshape(len(made), -1)
    place = np.interp(wavelengths, table.wavelengths, np.arange(len(flat)))
    low = np.minimum(place.astype(int), len(flat) - 2)
    share = (place - low)[:, None]
    return (flat[low] * (1.0 - share) + flat[low + 1] * share).reshape(-1, *made.shape[1:])


@dataclass(frozen=True, eq=False)
class _Adder:
    """Adds layers from the substrate upwards, for some bands at a time."""

    layers: Sequence[LayerMatter]
    directions: Directions
    cosines: Sequence[np.ndarray]
    sizes: Sequence[int]
    scattered: Sequence
    substrate: np.ndarray

    def solve(self, bands: slice) -> tuple[np.ndarray, np.ndarray]:
        """Kernels and mode 0 of the single reflection, of bands, as `Solution` has them."""
        below, straight = self.substrate[bands], None
        leaving = self.directions.leaving
        extinctions = [self._extinction(k, bands) for k in range(len(self.layers))]
        for k in range(len(self.layers) - 1, -1, -1):
            layer, cosine = self.layers[k], self.cosines[k]
            flux = self.directions.weights[: self.sizes[k]] / layer.mean_index**2
            through = np.exp(-extinctions[k] * layer.thickness / cosine)
            if straight is not None:
                straight = straight * through[:, :leaving] ** 2
            if self.scattered[k] is None:
                below = below * (through[:, None, :, None] * through[:, None, None, :])
            else:
                back, forth = (each[bands] for each in self.scattered[k])
                rates = find_rates(extinctions[k][:, None], back, forth, cosine, flux)
                reflected, passed = find_slab(rates, layer.thickness)
                below = _on(reflected, passed, below)
            face = self._face(k, bands)
            if k == 0:
                below = under_face(below, face[:, None])
                if straight is not None:
                    straight = straight / (1.0 - face[:, :leaving] * straight)
            elif face is not None:
                below = self._through(k, face, below)
                own = np.zeros_like(face[:, :leaving]) if straight is None else straight
                share = face[:, :leaving]
                straight = share + (1.0 - share) ** 2 * own / (1.0 - share * own)
        root = np.sqrt(self.directions.weights[:leaving])
        kernels = below[..., :leaving, :leaving] / np.outer(root, root)
        if straight is not None:
            n = np.arange(leaving)
            kernels[..., n, n] -= (straight / root**2)[:, None]
        single = self._single(extinctions, bands, kernels.shape[1])
        kernels -= single
        return kernels, single[:, 0]

    def _extinction(self, k: int, bands: slice) -> np.ndarray:
        """Extinction that keeps energy on these very directions: what is scattered to them, and absorbed. (w, n)"""
        layer, cosine = self.layers[k], self.cosines[k]
        lost = layer.absorbed(cosine)[bands]
        if self.scattered[k] is None:
            return lost
        weights = self.directions.weights[: self.sizes[k]] / layer.mean_index**2 / cosine
        back, forth = (each[bands, 0] for each in self.scattered[k])
        return lost + weights @ (back + forth)

    def _face(self, k: int, bands: slice) -> np.ndarray | None:
        """Reflectance of the face above a layer, for the directions in it; None where there is none. (w, n)"""
        layer = self.layers[k]
        upper = 1.0 if k == 0 else self.layers[k - 1].index[bands]
        limit = 1.0 if k == 0 else min(self.layers[k - 1].mean_index, layer.mean_index)
        lower = layer.index[bands]
        if k > 0 and np.abs(upper - lower).max() < 1e-6:
            return None
        sines = self.directions.sines[: self.sizes[k]] / limit
        # By the share of the limit, so that total reflection begins at the same directions in all bands.
        scale = np.minimum(upper, lower) * np.ones(len(lower))
        share = face_reflectance(
            sines * scale[:, None], np.atleast_1d(upper)[:, None], lower[:, None]
        )
        # What is held between two faces in clear matter must end, though nothing comes there.
        return np.where(sines >= 1.0, 1.0 - HELD_LOSS, share)

    def _through(self, k: int, face: np.ndarray, below: np.ndarray) -> np.ndarray:
        """Reflection on a face of what lies below it, for the directions of the layer above."""
        count, above = self.sizes[k], self.sizes[k - 1]
        both = min(count, above)
        inner = under_face(below, face[:, None])[..., :both, :both]
        share = 1.0 - face[:, None, :both]
        made = np.zeros((*below.shape[:2], above, above))
        n = np.arange(above)
        made[..., n, n] = 1.0
        made[..., n[:both], n[:both]] = 1.0 - share
        made[..., :both, :both] += share[..., :, None] * inner * share[..., None, :]
        return made

    def _single(self, extinctions, bands: slice, modes: int) -> np.ndarray:
        """What single flakes reflect between the directions that leave, by these extinctions. (w, m, l, l)"""
        leaving = self.directions.leaving
        total = np.zeros((bands.stop - bands.start, modes, leaving, leaving))
        taken = 1.0
        for k, layer in enumerate(self.layers):
            if k > 0:
                face = self._face(k, bands)
                if face is not None:
                    taken = taken * (1.0 - face[:, :leaving])
            rate = extinctions[k][:, :leaving] / self.cosines[k][:leaving]
            if layer.flakes:
                cosine = self.cosines[k][:leaving]
                both = rate[:, :, None] + rate[:, None, :]
                depth = -np.expm1(-both * layer.thickness) / np.maximum(both, 1e-300)
                depth = depth * (np.ones((1, leaving)) * taken)[:, :, None]
                depth = depth * (np.ones((1, leaving)) * taken)[:, None, :]
                depth /= layer.mean_index**2 * np.outer(cosine, cosine)
                total += depth[:, None] * self.flake_scattering(k, bands, modes)
            taken = taken * np.exp(-rate * layer.thickness)
        return total

    def flake_scattering(self, k: int, bands: slice, modes: int) -> np.ndarray:
        """Modes of pi times what a layer's flakes turn back between the directions that leave. (w, m, l, l)"""
        layer, leaving = self.layers[k], self.directions.leaving
        if not layer.pigments:
            return self.scattered[k][0][bands, :modes, :leaving, :leaving]
        flakes = LayerMatter(
            layer.thickness, layer.index, layer.mean_index, layer.absorption, layer.flakes, ()
        )
        return scattering(flakes, self.cosines[k], modes)[0][bands, :, :leaving, :leaving]


def _on(reflected, passed, below) -> np.ndarray:
    """Layer on what lies below, which may have mode 0 alone."""
    if below.shape[1] == reflected.shape[1]:
        return add_below(reflected, passed, below)
    made = reflected.copy()
    if below.any():
        made[:, :1] = add_below(reflected[:, :1], passed[:, :1], below)
    return made
