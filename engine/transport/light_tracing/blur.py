"""What the spheres that stand for ideal points change at sensors: how wrong light over bends may be for their size.

The illuminance by a sphere of the radius r is that of the point and c r^2 more where light is spread evenly. Of a ray that
meets the sphere it is known whether it meets half of its disk too, so with r^2 / 2 the same rays tell half the difference.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...errors import Cancelled
from ..paths import gather
from ..paths.illuminance import LANES
from ..paths.sampler import hash_words, random_stream
from ..paths.wavelengths import make_sampler

GROUPS, BATCHES = 16, (1 << 8, 1 << 14)
"""Independent groups of samples of every sensor, and fewest and most samples in each."""

SHARE = 1.0
"""Samples, relative to those of the sensors: of fewer, the difference at the tip of a caustic may pass for chance. [-]"""

SURE = 3.0
"""Standard errors of a difference that are put down to chance."""

SALT = 0x9D2C
"""Sets these rays apart from others of the same seed."""


def find_blur(
    scene, receivers, samples: int, seed: int, reflections: int | None, cancelled, known=None
) -> np.ndarray:
    """By how much the size of points that are seen over bends may change the illuminance of receivers.

    Parameters
    ----------
    scene : CompiledScene    With its light over bends prepared.
    receivers : Receivers    One place each.
    samples : int    That every receiver had.
    seed : int
    reflections : int or None    Most that light may have had.
    cancelled : callable    Asked before every launch.
    known : KnownDirections or None    Where receivers get this light from, if it was looked for.

    Returns
    -------
    (n,) array    0 where nothing is sure. [lx]
    """
    count = len(receivers.start)
    if scene.bent is None or not scene.bent.has_points or not count:
        return np.zeros(count)
    sampler = make_sampler(scene, "luminance")
    limit = None if reflections is None else dr.opaque(mi.UInt32, int(reflections))
    places, normals = receivers.outlooks(scene)
    columns = [upload(mi.Float, each[:count]) for each in (places, normals)]
    sums = np.zeros((count, GROUPS))
    batch = 1 << int(np.log2(np.clip(SHARE * samples / GROUPS, *BATCHES)))
    step = max(LANES // (GROUPS * batch), 1)
    scene.bent.is_compared = True
    try:
        for first in range(0, count, step):
            if cancelled():
                raise Cancelled("cancelled")
            width = min(step, count - first)
            found = _launch(
                scene, receivers, columns, sampler, seed, limit, first, width, batch, known
            )
            sums[first : first + width] = found
    finally:
        scene.bent.is_compared = False
    means = sums / batch
    difference = means.mean(axis=1)
    chance = means.std(axis=1, ddof=1) / np.sqrt(GROUPS)
    return 2.0 * np.maximum(np.abs(difference) - SURE * chance, 0.0)


def _launch(
    scene, receivers, columns, sampler, seed, limit, first, width, batch, known
) -> np.ndarray:
    """Sums of the samples of some receivers by group. (width, GROUPS)"""
    lane = dr.arange(mi.UInt32, width * GROUPS * batch)
    many = dr.opaque(mi.UInt32, GROUPS * batch)
    who = lane // many + dr.opaque(mi.UInt32, first)
    own = hash_words(who, dr.opaque(mi.UInt32, (int(seed) + SALT) & 0xFFFFFFFF))
    stream = random_stream(lane, own)
    point, normal = (dr.gather(mi.Vector3f, column, who) for column in columns)
    wavelengths = None if sampler is None else sampler.sample(stream.next_float32())
    true = mi.Normal3f(normal) if receivers.geometric_normals.any() else mi.Normal3f(0.0)
    si = gather.receiver(mi.Point3f(point), mi.Normal3f(normal), true, wavelengths)
    respond = gather.response_of(receivers.kind, si)
    value = scene.bent.light(
        si,
        stream,
        lambda direction, asked: (respond(direction), mi.Float(0.0)),
        mi.Bool(True),
        limit=limit,
        known=None if known is None else known.of(who),
    )
    amount = gather.photometric(sampler, value, wavelengths)
    amount = dr.select(dr.isfinite(amount), amount, 0.0) + mi.Float(lane) * 0.0
    dr.eval(amount)
    return np.array(amount, dtype=np.float64).reshape(width, GROUPS, batch).sum(axis=2)
