"""The picture job: passes over all pixels, even and odd halves, until the rule is met.

Every pass doubles the samples of those tiles and kinds of samples that another one serves best. The halves have points of
their own, so half the difference of their means is the error of a pixel.
"""

from collections import deque
from dataclasses import replace
from itertools import zip_longest

import numpy as np

from ...accuracy.estimate import Estimate, relative_error
from ...accuracy.stopping import Clock
from ...errors import Cancelled, SceneError
from ...scene.camera import Camera
from ..lux_maps.bands import TOLERANCE, interpolation_error
from ..paths.channels import LOST
from ..paths.film import GROUPS, MAXIMUM_PIXELS, Film, learn_lights, look
from ..paths.first_layers import first_layers
from ..paths.guides import trace_guides
from .allocation import Allocation
from .foresight import Foresight
from .kept_cells import KeptCells
from .pixel_light import CORRECTION, COSTS, FLOORS, STEERING, VIEW, PixelLight
from .sharing import Shared, find_sharing

METHODS = ("auto", "cells", "paths")

FEWEST_PIXELS, FEWEST_PATHS = 1 << 14, 1 << 19
"""Pixels, and paths, below which finding the light of cells takes longer than full paths."""

FEWEST_SECONDS = 30.0
"""Time below which it would take too much of it. [s]"""

CHECK_SHARE, FEWEST_CHECKS, MOST_CHECKS = 0.01, 1 << 12, 1 << 17
"""Samples that compare cells with full paths, relative to all, and bounds on their number."""

CHANCE = 2.0
"""What of a measured change is taken for chance, in its standard errors."""

LANES = 1 << 19
FIRST_LANES = 1 << 18
"""Samples of one launch, and of one of the first pass."""

BELIEVED = 8
"""Samples per pixel below which the error is not believed enough to stop by it: of so few it is too noisy itself."""

FORETOLD = 16
"""Samples per pixel from which on it is foretold how many will be needed: of fewer it is not known where they will go."""

DARK = 1 << 20
"""Samples of a whole picture that have found no light at all, after which it is known to be dark."""

GROWTH = 0.5
"""Samples of a pass, relative to all before. [-]"""

AHEAD = 1
"""Launches that run while the next one is put together."""

SHARED = 2
"""Samples of a pixel in a half from which on light is shared between pixels: of one it is not known how they scatter."""

EVEN = 4
"""Samples of a pixel in a half up to which all get as many: of fewer it is not known how they scatter."""

LEAST_MEAN = 1.0
"""Samples of a pixel in a half that a pass takes at least, on the mean, where the rule allows as many."""

LEAST = 0.03
"""Samples of a pass, relative to all before, that are worth one. [-]"""

SWEEP_SHARE = 0.15
"""Paths of later sweeps over the cells, relative to the samples of the picture. [-]"""


def choose_method(scene, camera: Camera, settings) -> tuple[bool, str]:
    """Whether to read light beyond the first bounce from cells, and why.

    Raises
    ------
    SceneError    The method is none of the three.
    """
    if settings.method not in METHODS:
        raise SceneError(f"method is '{settings.method}', expected {' or '.join(METHODS)}")
    method = scene.requirements.method_of(settings.method)
    if method == "paths":
        return False, "full paths are asked for"
    spectra = [] if not scene.requirements.spectral else scene.light_spectra
    error = interpolation_error(scene.mean_light, spectra)
    reason = "the radiance beyond the first bounce is read from cells"
    if method == "cells":
        remedy = "; what they change is corrected" if settings.unbiased else ""
        return True, f"{reason}, as asked for{remedy}"
    if settings.unbiased:
        return (
            False,
            "an unbiased picture is asked for, and full paths are sooner than corrected cells: full paths",
        )
    if error > TOLERANCE:
        return False, (
            f"the lights' spectra are so unlike that cells would be wrong by up to {100.0 * error:.2g} %: full paths"
        )
    rule, pixels = settings.rule, camera.width * camera.height
    if rule.seconds is not None and rule.seconds < FEWEST_SECONDS:
        return False, "there is so little time that cells would not pay: full paths"
    if pixels < FEWEST_PIXELS or (rule.samples or np.inf) * pixels < FEWEST_PATHS:
        return False, "there are so few paths that cells would not pay: full paths"
    return True, f"{reason}; the bias is measured"


def render(
    scene,
    camera: Camera,
    settings,
    uses_cells=True,
    progress=None,
    cancelled=lambda: False,
    traced=None,
    kept: KeptCells | None = None,
    keeps_caught: bool = False,
):
    """Render until the rule of ``settings`` is met.

    Parameters
    ----------
    uses_cells : bool    Whether light beyond the first bounce is read from cells.
    traced : CameraLight or None    Adds light that is traced to the camera.
    kept : KeptCells or None    Cells that pictures of the session share.
    keeps_caught : bool
        Whether what is seen of shadow catchers is told as the field ``caught``, means of both halves (2, n, columns), and
        is no part of the picture.

    Returns
    -------
    (dict, int, dict, tuple)    Fields of `views.Picture` but the provenance, the samples per pixel, how many were lost, as
        of `lost_samples.tell_lost`, and notes.

    Raises
    ------
    Cancelled    When ``cancelled`` answered true.
    SceneError    The picture's size is not usable.
    """
    pixels = camera.width * camera.height
    if camera.width < 1 or camera.height < 1 or pixels > MAXIMUM_PIXELS:
        raise SceneError(f"a picture of {camera.width} x {camera.height} pixels cannot be rendered")
    clock = Clock(settings.rule, "picture", foresees=True)
    film = Film(camera, scene.origin)
    layers = first_layers(scene, film)
    learn_lights(scene, film)
    cells = None
    samples = None if settings.rule.samples is None else settings.rule.samples * pixels
    if uses_cells:
        places, normals = look(scene, film)
        if len(places):
            kept = KeptCells() if kept is None else kept
            cells = kept.open(scene, places, normals, pixels, settings.seed, samples, cancelled)
    if cells:
        if progress is not None:
            progress(replace(clock.progress(0, float("inf")), stage="light of the cells"), None)
        cells.prepare()
    if settings.guides:
        layers |= trace_guides(scene, film)
    light = PixelLight(scene, film, settings, cells if cells else None, keeps_caught)
    shares = settings.shares and settings.method != "paths" and not settings.unbiased
    return _Passes(
        light, camera, clock, settings, layers, shares, progress, cancelled, traced
    ).run()


class TracedLight:
    """Mean of the light that is traced to the camera, pass by pass.

    Parameters
    ----------
    source : CameraLight
    channels : Channels
    shape : tuple of int    Halves, pixels and channels.
    """

    def __init__(self, source, channels, shape: tuple[int, int, int]):
        self.source, self.samples = source, 0
        self._channels = channels
        self._sums = np.zeros(shape, dtype=np.float32)

    def add(self, means: np.ndarray, samples: float) -> np.ndarray:
        """Trace for a pass of so many samples of a pixel and half; returns the mean of all so far. (halves, n, channels)

        ``means``: of all other light, which tell the first time how many paths are worth their time.
        """
        more = max(round(samples), 1)
        new = means * more
        self.source.add(new, self.samples, more, self._channels)
        self._sums += new - means * more
        self.samples += more
        return self._sums / self.samples


class _Passes:
    """Makes passes and adds them up."""

    def __init__(
        self,
        light: PixelLight,
        camera,
        clock,
        settings,
        layers,
        shares,
        progress,
        cancelled,
        traced,
    ):
        self.light, self.camera, self.rule = light, camera, settings.rule
        self.layers, self.progress, self.cancelled = layers, progress, cancelled
        self.pixels = camera.width * camera.height
        self.clock, self._begun = clock, clock.seconds
        shape = (GROUPS, self.pixels, light.channels.count)
        costs = {kind: COSTS[kind] for kind in light.kinds}
        self.allocation = Allocation(camera.width, camera.height, costs, FLOORS)
        self.sums = {kind: np.zeros(shape, dtype=np.float32) for kind in light.kinds}
        squares = (len(STEERING), GROUPS, self.pixels)
        self.squares = {kind: np.zeros(squares, dtype=np.float32) for kind in light.kinds}
        self.error = float("inf")
        self.foresight = None
        if self.rule.error is not None:
            self.foresight = Foresight(self.allocation, GROUPS, self.rule.error)
        self.traced = None if traced is None else TracedLight(traced, light.channels, shape)
        self._sharing = self._caught = None
        if shares:
            self._sharing = find_sharing(
                light.scene, light.film, light.channels, light.cells is not None
            )
        # What sharing makes of the light, and what it smooths away, as `error`.
        self._shared: Shared | None = None
        self._smoothed = 0.0

    def run(self):
        """Make passes until the rule is met; returns as `render`."""
        self.clock.begin()
        added = self.allocation.begin()
        while True:
            self._pass(added)
            means = {kind: self._mean(kind) for kind in self.sums}
            whole = sum(means.values())
            if self.traced is not None:
                whole += self.traced.add(whole, self.allocation.mean(added))
            self._caught = self.light.channels.caught(whole)
            whole = self.light.channels.composed(whole)
            estimate = self._estimate(whole, means)
            self.error = relative_error(estimate.mean[:, 1], estimate.standard_error[:, 1])
            is_believed = self.samples >= BELIEVED
            error = self.error if is_believed else float("inf")
            if is_believed and self.samples * self.pixels >= DARK and not whole[..., 1].any():
                error = 0.0
            if self.clock.is_done(self.samples, error):
                self._report(estimate.mean[:, :3])
                return self._finish(estimate)
            squares = self._squares(estimate.mean[:, 1])
            if self.foresight is not None and self.allocation.samples > EVEN:
                self._foresee(whole[..., 1], squares)
            self._report(estimate.mean[:, :3])
            if self.allocation.samples < EVEN <= self._left:
                added = self.allocation.double()
            else:
                added = self.allocation.choose(squares, self._budget(), self._left)

    @property
    def samples(self) -> int:
        """Per pixel, on the mean."""
        return round(GROUPS * self.allocation.samples)

    # ---- private ----

    def _estimate(self, whole: np.ndarray, means: dict[int, np.ndarray]) -> Estimate:
        """Means and errors of all light once it is shared between pixels.

        ``whole``: of the halves, (2, n, channels). ``means``: by kind, without what is traced.
        """
        if self._sharing is None or self.allocation.samples < SHARED:
            return Estimate.from_groups(whole, self.samples)
        # What is shared now goes by how samples scatter without.
        self._shared = None
        shared = self._shared = self._sharing.share(
            means,
            {kind: self._scatter(kind, 0) * GROUPS for kind in self.sums},
        )
        estimate = Estimate.from_groups(whole + shared.change, self.samples)
        scale = _scale(estimate.mean[:, 1])
        smoothed = self._sharing.smoothed_away(shared.change, scale)
        self._smoothed = float(np.sqrt((smoothed[:, 1] / scale**2).mean()))
        return replace(estimate, standard_error=np.sqrt(estimate.standard_error**2 + smoothed))

    def _mean(self, kind: int, channels=slice(None)) -> np.ndarray:
        """Mean of the samples of a kind so far. (2, n, channels)"""
        count = np.maximum(self.allocation.of_pixels(kind), 1).astype(np.float32)
        sums = self.sums[kind][..., channels]
        return sums / count.reshape(count.shape + (1,) * (sums.ndim - 2))

    @property
    def _left(self) -> float:
        """Samples of a pixel in a half that the rule allows yet, on the mean."""
        samples = self.rule.samples
        return np.inf if samples is None else samples / GROUPS - self.allocation.samples

    def _budget(self) -> float:
        """Samples of a pixel in a half that the next pass may take, on the mean."""
        done = self.allocation.samples
        budget = max(GROWTH * done, LEAST_MEAN)
        if self._left - budget < LEAST * done:
            # What would be left is no pass of its own.
            budget = self._left
        if self.rule.seconds is not None:
            each = (self.clock.seconds - self._begun) / max(done, 1e-9)
            left = self.rule.seconds - self.clock.seconds
            budget = min(budget, max(left / max(each, 1e-9), LEAST * done))
        if self.rule.error is not None and self.samples >= BELIEVED:
            # The error falls at least as one over the root.
            more = done * ((self.error / self.rule.error) ** 2 - 1.0)
            budget = min(budget, max(more, LEAST * done))
        return budget

    def _squares(self, luminance: np.ndarray) -> dict[int, np.ndarray]:
        """Squares of the relative errors of pixels by kind, as single samples scatter. (n,) each

        How the halves differ must not decide who gets samples: those whose halves agree by chance would be left alone, and
        the error that is stated would be too small.
        """
        found = {}
        for kind in self.sums:
            found[kind] = self._scatter(kind, 0).mean(axis=0) / _scale(luminance) ** 2
        if self.light.channels.illuminance:
            lux = self._mean(VIEW, STEERING[1]).mean(axis=0)
            found[VIEW] = found[VIEW] + self._scatter(VIEW, 1).mean(axis=0) / _scale(lux) ** 2
        return found

    def _scatter(self, kind: int, number: int) -> np.ndarray:
        """Variance of the mean of a kind's samples, of one of `STEERING`, as those of each half scatter. (2, n)"""
        count = self.allocation.of_pixels(kind)
        mean = self._mean(kind, STEERING[number])
        around = np.maximum(self.squares[kind][number] / count - mean**2, 0.0)
        scatter = around / (GROUPS * np.maximum(count - 1, 1))
        if kind == VIEW and number == 0:
            scatter = scatter + self.light.channels.scatter_of_catchers(self._mean(kind), count)
        if self._shared is not None and number == 0 and kind in self._shared.left:
            scatter *= self._shared.left[kind]
        return scatter

    def _foresee(self, halves: np.ndarray, squares: dict[int, np.ndarray]) -> None:
        """Tell the clock how many samples are needed.

        ``halves``: luminance, (2, n) [cd/m2]. ``squares``: as of `_squares`.
        """
        scales = _scale(halves.mean(axis=0)), np.stack([_scale(each) for each in halves[::-1]])
        scatter = {kind: self._scatter(kind, 0) for kind in self.sums}
        own, others = (
            {kind: (each / scale**2).mean(axis=0) for kind, each in scatter.items()}
            for scale in scales
        )
        self.foresight.note(own, self.error)
        span = self.foresight.span(squares, own, others)
        if self.samples >= FORETOLD and span is not None:
            # As long as the error is not the wanted one, there is a pass to come.
            least = self.samples * (1.0 + LEAST)
            self.clock.foresee(*(max(each, least) for each in span))

    def _pass(self, added: dict[int, np.ndarray]) -> None:
        cells, allocation = self.light.cells, self.allocation
        if cells is not None and self._sweeps_due():
            cells.refresh()
        # What comes first is wanted soon.
        lanes = LANES if allocation.samples else FIRST_LANES
        work = sum(float(more @ allocation.size) for more in added.values()) * GROUPS
        done = 0.0
        # What comes first is shown as it comes.
        ahead, begun = AHEAD if allocation.samples else 0, deque()
        for half in range(GROUPS):
            if cells is not None:
                cells.use(half)
            for parts in self._parts(added, lanes):
                for kind, part in parts:
                    if self.cancelled():
                        raise Cancelled("cancelled")
                    begun.append((kind, part, half, self.light.begin(kind, part, half)))
                    if len(begun) > ahead:
                        self._add(*begun.popleft())
                    done += len(part.lumel) * part.samples
                self._report_part(added, done / max(work, 1.0))
        while begun:
            self._add(*begun.popleft())
        allocation.extend(added)

    def _add(self, kind: int, part, half: int, finish) -> None:
        """Add what `PixelLight.begin` has begun, once it is there."""
        begins = np.flatnonzero(np.diff(part.lumel, prepend=-1))
        rows = part.lumel[begins]
        sums = finish()
        if len(begins) < len(sums):
            sums = np.add.reduceat(sums, begins, axis=0)
        values, squares = np.split(sums, [-len(STEERING)], axis=1)
        if len(rows) == rows[-1] - rows[0] + 1:
            rows = slice(rows[0], rows[-1] + 1)
        self.sums[kind][half][rows] += values
        self.squares[kind][:, half, rows] += squares.T

    def _parts(self, added: dict[int, np.ndarray], lanes: int):
        """Yield kinds and units of work that fit a launch each, all kinds of some pixels together."""
        units = {kind: self.allocation.units(kind, more) for kind, more in added.items()}
        splits = [
            [(kind, part) for part in each.split(lanes)]
            for kind, each in units.items()
            if each is not None
        ]
        for parts in zip_longest(*splits):
            yield [part for part in parts if part is not None]

    def _sweeps_due(self) -> bool:
        cells = self.light.cells
        if self.light.is_corrected:
            # What one kind reads another takes away again, in numbers of their own: all have to read the same.
            return False
        spent = GROUPS * self.allocation.samples * len(self.sums) * self.pixels
        return (cells.sweeps + 1) * cells.work <= SWEEP_SHARE * spent

    def _report_part(self, added: dict[int, np.ndarray], share: float) -> None:
        """Tell of a share of a pass; the first one shows what it has, as far as it is."""
        if self.progress is None:
            return
        samples = GROUPS * (self.allocation.samples + share * self.allocation.mean(added))
        state = self.clock.progress(int(samples + 1e-6), self.error)
        if self.allocation.samples:
            self.progress(state, None)
            return
        sums, shape = self.sums, (self.camera.height, self.camera.width, 3)
        self.progress(state, lambda: sum(each[0, :, :3] for each in sums.values()).reshape(shape))

    def _report(self, mean: np.ndarray) -> None:
        if self.progress is None:
            return
        shape = (self.camera.height, self.camera.width, 3)
        self.progress(
            self.clock.progress(self.samples, self.error),
            lambda: mean.reshape(shape).astype(np.float32),
        )

    def _finish(self, estimate: Estimate):
        channels, counts = self.light.channels, self.allocation.counts
        made = GROUPS * sum(int(n @ self.allocation.size) for n in counts.values())
        # Of a kind that has lost much little may be left, however many samples others have.
        shares = np.zeros((len(LOST), self.pixels))
        for kind, lost in self.light.lost.items():
            count = GROUPS * np.maximum(self.allocation.of_pixels(kind), 1)
            shares = np.maximum(shares, lost / count)
        if self.light.cells is not None:
            shares[0] = np.maximum(shares[0], self.light.cells.lost_share)
        by_chance = estimate.standard_error.copy()
        if shares.any():
            estimate = channels.widened(estimate, shares)
        notes = ()
        if self._shared is not None:
            notes = (
                "pixels share light that is even over a surface; of the stated error "
                f"{100.0 * self._smoothed:.2g} % is what that smooths away",
            )
        if self.light.cells is not None:
            luminance = float(estimate.mean[:, 1].mean())
            tell = self._tell_correction if self.light.is_corrected else self._compare
            beyond, note = tell(luminance)
            estimate.standard_error[:, :3] = np.hypot(
                estimate.standard_error[:, :3], beyond * estimate.mean[:, :3]
            )
            notes += (note, *self.light.cells.notes)
        self.error = relative_error(estimate.mean[:, 1], estimate.standard_error[:, 1])
        all_lost = sum(lost.sum(axis=1) for lost in self.light.lost.values())
        lost = {name: (int(n), made) for name, n in zip(LOST, all_lost, strict=True)}
        if self.light.cells is not None:
            lost["samples of the cells"] = tuple(map(int, self.light.cells.counts))
        shape = (self.camera.height, self.camera.width)
        fields = {
            **channels.fields(estimate, shape),
            **_floors(channels, estimate, by_chance, shape),
            "relative_error": self.error,
            **self.layers,
        }
        if channels.keeps_caught:
            fields["caught"] = self._caught
        return fields, self.samples, lost, notes

    def _tell_correction(self, luminance: float) -> tuple[float, str]:
        """Say what correcting cells by full paths has changed; parameters and values as of `_compare`."""
        scale = max(luminance, 1e-30)
        change = float(self._mean(CORRECTION, STEERING[0]).mean()) / scale
        scatter = self._scatter(CORRECTION, 0).mean(axis=0)
        error = float(np.sqrt(scatter.sum())) / self.pixels / scale
        counts, size = self.allocation.counts, self.allocation.size
        share = COSTS[CORRECTION] * (counts[CORRECTION] @ size)
        share /= sum(COSTS[kind] * (each @ size) for kind, each in counts.items())
        return 0.0, (
            f"what cells change is corrected by full paths, whose picture is the expected one: {100.0 * change:+.2g} +- "
            f"{100.0 * error:.1g} % of the picture's mean, by about {100.0 * share:.0f} % of the work"
        )

    def _compare(self, luminance: float) -> tuple[float, str]:
        """Compare reading cells with full paths at random pixels.

        ``luminance``: mean of the picture. [cd/m2]

        Returns
        -------
        (float, str)    What cells add to that mean or take from it beyond chance, relative [-], and words on it.
        """
        samples = CHECK_SHARE * self.samples * self.pixels
        count = int(np.clip(samples, FEWEST_CHECKS, MOST_CHECKS))
        draw = np.random.default_rng([self.light.seed & 0xFFFFFFFF, 78])
        if self.cancelled():
            raise Cancelled("cancelled")
        self.light.cells.use_mean()
        found = self.light.differences(np.sort(draw.integers(0, self.pixels, GROUPS * count)))
        found /= max(luminance, 1e-30)
        bias, error = float(found.mean()), float(found.std(ddof=1) / np.sqrt(len(found)))
        beyond = max(abs(bias) - CHANCE * error, 0.0)
        note = (
            f"cells instead of full paths change what is seen by {100.0 * bias:+.2g} +- "
            f"{100.0 * error:.1g} % of the picture's mean (measured at {len(found)} pixels)"
        )
        if beyond > 0.0:
            note += f"; the stated errors hold the {100.0 * beyond:.2g} % that are no chance"
        return beyond, note


def _floors(channels, estimate: Estimate, by_chance: np.ndarray, shape) -> dict:
    """What of the errors more samples do not lower, as fields of `views.Picture`; none where that is nothing.

    ``by_chance``: errors without it. (n, channels)
    """
    square = np.maximum(estimate.standard_error**2 - by_chance**2, 0.0)
    if not square.any():
        return {}
    told = channels.fields(replace(estimate, standard_error=np.sqrt(square)), shape)
    names = {"luminance_error": "luminance_floor", "illuminance_error": "illuminance_floor"}
    return {new: told[old] for old, new in names.items() if told.get(old) is not None}


def _scale(values: np.ndarray) -> np.ndarray:
    """What errors of values are relative to, as `relative_error` counts them."""
    values = np.asarray(values, dtype=np.float64)
    return np.maximum(values, max(values.mean(), 1e-30))
