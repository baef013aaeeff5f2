"""A pigment layer on its substrate: what it scatters in all directions, with light of both polarisations.

The scalar equation knows one polarisation, that across the plane of incidence. Coherent light is what that matters for: its
shares are those of the homogeneous film of the mean permittivity for both polarisations, times what realisations lose
against that film for the one. The light that is left is scattered and absorbed in the proportions of the scalar solution:
with factors e of the directions, e(i) [A(i) + sum_j G_ij W_j e_j] = 1 - R(i) - T(i), which is symmetric and keeps energy.

Over a matt substrate of the reflectance rho, with the film's total transmittance T and its hemispherical reflectance Rb from
below, in the index n,

    f(i, o) = f_film(i, o) + T(i) rho T(o) / (pi n^2 (1 - rho Rb))

over a table the same with matrices in modes of the azimuth, T (1 - S Rb)^-1 S T.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..scattering.data.table import evaluate_table
from ..scene.scattering import ScatterTable
from .composition import Ink
from .film import DEGREES, Film
from .films import film_shares
from .realisation import SIDES, thickness_of

NODES = 32
"""Directions on each side by which light between film and substrate is followed."""

THICKNESSES = 24
"""Thicknesses by which their spread is averaged."""

ROUNDS = 200

TURNS = 48
"""Azimuths by which the modes of a substrate's table are found."""

LEAST = 1e-9


@dataclass(frozen=True, eq=False)
class Nodes:
    """Directions for a film: those that leave it, and on the side below those beyond.

    Parameters
    ----------
    tangential : (n,) float64 array    s = n sin theta.
    weights : (n,) float64 array    In integrals over d2s.
    leaving : int    How many of them air has too.
    """

    tangential: np.ndarray
    weights: np.ndarray
    leaving: int

    def count(self, side: str) -> int:
        """Directions on a side."""
        return self.leaving if side == "above" else len(self.weights)


def place_nodes(below: float, count: int) -> Nodes:
    """Gauss' cosines in air and, under a denser side, beyond its critical angle."""
    places, weights = np.polynomial.legendre.leggauss(count)
    cosines, shares = 0.5 * (places + 1.0), 0.5 * weights
    tangential, whole = np.sqrt(1.0 - cosines**2), 2.0 * np.pi * cosines * shares
    if below > 1.0:
        highest = np.sqrt(below**2 - 1.0)
        normal, more = highest * cosines, highest * shares
        tangential = np.append(tangential, np.sqrt(below**2 - normal**2))
        whole = np.append(whole, 2.0 * np.pi * normal * more)
    return Nodes(tangential, whole, count)


class Printed:
    """A film on its substrate, solved."""

    def __init__(
        self,
        ink: Ink,
        wavelengths,
        film: Film,
        runs: int,
        count: int = NODES,
        is_scalar: bool = False,
    ):
        """Prepare.

        Parameters
        ----------
        wavelengths : (w,) array    [nm]
        runs : int    Realisations that the film's mean is of, whose thicknesses it was at.
        count : int    Directions on each side.
        is_scalar : bool    Whether coherent light too is only polarised across the plane of incidence.
        """
        self.ink, self.film = ink, film
        self._polarisations = 1 if is_scalar else 2
        self.wavelengths = np.asarray(wavelengths, np.float64)
        self.nodes = place_nodes(ink.below, count)
        self._indices = {"above": 1.0, "below": ink.below}
        self._means = np.array([ink.mean_permittivity(each) for each in self.wavelengths])
        heights = np.array([thickness_of(ink, k) for k in range(runs)])
        self._kept = {side: self._keep(side, heights) for side in SIDES}
        self._missing = dict.fromkeys(SIDES)
        self._straight = self._coherent_at_nodes()
        self._factors = self._balance()
        # What nothing takes, near grazing where hardly anything is scattered, is coherent too.
        self._missing = {
            side: np.maximum(
                1.0 - sum(self.total(side, self._places(side))) - self._absorbed(side), 0.0
            )
            for side in SIDES
        }
        self._straight = self._coherent_at_nodes()

    def coherent(self, side: str, tangential) -> np.ndarray:
        """Shares of unpolarised light that go on as by a mirror and straight on. (n,) -> (2, w, n)"""
        tangential = np.asarray(tangential, np.float64)
        cosines = np.sqrt(np.maximum(1.0 - (tangential / self._indices[side]) ** 2, 0.0))
        heights = self._all_heights()
        count = self._polarisations
        made = np.mean(
            [self._slab(side, tangential, each)[:, :count].mean(axis=1) for each in heights], axis=0
        )
        known = np.sqrt(1.0 - self.film.sines[::-1] ** 2)
        kept = self._kept[side][..., ::-1]
        for number in range(2):
            for band in range(len(self.wavelengths)):
                made[number, band] *= np.interp(cosines, known, kept[number, band])
        made /= np.maximum(made.sum(axis=0), 1.0)
        if self._missing[side] is None:
            return made
        more = self._between_nodes(side, self._missing[side], tangential)
        return made * (1.0 + more / np.maximum(made.sum(axis=0), LEAST))

    def total(self, side: str, tangential) -> tuple[np.ndarray, np.ndarray]:
        """Shares of light that the film reflects and lets pass, scattered light included. (n,) -> two (w, n)"""
        tangential = np.asarray(tangential, np.float64)
        straight = self.coherent(side, tangential)
        other = SIDES[1 - SIDES.index(side)]
        spread = []
        for end in (side, other):
            count = self.nodes.count(end)
            kernel = self._kernel(side, end, tangential, self.nodes.tangential[:count])
            weight = self.nodes.weights[:count] * self._factors[end]
            spread.append(
                self._factor(side, tangential) * np.einsum("wij,wj->wi", kernel[0], weight)
            )
        return straight[0] + spread[0], straight[1] + spread[1]

    def mirror(self, sines) -> np.ndarray:
        """Share that is reflected as by a mirror. (n,) -> (n, w)"""
        return self.coherent("above", sines)[0].T

    def evaluate(self, wi, wo) -> np.ndarray:
        """BRDF without the mirror's part. (n, 3), (n, 3) -> (n, w) [1/sr]"""
        wi, wo = np.asarray(wi, np.float64), np.asarray(wo, np.float64)
        values = np.zeros((len(wi), len(self.wavelengths)))
        above = (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)
        if not above.any():
            return values
        wi, wo = wi[above], wo[above]
        lengths = [np.hypot(each[:, 0], each[:, 1]) for each in (wi, wo)]
        # Azimuths count from where a mirror sends the light.
        turn = -(wi[:, :2] * wo[:, :2]).sum(axis=1) / np.maximum(lengths[0] * lengths[1], 1e-12)
        kernel = self.film.kernel("reflection_above", wi[:, 2], wo[:, 2], turn)
        factor = self._factor("above", lengths[0]) * self._factor("above", lengths[1])
        made = np.maximum(kernel, 0.0) * factor.T
        if isinstance(self.ink.substrate, ScatterTable):
            made = made + self._over_table(wi, wo, lengths, turn)
        else:
            passed = [
                np.array([np.interp(each, self._fine, row) for row in self._passed]).T
                for each in lengths
            ]
            made = made + passed[0] * passed[1] * self._between / np.pi
        values[above] = made
        return values

    def evaluate_error(self, wi, wo) -> np.ndarray:
        """Standard error of `evaluate` by the speckle of what the film itself reflects. (n, 3), (n, 3) -> (n, w) [1/sr]"""
        lengths = [np.hypot(each[:, 0], each[:, 1]) for each in (wi, wo)]
        turn = -(wi[:, :2] * wo[:, :2]).sum(axis=1) / np.maximum(lengths[0] * lengths[1], 1e-12)
        error = self.film.kernel_error("reflection_above", wi[:, 2], wo[:, 2], turn)
        return error * (self._factor("above", lengths[0]) * self._factor("above", lengths[1])).T

    def albedo(self, sines) -> np.ndarray:
        """Share of light that is scattered, without the mirror's part. (n,) -> (n, w)"""
        reflected, passed = self.total("above", sines)
        own = reflected - self.coherent("above", sines)[0]
        if isinstance(self.ink.substrate, ScatterTable):
            leaving = self.nodes.leaving
            mode = self._returned[:, 0]
            root = np.sqrt(self.nodes.weights[:leaving])
            spread = np.einsum("wij,j->wi", mode, root) / root
            order = np.argsort(self.nodes.tangential[:leaving])
            places = self.nodes.tangential[:leaving][order]
            more = np.array([np.interp(sines, places, row[order]) for row in spread])
            return (own + more).T
        leaving = self.nodes.leaving
        _, out = self.total("above", self.nodes.tangential[:leaving])
        mean = out @ self.nodes.weights[:leaving] / np.pi
        return (own + passed * (self._between * mean)[:, None]).T

    @cached_property
    def hemispherical(self) -> tuple[np.ndarray, np.ndarray]:
        """Reflectance from below and transmittance, of light from everywhere there. two (w,) arrays"""
        shares = self.total("below", self.nodes.tangential)
        area = np.pi * self.ink.below**2
        return tuple(each @ self.nodes.weights / area for each in shares)

    # ---- private ----

    def _places(self, side: str) -> np.ndarray:
        """Tangential parts of the nodes of a side. (n,)"""
        return self.nodes.tangential[: self.nodes.count(side)]

    def _coherent_at_nodes(self) -> dict[str, np.ndarray]:
        return {side: self.coherent(side, self._places(side)) for side in SIDES}

    def _absorbed(self, side: str) -> np.ndarray:
        """Absorbed share at the nodes. (w, n)"""
        return self._lost(side, self._places(side)) * self._factors[side]

    def _slab(self, side: str, tangential, height) -> np.ndarray:
        """Shares of the homogeneous film: (R and T, polarisations, w, n)."""
        index, other = self._indices[side], self._indices[SIDES[1 - SIDES.index(side)]]
        shares = film_shares(
            self._means[:, None],
            height,
            tangential[None] / index,
            self.wavelengths[:, None] * 1e-3,
            index,
            other,
        )
        return np.stack(shares)

    def _keep(self, side: str, heights) -> np.ndarray:
        """What realisations have of the coherent light of a homogeneous film. (2, w, k)

        More of it than by the film of all thicknesses, or than all of it, is chance: at the few thicknesses of realisations
        waves may cancel in that film.
        """
        tangential = self.film.sines * self._indices[side]
        own, whole = (
            np.mean([self._slab(side, tangential, each)[:, 0] for each in some], axis=0)
            for some in (heights, self._all_heights())
        )
        found = self.film.coherent[side]
        most = np.maximum(found / np.maximum(whole, LEAST), 1.0)
        return np.where(own > 1e-6, np.minimum(found / np.maximum(own, 1e-6), most), 1.0)

    def _all_heights(self) -> np.ndarray:
        """Thicknesses by which their spread is averaged. [um]"""
        spread = self.ink.thickness_spread
        places = (np.arange(THICKNESSES) + 0.5) / THICKNESSES * 2.0 - 1.0
        return self.ink.thickness * (1.0 + spread * (places if spread else np.zeros(1)))

    def _kernel(self, side: str, end: str, tangential, ends) -> np.ndarray:
        """Modes 0 of the scalar scattering between directions. (1, w, n, m)"""
        return self._modes(side, end, tangential, ends, 1)

    def _modes(self, side: str, end: str, tangential, ends, modes: int) -> np.ndarray:
        """Modes of the azimuth of the scalar scattering, 1 for m = 0 and half of the cosine's factor beyond. (m, w, n, o)"""
        name = "transmission" if side != end else f"reflection_{side}"
        first = np.sqrt(np.maximum(1.0 - (tangential / self._indices[side]) ** 2, 0.0))
        second = np.sqrt(np.maximum(1.0 - (ends / self._indices[end]) ** 2, 0.0))
        one, two = (each.ravel() for each in np.meshgrid(first, second, indexing="ij"))
        if name == "transmission" and side == "below":
            one, two = two, one
        turns = (np.arange(8) + 0.5) * np.pi / 8
        made = np.zeros((modes, len(self.wavelengths), len(first), len(second)))
        for turn in turns:
            values = np.maximum(
                self.film.kernel(name, one, two, np.full(len(one), np.cos(turn))), 0.0
            )
            values = values.T.reshape(len(self.wavelengths), len(first), len(second))
            for mode in range(modes):
                made[mode] += np.cos(mode * turn) / len(turns) * values
        return made

    def _balance(self) -> dict[str, np.ndarray]:
        """Factors by which directions scatter so that all light is accounted for. (w, n) by side"""
        counts = [self.nodes.count(side) for side in SIDES]
        bands = len(self.wavelengths)
        kernel = np.concatenate(
            [
                np.concatenate(
                    [
                        self._kernel(
                            side, end, self.nodes.tangential[:rows], self.nodes.tangential[:columns]
                        )[0]
                        for end, columns in zip(SIDES, counts, strict=True)
                    ],
                    axis=2,
                )
                for side, rows in zip(SIDES, counts, strict=True)
            ],
            axis=1,
        )
        weights = np.concatenate([self.nodes.weights[:count] for count in counts])
        goal = np.concatenate([1.0 - self._straight[side].sum(axis=0) for side in SIDES], axis=1)
        goal = np.maximum(goal, 0.0)
        lost = np.concatenate(
            [
                self._lost(side, self.nodes.tangential[:count])
                for side, count in zip(SIDES, counts, strict=True)
            ],
            axis=1,
        )
        factors = np.ones((bands, len(weights)))
        for _ in range(ROUNDS):
            all_ = lost + np.einsum("wij,wj->wi", kernel, weights * factors)
            wanted = np.where(all_ > LEAST, goal / np.maximum(all_, LEAST), 0.0)
            before, factors = factors, np.sqrt(factors * wanted)
            if np.abs(factors - before).max() < 1e-13:
                break
        parts = np.split(factors, [counts[0]], axis=1)
        return dict(zip(SIDES, parts, strict=True))

    def _lost(self, side: str, tangential) -> np.ndarray:
        """Absorbed share by the scalar solution. (n,) -> (w, n)"""
        cosines = np.sqrt(np.maximum(1.0 - (tangential / self._indices[side]) ** 2, 0.0))
        known = np.sqrt(1.0 - self.film.sines[::-1] ** 2)
        rows = np.maximum(self.film.absorbed(side), 0.0)[:, ::-1]
        return np.array([np.interp(cosines, known, row) for row in rows])

    def _factor(self, side: str, tangential) -> np.ndarray:
        """Factors of directions between the nodes. (n,) -> (w, n)"""
        return self._between_nodes(side, self._factors[side], tangential)

    def _between_nodes(self, side: str, rows, tangential) -> np.ndarray:
        """What nodes of a side have, between them, linear in the cosine. (w, m), (n,) -> (w, n)"""
        cosines = np.sqrt(1.0 - (self._places(side) / self._indices[side]) ** 2)
        order = np.argsort(cosines)
        wanted = np.sqrt(np.maximum(1.0 - (tangential / self._indices[side]) ** 2, 0.0))
        return np.array([np.interp(wanted, cosines[order], row[order]) for row in rows])

    @cached_property
    def _between(self) -> np.ndarray:
        """Rho / (n^2 (1 - rho Rb)) of a matt substrate. (w,)"""
        share = np.real(self.ink.substrate.at(self.wavelengths))
        return share / (self.ink.below**2 * (1.0 - share * self.hemispherical[0]))

    @cached_property
    def _fine(self) -> np.ndarray:
        """Tangential parts at which the film's transmittance is kept: close where it changes, near grazing."""
        return np.sin(np.linspace(0.0, 0.5 * np.pi, 181))

    @cached_property
    def _passed(self) -> np.ndarray:
        """Total transmittance from above there. (w, n)"""
        return self.total("above", self._fine)[1]

    @cached_property
    def _returned(self) -> np.ndarray:
        """What comes back from a substrate's table to above but for light that goes straight both ways. (w, m, n, n)

        As matrices with the roots of the weights.
        """
        whole, straight = self._with_table()
        return whole - straight

    def _with_table(self):
        count, leaving, modes = len(self.nodes.weights), self.nodes.leaving, len(DEGREES)
        root = np.sqrt(self.nodes.weights)
        places = self.nodes.tangential

        def matrices(side, end):
            rows, columns = self.nodes.count(side), self.nodes.count(end)
            made = self._modes(side, end, places[:rows], places[:columns], modes)
            made = made * self._factors[side][:, :, None] * self._factors[end][:, None, :]
            return np.swapaxes(made * np.outer(root[:rows], root[:columns]), 0, 1)

        substrate = self._substrate_modes(modes) * np.outer(root, root)
        back = matrices("below", "below")
        k = np.arange(count)
        back[..., k, k] += self._straight["below"][0][:, None]
        down = matrices("above", "below")
        n = np.arange(leaving)
        passed = self._straight["above"][1]
        down[..., n, n] += passed[:, None]
        unit = np.eye(count)
        inner = np.linalg.solve(unit - substrate @ back, substrate)
        whole = down @ inner @ np.swapaxes(down, -1, -2)
        own = substrate[..., :leaving, :leaving]
        return whole, passed[:, None, :, None] * own * passed[:, None, None, :]

    def _substrate_modes(self, modes: int) -> np.ndarray:
        """Modes of a table's scattering per d2s. (w, m, n, n)"""
        turns = (np.arange(TURNS) + 0.5) * np.pi / TURNS
        sines = self.nodes.tangential / self.ink.below
        i, j, k = (each.ravel() for each in np.indices((len(sines), len(sines), TURNS)))
        values = self._substrate(sines[i], sines[j], np.cos(turns[k]))
        values = values.reshape(len(sines), len(sines), TURNS, -1) / self.ink.below**2
        waves = np.cos(np.outer(np.arange(modes), turns)) / TURNS
        made = np.einsum("ijkw,mk->wmij", values, waves)
        return 0.5 * (made + np.swapaxes(made, -1, -2))

    def _substrate(self, first, second, turn) -> np.ndarray:
        """The table's BRDF between directions below, by their sines and azimuth from the mirror's. (n, w)"""
        table = self.ink.substrate
        zero = np.zeros_like(first)
        wi = np.stack([first, zero, np.sqrt(np.maximum(1.0 - first**2, 1e-12))], axis=1)
        aside = np.sqrt(np.maximum(1.0 - turn**2, 0.0))
        wo = np.stack(
            [-second * turn, second * aside, np.sqrt(np.maximum(1.0 - second**2, 1e-12))], axis=1
        )
        values = evaluate_table(table, wi, wo)
        if len(table.wavelengths) == 1:
            return np.repeat(values, len(self.wavelengths), axis=1)
        return np.stack([np.interp(self.wavelengths, table.wavelengths, row) for row in values])

    def _over_table(self, wi, wo, lengths, turn) -> np.ndarray:
        """What a substrate's table adds. (n, w)"""
        straight = [self.coherent("above", each)[1].T for each in lengths]
        below = self.ink.below
        made = (
            straight[0] * straight[1]
            * self._substrate(lengths[0] / below, lengths[1] / below, turn) / below**2
        )  # fmt: skip
        leaving = self.nodes.leaving
        root = np.sqrt(self.nodes.weights[:leaving])
        table = self._returned / np.outer(root, root)
        cosines = np.sqrt(1.0 - self.nodes.tangential[:leaving] ** 2)
        order = np.argsort(cosines)
        table = table[..., order, :][..., order]
        places = [
            np.interp(each, cosines[order], np.arange(leaving)) for each in (wi[:, 2], wo[:, 2])
        ]
        low = [np.minimum(each.astype(int), leaving - 2) for each in places]
        part = [each - base for each, base in zip(places, low, strict=True)]
        angle = np.arccos(np.clip(turn, -1.0, 1.0))
        for mode in range(table.shape[1]):
            wave = (1.0 if mode == 0 else 2.0) * np.cos(mode * angle)
            for di in (0, 1):
                for dj in (0, 1):
                    weight = (part[0] if di else 1 - part[0]) * (part[1] if dj else 1 - part[1])
                    made += table[:, mode, low[0] + di, low[1] + dj].T * (weight * wave)[:, None]
        return np.maximum(made, 0.0)
