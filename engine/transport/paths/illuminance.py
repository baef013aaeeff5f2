"""The illuminance job: many receivers, many passes, independent groups, cancellable between launches."""

import math
from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ...accuracy.estimate import Estimate
from ...accuracy.lost_samples import find_missing
from ...accuracy.need import (
    WORTHWHILE,
    foretell,
    gain_of,
    order_by_place,
    share_out,
    wanted_for_all,
    wanted_for_each,
)
from ...accuracy.stopping import Clock, Fall, StopRule, excess_of, excesses_of
from ...accuracy.uneven_sums import HALVES, UnevenSums
from ...arrays import upload
from ...errors import Cancelled, SceneError
from ...photometry.spectra import observer
from ...requirements.fading import find_share
from ...scene.sensor import SensorColour, SensorKind
from ..compiled.compile import CompiledScene
from . import gather
from .light_learning import learn
from .lost_samples import LostSamples
from .sampler import hash_words, random_stream, sobol_pair
from .spectral_meter import CHANNELS, SpectralMeter
from .wavelengths import make_sampler

LANES = 1 << 19
"""Paths per launch: a fraction of a second each, so that a cancel is heard soon."""

LARGEST_SUM = 64
"""Most samples that are summed in single precision."""

STAGE = "illuminance"
"""What a job is called while it runs."""

SNAP_DISTANCE = 1e-4
"""Sensors that lie less than this below a surface are taken to lie on it, in scenes of 1 m and more; in smaller ones this
is a share of the radius. [m]"""

FIRST_SHARE, FIRST_SAMPLES = 64, 8
"""Part of a whole pass that the first one makes, and its fewest samples; the next ones double what there is. They tell how
the error falls, so that a forecast can be made soon."""

FALL = Fall(power=0.57, support=0.4, begins=4.0, ends=math.inf, fades=0.1, window=12.0)
"""How the error falls where well-distributed points meet edges, which passes of few samples show only roughly."""

LATER_SHARE, GROWTH = 4, 8
"""Least part of a whole pass that later ones make, and the part of all samples so far, both as their inverse."""

MANY, LEAST_SHARE, FEWEST_OF_GROUP = 256, 4, 4
"""Receivers from which on the error of the whole is known before a whole pass; the part of it, as its inverse, and samples
of each in a group that are made at least then."""

SOON = 1.2
"""Error, in those that are asked for, from which on passes are so short that the end is met closely. [-]"""

FEWEST_SAMPLES = 1 << 14
"""Samples per receiver before the errors of single receivers are believed."""

UNITS, PARTS = (64, 8, 1), 4
"""Neighbouring samples of a group that a receiver gets together where each gets as many as it needs, and into how many of
these a pass is parted for one receiver at least."""


@dataclass(frozen=True)
class Receivers:
    """Where illuminance is wanted.

    Each receiver owns ``count`` places from ``start`` on; samples are spread evenly over them.

    Parameters
    ----------
    positions : (k, 3) float64 array    Places. [m]
    normals : (k, 3) float64 array    Unit normals of the receiving side.
    geometric_normals : (k, 3) float64 array    Unit normals of the true surface.
    start, count : (n,) int array    Range of places of every receiver.
    weights : (n,) float64 array    Areas, for means. [m2]
    kind : SensorKind    Which illuminance is meant.
    snaps : bool    Whether places a little below a surface are meant to lie on it.
    """

    positions: np.ndarray
    normals: np.ndarray
    geometric_normals: np.ndarray
    start: np.ndarray
    count: np.ndarray
    weights: np.ndarray
    kind: SensorKind = SensorKind.PLANAR
    snaps: bool = False

    def outlooks(self, scene) -> tuple[np.ndarray, np.ndarray]:
        """Where receivers look from, surely not from below what they lie on, and whereto. (m, 3) in its frame [m], (m, 3)"""
        places = scene.local(self.positions)
        if self.kind is not SensorKind.PLANAR:
            # To all sides.
            return np.concatenate([places, places]), np.concatenate([self.normals, -self.normals])
        lift = SNAP_DISTANCE * min(scene.radius, 1.0) if self.snaps else 0.0
        return places + self.normals * lift, self.normals

    @classmethod
    def at_points(cls, positions, normals, kind: SensorKind = SensorKind.PLANAR) -> "Receivers":
        """One place each, which may lie on a surface. (n, 3), (n, 3)

        Raises
        ------
        SceneError    The counts differ, a position or normal is not finite, or a normal has no length; names the first row.
        """
        positions = np.asarray(positions, dtype=np.float64).reshape(-1, 3)
        normals = np.asarray(normals, dtype=np.float64).reshape(-1, 3)
        if len(positions) != len(normals):
            raise SceneError(
                f"{len(positions)} sensors have {len(normals)} normals, expected one each"
            )
        if kind in (SensorKind.SPHERICAL, SensorKind.CYLINDRICAL):
            normals = np.tile([0.0, 0.0, 1.0], (len(positions), 1))
        if kind is SensorKind.SEMICYLINDRICAL:
            normals = normals * [1.0, 1.0, 0.0]
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        bad = ~(
            np.isfinite(positions).all(axis=1)
            & np.isfinite(lengths[:, 0])
            & (lengths[:, 0] > 1e-12)
        )
        if bad.any():
            row = int(np.flatnonzero(bad)[0])
            raise SceneError(
                f"sensor {row + 1} has a position or normal that is not usable: {positions[row]}, {normals[row]}"
            )
        normals = normals / lengths
        count = len(positions)
        is_planar = kind is SensorKind.PLANAR
        return cls(
            positions,
            normals,
            # A small body has no surface whose other side could not be seen.
            normals if is_planar else np.zeros_like(normals),
            np.arange(count),
            np.ones(count, dtype=np.int64),
            np.ones(count),
            kind,
            is_planar,
        )


def compute(
    scene: CompiledScene,
    receivers: Receivers,
    rule: StopRule,
    seed: int = 0,
    groups: int = 2,
    progress=None,
    cancelled=lambda: False,
    reflections: int | None = None,
    colour: bool = False,
    known=None,
    clock: Clock | None = None,
    leaves=lambda brightness, clock: False,
    by_need: bool = False,
):
    """Estimate the illuminance of every receiver by full paths until the rule is met.

    Parameters
    ----------
    scene : CompiledScene
    receivers : Receivers
    rule : StopRule    ``samples`` counts per receiver over all groups, on the mean.
    seed : int    Same seed, same result.
    groups : int    Independent groups, even, see `UnevenSums`.
    progress : callable or None    Called with a `Progress` after every launch.
    cancelled : callable    Asked before every launch.
    reflections : int or None    Most reflections that light may have had; None: no limit.
    colour : SensorColour or bool    What of the colour is wanted too; True: X and Z.
    known : KnownDirections or None    Where the receivers get light over bends from, if it was looked for.
    clock : Clock or None    Follows the job; None: one of its own.
    leaves : callable    Asked after every pass but the last, with the `Estimate` of the illuminance (n,) and the clock,
        whether the job is to be left to others.
    by_need : bool    Whether receivers get as many samples as the error that is asked for needs of them; all get as many
        otherwise, and where none is asked for.

    Returns
    -------
    Estimate or None    Of shape (n,), (n, 3) for X, Y, Z, or with the channels of `spectral_meter` behind these; errors hold
        what lost samples may have brought [lx]. None: it was left.

    Raises
    ------
    Cancelled    When ``cancelled`` answered true.
    """
    total = len(receivers.start)
    channels, bright = count_channels(colour), 1 if colour else 0
    sums = UnevenSums(groups, total, channels)
    if total == 0:
        return finish(sums.estimate(), colour)
    job = _Job(scene, receivers, groups, seed, reflections, colour, known)
    whole = _batch(total * groups, rule, groups)
    least = whole if total < MANY else min(max(whole // LEAST_SHARE, FEWEST_OF_GROUP), whole)
    clock = Clock(rule, STAGE, fall=FALL) if clock is None else clock
    order = order_by_place(receivers.positions, receivers.normals) if by_need else None
    error = float("inf")
    while True:
        done = round(sums.samples)
        batch = _next_batch(done, whole, rule, groups, error)
        entries = None
        if order is not None and done >= whole:
            # Before, the scatter of single ones is not known.
            entries = _by_need(sums, batch, rule, bright, order)
        entries = _Entries.even(sums.counts, batch) if entries is None else entries
        clock.grain = len(entries.who) * entries.samples * groups // sums.counts.size
        for part, share in entries.launches(groups):
            if cancelled():
                raise Cancelled("cancelled")
            sums.add(part.half, part.who, part.samples, *job.launch(part))
            if progress is not None:
                progress(clock.progress(int((done + share * batch) * groups), error))
        made = sums.estimate()
        brightness = made.channel(bright)
        if rule.samples is None:
            # A number of samples gives the same values however passes part it.
            job.learn(sums.variances(bright), brightness.mean)
        error = brightness.relative_error(receivers.weights)
        fewest = int(sums.counts.min()) * groups
        excess = excess_of(rule, brightness) if fewest >= FEWEST_SAMPLES else None
        is_done = clock.is_done(made.samples, error, excess)
        # So few samples may have seen nothing of what matters.
        if is_done and sums.samples >= least:
            lost = int(sums.lost.sum())
            made = finish(widened_by_loss(made, sums.lost_shares(), lost), colour)
            own = sums.counts.sum(axis=0) * groups // HALVES
            fewest, most = int(own.min()), int(own.max())
            return made if fewest == most else replace(made, fewest_most=(fewest, most))
        if leaves(brightness, clock):
            return None


def _by_need(
    sums: UnevenSums, batch: int, rule: StopRule, bright: int, order: np.ndarray
) -> "_Entries | None":
    """What the next pass makes where receivers get what they need; None: as many for all."""
    if sums.groups < 2 * HALVES:
        return None
    if rule.error is not None:
        variances = foretell(sums.variances(bright), order)
        if gain_of(variances) < WORTHWHILE:
            return None
        wanted = wanted_for_all(sums.counts, variances, batch)
    else:
        excesses = excesses_of(rule, sums.estimate().channel(bright))
        # Before, no error of a single one is believed.
        if excesses is None or int(sums.counts.min()) * sums.groups < FEWEST_SAMPLES:
            return None
        wanted = wanted_for_each(sums.counts, excesses, batch)
    unit = next(each for each in UNITS if each * PARTS <= max(batch, PARTS))
    return _Entries.of(sums.counts, share_out(wanted, sums.counts, unit), unit)


@dataclass(frozen=True)
class _Entries:
    """Samples that are made together, row by row: neighbours of one receiver in all groups of a half.

    Parameters
    ----------
    half, who, index : (m,) int array    Half, receiver, and number of the first sample.
    samples : int    Of each row in a group, a power of two.
    """

    half: np.ndarray
    who: np.ndarray
    index: np.ndarray
    samples: int

    @classmethod
    def of(cls, counts: np.ndarray, units: np.ndarray, samples: int) -> "_Entries":
        """So many units of samples beyond those that there are. (2, n), (2, n)"""
        flat = units.ravel()
        row = np.repeat(np.arange(flat.size), flat)
        nth = np.arange(len(row)) - np.repeat(np.cumsum(flat) - flat, flat)
        half, who = np.divmod(row, units.shape[1])
        return cls(half, who, counts.ravel()[row] + nth * samples, samples)

    @classmethod
    def even(cls, counts: np.ndarray, batch: int) -> "_Entries":
        """A batch for all receivers."""
        samples = min(batch, LARGEST_SUM)
        return cls.of(counts, np.full(counts.shape, batch // samples), samples)

    def launches(self, groups: int):
        """Parts for one launch each, with the share that is made after it. [-]"""
        many = max(LANES * HALVES // (groups * self.samples), 1)
        for first in range(0, len(self.who), many):
            rows = slice(first, first + many)
            part = replace(self, half=self.half[rows], who=self.who[rows], index=self.index[rows])
            yield part, (first + len(part.who)) / len(self.who)


def widened_by_loss(made: Estimate, shares: np.ndarray, lost: int) -> Estimate:
    """With errors that hold what lost samples may have brought, and with their number.

    ``shares``: of its samples that each receiver has lost. (n,) [-]
    """
    if not shares.any():
        return made
    brightest = made.mean.max(axis=1)
    return replace(made.widened(find_missing(brightest, shares, brightest.mean())), lost=lost)


def finish(made: Estimate, colour: bool) -> Estimate:
    """The illuminance alone where no colour is wanted."""
    events = made.events[:, 0] if made.events is not None else None
    if colour:
        return replace(made, events=events)
    return replace(made.channel(0), events=events)


def _batch(lanes_per_sample: int, rule: StopRule, groups: int) -> int:
    """Samples per receiver and group in one pass: a power of two that fills a launch and does not overshoot."""
    limit = max(LANES // max(lanes_per_sample, 1), 8)
    if rule.limits or rule.each is not None:
        # A pass must not take long where few samples are enough.
        limit = min(limit, FEWEST_SAMPLES // groups)
    if rule.samples is not None:
        limit = min(limit, max(rule.samples // groups, 1))
    return 1 << int(np.floor(np.log2(max(limit, 1))))


def _next_batch(samples: int, whole: int, rule: StopRule, groups: int, error: float) -> int:
    """Samples per receiver and group in the pass after so many of them, with such an error: a power of two.

    Twice as many in all, up to a part of a whole pass; then as few that the end is met closely.
    """
    first = min(max(whole // FIRST_SHARE, FIRST_SAMPLES), whole)
    most = min(max(whole // LATER_SHARE, samples // GROWTH, 1), max(LANES // groups, 1))
    batch = min(max(samples, first), most)
    if rule.samples is not None and rule.samples > samples * groups:
        batch = min(batch, -(-rule.samples // groups) - samples)
    if rule.error is not None and rule.error < error < SOON * rule.error:
        # What is missing, and a little more, or the end is missed by chance as often as not.
        missing = 1.02 * samples * ((error / rule.error) ** 2 - 1.0)
        batch = min(batch, 2 ** int(np.ceil(np.log2(max(missing, 1.0)))))
    return 1 << int(np.log2(batch))


class Places:
    """Places of receivers on the device.

    Parameters
    ----------
    scene : CompiledScene
    receivers : Receivers    Places that are meant to lie on surfaces are put there.
    """

    def __init__(self, scene: CompiledScene, receivers: Receivers):
        self._columns = _upload(scene, receivers)
        if receivers.snaps:
            self._snap(scene)

    def _snap(self, scene) -> None:
        """Find the surfaces that places lie on, and lift those that are a little below onto them."""
        places = self._columns
        point, normal = mi.Point3f(*places["p"]), mi.Vector3f(*places["n"])
        lift = dr.opaque(mi.Float, SNAP_DISTANCE * min(scene.radius, 1.0))
        ray = mi.Ray3f(point + normal * lift, -normal)
        ray.maxt = 2.0 * lift
        hit = scene.solid.ray_intersect_preliminary(ray, mi.Bool(False), mi.Bool(True))
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.shape = dr.select(hit.is_valid(), hit.shape, dr.zeros(mi.ShapePtr))
        places["extent"] = scene.extent_at(si)
        point = dr.select(hit.is_valid() & (hit.t < lift), ray(hit.t), point)
        places["p"] = [point.x, point.y, point.z]
        dr.eval(places)

    def choose(self, who, sample, own_seed, wavelengths):
        """One of the places of receivers, as `gather.receiver` gives it. ``who``: their numbers."""
        places = self._columns
        place_sample = sobol_pair(sample, own_seed, gather.PAIR_PLACE)
        mine = dr.gather(mi.UInt32, places["count"], who)
        chosen = dr.minimum(mi.UInt32(place_sample.x * mi.Float(mine)), mine - 1)
        chosen += dr.gather(mi.UInt32, places["start"], who)

        def fetch(kind, name):
            return kind(*(dr.gather(mi.Float, column, chosen) for column in places[name]))

        return gather.receiver(
            fetch(mi.Point3f, "p"),
            fetch(mi.Normal3f, "n"),
            fetch(mi.Normal3f, "g"),
            wavelengths,
            dr.gather(mi.Float, places["extent"], chosen),
        )


def count_channels(colour: SensorColour | bool) -> int:
    """How many numbers receivers tell."""
    return {SensorColour.NONE: 1, SensorColour.TRISTIMULUS: 3}.get(int(colour), 3 + CHANNELS)


class Meter:
    """What receivers tell of the light that arrives: illuminance alone, X, Y and Z, or the spectrum as well.

    Parameters
    ----------
    scene : CompiledScene
    colour : SensorColour or bool    What of the colour is wanted too; True: X and Z.
    """

    def __init__(self, scene: CompiledScene, colour: SensorColour | bool):
        self._scene, self.colour = scene, colour
        self.sampler = make_sampler(scene, ("luminance", "colour", "bands")[int(colour)])
        self.count, self.bright = count_channels(colour), 1 if colour else 0
        self._spectrum = None
        if colour == SensorColour.SPECTRUM:
            self._spectrum = SpectralMeter(scene.mean_light, self.sampler)

    def sums(self, value, wavelengths, lane, rows: int, batch: int):
        """Sums of samples, ``batch`` neighbours to each of ``rows``.

        Parameters
        ----------
        value : Spectrum    Spectral irradiance [W/(m2 nm)], or illuminance [lx] in photometric variants.
        wavelengths : Spectrum or None    [nm]
        lane : UInt32    Numbers of the samples.

        Returns
        -------
        (rows, channels), (2, rows), (rows,) array    Sums [lx]; sum and largest of the squares of the samples' illuminance,
            up to a factor; how many of them are no numbers.
        """
        lost = LostSamples(rows)
        kept = [
            channel + mi.Float(lane) * 0.0
            for channel in lost.keep(
                self._channels(value, wavelengths), lane // dr.opaque(mi.UInt32, batch)
            )
        ]
        # Squares of huge samples would not fit; the scale makes no difference.
        square = dr.square(kept[self.bright] * 1e-6)
        # Sums are made apart, since their length would be a part of the kernel.
        spectrum = [] if self._spectrum is None else self._spectrum.arrays(value, wavelengths)
        dr.eval(kept, square, spectrum)
        block = min(batch, LARGEST_SUM)
        sums = [dr.block_reduce(dr.ReduceOp.Add, channel, block) for channel in kept]
        tails = [dr.block_reduce(op, square, block) for op in (dr.ReduceOp.Add, dr.ReduceOp.Max)]
        dr.eval(sums, tails)
        made = np.stack([np.array(s, dtype=np.float64) for s in sums], axis=-1)
        made = made.reshape(rows, batch // block, len(sums)).sum(axis=1)
        if self._spectrum is not None:
            more = self._spectrum.sums(spectrum, made[:, self.bright], rows)
            made = np.concatenate([made, more], axis=1)
        squares, largest = (np.array(t, dtype=np.float64).reshape(rows, -1) for t in tails)
        tails = np.stack([squares.sum(axis=1), largest.max(axis=1)])
        return made, tails, lost.counts().astype(np.int64)

    def _channels(self, value, wavelengths) -> list:
        if not self.colour:
            return [gather.photometric(self.sampler, value, wavelengths)]
        if self.sampler is not None:
            return list(self.sampler.tristimulus(value, wavelengths))
        lamp = self._scene.mean_light @ observer()
        return [value[0] * float(c / lamp[1]) for c in lamp]


class _Job:
    """What all launches of a job share."""

    def __init__(
        self,
        scene: CompiledScene,
        receivers: Receivers,
        groups,
        seed,
        reflections,
        colour,
        known=None,
    ):
        self.scene, self.kind = scene, receivers.kind
        self.groups, self.seed, self._known = groups, seed, known
        self.meter = Meter(scene, colour)
        places, normals = receivers.outlooks(scene)
        learn(scene, places, normals.astype(np.float32), gather.typical_wavelengths())
        self.places = Places(scene, receivers)
        self.limit = None if reflections is None else dr.opaque(mi.UInt32, int(reflections))
        self.faded = find_share(scene.requirements.reflectance)

    def learn(self, variances: np.ndarray, mean: np.ndarray) -> None:
        """Let roulette begin when it pays, by how samples have scattered. (2, n), (n,)"""
        square = float(mean.mean()) ** 2
        if variances.any() and square > 0.0:
            reflectance = self.scene.requirements.reflectance
            self.faded = find_share(reflectance, float(variances.mean()) / square, self.faded)

    def launch(self, entries: _Entries):
        """Run one kernel.

        Returns
        -------
        (m, groups / 2, channels), (2, m), (m,) array    As `UnevenSums.add` takes them.
        """
        groups, sampler, count = self.groups // HALVES, self.meter.sampler, len(entries.who)
        seed = dr.opaque(mi.UInt32, int(self.seed) & 0xFFFFFFFF)
        many = dr.opaque(mi.UInt32, entries.samples)
        # Of at least two rows, as tables of one would be another kernel.
        columns = entries.half, entries.who, entries.index
        table = [upload(mi.UInt32, np.append(each, 0)) for each in columns]
        lane = dr.arange(mi.UInt32, count * groups * entries.samples)
        row = lane // (many * groups)
        half, who, index = (dr.gather(mi.UInt32, column, row) for column in table)
        sample = index + lane % many
        group = half * groups + (lane // many) % groups
        own_seed = hash_words(who, hash_words(group, seed))
        wavelengths = gather.draw_wavelengths(sampler, sample, own_seed)
        value = gather.spectral_illuminance(
            self.scene,
            self.places.choose(who, sample, own_seed, wavelengths),
            wavelengths,
            random_stream(sample, own_seed),
            sobol_pair(sample, own_seed, gather.PAIR_LIGHT),
            sobol_pair(sample, own_seed, gather.PAIR_SCATTER),
            mi.Bool(True),
            self.kind,
            self.limit,
            None if self._known is None else self._known.of(who),
            dr.opaque(mi.Float, self.faded),
        )
        made, tails, lost = self.meter.sums(
            value, wavelengths, lane, count * groups, entries.samples
        )
        tails = tails.reshape(2, count, groups)
        tails = np.stack([tails[0].sum(axis=1), tails[1].max(axis=1)])
        lost = lost.reshape(count, groups).sum(axis=1)
        return made.reshape(count, groups, -1), tails, lost


def _upload(scene: CompiledScene, receivers: Receivers) -> dict:
    columns = scene.local(receivers.positions)
    places = {
        "p": [upload(mi.Float, columns[:, i]) for i in range(3)],
        "n": [upload(mi.Float, receivers.normals[:, i]) for i in range(3)],
        "g": [upload(mi.Float, receivers.geometric_normals[:, i]) for i in range(3)],
        "start": upload(mi.UInt32, receivers.start),
        "count": upload(mi.UInt32, receivers.count),
        # Lumels lie on surfaces that may be as large as the scene.
        "extent": upload(mi.Float, np.full(len(columns), scene.radius)),
    }
    dr.eval(places)
    return places
