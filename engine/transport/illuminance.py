"""The illuminance job: many receivers, many passes, independent groups, cancellable between launches."""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ..accuracy.estimate import Accumulator
from ..accuracy.stopping import Clock, StopRule
from ..errors import Cancelled, SceneError
from . import gather
from .compile import CompiledScene
from .lights import learn
from .sampler import hash_words, random_stream, sobol_pair
from .textures import is_spectral
from .wavelengths import WavelengthSampler

LANES = 1 << 19
"""Paths per launch: a fraction of a second each, so that a cancel is heard soon."""

MAXIMUM_BATCH = 1024
"""Most samples per receiver and group in one pass; sums over a pass are single precision."""

SURFACE_OFFSET = 1e-4
"""Receivers given as points are lifted by this along their normal, as a sensor lies on a surface. [m]"""


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
    """

    positions: np.ndarray
    normals: np.ndarray
    geometric_normals: np.ndarray
    start: np.ndarray
    count: np.ndarray
    weights: np.ndarray

    @classmethod
    def at_points(cls, positions, normals) -> "Receivers":
        """One place each, lifted off the surface that it may lie on. (n, 3), (n, 3)

        Raises
        ------
        SceneError    A position or normal is not finite or a normal has no length; names the first such row.
        """
        positions = np.asarray(positions, dtype=np.float64).reshape(-1, 3)
        normals = np.asarray(normals, dtype=np.float64).reshape(-1, 3)
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
        return cls(
            positions + SURFACE_OFFSET * normals,
            normals,
            normals,
            np.arange(count),
            np.ones(count, dtype=np.int64),
            np.ones(count),
        )


def compute(
    scene: CompiledScene,
    receivers: Receivers,
    rule: StopRule,
    seed: int = 0,
    groups: int = 2,
    progress=None,
    cancelled=lambda: False,
):
    """Estimate the illuminance of every receiver until the rule is met.

    Parameters
    ----------
    scene : CompiledScene
    receivers : Receivers
    rule : StopRule    ``samples`` counts per receiver over all groups.
    seed : int    Same seed, same result.
    groups : int    Independent groups, see `Accumulator`.
    progress : callable or None    Called with a `Progress` after every launch.
    cancelled : callable    Asked before every launch.

    Returns
    -------
    Estimate    Of shape (n,). [lx]

    Raises
    ------
    Cancelled    When ``cancelled`` answered true.
    """
    total = len(receivers.start)
    sums = Accumulator(groups, total)
    if total == 0:
        return sums.estimate()
    sampler = WavelengthSampler(scene.mean_light, "luminance") if is_spectral() else None
    learn(
        scene,
        scene.local(receivers.positions),
        receivers.normals.astype(np.float32),
        gather.typical_wavelengths(),
    )
    places = _upload(scene, receivers)
    batch = _batch(total * groups, rule, groups)
    per_launch = max(LANES // (groups * batch), 1)
    clock = Clock(rule, "illuminance")
    estimate, error = None, float("inf")
    while True:
        new = np.zeros((groups, total))
        for first in range(0, total, per_launch):
            if cancelled():
                raise Cancelled("cancelled")
            count = min(per_launch, total - first)
            new[:, first : first + count] = _launch(
                scene, places, sampler, first, count, groups, batch, sums.samples, seed
            )
            if progress is not None:
                share = (first + count) / total
                progress(clock.progress(int((sums.samples + share * batch) * groups), error))
        sums.add(new, batch)
        estimate = sums.estimate()
        error = estimate.relative_error(receivers.weights)
        if clock.is_done(sums.samples * groups, error):
            return estimate


def _batch(lanes_per_sample: int, rule: StopRule, groups: int) -> int:
    """Samples per receiver and group in one pass: a power of two that fills a launch and does not overshoot."""
    wanted = MAXIMUM_BATCH if rule.samples is None else max(rule.samples // groups, 1)
    if rule.samples is None:
        wanted = max(LANES // max(lanes_per_sample, 1), 8)
    limit = min(wanted, MAXIMUM_BATCH, max(LANES // max(groups, 1), 1))
    return 1 << int(np.floor(np.log2(max(limit, 1))))


def _upload(scene: CompiledScene, receivers: Receivers) -> dict:
    columns = scene.local(receivers.positions)
    places = {
        "p": [mi.Float(np.ascontiguousarray(columns[:, i])) for i in range(3)],
        "n": [mi.Float(receivers.normals[:, i].astype(np.float32)) for i in range(3)],
        "g": [mi.Float(receivers.geometric_normals[:, i].astype(np.float32)) for i in range(3)],
        "start": mi.UInt32(receivers.start.astype(np.uint32)),
        "count": mi.UInt32(receivers.count.astype(np.uint32)),
    }
    dr.eval(places)
    return places


def _launch(scene, places, sampler, first, count, groups, batch, index, seed) -> np.ndarray:
    """Run one kernel and return the sums of its samples, (groups, count)."""
    first = dr.opaque(mi.UInt32, int(first))
    start_index = dr.opaque(mi.UInt32, int(index))
    seed = dr.opaque(mi.UInt32, int(seed) & 0xFFFFFFFF)
    lane = dr.arange(mi.UInt32, count * groups * batch)
    sample = start_index + lane % batch
    group = (lane // batch) % groups
    who = first + lane // (batch * groups)
    own_seed = hash_words(who, hash_words(group, seed))

    wavelengths = gather.draw_wavelengths(sampler, sample, own_seed)
    place_sample = sobol_pair(sample, own_seed, gather.PAIR_PLACE)
    mine = dr.gather(mi.UInt32, places["count"], who)
    chosen = dr.minimum(mi.UInt32(place_sample.x * mi.Float(mine)), mine - 1)
    chosen += dr.gather(mi.UInt32, places["start"], who)

    def fetch(kind, name):
        return kind(*(dr.gather(mi.Float, column, chosen) for column in places[name]))

    si = gather.receiver(
        fetch(mi.Point3f, "p"), fetch(mi.Normal3f, "n"), fetch(mi.Normal3f, "g"), wavelengths
    )
    value = gather.spectral_illuminance(
        scene,
        si,
        wavelengths,
        random_stream(sample, own_seed),
        sobol_pair(sample, own_seed, gather.PAIR_LIGHT),
        sobol_pair(sample, own_seed, gather.PAIR_SCATTER),
        mi.Bool(True),
    )
    value = gather.photometric(sampler, value, wavelengths)
    value = dr.select(dr.isfinite(value), value, 0.0)
    sums = dr.block_reduce(dr.ReduceOp.Add, value, batch)
    return np.array(sums, dtype=np.float64).reshape(count, groups).T
