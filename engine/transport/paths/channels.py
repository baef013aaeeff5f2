"""What is told of a pixel: colour, illuminance, backdrop and bands of samples, and the result that their means make."""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ...accuracy.estimate import Estimate
from ...accuracy.lost_samples import find_missing
from ...arrays import average
from ...caught_light import SHADED
from ...photometry.spectra import GRID, observer
from ...photometry.units import LUMINOUS_EFFICACY
from ..rays import spawn_straight
from . import gather
from .catchers import Catchers
from .film import sees
from .sampler import hash_words, random_stream, sobol_pair
from .visibility import closest_hit, first_seen
from .wavelengths import WavelengthSampler, make_sampler

BAND_RANGE = (380.0, 780.0)
"""Wavelengths that the bands cover. [nm]"""

LONGEST_WAY = 1000
"""Surfaces that a ray of the camera is followed through on its way out."""

LOST = ("samples of the picture", "samples of the illuminance")
"""Of what samples are counted that are no numbers."""


class Channels:
    """Numbers of pixels, in this order: X, Y, Z; illuminance; X, Y, Z and share of the backdrop; of shadow catchers; bands.

    Parameters
    ----------
    scene : CompiledScene
    settings : ViewSettings    Tells which of them are wanted.
    keeps_caught : bool    Whether what is seen of shadow catchers is no part of the picture yet, as light groups need it.

    Attributes
    ----------
    count : int    Numbers of a pixel.
    catchers : Catchers or None
    keeps_caught : bool
    """

    def __init__(self, scene, settings, keeps_caught=False):
        self.scene = scene
        self.illuminance, self.bands = settings.illuminance, settings.bands
        self.transparent = settings.transparent
        self.keeps_caught = keeps_caught
        # Holdouts make holes in every film.
        self._has_alpha = settings.transparent or scene.holdouts is not None
        self.sampler = picture_sampler(scene, self.bands)
        self.catchers = None
        if scene.catchers is not None:
            self.catchers = Catchers(scene, self._colour, self._bands, self.bands)
        self._first_caught = 3 + int(self.illuminance) + 4 * int(self._has_alpha)
        self.count = self._first_caught + self.bands
        if self.catchers is not None:
            self.count += self.catchers.layout.count
        # Photometric transport carries luminance alone; the lamps' common spectrum gives colour and bands back.
        self._lamp_tristimulus, self._lamp_bands = colour_of(scene.mean_light, self.bands)

    @property
    def light_columns(self) -> list[int]:
        """Numbers of the columns that `of_light` gives."""
        return [0, 1, 2, *range(self.count - self.bands, self.count)]

    @property
    def light_colour(self) -> np.ndarray | None:
        """What these columns are for each unit of luminance, where all light has one colour; else None."""
        if self.sampler is not None:
            return None
        return np.concatenate([self._lamp_tristimulus, self._lamp_bands])

    # ---- inside kernels ----

    def of_light(self, radiance, wavelengths) -> dict:
        """Columns of radiance, by their numbers."""
        made = dict(enumerate(self._colour(radiance, wavelengths)))
        first = self.count - self.bands
        return made | {first + k: each for k, each in enumerate(self._bands(radiance, wavelengths))}

    def of_view(self, ray, wavelengths, sample, seed, row, lost) -> dict:
        """Columns of the place that is seen and of what is behind everything, by their numbers.

        ``lost``: `LostSamples` of the illuminance, with a counter for each ``row``.
        """
        columns = []
        if self.illuminance:
            columns += lost.keep([self._illuminance(ray, wavelengths, sample, seed)], row)
        if self._has_alpha:
            columns += self._backdrop(ray, wavelengths)
        if self.catchers is not None:
            columns += self.catchers.of_view(ray, wavelengths, sample, seed)
        return {3 + k: each for k, each in enumerate(columns)}

    def _colour(self, radiance, wavelengths) -> list:
        if self.sampler is not None:
            xyz = self.sampler.tristimulus(radiance, wavelengths)
            return [xyz.x, xyz.y, xyz.z]
        return [radiance[0] * float(c) for c in self._lamp_tristimulus]

    def _bands(self, radiance, wavelengths) -> list:
        """Spectral radiance by band."""
        if self.sampler is None:
            return [radiance[0] * float(value) for value in self._lamp_bands]
        if not self.bands:
            return []
        width = (BAND_RANGE[1] - BAND_RANGE[0]) / self.bands
        density = self.sampler.density(wavelengths)
        made = [mi.Float(0.0)] * self.bands
        for k in range(4):
            value = radiance[k] / (4.0 * density[k] * width)
            # A wavelength stands for the nanometre about it, which an edge between two bands may divide.
            start = (wavelengths[k] - 0.5 - BAND_RANGE[0]) / width
            for band in range(self.bands):
                low = dr.maximum(start, float(band))
                high = dr.minimum(start + 1.0 / width, band + 1.0)
                made[band] = made[band] + value * dr.maximum((high - low) * width, 0.0)
        return made

    def _backdrop(self, ray, wavelengths) -> list:
        """X, Y, Z of what rays of the camera see of the surroundings, and the share of rays that do or see holdouts.

        Of a film that is not transparent the surroundings are a part.
        """
        scene = self.scene
        passed, held = way_out(scene, ray, wavelengths)
        if not self.transparent:
            return [dr.zeros(mi.Float, dr.width(ray))] * 3 + [average(held)]
        if scene.backdrop is None:
            colour = [dr.zeros(mi.Float, dr.width(ray))] * 3
        else:
            away = dr.zeros(mi.SurfaceInteraction3f)
            away.wi, away.p = -ray.d, ray.o
            if self.sampler is not None:
                away.wavelengths = wavelengths
            colour = self._colour(passed * scene.backdrop.eval(away), wavelengths)
        # Where the camera has no picture there is nothing behind it either.
        seen = sees(ray)
        gone = average(passed) if held is None else average(passed + held)
        return [*(dr.select(seen, each, 0.0) for each in colour), gone]

    def _illuminance(self, ray, wavelengths, sample, own_seed):
        """Illuminance of the first surface behind panes and bodies of lights, on the side that is seen."""
        si = first_solid(self.scene, ray)
        valid = si.is_valid()
        faces = dr.dot(si.n, ray.d) < 0.0
        side = dr.select(faces, 1.0, -1.0)
        at = gather.receiver(
            si.p, si.sh_frame.n * side, si.n * side, wavelengths, self.scene.extent_at(si)
        )
        pair = gather.PAIR_FILM + 1
        value = gather.spectral_illuminance(
            self.scene,
            at,
            wavelengths,
            random_stream(sample, hash_words(own_seed, mi.UInt32(1))),
            sobol_pair(sample, own_seed, pair),
            sobol_pair(sample, own_seed, pair + 1),
            valid,
        )
        value = gather.photometric(self.sampler, value, wavelengths)
        return dr.select(valid, value, 0.0)

    # ---- of means ----

    def composed(self, halves: np.ndarray) -> np.ndarray:
        """Means of both halves with what is seen of shadow catchers, where it is not kept apart. (2, n, channels)"""
        if self.catchers is None or self.keeps_caught:
            return halves
        made = halves.copy()
        caught = self.caught(halves)
        shown, is_open = self.catchers.layout.shade(caught)
        made[..., :3] += shown.tristimulus + shown.change
        if self.bands:
            made[..., -self.bands :] += shown.bands + shown.band_change
        # Holes so far: of a film that is not transparent they are none, else as far as they are in the light.
        alpha = self._first_caught - 4
        share = caught[..., 0]
        if self.transparent:
            made[..., alpha : alpha + 3] += shown.tristimulus
            made[..., alpha + 3] += is_open - share
        else:
            made[..., alpha + 3] -= share
        return made

    def scatter_of_catchers(self, means: np.ndarray, counts: np.ndarray):
        """Variance of what is seen of shadow catchers, by means of both halves (2, n, channels). (2, n) or 0 [cd2/m4]"""
        if self.catchers is None:
            return 0.0
        white = float(means[..., 1].mean()) if self.transparent else 0.0
        caught = self.caught(means)
        whole = caught.mean(axis=0, dtype=np.float64)
        return self.catchers.layout.scatter(caught, whole, counts, white)

    def caught(self, means: np.ndarray) -> np.ndarray | None:
        """Columns of shadow catchers, None without any. (..., count)"""
        if self.catchers is None:
            return None
        return means[..., self.caught_columns]

    @property
    def caught_columns(self) -> slice:
        """Which they are."""
        return slice(self._first_caught, self._first_caught + self.catchers.layout.count)

    @property
    def shaded_columns(self) -> slice:
        """Those of the illuminance of catchers in straight view with all that stands there."""
        return slice(self._first_caught + 1 + SHADED.start, self._first_caught + 1 + SHADED.stop)

    def widened(self, estimate: Estimate, shares: np.ndarray) -> Estimate:
        """With errors that hold what lost samples may have brought; the brightest pixel stands for those without any other.

        ``shares``: of the samples of every pixel, of the colour and of the illuminance. (2, n) [-]
        """
        error = estimate.standard_error.copy()
        # The illuminance, where there is one, stands behind the colour.
        for part, share in zip((slice(0, 3), slice(3, 4)), shares, strict=True):
            mean = estimate.mean[:, part]
            missing = find_missing(mean, share[:, None], mean.mean(axis=0))
            if not np.isinf(missing).all():
                missing = np.where(np.isfinite(missing), missing, mean.max(axis=0, initial=0.0))
            error[:, part] = np.hypot(error[:, part], missing)
        return replace(estimate, standard_error=error)

    def fields(self, estimate: Estimate, shape: tuple[int, int]) -> dict:
        """Fields of `views.Picture` that means and errors of all pixels make. ``shape``: rows and columns."""
        mean = estimate.mean.reshape(*shape, -1).astype(np.float32)
        deviation = estimate.standard_error.reshape(*shape, -1).astype(np.float32)
        made = {"tristimulus": mean[..., :3], "luminance_error": deviation[..., 1]}
        if self.illuminance:
            made["illuminance"] = mean[..., 3]
            made["illuminance_error"] = deviation[..., 3]
        if self.bands:
            made["bands"] = mean[..., -self.bands :]
            made["band_edges"] = np.linspace(*BAND_RANGE, self.bands + 1)
        if self._has_alpha:
            first = self._first_caught - 4
            made["backdrop"] = mean[..., first : first + 3]
            made["coverage"] = np.clip(1.0 - mean[..., first + 3], 0.0, 1.0)
        return made


def picture_sampler(scene, bands: int) -> WavelengthSampler | None:
    """Wavelengths of a picture's paths; None in photometric variants."""
    response = "bands" if bands else "colour"
    return make_sampler(scene, response)


def colour_of(light: np.ndarray, bands: int) -> tuple[np.ndarray, np.ndarray]:
    """X, Y, Z (Y = 1) and band radiances per unit of luminance of a spectrum on the grid."""
    tristimulus = light @ observer()
    density = light / (LUMINOUS_EFFICACY * tristimulus[1])
    edges = np.linspace(*BAND_RANGE, bands + 1)
    means = [
        density[(a <= GRID) & (b > GRID)].mean() for a, b in zip(edges, edges[1:], strict=False)
    ]
    return tristimulus / tristimulus[1], np.array(means)


def way_out(scene, ray, wavelengths):
    """Shares of rays of the camera that leave the scene straight, through panes and what the camera does not see.

    Returns
    -------
    (Spectrum, Spectrum or None)    The share that gets out, and that which ends in holdouts; None without any.
    """
    ray = mi.Ray3f(ray)
    if wavelengths is not None:
        ray.wavelengths = wavelengths

    def step(ray, share, held, active, steps):
        si = closest_hit(scene, ray, active, looks=mi.Bool(True))
        met = active & si.is_valid()
        passed = scene.bsdf(si, met).eval_null_transmission(si, met)
        if scene.hidden is not None:
            ids = dr.reinterpret_array(mi.UInt32, si.shape)
            passed = dr.select(dr.gather(mi.Bool, scene.hidden, ids, met), 1.0, passed)
        if scene.holdouts is not None:
            ids = dr.reinterpret_array(mi.UInt32, si.shape)
            is_hole = dr.gather(mi.Bool, scene.holdouts, ids, met) & met
            if scene.hidden is not None:
                is_hole &= ~dr.gather(mi.Bool, scene.hidden, ids, met)
            held = dr.select(is_hole, held + share, held)
            passed = dr.select(is_hole, 0.0, passed)
        share = dr.select(met, share * passed, share)
        ray = dr.select(met, spawn_straight(scene, si, ray), ray)
        going = met & dr.any(share != 0.0) & (steps < LONGEST_WAY)
        share = dr.select(met & (steps >= LONGEST_WAY), 0.0, share)
        return ray, share, held, going, steps + 1

    held = None if scene.holdouts is None else mi.Spectrum(0.0)
    _, share, held, _, _ = dr.while_loop(
        state=(ray, mi.Spectrum(1.0), held, sees(ray), mi.UInt32(0)),
        cond=lambda ray, share, held, active, steps: active,
        body=step,
        labels=("ray", "share", "held", "active", "steps"),
    )
    return share, held


def first_solid(scene, ray):
    """First surface that a camera's ray sees behind panes and bodies of lights."""
    return first_seen(scene, ray, sees(ray), passes_veil=True)
