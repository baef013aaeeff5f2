"""From where single sensors get light over bends: what rays have found there, so that later ones look there again.

The aims of `bent_lights` serve all places, and what a sensor sees of a lamp in a ball of glass may be a hundredth of what
they look at. Light that lands near to a sensor tells by which ways it comes there: some of these are supposed to be the
sensor's too. Some rays look about them and by the aims, and of the directions in which they have met a light some are kept.
Later rays look about one of either kind, or by the aims, and are weighed by the density of all together: wherever light
comes from, the estimate has no bias, and what the first rays have found is not used itself.

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

SUPPOSED, NEAR = (4, 16), 128
"""Those of them that are supposed, where others are sure and where not, and ways of light that lands nearest, out of which
they are chosen."""

SURE = 64.0
"""Rays, all of which bring the same, that scatter as those do which have found directions: with more these are sure."""

ALL_PAIRS = 1 << 26
"""Distances from sensors to where light lands that are looked at, of all sensors together, about."""

CHUNK = 64
"""Sensors whose distances are taken at once."""

FEWEST = 2
"""Directions of a light of a smaller size that must have been found for a sensor to keep to it."""

SHARES, BELIEVED = (0.75, 0.5), 8
"""Share of the rays that looks about known directions, where at least so many have been found, and where not. [-]"""

RAYS, ALL_RAYS = (1 << 9, 1 << 13), 1 << 21
"""Fewest and most rays of a sensor that look for directions; and of all sensors together, about."""

WIDTH, NEIGHBOURS = 2.0, 4
"""Width of the cone about a direction, in distances to its nearest neighbours among those found, or to those that a supposed
one stands for; of so many of these among KEPT."""

MOST_FOUND = 512
"""Directions that were found, among which neighbours are looked for, about."""

LONELY = 5e-4
"""Width about the only direction that was found, as 1 - cos."""

NARROWEST = 1e-12
"""Least width, as 1 - cos: directions have no more digits."""

SIZES = (1.0, 0.25)
"""Sizes of spheres that stand for points, relative to the usual one, turn by turn of looking for directions."""

COLUMNS = 5
"""Direction, aim and 1 - cos of the half angle of the cone, row by row."""

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
        self._rows[..., 4] = NARROWEST
        self._shares, self._scales = np.zeros(count), np.ones(count)
        self._draw = np.random.default_rng([seed & 0xFFFFFFFF, SALT])
        self._step = max(LANES // rays, 1)
        self._supposed = self._suppose(receivers)
        for number in range(count):
            self._keep(number, np.zeros((0, COLUMNS)), SUPPOSED[1], SHARES[1])
        for turn, scale in enumerate(SIZES):
            if turn and not (self.is_useful and scene.bent.has_points):
                break
            self._learn(turn, scale, rays, cancelled)

    def _suppose(self, receivers) -> list[np.ndarray]:
        """Ways by which light comes to what lies near, of every receiver, as `_spread` takes them. (m, COLUMNS) each"""
        bent, count = self.scene.bent, len(receivers.start)
        lines = bent.lines
        held = np.flatnonzero(lines.light < len(bent.lights))
        most = max(ALL_PAIRS // count, NEAR)
        if len(held) > most:
            held = self._draw.choice(held, most, replace=False)
        start, end = lines.start[held], lines.end[held]
        aims = np.array([bent.first_aim(number) for number in lines.light[held]])
        places, normals = receivers.outlooks(self.scene)
        is_planar, made = receivers.geometric_normals.any(), []
        for first in range(0, count, CHUNK):
            some = places[first : min(first + CHUNK, count)]
            # All distances at once, but for the square of the place, which is the same for all.
            order = (end**2).sum(axis=1) - 2.0 * some @ end.T
            near = np.argsort(order) if len(held) <= NEAR else np.argpartition(order, NEAR)
            for own, place, normal in zip(near[:, :NEAR], some, normals[first:], strict=False):
                ways = start[own] - place
                distances = np.maximum(np.linalg.norm(ways, axis=1), 1e-30)
                # From where light comes to a place beside is known no better than by this angle.
                doubt = np.linalg.norm(end[own] - place, axis=1) / distances
                columns = np.column_stack([ways / distances[:, None], aims[own], doubt])
                made.append(columns[ways @ normal > 0.0] if is_planar else columns)
        return made

    def _learn(self, turn: int, scale: float, rays: int, cancelled) -> None:
        """Look for directions at receivers, by those that are known so far, and keep what is found."""
        before = self._scales.copy()
        # Who knows nothing yet has no use for smaller lights.
        self._scales[self._shares > 0.0] = scale
        self._put()
        count = len(self._shares)
        is_found = np.zeros(count, dtype=bool)
        for first in range(0, count, self._step):
            if cancelled():
                raise Cancelled("cancelled")
            found = self._look(turn, first, min(self._step, count - first), rays)
            for number in np.unique(found[0]):
                amounts, directions, aims = (each[found[0] == number] for each in found[1:])
                if len(amounts) >= (FEWEST if turn else 1):
                    is_found[first + number] = True
                    # Rather those that bring more, but not what one ray has brought by chance alone.
                    chance = np.sqrt(amounts)
                    kept = self._draw.choice(len(chance), KEPT, p=chance / chance.sum())
                    widths = _widths(directions, kept)
                    rows = np.column_stack([directions[kept], aims[kept], widths])
                    is_sure = amounts.sum() ** 2 > SURE * (amounts**2).sum()
                    share = SHARES[0 if len(amounts) >= BELIEVED else 1]
                    self._keep(first + number, rows, SUPPOSED[0 if is_sure else 1], share)
        self._scales = np.where(is_found, scale, before)
        self.is_useful = bool(self._shares.any())
        self._put()

    def _keep(self, receiver: int, found: np.ndarray, most: int, share: float) -> None:
        """Look about what was found, and about what is supposed: rays may not have met all that is there.

        ``found``: rows, (m, COLUMNS); ``most``: that are supposed; ``share``: of the rays that looks so.
        """
        supposed = _spread(self._supposed[receiver], most)
        rows = np.concatenate([found[: KEPT - len(supposed)], supposed])
        if len(rows):
            self._rows[receiver] = np.resize(rows, (KEPT, COLUMNS))
            self._shares[receiver] = share

    def _put(self) -> None:
        """Upload the tables."""
        self.rows = upload(mi.Float, self._rows)
        self.numbers = [upload(mi.Float, each) for each in (self._shares, self._scales)]
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
            known=self.of(who),
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
        row = dr.minimum(mi.UInt32(stream.next_float32() * KEPT), KEPT - 1)
        is_known = stream.next_float32() < self._number(0)
        axis, aim, cap = self._row(row)
        sample = mi.Point2f(stream.next_float32(), stream.next_float32())
        near = mi.Frame3f(axis).to_world(in_cap(cap, sample))
        return (
            dr.select(is_known, mi.UInt32(aim), index),
            dr.select(is_known, near, direction),
        )

    def density(self, other, light, direction):
        """Density of a direction, for a light: of known directions and of others of the density ``other``. [sr-1]"""
        share, bent = self._number(0), self.tables.scene.bent

        def add(held, i):
            axis, aim, cap = self._row(i)
            # By the chord, since cosines of narrow cones have no digits left.
            inside = 0.5 * dr.squared_norm(direction - axis) <= cap * (1.0 + 1e-4) + 1e-13
            own = inside & (bent.light_of(mi.UInt32(aim)) == light)
            return dr.select(own, held + dr.rcp(cap), held), i + 1

        held, _ = dr.while_loop(
            state=(mi.Float(0.0), mi.UInt32(0)),
            cond=lambda held, i: (share > 0.0) & (i < KEPT),
            body=add,
            labels=("held", "i"),
        )
        known = held * (dr.inv_two_pi / KEPT)
        return (1.0 - share) * other + share * known

    def scale(self):
        """Size of spheres that stand for points, relative to the usual one."""
        return self._number(1)

    def _number(self, column: int):
        """Share of the rays that looks about known directions, or `scale`."""
        return dr.gather(mi.Float, self.tables.numbers[column], self.who)

    def _row(self, number):
        """A direction, its aim, and 1 - cos of the half angle of the cone about it."""
        first = (self.who * KEPT + number) * COLUMNS
        axis = mi.Vector3f(*(dr.gather(mi.Float, self.tables.rows, first + k) for k in range(3)))
        aim, cap = (dr.gather(mi.Float, self.tables.rows, first + k) for k in (3, 4))
        return axis, aim, cap


def _spread(ways: np.ndarray, most: int) -> np.ndarray:
    """Ways that lie as far apart as can be, with cones that hold the others. (n, COLUMNS) -> (m, COLUMNS)

    ``ways``: direction, aim, and angle by which it is in doubt [rad]; ``most``: that are kept.
    """
    if not len(ways):
        return ways
    directions = ways[:, :3]
    chosen, held = [0], np.zeros(len(ways), dtype=int)
    squares = ((directions - directions[0]) ** 2).sum(axis=1)
    while len(chosen) < min(most, len(ways)):
        farthest = int(squares.argmax())
        own = ((directions - directions[farthest]) ** 2).sum(axis=1)
        held[own < squares] = len(chosen)
        squares = np.minimum(own, squares)
        chosen.append(farthest)
    reach = np.zeros(len(chosen))
    np.maximum.at(reach, held, squares)
    made = ways[chosen]
    widths = np.maximum(WIDTH**2 * reach, made[:, 4] ** 2)
    made[:, 4] = np.clip(0.5 * widths, NARROWEST, 1.0)
    return made


def _widths(directions: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """1 - cos of the half angles of cones about kept directions that reach over their neighbours. (k,)

    ``directions``: all that were found, (n, 3); ``kept``: numbers of some of them. (k,)
    """
    some = directions[:: max(len(directions) // MOST_FOUND, 1)].astype(np.float64)
    if len(some) < 2:
        return np.full(len(kept), LONELY)
    squares = ((directions[kept][:, None] - some[None]) ** 2).sum(axis=2)
    # Of KEPT ones about as many are as near to each other as of all found the NEIGHBOURS * n / KEPT nearest.
    rank = min(max(NEIGHBOURS * len(some) // KEPT, NEIGHBOURS), len(some) - 1)
    near = np.sqrt(np.partition(squares, rank, axis=1)[:, rank])
    return np.clip(0.5 * (WIDTH * near) ** 2, NARROWEST, 1.0)
