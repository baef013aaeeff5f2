"""Choice of the four wavelengths of a path and the weights that turn spectral radiance into answers."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...materials.plugins import DISPERSED_COMPONENT
from ...photometry.spectra import GRID, observer
from ...photometry.units import LUMINOUS_EFFICACY, MINIMUM_WAVELENGTH
from ..compiled.textures import is_spectral

DEFENSIVE_SHARE = 0.1
"""Share of wavelengths drawn without regard to the lamps, so that no wavelength has zero density."""


class WavelengthSampler:
    """Draws wavelengths in proportion to response times the scene's mean light.

    They are full nanometres, on which all spectra are tabulated, so that the mean of the estimate is exactly the 1 nm sum
    of photometry, for narrow lines as for daylight.

    With one lamp spectrum and neutral surfaces the weight of every path is then nearly the same, and spectral transport
    costs no extra noise. The four wavelengths of a path are equally spaced in the cumulative distribution.

    Parameters
    ----------
    light : (471,) array    Mean spectral power of the scene's lights on the 1 nm grid, any scale.
    response : str    ``luminance`` when only V(lambda) matters, ``colour`` for x-bar + y-bar + z-bar,
        ``bands`` when spectral bands are wanted too.
    is_even : bool    Whether they are drawn evenly from the whole range instead.
    """

    def __init__(self, light: np.ndarray, response: str, is_even: bool = False):
        functions = observer()
        base = {"luminance": functions[:, 1], "colour": functions.sum(axis=1)}.get(response)
        if base is None:
            base = functions.sum(axis=1) + 0.5 * ((GRID >= 380.0) & (GRID <= 780.0))
        wanted = base * light
        density = wanted if np.any(wanted > 0.0) else base
        density = (
            1.0 - DEFENSIVE_SHARE
        ) * density / density.sum() + DEFENSIVE_SHARE * base / base.sum()
        density = np.ones(len(GRID)) if is_even else np.maximum(density, 1e-7)
        density /= density.sum()
        self._cdf = upload(mi.Float, np.concatenate([[0.0], np.cumsum(density)]))
        self._density = upload(mi.Float, density)
        self._response = [
            upload(mi.Float, LUMINOUS_EFFICACY * functions[:, i] / density / 4.0) for i in range(3)
        ]
        dr.eval(self._cdf, self._density, *self._response)

    def sample(self, u):
        """Return the four wavelengths of a path from one number in [0, 1). [nm]"""
        wavelengths = mi.Spectrum(0.0)
        for k in range(4):
            v = u + 0.25 * k
            v = dr.select(v >= 1.0, v - 1.0, v)
            cell = dr.binary_search(
                0, len(GRID), lambda i, v=v: dr.gather(mi.Float, self._cdf, i) <= v
            )
            cell = dr.clip(mi.Int32(cell) - 1, 0, len(GRID) - 1)
            wavelengths[k] = mi.Float(cell) + MINIMUM_WAVELENGTH
        return wavelengths

    def _weight(self, table, wavelengths):
        weights = mi.Spectrum(0.0)
        for k in range(4):
            cell = mi.UInt32(dr.clip(wavelengths[k] - (MINIMUM_WAVELENGTH - 0.5), 0, len(GRID) - 1))
            weights[k] = dr.gather(mi.Float, table, cell)
        return weights

    def luminance(self, radiance, wavelengths):
        """Estimate of K_m * integral of radiance times V. [W/m2/sr/nm -> cd/m2, or W/m2/nm -> lx]"""
        return dr.sum(self.luminances(radiance, wavelengths))

    def luminances(self, radiance, wavelengths):
        """Its parts by wavelength, whose sum it is."""
        return radiance * self._weight(self._response[1], wavelengths)

    def from_lumens(self, amount, wavelengths):
        """Turn lumens by wavelength into what `luminance` makes as many of. [lm -> W/nm]"""
        return amount / dr.maximum(self._weight(self._response[1], wavelengths), 1e-20)

    def tristimulus(self, radiance, wavelengths):
        """Estimate of X, Y, Z in photometric units (Y is the luminance). [W/m2/sr/nm -> cd/m2]"""
        return mi.Color3f(
            *(dr.sum(radiance * self._weight(table, wavelengths)) for table in self._response)
        )

    def density(self, wavelengths):
        """Probability of each wavelength, which stands for 1 nm. [1/nm]"""
        return self._weight(self._density, wavelengths)


def make_sampler(scene, response: str) -> WavelengthSampler | None:
    """Return what draws the wavelengths of a compiled scene's paths; None in photometric variants.

    ``response``: as of `WavelengthSampler`.
    """
    if not is_spectral():
        return None
    return WavelengthSampler(scene.mean_light, response, scene.requirements.draws_evenly)


def disperse(scene, bs, throughput, dispersed, turned):
    """Leave a path to the first of its wavelengths, with the share of all four, where glass sends them apart.

    Parameters
    ----------
    scene : CompiledScene
    bs : BSDFSample3f    Where the path goes on.
    throughput : Spectrum
    dispersed : Bool    Whether the path has one wavelength left.
    turned : Bool    Whether it does not go straight on.

    Returns
    -------
    (Spectrum, Bool)    Throughput, and whether the path has one wavelength left now.
    """
    if not scene.requirements.dispersive:
        return throughput, dispersed
    splits = turned & (bs.sampled_component == DISPERSED_COMPONENT) & ~dispersed
    hero = mi.Spectrum(0.0)
    hero[0] = 4.0 * throughput[0]
    return dr.select(splits, hero, throughput), dispersed | splits
