"""From where single sensors get light over bends: what rays have found there, so that later ones look there again.

The aims of `bent_lights` serve all places, and what a sensor sees of a lamp in a ball of glass may be a hundredth of what
they look at. So some rays of each sensor look by the aims; of the directions in which they have met a light, some are kept,
drawn by what was found. Later rays look about one of these, or by the aims, and are weighed by the density of both together:
wherever light comes from, the estimate has no bias, and what the first rays have found is not used itself.

Ideal points are taken for spheres, which makes edges of caustics less sharp. Rays that know where to look meet smaller ones
as well: a second turn looks for a quarter of the size, and such light errs by a sixteenth.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...errors import Cancelled
from ..paths import gather
from ..paths.illuminance import LANES, Places
from ..paths.sampler import hash_words, random_stream
from .emission_rays import in_cap

KEPT = 32
"""Directions that are kept of a sensor."""

FEWEST = 8
"""Different ones that must have been found; with fewer, rays go by the aims alone."""

SHARE = 0.75
"""Share of the rays that looks about known directions. [-]"""

RAYS, ALL_RAYS = (1 << 9, 1 << 13), 1 << 21
"""Fewest and most rays of a sensor that look for directions; and of all sensors together, about."""

WIDTH = 2.0
"""Width of the cone about a known direction, in median distances from one found direction to its nearest neighbours; of so
many of these."""

NEIGHBOURS = 4

NARROWEST = 1e-12
"""Least width, as 1 - cos: directions have no more digits."""

SIZES = (1.0, 0.25)
"""Sizes of spheres that stand for points, relative to the usual one, turn by turn of looking for directions."""

COLUMNS = 4
"""Direction and aim, row by row."""

SALT = 0x6B21
"""Sets these rays apart from others of the same seed."""


class KnownDirections:
    """Tables of sensors on the device.

    Parameters
    ----------
    scene : CompiledScene    With its light over bends.
    receivers : Receivers
    seed : int
    samples : int or None    That each receiver will have at most, where it is known.
    cancelled : callable    Asked before every launch.

    Attributes
    ----------
    is_useful : bool    Whether anything is known.
    rows, numbers : Float, list of Float    The tables, see `Directions`.
    """

    def __init__(self, scene, receivers, seed: int, samples: int | None, cancelled):
        self.scene, self._kind, self._seed = scene, receivers.kind, seed
        count = len(receivers.start)
        self.is_useful = False
        rays = min(ALL_RAYS // max(count, 1), RAYS[1], RAYS[1] if samples is None else samples)
        if scene.bent is None or not count or rays < RAYS[0]:
            return
        self._places = Places(scene, receivers)
        rays = 1 << int(np.log2(rays))
        self._rows = np.zeros((count, KEPT, COLUMNS), dtype=np.float32)
        self._caps, self._shares = np.full(count, NARROWEST), np.zeros(count)
        self._scales = np.ones(count)
        self._draw = np.random.default_rng([seed & 0xFFFFFFFF, SALT])
        self._step = max(LANES // rays, 1)
        self._put()
        for turn, scale in enumerate(SIZES):
            if turn and not (self.is_useful and scene.bent.has_points):
                break
            self._learn(turn, scale, rays, cancelled)

    def _learn(self, turn: int, scale: float, rays: int, cancelled) -> None:
        """Look for directions at receivers, by those that are known so far, and keep what is found."""
        known, before = [], self._scales.copy()
        # Who knows nothing yet has no use for smaller lights.
        self._scales[self._shares > 0.0] = scale
        self._put()
        count = len(self._shares)
        for first in range(0, count, self._step):
            if cancelled():
                raise Cancelled("cancelled")
            found = self._look(turn, first, min(self._step, count - first), rays)
            for number in np.unique(found[0]):
                own = found[0] == number
                if own.sum() >= FEWEST and (turn == 0 or self._shares[first + number] > 0.0):
                    known.append(first + number)
                    self._keep(first + number, *(each[own] for each in found[1:]))
        is_known = np.zeros(count, dtype=bool)
        is_known[known] = True
        self._shares[is_known] = SHARE
        self._scales = np.where(is_known, scale, before)
        self.is_useful = bool(self._shares.any())
        self._put()

    def _keep(self, receiver: int, amounts, directions, aims) -> None:
        """Keep some of the directions that were found, drawn by what they bring."""
        kept = self._draw.choice(len(amounts), KEPT, p=amounts / amounts.sum())
        self._rows[receiver, :, :3] = directions[kept]
        self._rows[receiver, :, 3] = aims[kept]
        self._caps[receiver] = _width(directions)

    def _put(self) -> None:
        """Upload the tables."""
        self.rows = upload(mi.Float, self._rows)
        self.numbers = [upload(mi.Float, each) for each in (self._shares, self._caps, self._scales)]
        dr.eval(self.rows, self.numbers)

    def of(self, who) -> "Directions":
        """What receivers know. ``who``: their numbers, UInt32."""
        return Directions(self, who)

    def _look(self, turn: int, first: int, count: int, rays: int):
        """Rays of receivers that have met a light: receiver, what was found [any unit], direction and aim. (m,) each"""
        lane = dr.arange(mi.UInt32, count * rays)
        who = lane // dr.opaque(mi.UInt32, rays) + dr.opaque(mi.UInt32, first)
        seed = dr.opaque(mi.UInt32, (int(self._seed) + SALT + turn) & 0xFFFFFFFF)
        own = hash_words(who, seed)
        wavelengths = gather.typical_wavelengths()
        stream = random_stream(lane, own)
        point = mi.UInt32(stream.next_uint32())
        si = self._places.choose(who, point, own, wavelengths)
        respond = gather.response_of(self._kind, si)
        value, index, direction = self.scene.bent.look(
            si,
            stream,
            lambda direction, asked: (respond(direction), mi.Float(0.0)),
            mi.Bool(True),
            known=self.of(who) if turn else None,
        )
        amount = dr.max(value)
        amount = dr.select(dr.isfinite(amount), amount, 0.0) + mi.Float(lane) * 0.0
        dr.eval(amount, index, direction)
        amount = np.array(amount, dtype=np.float64)
        hits = np.flatnonzero(amount > 0.0)
        directions = np.stack([np.array(direction[k]) for k in range(3)], axis=1)[hits]
        return hits // rays, amount[hits], directions, np.array(index)[hits]


@dataclass(frozen=True)
class Directions:
    """What receivers know, inside a kernel."""

    tables: KnownDirections
    who: object

    def draw(self, stream, index, direction):
        """An aim and a direction: about a known one, or those given."""
        share, cap = self._number(0), self._number(1)
        row = dr.minimum(mi.UInt32(stream.next_float32() * KEPT), KEPT - 1)
        is_known = stream.next_float32() < share
        axis, aim = self._row(row)
        sample = mi.Point2f(stream.next_float32(), stream.next_float32())
        near = mi.Frame3f(axis).to_world(in_cap(cap, sample))
        return (
            dr.select(is_known, mi.UInt32(aim), index),
            dr.select(is_known, near, direction),
        )

    def density(self, other, light, direction):
        """Density of a direction, for a light: of known directions and of others of the density ``other``. [sr-1]"""
        share, cap = self._number(0), self._number(1)
        bent = self.tables.scene.bent

        def add(held, i):
            axis, aim = self._row(i)
            # By the chord, since cosines of narrow cones have no digits left.
            inside = 0.5 * dr.squared_norm(direction - axis) <= cap * (1.0 + 1e-4) + 1e-13
            own = inside & (bent.light_of(mi.UInt32(aim)) == light)
            return dr.select(own, held + 1.0, held), i + 1

        held, _ = dr.while_loop(
            state=(mi.Float(0.0), mi.UInt32(0)),
            cond=lambda held, i: (share > 0.0) & (i < KEPT),
            body=add,
            labels=("held", "i"),
        )
        known = held * (dr.inv_two_pi / KEPT) / cap
        return (1.0 - share) * other + share * known

    def scale(self):
        """Size of spheres that stand for points, relative to the usual one."""
        return self._number(2)

    def _number(self, column: int):
        """Share of the rays that looks about known directions, 1 - cos of the cone's half angle, or `scale`."""
        return dr.gather(mi.Float, self.tables.numbers[column], self.who)

    def _row(self, number):
        """A direction, and its aim."""
        first = (self.who * KEPT + number) * COLUMNS
        axis = mi.Vector3f(*(dr.gather(mi.Float, self.tables.rows, first + k) for k in range(3)))
        return axis, dr.gather(mi.Float, self.tables.rows, first + 3)


def _width(directions: np.ndarray) -> float:
    """1 - cos of the half angle of a cone that reaches from one found direction over its neighbours."""
    some = directions[:256].astype(np.float64)
    squares = ((some[:, None] - some[None]) ** 2).sum(axis=2)
    # Of KEPT ones about as many are as near to each other as of all found the NEIGHBOURS * n / KEPT nearest.
    rank = min(max(NEIGHBOURS * len(some) // KEPT, NEIGHBOURS), len(some) - 1)
    near = float(np.sqrt(np.median(np.partition(squares, rank, axis=1)[:, rank])))
    return float(np.clip(0.5 * (WIDTH * near) ** 2, NARROWEST, 1.0))
