"""Light of pixels by single samples, apart by kind: the kernels of a picture.

What a camera sees first is often matt. Its base answers light from all sides alike, so the light that reaches it is
sampled as at a lumel of a lux map: next-event to lights, rays that end at cells, points on bright cells, next-event over
mirrors, each with as many samples as it needs. All other light of a pixel comes by paths: emitters in view, coats, glass,
metals, and what is seen through or in them.

Where the answer has to be unbiased a last kind corrects what cells change (two-level Monte Carlo): the same sample by full
paths, less what it reads of the same cells.

References
----------
S. Heinrich: Multilevel Monte Carlo Methods, in: Large-Scale Scientific Computing, 2001.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ..compiled.textures import is_spectral
from ..lux_maps.cached_gather import incoming
from ..lux_maps.cell_reader import CellReader, spread_of
from ..lux_maps.levels import Units
from ..lux_maps.receiving import direct
from ..paths import gather
from ..paths.channels import Channels
from ..paths.film import GROUPS, Film, sees
from ..paths.lost_samples import LostSamples
from ..paths.next_event import mirrored_light
from ..paths.path_loop import trace
from ..paths.sampler import hash_words, random_stream, sobol_pair
from ..paths.visibility import closest_hit
from ..rays import spawn_ray
from .view_cells import ViewCells

KINDS = ("view", "direct", "gathered", "guided", "mirrored", "bent", "correction")
"""Ways in which light is sampled."""

VIEW, DIRECT, GATHERED, GUIDED, MIRRORED, BENT, CORRECTION = range(7)

COSTS = (5.0, 1.0, 4.0, 1.2, 1.3, 3.5, 20.0)
"""What a sample of each kind costs, relative to next-event; measured in rooms."""

FLOORS = {VIEW: 1.0 / 4.0, CORRECTION: 1.0 / 8.0}
"""Least samples of kinds whose light may be rare and bright, thin slivers of lamps in view and what cells know nothing of,
over the mean of all: until one has met it, nothing tells of it. [-]"""

PAIRS = (
    gather.PAIR_LIGHT,
    gather.PAIR_LIGHT,
    gather.PAIR_SCATTER,
    gather.PAIR_PLACE,
    gather.PAIR_LIGHT,
    gather.PAIR_LIGHT,
    gather.PAIR_SCATTER,
)
"""Points for the choice of a light or a direction, by kind."""


STEERING = (1, 3)
"""Channels whose scatter decides who gets samples: luminance and, where it is wanted, illuminance."""


@dataclass(frozen=True)
class _Numbers:
    """Paths of the camera: ray, wavelengths, and what their points are made of."""

    ray: object
    wavelengths: object
    sample: object
    own: object

    def take(self, index) -> "_Numbers":
        """Some of them. Their number is no part of the kernel."""
        return _Numbers(
            dr.gather(mi.Ray3f, self.ray, index),
            None if self.wavelengths is None else dr.gather(mi.Spectrum, self.wavelengths, index),
            dr.gather(mi.UInt32, self.sample, index),
            dr.gather(mi.UInt32, self.own, index),
        )


class PixelLight:
    """Sums of samples of the light of pixels.

    Parameters
    ----------
    scene : CompiledScene
    film : Film
    settings : views.ViewSettings
    cells : ViewCells or None    None: all light comes by paths.
    keeps_caught : bool    As of `Channels`.

    Attributes
    ----------
    is_corrected : bool    Whether what cells change is taken out by samples of their own.
    lost : dict    Samples that were no numbers, by kind and pixel: (2, n), of each of `channels.LOST`.
    """

    def __init__(self, scene, film: Film, settings, cells: ViewCells | None, keeps_caught=False):
        self.scene, self.film, self.seed = scene, film, settings.seed
        self.channels = Channels(scene, settings, keeps_caught)
        self.cells, self._pixels = cells, film.camera.width * film.camera.height
        self.is_corrected = cells is not None and settings.unbiased
        self.lost: dict[int, np.ndarray] = {}
        self._left_out = None if scene.bent is None else scene.bent.left_out
        self._reader = None
        if cells is not None:
            self._reader = CellReader(scene, cells.cells, True, 1.0, leaves_matt=True)

    @property
    def kinds(self) -> tuple[int, ...]:
        """Kinds of samples that the scene needs."""
        if self.cells is None:
            return (VIEW,)
        needed = {
            DIRECT: self.scene.lights.count > 0,
            BENT: self.scene.bent is not None,
            GUIDED: self.cells.guide is not None,
            MIRRORED: self.scene.mirrors is not None and self.scene.lights.count > 0,
            CORRECTION: self.is_corrected,
        }
        return tuple(kind for kind in range(len(KINDS)) if needed.get(kind, True))

    def sum(self, kind: int, units: Units, half: int) -> np.ndarray:
        """Sums over the samples of units, those of squares of `STEERING` last. (u, channels + 2)"""
        return self.begin(kind, units, half)()

    def begin(self, kind: int, units: Units, half: int) -> Callable[[], np.ndarray]:
        """Begin with the samples of units; what is returned waits for their end and returns as `sum`.

        Meanwhile the next kernel may be put together, which takes about as long.
        """
        who, begin = upload(mi.UInt32, units.lumel), upload(mi.UInt32, units.first)
        many = dr.opaque(mi.UInt32, units.samples)
        seed = dr.opaque(mi.UInt32, int(self.seed) & 0xFFFFFFFF)
        lane = dr.arange(mi.UInt32, len(units.lumel) * units.samples)
        row = lane // many
        sample = dr.gather(mi.UInt32, begin, row) + lane % many
        pixel = dr.gather(mi.UInt32, who, row)
        own = hash_words(pixel, hash_words(dr.opaque(mi.UInt32, len(KINDS) * half + kind), seed))
        wavelengths = gather.draw_wavelengths(self.channels.sampler, sample, own)
        ray = self.film.ray_of(pixel, sample, own)
        if is_spectral():
            ray.wavelengths = wavelengths
        lost = [LostSamples(len(units.lumel)) for _ in range(2)]
        if kind == VIEW:
            columns = self._look(ray, wavelengths, sample, own, row, lost)
        else:
            receive = self._correct if kind == CORRECTION else partial(self._receive, kind)
            light = receive(ray, wavelengths, sample, own)
            light = mi.Spectrum(*lost[0].keep(light, row))
            columns = self.channels.of_light(light, wavelengths)
        # At the full width of the launch, and apart from the sums, whose length would be a part of the kernel.
        columns = {number: each + mi.Float(lane) * 0.0 for number, each in columns.items()}
        dr.eval(columns)
        whole = self.channels.count
        columns |= {
            whole + k: dr.square(columns[c]) for k, c in enumerate(STEERING) if c in columns
        }
        sums = {
            number: dr.block_reduce(dr.ReduceOp.Add, each, units.samples)
            for number, each in columns.items()
        }
        dr.eval(sums)

        def finish() -> np.ndarray:
            known = self.lost.setdefault(kind, np.zeros((len(lost), self._pixels), dtype=np.int64))
            for part, each in zip(known, lost, strict=True):
                counts = each.counts()
                if counts.any():
                    np.add.at(part, units.lumel, counts)
            made = np.zeros((len(units.lumel), whole + len(STEERING)))
            for number, each in sums.items():
                made[:, number] = np.array(each)
            return made

        return finish

    def differences(self, pixels: np.ndarray) -> np.ndarray:
        """Luminance that reading cells adds to that of full paths, by one sample at each of some pixels. (k,) [cd/m2]"""
        units = Units(pixels, np.arange(len(pixels)), 1, np.zeros(0))
        return -self.sum(CORRECTION, units, GROUPS)[:, 1]

    # ---- private ----

    def _look(self, ray, wavelengths, sample, own, row, lost) -> dict:
        """Light by paths, and what else is told of a pixel."""
        radiance = mi.Spectrum(*lost[0].keep(self._follow(ray, wavelengths, sample, own), row))
        made = self.channels.of_light(radiance, wavelengths)
        return made | self.channels.of_view(ray, wavelengths, sample, own, row, lost[1])

    def _follow(self, ray, wavelengths, sample, own):
        """Radiance along paths of the camera, without what matt surfaces send that are seen first."""
        numbers = _Numbers(ray, wavelengths, sample, own)
        if self._reader is None:
            return self._trace(numbers, None)
        return _of_few(
            numbers, self._goes_on(ray, sample), lambda few: self._trace(few, self._reader)
        )

    def _correct(self, ray, wavelengths, sample, own):
        """What full paths add to light that is read from cells, by the same sample of either.

        Points on bright cells take nothing away from rays here: what both together read is what rays alone would.
        """
        full, read = (
            self._receive(GATHERED, ray, wavelengths, sample, own, is_exact=exact, is_alone=True)
            for exact in (True, False)
        )
        return full - read + self._correct_view(_Numbers(ray, wavelengths, sample, own))

    def _correct_view(self, numbers: "_Numbers"):
        """The same of paths of the camera that meet anything but a matt surface first."""
        _, is_matt = self._first(numbers.ray)
        goes_on = self._goes_on(numbers.ray, numbers.sample) & ~is_matt
        return _of_few(
            numbers,
            goes_on,
            lambda few: self._trace(few, None) - self._trace(few, self._reader),
        )

    def _goes_on(self, ray, sample):
        """Which paths meet anything but a matt surface without light of its own first."""
        si, is_matt = self._first(ray)
        is_dark = self.scene.emitter(si, is_matt) == None  # noqa: E711 - element-wise
        goes_on = sees(ray) & ~(is_matt & is_dark)
        if self.scene.surroundings is None and self.scene.backdrop is None:
            goes_on &= si.is_valid()
        # At the full width of the launch, also where nothing depends on the ray.
        goes_on &= mi.Float(sample) >= 0.0
        dr.eval(goes_on)
        return goes_on

    def _trace(self, numbers: "_Numbers", reader: CellReader | None):
        sample, own = numbers.sample, numbers.own
        return trace(
            self.scene,
            numbers.ray,
            numbers.wavelengths,
            random_stream(sample, own),
            mi.Float(0.0),
            numbers.ray.o,
            sees(numbers.ray),
            first=gather.first_points(sample, own),
            reader=reader,
            pixel_width=self.film.pixel_width,
        )

    def _first(self, ray):
        """What is seen first, and whether it is matt."""
        scene = self.scene
        si = closest_hit(scene, ray, sees(ray), coherent=True, looks=mi.Bool(True))
        seen = si.is_valid()
        if scene.hidden is not None:
            number = dr.reinterpret_array(mi.UInt32, si.shape)
            seen &= ~dr.gather(mi.Bool, scene.hidden, number, seen)
        return si, seen & (self.cells.cells.matt.row(si.shape, seen) > 0)

    def _receive(self, kind: int, ray, wavelengths, sample, own, is_exact=False, is_alone=False):
        """Light that the matt surface which is seen first sends on.

        ``is_exact``: whether rays read no cells after all; ``is_alone``: whether no points on cells compete with them.
        """
        scene, cells = self.scene, self.cells
        si, is_matt = self._first(ray)
        stream = random_stream(sample, own)
        bsdf = scene.bsdf(si, is_matt)
        receiver = _SeenSurface(
            si,
            wavelengths,
            stream,
            sobol_pair(sample, own, PAIRS[kind]),
            mi.Float(1.0),
            bsdf,
            is_matt,
        )
        if kind == DIRECT:
            light = direct(scene, receiver, is_matt)
        elif kind == BENT:
            light = scene.bent.light(si, stream, receiver.answer, is_matt, is_seen=mi.Bool(True))
        elif kind == MIRRORED:
            light = mirrored_light(scene, si, receiver.sample, stream, receiver.answer, is_matt)
        elif kind == GUIDED:
            traced, read = cells.guide.light(scene, receiver, stream, by_width=True)
            light = traced + read
        else:
            light = self._gather(receiver, is_exact, 0.0 if is_alone else 1.0)
        return dr.select(is_matt, light, 0.0)

    def _gather(self, receiver: "_SeenSurface", is_exact: bool, guided: float):
        """Light along a ray that the surface scatters, beside so many points on cells."""
        si = receiver.si
        bs, weight = receiver.bsdf.sample(
            mi.BSDFContext(), si, receiver.stream.next_float32(), receiver.sample, receiver.active
        )
        rest, read = incoming(
            self.scene,
            self.cells.cells,
            spawn_ray(self.scene, si, si.to_world(bs.wo)),
            receiver.wavelengths,
            receiver.stream,
            bs.pdf,
            si.p,
            receiver.active & (bs.pdf > 0.0) & dr.any(weight != 0.0),
            receiver.ratio,
            left_out=self._left_out,
            is_exact=is_exact,
            guide=None if is_exact else self.cells.guide,
            # No plain number, which would make kernels of its own.
            guided_ratio=dr.opaque(mi.Float, guided),
            spread=spread_of(bs.pdf),
        )
        return (rest + read) * weight


def _of_few(numbers: _Numbers, goes_on, trace):
    """Light of those paths that go on, in a kernel of their own: most end at once at a matt surface."""
    few = dr.compress(goes_on)
    whole = dr.zeros(mi.Spectrum, dr.width(numbers.sample))
    if len(few):
        dr.scatter(whole, trace(numbers.take(few)), few)
    return whole


@dataclass(frozen=True)
class _SeenSurface:
    """A surface that light is sampled for; as `receiving.Receiver`, but answers by its whole model."""

    si: object
    wavelengths: object
    stream: object
    sample: object
    ratio: object
    bsdf: object
    active: object

    def answer(self, direction, asked):
        """Response and density of a direction, as `next_event` asks for them."""
        local = self.si.to_local(direction)
        return self.bsdf.eval_pdf(mi.BSDFContext(), self.si, local, asked & self.active)
