"""Light at sensors by single samples, apart by kind: the kernels of a job that reads cells."""

import drjit as dr
import mitsuba as mi

from ...scene.sensor import SensorKind
from ..lux_maps.path_guiding import Cosine
from ..lux_maps.receiving import Receiver, direct, gathered, mirrored
from ..paths import gather
from ..paths.illuminance import Meter, Places, Receivers
from ..paths.sampler import hash_words, random_stream, sobol_pair
from ..pictures.view_cells import ViewCells

KINDS = ("direct", "gathered", "guided", "mirrored", "bent", "residual")
"""Ways in which light is sampled; the last one is what cells leave out of full paths."""

DIRECT, GATHERED, GUIDED, MIRRORED, BENT, RESIDUAL = range(6)

COSTS = (1.0, 2.0, 0.7, 0.7, 1.0, 8.0)
"""What a sample of each kind costs, relative to next-event; measured in rooms."""

PAIRS = (
    gather.PAIR_LIGHT,
    gather.PAIR_SCATTER,
    gather.PAIR_LENS,
    gather.PAIR_LIGHT,
    gather.PAIR_LIGHT,
    gather.PAIR_SCATTER,
)
"""Points for the choice of a light or a direction, by kind."""


class Sphere:
    """Rays to all sides alike, in the manner of `path_guiding.Cosine`."""

    def sample(self, point):
        """Direction in the receiver's frame, and its density. ``point``: Point2f. [sr-1]"""
        return mi.warp.square_to_uniform_sphere(point), mi.Float(dr.inv_four_pi)

    def density(self, local):
        """Density of a direction in the receiver's frame. [sr-1]"""
        return mi.Float(dr.inv_four_pi)


class SensorLight:
    """Sums of samples of the light at receivers.

    Parameters
    ----------
    scene : CompiledScene
    receivers : Receivers
    seed : int
    colour : bool    Whether X and Z are wanted too.
    cells : ViewCells
    known : KnownDirections or None    Where the receivers get light over bends from, if it was looked for.
    """

    def __init__(
        self,
        scene,
        receivers: Receivers,
        seed: int,
        colour: bool,
        cells: ViewCells,
        known=None,
    ):
        self.scene, self.cells, self.seed, self._known = scene, cells, seed, known
        self.meter = Meter(scene, colour)
        self._kind, self._places = receivers.kind, Places(scene, receivers)
        self._left_out = None if scene.bent is None else scene.bent.left_out

    @property
    def kinds(self) -> tuple[int, ...]:
        """Kinds of samples that make up the light as it is read from cells."""
        has_lights = self.scene.lights.count > 0
        needed = {
            DIRECT: has_lights,
            GUIDED: self.cells.guide is not None,
            MIRRORED: self.scene.mirrors is not None and has_lights,
            BENT: self.scene.bent is not None,
        }
        return tuple(kind for kind in range(RESIDUAL) if needed.get(kind, True))

    def sum(self, kind: int, group: int, first: int, count: int, batch: int, index: int):
        """Samples of receivers, with the cells as they are.

        Parameters
        ----------
        kind : int    One of `KINDS`.
        group : int
        first, count : int    Receivers.
        batch, index : int    Samples of each, a power of two, and the number of the first.

        Returns
        -------
        As `Meter.sums`, by receiver.
        """
        lane = dr.arange(mi.UInt32, count * batch)
        many = dr.opaque(mi.UInt32, int(batch))
        sample = dr.opaque(mi.UInt32, int(index)) + lane % many
        who = dr.opaque(mi.UInt32, int(first)) + lane // many
        seed = dr.opaque(mi.UInt32, int(self.seed) & 0xFFFFFFFF)
        own = dr.opaque(mi.UInt32, len(KINDS) * int(group) + kind + 1)
        own_seed = hash_words(who, hash_words(own, seed))
        wavelengths = gather.draw_wavelengths(self.meter.sampler, sample, own_seed)
        si = self._places.choose(who, sample, own_seed, wavelengths)
        receiver = Receiver(
            si,
            wavelengths,
            random_stream(sample, own_seed),
            sobol_pair(sample, own_seed, PAIRS[kind]),
            mi.Float(1.0),
            gather.response_of(self._kind, si),
            Cosine() if self._kind is SensorKind.PLANAR else Sphere(),
        )
        value = self._receive(kind, receiver, who)
        return self.meter.sums(value, wavelengths, lane, count, batch)

    def _receive(self, kind: int, receiver: Receiver, who):
        """One sample of a kind. ``who``: numbers of the receivers."""
        scene, stream = self.scene, receiver.stream
        if kind == DIRECT:
            return direct(scene, receiver)
        if kind == MIRRORED:
            return mirrored(scene, receiver)
        if kind == BENT:
            known = None if self._known is None else self._known.of(who)
            return scene.bent.light(
                receiver.si, stream, receiver.answer, mi.Bool(True), known=known
            )
        if kind == GUIDED:
            traced, read = self.cells.guide.light(scene, receiver, stream)
            return traced + read
        if kind == GATHERED:
            return self._gather(receiver, self.cells.guide)
        # Without points on cells beside the rays, which make no difference to the sum.
        return self._gather(receiver, None, True) - self._gather(receiver, None)

    def _gather(self, receiver: Receiver, guide, is_exact: bool = False):
        """Light along a ray, read from cells or to the path's end."""
        return gathered(
            self.scene,
            self.cells.cells,
            receiver,
            left_out=self._left_out,
            is_exact=is_exact,
            guide=guide,
        )
