"""Light at lumels by single samples: the kernels of a lux map job."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...photometry.spectra import observer
from ..light_tracing.bent_lights import BentLights
from ..paths import gather
from ..paths.lost_samples import LostSamples
from ..paths.sampler import hash_words, random_stream, sobol_pair
from ..paths.visibility import closest_hit
from .cell_guide import Guide
from .cells import CellSet
from .levels import DIRECT, GATHERED, GUIDED, MIRRORED, NO_SAMPLES, Units, count_of
from .lumel_places import LumelPlaces
from .path_guiding import BINS, SIDE, Cosine
from .receiving import Receiver, direct, gathered, mirrored

AIM_SALT = 23
"""Sets the points of the rays that aims are learned from apart."""


class LumelLight:
    """Sums of samples of the light at lumels.

    Parameters
    ----------
    scene : CompiledScene
    places : LumelPlaces
    seed : int
    sampler : WavelengthSampler or None    None in photometric variants.
    cells : CellSet or None
    reads_cells : bool    Whether the radiance beyond the first bounce is read from them.
    left_out : LeftOut or None    What rays must not count after a bend.
    bent : BentLights or None    What lights give over bends to lumels that ask for it.
    is_qmc : bool    Low-discrepancy points instead of random numbers.
    has_exitance : bool    Whether the light that leaves the surface is estimated too.

    Attributes
    ----------
    guide : Guide or None    Points on bright cells beside rays.
    """

    def __init__(
        self,
        scene,
        places: LumelPlaces,
        seed: int,
        sampler,
        cells: CellSet | None,
        reads_cells: bool,
        left_out,
        bent: BentLights | None,
        is_qmc: bool,
        has_exitance: bool,
    ):
        self.scene, self.places, self.seed, self.sampler = scene, places, seed, sampler
        self.cells, self._reads_cells = cells, reads_cells
        self._left_out, self._bent = left_out, bent
        self._is_qmc, self._has_exitance = is_qmc, has_exitance
        self.guide: Guide | None = None

    def sum(
        self, span, kind, units: Units, number, columns, salt=0, is_exact=False
    ) -> tuple[np.ndarray, np.ndarray]:
        """Sums over the samples of units, (u, channels), and how many of these are no numbers, (u,).

        ``kind``: one of `KINDS`.
        """
        scene, places = self.scene, self.places.upload(span)
        aims = places.get("aims")
        who = upload(mi.UInt32, units.lumel)
        begin = upload(mi.UInt32, units.first)
        first = dr.opaque(mi.UInt32, int(span.start) & 0xFFFFFFFF)
        counts = [count_of(column[units.lumel]) for column in columns]
        ratios = {
            k: upload(mi.Float, np.clip(counts[k] / np.maximum(counts[GATHERED], 1e-9), 1e-4, 1e4))
            for k in (DIRECT, GUIDED, MIRRORED)
        }
        many = dr.opaque(mi.UInt32, units.samples)
        seed = dr.opaque(
            mi.UInt32,
            (int(self.seed) * 2654435761 + number * 40503 + kind * 9176 + salt) & 0xFFFFFFFF,
        )
        has_guide = self.guide is not None and bool((columns[GUIDED] != NO_SAMPLES).any())
        pair = (gather.PAIR_LIGHT, gather.PAIR_SCATTER, gather.PAIR_LENS, gather.PAIR_LIGHT)[kind]

        lane = dr.arange(mi.UInt32, len(units.lumel) * units.samples)
        row = lane // many
        sample = dr.gather(mi.UInt32, begin, row) + lane % many
        lumel = dr.gather(mi.UInt32, who, row)
        own = hash_words(first + lumel, seed)
        stream = random_stream(sample, own)
        place_sample, point, tint = self._samples(sample, own, stream, pair)
        wavelengths = None if self.sampler is None else self.sampler.sample(tint)
        si = self.places.choose(places, lumel, place_sample, wavelengths)
        ratio = dr.gather(mi.Float, ratios[DIRECT if kind == GATHERED else kind], row)
        aim = aims.of_tile(dr.gather(mi.UInt32, places["tile"], lumel)) if aims else Cosine()
        receiver = Receiver(si, wavelengths, stream, point, ratio, _facing(si), aim)
        if kind == DIRECT:
            value = direct(scene, receiver)
            if self._bent is not None:
                value += self._bent_light(places, lumel, receiver)
        elif kind == MIRRORED:
            value = mirrored(scene, receiver)
        elif kind == GUIDED:
            traced, read = self.guide.light(scene, receiver, stream)
            value = traced + read
        else:
            value = gathered(
                scene,
                self.cells,
                receiver,
                is_exact=is_exact or not self._reads_cells,
                left_out=self._left_out,
                guide=self.guide if has_guide else None,
                guided_ratio=dr.gather(mi.Float, ratios[GUIDED], row) if has_guide else 1.0,
                mirrored_ratio=dr.gather(mi.Float, ratios[MIRRORED], row),
            )
        # At the full width of the launch, also where there is no light to choose.
        lost = LostSamples(len(units.lumel))
        kept = [
            channel + mi.Float(lane) * 0.0
            for channel in lost.keep(self._channels(value, wavelengths, si), row)
        ]
        # Sums are made apart, since their length would be a part of the kernel.
        dr.eval(kept)
        sums = [dr.block_reduce(dr.ReduceOp.Add, each, units.samples) for each in kept]
        sums = np.stack([np.array(s, dtype=np.float64) for s in sums], axis=-1)
        return sums, lost.counts()

    def look_around(self, span, order, first, many, rays: int) -> np.ndarray:
        """Mean squares of what rays bring, through the bins of some tiles. (t, BINS)

        ``order``: lumels of the span tile by tile; ``first``, ``many``: where each tile's begin, and their number.
        """
        places = self.places.upload(span)
        seed = (int(self.seed) * 2654435761 + AIM_SALT) & 0xFFFFFFFF
        lane = dr.arange(mi.UInt32, len(first) * BINS * rays)
        bin_ = (lane // rays) % BINS
        tile = lane // (BINS * rays)
        lumels, starts, counts = (upload(mi.UInt32, each) for each in (order, first, many))
        unique = dr.gather(mi.UInt32, starts, tile) + dr.opaque(mi.UInt32, span.start & 0xFFFFFFFF)
        stream = random_stream(lane % (BINS * rays), hash_words(unique, dr.opaque(mi.UInt32, seed)))
        mine = dr.gather(mi.UInt32, counts, tile)
        chosen = dr.minimum(mi.UInt32(stream.next_float32() * mi.Float(mine)), mine - 1)
        lumel = dr.gather(mi.UInt32, lumels, dr.gather(mi.UInt32, starts, tile) + chosen)
        numbers = [stream.next_float32() for _ in range(5)]
        wavelengths = None if self.sampler is None else self.sampler.sample(numbers[4])
        si = self.places.choose(places, lumel, mi.Point2f(numbers[0], numbers[1]), wavelengths)
        row, column = (mi.Float(each) for each in (bin_ // SIDE, bin_ % SIDE))
        point = mi.Point2f((row + numbers[2]) / SIDE, (column + numbers[3]) / SIDE)
        value = gathered(
            self.scene,
            self.cells,
            Receiver(si, wavelengths, stream, point, mi.Float(1.0), _facing(si)),
            is_exact=not self._reads_cells,
            left_out=self._left_out,
        )
        light = gather.photometric(self.sampler, value, wavelengths)
        square = dr.square(dr.select(dr.isfinite(light), light, 0.0))
        square += mi.Float(lane) * 0.0
        dr.eval(square)
        found = dr.block_reduce(dr.ReduceOp.Add, square, rays)
        return np.array(found, dtype=np.float64).reshape(-1, BINS) / rays

    def _bent_light(self, places, lumel, receiver: Receiver):
        """What comes over bends to lumels on which traced light never lands."""
        asks = dr.gather(mi.Bool, places["missed"], lumel)
        return self._bent.light(receiver.si, receiver.stream, receiver.answer, asks)

    def _samples(self, sample, seed, stream, pair: int):
        """Points for the place, the direction or light, and the wavelengths."""
        if self._is_qmc:
            return (
                sobol_pair(sample, seed, gather.PAIR_PLACE),
                sobol_pair(sample, seed, pair),
                sobol_pair(sample, seed, gather.PAIR_WAVELENGTH).x,
            )
        place, direction = (
            mi.Point2f(stream.next_float32(), stream.next_float32()) for _ in range(2)
        )
        return place, direction, stream.next_float32()

    def _channels(self, value, wavelengths, si) -> list:
        made = [gather.photometric(self.sampler, value, wavelengths)]
        if self._has_exitance:
            leaving = value * self._reflectance(si)
            if self.sampler is not None:
                made += list(self.sampler.tristimulus(leaving, wavelengths))
            else:
                lamp = self.scene.mean_light @ observer()
                made += [leaving[0] * float(c / lamp[1]) for c in lamp]
        return made

    def _reflectance(self, si):
        """Diffuse reflectance of the surface that a place lies on, found by looking at it from a hair's breadth."""
        lift = self.scene.extent * 1e-5
        ray = mi.Ray3f(si.p + si.n * lift, -mi.Vector3f(si.n))
        ray.maxt = 3.0 * lift
        seen = closest_hit(self.scene, ray, mi.Bool(True))
        if si.wavelengths is not None:
            seen.wavelengths = si.wavelengths
        found = seen.is_valid()
        return dr.select(
            found, self.scene.bsdf(seen, found).eval_diffuse_reflectance(seen, found), 0.0
        )


def _facing(si):
    """How much light from a direction counts at a receiver. [-]"""

    def respond(direction):
        above = dr.dot(direction, si.n) > 0.0
        return dr.select(above, dr.maximum(dr.dot(direction, si.sh_frame.n), 0.0), 0.0)

    return respond
