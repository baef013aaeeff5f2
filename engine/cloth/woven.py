"""What a woven cloth reflects and lets through, as the tables of a measured material on both sides.

Rays come from each direction of the table. Where they leave is counted on the disk of directions' x and y, of which equal
areas are equal projected solid angles, and `tabulation` reads them off at the table's directions. What met no yarn passes
straight and stands in the tables' direct part.

Clear yarns send light along narrow arcs. So a table's rotations and azimuths hold means weighted by how much they count in
between, and a mean over turns of the light or of the eye is that of the cloth.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

from ..errors import SceneError
from ..reading.remarks import Remark
from ..scattering.data.record import ScatteringFile
from ..scattering.data.surface import ROUNDING, excess_of
from ..scattering.data.tree import square_of
from ..scene.material import Measured
from ..scene.scattering import ScatterTable
from .composition import Cloth
from .matter import ANCHORS, WAVELENGTHS, absorption, anchor_weights, thread_optics
from .plan import INCIDENCES, QUARTER, RAYS, ROUND, is_alike
from .records import EXITS, DrawnExits, recorded
from .tabulation import BLUR, CELLS, Counted, tabulate
from .tracer import KINDS, WovenScene
from .tubes import lay_out, lay_out_straight

CUTOFF_TILTS = np.radians(np.arange(0.5, 90.0, 0.5))
"""Angles of incidence among which the one is sought from which on no light passes straight. [rad]"""

CUTOFF_RAYS = 2500
"""Rays of each."""

NEAR_NOTHING = 1e-3
"""Straight share below which a cloth counts as closed. [-]"""

MOST_LOST = 1e-3
"""Share of rays that may be given up."""


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
        excess = max(
            excess_of(*(self.sides[f"{light}_{part}"] for part in ("reflection", "transmission")))
            for light in ("front", "back")
        )
        if excess > 1.0 + ROUNDING:
            notes.append(
                f"between its angles of incidence up to {100.0 * (excess - 1.0):.2g} % too much light leaves it; where "
                "light is computed with it, it is scaled down there"
            )
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
    counted = {
        light: maker.count(light == "front", lambda s: report((number + s) / len(lights)))  # noqa: B023
        for number, light in enumerate(lights)
    }
    # The back of a cloth that is alike is its front.
    counted.setdefault("back", counted["front"])
    sides = tabulate(counted, maker.rotations, maker.wavelengths, maker.is_alike)
    errors = {side: maker.spread_of(counted, side) for side in sides}
    absorbed = {light: each.absorbed for light, each in counted.items()}
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


class Maker:
    """Sends light onto a cloth and makes tables of where it leaves. Parameters as of `weave`."""

    def __init__(
        self, cloth: Cloth, wavelengths, rays: int, seed: int, exits: int, is_mean: bool = False
    ):
        self.cloth, self.wavelengths, self.seed = cloth, wavelengths, seed
        yarns = [*cloth.yarns, cloth.warp][:KINDS]
        anchors = ANCHORS
        if all(_is_clear(yarn) for yarn in yarns):
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
        self.is_alike = is_mean or is_alike(cloth)
        self.rotations = QUARTER if self.is_alike else ROUND
        self.lost, self.sent, self.given_up = 0.0, 0, 0

    def count(self, is_front: bool, report) -> Counted:
        """Send light onto one side from all directions of a table."""
        shape = len(self.rotations), len(INCIDENCES)
        cells = (*shape, 2, CELLS * CELLS, len(self.wavelengths))
        found = Counted(
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

    def spread_of(self, counted: dict[str, Counted], side: str) -> np.ndarray:
        """Standard errors of the totals of a side. (p, s, w) [-]"""
        light, part = side.split("_")
        mean = getattr(counted[light], part).sum(axis=3).mean(axis=2)
        # Of a share of all rays, counted: never more than that of a ray that is there or not.
        return np.sqrt(np.maximum(mean * (1.0 - mean), 0.0) * self.anchors / self.rays)

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


def _is_clear(yarn) -> bool:
    """Whether a yarn scatters at all wavelengths as at the middle one: it has nothing that scatters."""
    return not yarn.scatterers
