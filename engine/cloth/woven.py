"""What a woven cloth reflects and lets through, as the tables of a measured material on both sides.

Rays come from each direction of the table. Where they leave is counted on the disk of directions' x and y, of which equal
areas are equal projected solid angles, and read off at the table's directions; tables are scaled to the light that was
counted exactly. What met no yarn passes straight and stands in the tables' direct part.

Clear yarns send light along narrow arcs. So a table's rotations and azimuths hold means weighted by how much they count in
between, and a mean over turns of the light or of the eye is that of the cloth.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

from ..errors import SceneError
from ..reading.remarks import Remark
from ..scattering.data.record import ScatteringFile
from ..scattering.data.table import albedos_of, direction_of
from ..scattering.data.tree import square_of
from ..scene.material import Measured
from ..scene.scattering import ScatterTable
from .composition import Cloth
from .matter import ANCHORS, WAVELENGTHS, absorption, anchor_weights, thread_optics
from .records import EXITS, DrawnExits, recorded
from .tracer import KINDS, WovenScene
from .tubes import lay_out, lay_out_straight

INCIDENCES = np.radians([0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 80.0, 87.0])
"""Angles of incidence of tables. [rad]"""

RADIALS = np.radians([0, 8, 16, 24, 34, 45, 57, 70, 85, 100, 120, 140, 160, 180.0])

AZIMUTH_STEP = np.radians(15.0)

AZIMUTHS = AZIMUTH_STEP * np.arange(25)

QUARTER, ROUND = np.radians(np.arange(0.0, 91.0, 15.0)), np.radians(np.arange(0.0, 360.0, 30.0))
"""Rotations of orthotropic cloths, and of others. [rad]"""

RAYS = 120_000
"""Rays of each direction."""

CELLS = 20
"""Cells along the sides of the square that the disk of directions is mapped to."""

BLUR = 0.8
"""Standard deviation by which counts are smoothed. [cell]"""

LOWEST = np.cos(np.radians(89.0))
"""Directions below take the value there, so that what lies below the horizon does not count as dark."""

CUTOFF_TILTS = np.radians(np.arange(0.5, 90.0, 0.5))
"""Angles of incidence among which the one is sought from which on no light passes straight. [rad]"""

CUTOFF_RAYS = 2500
"""Rays of each."""

NEAR_NOTHING = 1e-3
"""Straight share below which a cloth counts as closed. [-]"""

MOST_LOST = 1e-3
"""Share of rays that may be given up."""

FLOOR = 0.05
"""Share of the largest albedo over pi that is added to values where errors are told relative to them."""


@dataclass(frozen=True, eq=False)
class Woven:
    """A cloth's tables, and how far they may be trusted.

    Parameters
    ----------
    cloth : Cloth
    sides : dict of str to ScatterTable    By the names of `scattering.data.record.SIDES`.
    absorbed : dict of str to (p, s, w) array    Share of light onto ``front`` and ``back`` that is absorbed. [-]
    errors : dict of str to (p, s, w) array    Standard error of the totals of ``sides``, their direct part included. [-]
    cutoffs : (float, float)
        Angles of incidence from which on no light passes straight, light coming along the warp, and along the weft. [rad]
    lost : float    Share of rays that were given up. [-]
    rays, seed : int    Rays in all.
    is_mean : bool    Whether they are the mean of warp and weft, see `weave`.
    """

    cloth: Cloth
    sides: dict[str, ScatterTable]
    absorbed: dict[str, np.ndarray]
    errors: dict[str, np.ndarray]
    cutoffs: tuple[float, float]
    lost: float
    rays: int
    seed: int
    is_mean: bool = False

    @property
    def surface(self) -> Measured:
        """The cloth as a surface."""
        return Measured(**self.sides)

    @property
    def openness(self) -> float:
        """Share of light along the normal that passes straight. [-]"""
        return float(self.sides["front_transmission"].direct[0, 0, 0])

    def file(self) -> ScatteringFile:
        """The tables as a file of ours holds them."""
        cloth = self.cloth
        table = self.sides["front_reflection"]
        return ScatteringFile(
            Path(f"{cloth.name}.lumbsdf"),
            "Lumenray scattering",
            self.sides,
            cloth.name,
            cloth.description,
            cloth.source,
            table.incidences,
            remarks=tuple(Remark(text) for text in self.notes()),
        )

    def notes(self) -> list[str]:
        """Say what the tables leave out or assume."""
        worst = max(each.error for each in self.sides.values())
        notes = [
            f"computed from its yarns with {self.rays} rays, seed {self.seed}; values within {100 * worst:.2g} % "
            "(standard error, relative to the value plus a twentieth of the largest albedo over pi)",
            "yarns are smooth bodies of one matter, not twists of fibres: no hairs stand off them",
            f"directions are resolved to about {np.degrees(2.0 * BLUR / CELLS * np.sqrt(np.pi)):.0f} degrees",
        ]
        if self.is_mean:
            notes.append("the mean of warp and weft, each straight as if the other were not there")
        if any(abs(yarn.width_mm - yarn.height_mm) > 1e-9 for yarn in self.cloth.yarns):
            notes.append("light in flat yarns goes as in round ones with the same mean way")
        if self.lost > 0.0:
            notes.append(f"{100 * self.lost:.2g} % of the rays were given up and count as absorbed")
        return notes


def weave(
    cloth: Cloth,
    wavelengths=WAVELENGTHS,
    rays: int = RAYS,
    seed: int = 0,
    exits: int = EXITS,
    report=lambda share: None,
    is_mean: bool = False,
) -> Woven:
    """Compute the tables of a cloth. A variant of Mitsuba must be active.

    Parameters
    ----------
    wavelengths : (w,) array    [nm]
    rays : int    For each direction from which light comes.
    exits : int    For each way into a thread, see `records`.
    report : callable    Told from time to time which share of the work is done; what it raises ends it.
    is_mean : bool
        Whether to take the mean of the warp and of the weft, each straight and side by side as if the other were not
        there, in place of the weave: the reference's simple way. It has no pile, and no openings where yarns cross.

    Raises
    ------
    SceneError    Rays got lost, or the pile is too dense.
    """
    maker = Maker(cloth, np.asarray(wavelengths, np.float64), rays, seed, exits, is_mean)
    lights = ("front",) if maker.is_alike else ("front", "back")
    sides, absorbed, errors = {}, {}, {}
    for number, light in enumerate(lights):
        found = maker.count(light == "front", lambda s: report((number + s) / len(lights)))  # noqa: B023
        for part in ("reflection", "transmission"):
            sides[f"{light}_{part}"], errors[f"{light}_{part}"] = maker.tabulate(found, part)
        absorbed[light] = found.absorbed
    if maker.is_alike:
        for part in ("reflection", "transmission"):
            sides[f"back_{part}"] = sides[f"front_{part}"]
            errors[f"back_{part}"] = errors[f"front_{part}"]
        absorbed["back"] = absorbed["front"]
    if maker.lost > MOST_LOST:
        raise SceneError(
            f"'{cloth.name}': {100 * maker.lost:.2g} % of the rays found no way out, expected {100 * MOST_LOST:g} % at most"
        )
    cutoffs = np.max([cutoff_angles(scene, seed) for scene in maker.scenes], axis=0)
    cutoffs = float(cutoffs[0]), float(cutoffs[1])
    return Woven(cloth, sides, absorbed, errors, cutoffs, maker.lost, maker.sent, seed, is_mean)


def cutoff_angles(scene: WovenScene, seed: int = 0) -> tuple[float, float]:
    """Angles of incidence from which on no light passes straight, along warp and weft; 0 if none does at all. [rad]"""
    sine, cosine, none = np.sin(CUTOFF_TILTS), -np.cos(CUTOFF_TILTS), np.zeros(len(CUTOFF_TILTS))
    found = []
    for light in ((none, sine, cosine), (sine, none, cosine)):
        is_open = scene.straight_shares(np.stack(light, axis=1), CUTOFF_RAYS, seed) > NEAR_NOTHING
        last = np.flatnonzero(is_open)
        # Half a step on: between the last that is open and the first that is not.
        found.append(CUTOFF_TILTS[last[-1]] + 0.5 * CUTOFF_TILTS[0] if len(last) else 0.0)
    return found[0], found[1]


@dataclass
class _Counted:
    """Light that left: by rotation, incidence, half of the rays, cell and band; and straight, by rotation and incidence."""

    reflection: np.ndarray
    transmission: np.ndarray
    straight: np.ndarray
    absorbed: np.ndarray


class Maker:
    """Sends light onto a cloth and makes tables of where it leaves. Parameters as of `weave`."""

    def __init__(
        self, cloth: Cloth, wavelengths, rays: int, seed: int, exits: int, is_mean: bool = False
    ):
        self.cloth, self.wavelengths, self.seed = cloth, wavelengths, seed
        yarns = [*cloth.yarns, cloth.warp][:KINDS]
        anchors = ANCHORS
        if all(_is_alike(yarn) for yarn in yarns):
            anchors = ANCHORS[1:2]
        optics = [[thread_optics(yarn, anchor) for yarn in yarns] for anchor in anchors]
        records = [recorded(each, exits, seed) for row in optics for each in row]
        drawn, radii = DrawnExits(records), [yarn.radius_mm for yarn in yarns]
        tubes = [lay_out_straight(cloth, kind) for kind in (0, 1)] if is_mean else [lay_out(cloth)]
        self.anchors = len(anchors)
        self.scenes = [WovenScene(each, optics[0], drawn, len(anchors), radii) for each in tubes]
        self.absorption = np.array([absorption(yarn, wavelengths) for yarn in yarns])
        self.weights = len(anchors) * anchor_weights(anchors, wavelengths)
        block = 2 * len(anchors) * len(self.scenes)
        self.rays = block * max(1, round(rays / block))
        # Yarns of one kind of plain weave change places when it is turned over.
        self.is_alike = is_mean or (cloth.weave.is_orthotropic and cloth.pile is None)
        self.rotations = QUARTER if self.is_alike else ROUND
        self.lost, self.sent, self.given_up = 0.0, 0, 0

    def count(self, is_front: bool, report) -> _Counted:
        """Send light onto one side from all directions of a table."""
        shape = len(self.rotations), len(INCIDENCES)
        cells = (*shape, 2, CELLS * CELLS, len(self.wavelengths))
        found = _Counted(
            np.zeros(cells), np.zeros(cells), np.zeros(shape), np.zeros((*shape, cells[-1]))
        )
        parts = found.reflection, found.transmission, found.straight, found.absorbed
        half_turn = len(self.rotations) // 2
        for p in range(shape[0]):
            for s in range(shape[1]):
                report((p * shape[1] + s) / (shape[0] * shape[1]))
                if self.cloth.weave.turns_back and not self.is_alike and self._turns(p) and s:
                    for part in parts:
                        part[p, s] = part[p - half_turn, s]
                elif s or not p:
                    self._shine(found, p, s, is_front)
        self.lost = self.given_up / self.sent
        return found

    def _turns(self, p: int) -> bool:
        return p >= len(self.rotations) // 2 and self.cloth.pile is None

    def _shine(self, found, p, s, is_front) -> None:
        upwards = 1.0 if is_front else -1.0
        # Light along the normal comes from one direction only, and counts for all rotations.
        count = self.rays * (1 if s else 2)
        number = (int(is_front) * len(self.rotations) + p) * len(INCIDENCES) + s
        rng = np.random.default_rng((self.seed, 13, number))
        step = (self.rotations[1] - self.rotations[0]) * (s > 0)
        turn = self.rotations[p] + step * (rng.random(count) - rng.random(count))
        cosine, sine = np.cos(turn), np.sin(turn)
        sideways, along = -np.sin(INCIDENCES[s]), -upwards * np.cos(INCIDENCES[s])
        light = [
            mi.Float(each) for each in (sideways * cosine, sideways * sine, np.full(count, along))
        ]
        lost, events, ways, x, y, z = self.trace(light, count, self.seed * 1000 + number + 1)
        straight = (events == 0) & ~lost
        weight = self.weigh(~lost & ~straight, ways)
        # In the plane of the light's own incidence.
        x, y = cosine * x + sine * y, cosine * y - sine * x
        above = z * upwards > 0.0
        half = np.arange(count) // self.anchors % 2
        for k in range(len(self.rotations) if s == 0 else 1):
            c, d = (np.cos(self.rotations[k]), np.sin(self.rotations[k])) if s == 0 else (1.0, 0.0)
            u, v = square_of(c * x + d * y, c * y - d * x)
            cell = [np.clip((each * CELLS).astype(np.int64), 0, CELLS - 1) for each in (u, v)]
            place = cell[0] * CELLS + cell[1] + CELLS * CELLS * half
            for part, is_there in ((found.reflection, above), (found.transmission, ~above)):
                for band in range(weight.shape[1]):
                    part[p + k, s, :, :, band] = np.bincount(
                        place, weight[:, band] * is_there, 2 * CELLS * CELLS
                    ).reshape(2, -1) * (2.0 / count)
            found.straight[p + k, s] = straight.mean()
            found.absorbed[p + k, s] = 1.0 - straight.mean() - weight.mean(axis=0)
        self.sent += count
        self.given_up += int(lost.sum())

    def weigh(self, scattered, ways) -> np.ndarray:
        """What is left of rays in each band, 0 of those that have not scattered. (n,) bool, (kinds, n) [mm] -> (n, w)"""
        anchor = np.arange(len(scattered)) % self.anchors
        weight = self.weights[anchor] * scattered[:, None]
        # As many as went in, though anchors have met their shares of openings by chance.
        weight *= scattered.mean() / np.maximum(weight.mean(axis=0), 1e-12)
        return weight * np.exp(-ways.T @ self.absorption)

    def trace(self, light, count: int, seed: int, places=None):
        """Send the first rays into the first scene, and so on.

        Returns
        -------
        lost (n,), events (n,), ways (kinds, n) [mm], and the three components of directions (n,)
        """
        part = count // len(self.scenes)
        found = []
        for k, scene in enumerate(self.scenes):
            rows = mi.UInt32(np.arange(k * part, (k + 1) * part))
            own, spots = (
                each
                if each is None or not isinstance(each[0], mi.Float)
                else [dr.gather(mi.Float, one, rows) for one in each]
                for each in (light, places)
            )
            made = scene.trace(own, part, seed, spots)
            ways = np.array([np.array(each) for each in made.ways], np.float64)
            direction = (np.array(each, np.float64) for each in (made.x, made.y, made.z))
            found.append((np.array(made.lost), np.array(made.events), ways, *direction))
        return [np.concatenate(each, axis=-1) for each in zip(*found, strict=True)]

    def tabulate(self, found: _Counted, part: str) -> tuple[ScatterTable, np.ndarray]:
        """Make the table of what was counted, ``reflection`` or ``transmission``; and standard errors of its totals."""
        counts = getattr(found, part)
        total = counts.sum(axis=3)  # (p, s, half, w)
        i, t, a = np.meshgrid(INCIDENCES, RADIALS, AZIMUTHS, indexing="ij")
        halves = np.zeros((2, len(self.rotations), *i.shape, len(self.wavelengths)))
        for shift, share in ((-0.5, 0.25), (0.0, 0.5), (0.5, 0.25)):
            wo = direction_of(i, t, a + shift * AZIMUTH_STEP)
            low = wo[..., 2] < LOWEST
            level = np.hypot(wo[..., 0], wo[..., 1])
            wo[low, :2] *= (np.sqrt(1.0 - LOWEST**2) / np.maximum(level, 1e-12))[low, None]
            for p in range(len(self.rotations)):
                for s in range(len(INCIDENCES)):
                    for half in range(2):
                        halves[half, p, s] += share * _read(
                            counts[p, s, half], wo[s, ..., 0], wo[s, ..., 1]
                        )
        direct = None
        if part == "transmission":
            direct = np.repeat(found.straight[..., None], len(self.wavelengths), 2).astype(
                np.float32
            )
        made = []
        for k in range(3):
            # Both halves, and all of them; each is brought to its own total.
            values = halves.mean(axis=0) if k == 2 else halves[k]
            want = total.mean(axis=2) if k == 2 else total[:, :, k]
            table = ScatterTable(
                self.rotations,
                INCIDENCES,
                RADIALS,
                AZIMUTHS,
                self.wavelengths,
                values.astype(np.float32),
                direct,
                is_orthotropic=self.is_alike,
            )
            own = albedos_of(table, INCIDENCES, self.rotations)
            scale = want / np.maximum(own, 1e-12)
            made.append(
                replace(table, values=(values * scale[:, :, None, None]).astype(np.float32))
            )
        whole = made[2]
        floor = max(FLOOR * float(total.max()) / np.pi, 1e-9)
        apart = 0.5 * (made[0].values - made[1].values) / (whole.values + floor)
        is_above = (direction_of(i, t, a)[..., 2] > 0.0)[None, ..., None]
        square = np.where(is_above, apart.astype(np.float64) ** 2, 0.0).sum() / (
            is_above.sum() * apart[0, 0, 0, 0].size * len(self.rotations)
        )
        # Of a share of all rays, counted: never more than that of a ray that is there or not.
        mean = total.mean(axis=2)
        spread = np.sqrt(np.maximum(mean * (1.0 - mean), 0.0) * self.anchors / self.rays)
        return replace(whole, error=float(np.sqrt(square))), spread


def _is_alike(yarn) -> bool:
    """Whether a yarn scatters at all wavelengths as at the middle one: it has nothing that scatters."""
    return not yarn.scatterers


def _read(cells: np.ndarray, x, y) -> np.ndarray:
    """Values at directions of counts on cells of the disk. (c, w), two (t, a) -> (t, a, w) [1/sr]"""
    square = cells.reshape(CELLS, CELLS, -1)
    reach = int(np.ceil(3.0 * BLUR))
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / BLUR) ** 2)
    weights /= weights.sum()
    for axis in (0, 1):
        pad = [(reach, reach) if k == axis else (0, 0) for k in range(3)]
        # Mirrored at the horizon, which keeps the light.
        wide = np.pad(square, pad, mode="symmetric")
        square = sum(
            weight * np.take(wide, np.arange(CELLS) + k, axis) for k, weight in enumerate(weights)
        )
    u, v = square_of(x.ravel(), y.ravel())
    found = 0.0
    places = [np.clip(each * CELLS - 0.5, 0.0, CELLS - 1.0) for each in (u, v)]
    lows = [np.minimum(place.astype(np.int64), CELLS - 2) for place in places]
    shares = [place - low for place, low in zip(places, lows, strict=True)]
    for one in (0, 1):
        for two in (0, 1):
            weight = np.abs(1 - one - shares[0]) * np.abs(1 - two - shares[1])
            found = found + weight[:, None] * square[lows[0] + one, lows[1] + two]
    return (found * CELLS * CELLS / np.pi).reshape(*x.shape, -1)
