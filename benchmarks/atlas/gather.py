"""The first rival: every lumel gathers by paths of independent random numbers, all lumels alike.

It has what a good plain path tracer has: at every vertex next-event to a light chosen by its share, joined with scattered
rays by multiple importance sampling, and Russian roulette. It has no low-discrepancy points, no light apart, no cells, and
spends as much on a bright lumel as on a dark one.
"""

import time

import drjit as dr
import mitsuba as mi
import numpy as np

from ...engine.arrays import upload
from ...engine.transport.paths import gather
from ...engine.transport.paths.light_learning import learn
from ...engine.transport.paths.sampler import hash_words
from ...engine.transport.paths.wavelengths import make_sampler
from .lumels import LumelPlaces
from .stage import Stage

LANES = 1 << 20
"""Paths per launch."""

LARGEST_SUM = 1024
"""Most samples that are summed in single precision."""


class PlainGather:
    """Gathers for lumels. ``samples`` of a run are per lumel."""

    def __init__(self, stage: Stage, places: LumelPlaces):
        compiled = stage.compiled
        self.compiled, self.count = compiled, len(places)
        self.sampler = make_sampler(compiled, "luminance")
        learn(
            compiled,
            compiled.local(places.positions),
            places.normals.astype(np.float32),
            gather.typical_wavelengths(),
        )
        local = compiled.local(places.positions)
        self.columns = {
            name: [upload(mi.Float, array[:, k]) for k in range(3)]
            for name, array in (
                ("p", local),
                ("n", places.normals),
                ("g", places.geometric_normals),
            )
        }
        self.start = upload(mi.UInt32, places.start)
        self.places = upload(mi.UInt32, places.count)
        dr.eval(self.columns, self.start, self.places)

    def run(self, samples: int, seed: int) -> tuple[np.ndarray, float]:
        """Illuminances (n,) [lx], and the time that they took [s]. ``samples``: a power of two."""
        begin = time.perf_counter()
        batch = 1 << int(np.log2(np.clip(LANES // self.count, 1, min(samples, LARGEST_SUM))))
        total = np.zeros(self.count)
        for first in range(0, samples, batch):
            total += self._launch(first, batch, seed)
        return total / samples, time.perf_counter() - begin

    def _launch(self, first: int, batch: int, seed: int) -> np.ndarray:
        lane = dr.arange(mi.UInt32, self.count * batch)
        who, number = lane // batch, lane % batch + dr.opaque(mi.UInt32, first)
        own = hash_words(who, dr.opaque(mi.UInt32, seed))
        stream = mi.PCG32(
            initstate=mi.UInt64(hash_words(number, own)), initseq=mi.UInt64(hash_words(own, number))
        )

        def draw():
            return stream.next_float32()

        mine = dr.gather(mi.UInt32, self.places, who)
        chosen = dr.minimum(mi.UInt32(draw() * mi.Float(mine)), mine - 1)
        chosen += dr.gather(mi.UInt32, self.start, who)

        def fetch(kind, name):
            return kind(*(dr.gather(mi.Float, column, chosen) for column in self.columns[name]))

        wavelengths = None
        if self.sampler is not None:
            wavelengths = self.sampler.sample(draw())
        si = gather.receiver(
            fetch(mi.Point3f, "p"),
            fetch(mi.Normal3f, "n"),
            fetch(mi.Normal3f, "g"),
            wavelengths,
            self.compiled.radius,
        )
        light_sample, scatter_sample = mi.Point2f(draw(), draw()), mi.Point2f(draw(), draw())
        value = gather.spectral_illuminance(
            self.compiled,
            si,
            wavelengths,
            stream,
            light_sample,
            scatter_sample,
            mi.Bool(True),
        )
        value = gather.photometric(self.sampler, value, wavelengths)
        value = dr.select(dr.isfinite(value), value, 0.0)
        sums = dr.block_reduce(dr.ReduceOp.Add, value, batch)
        return np.array(sums, dtype=np.float64)
