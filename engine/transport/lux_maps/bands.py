"""A few wavelengths at which the cells hold light, and how it is read at all others.

Cells hold the ratio of their irradiance to the scene's mean light, which is smooth where the lights share a spectrum,
however spiky that is, because reflectances are smooth. Between the nodes the ratio is interpolated linearly.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...photometry.spectra import GRID, observer
from ...photometry.units import LUMINOUS_EFFICACY, MINIMUM_WAVELENGTH
from ..compiled.textures import is_spectral

FIRST, LAST, WIDTH = 390.0, 710.0, 10.0
"""Range of the nodes and the width of the bands that hold one each. [nm]"""

PER_PATH = 4
"""Wavelengths of a path."""

TOLERANCE = 0.003
"""Largest error of luminance, relative, by which any single light may be interpolated between the nodes. [-]"""

LINE = 5.0
"""A wavelength with so many times the light of the middle of its band is a line, and takes the node."""


class Bands:
    """Nodes and the tables that read between them; one node that stands for everything in photometric variants.

    Parameters
    ----------
    light : (471,) array    Mean spectrum of the scene's lights on the 1 nm grid.
    """

    def __init__(self, light: np.ndarray):
        self.light = np.asarray(light, dtype=np.float64)
        self.nodes = choose_nodes(self.light) if is_spectral() else np.array([555])
        self.count = len(self.nodes)
        if not is_spectral():
            return
        places = self.nodes - int(MINIMUM_WAVELENGTH)
        steps = np.arange(len(GRID))
        low = np.clip(np.searchsorted(places, steps, side="right") - 1, 0, self.count - 2)
        share = np.clip((steps - places[low]) / (places[low + 1] - places[low]), 0.0, 1.0)
        light = self.light / self.light.max()
        # Where the lights give nothing there is no ratio, and the nearest node that has one serves.
        lit = np.flatnonzero(light[places] > 0.0)
        nearest = lit[np.abs(places[:, None] - places[lit]).argmin(axis=1)]
        self._below, self._above = (
            upload(mi.UInt32, nearest[low]),
            upload(mi.UInt32, nearest[low + 1]),
        )
        self._share, self._light = upload(mi.Float, share), upload(mi.Float, light)
        self._nodes = upload(mi.Float, self.nodes)
        dr.eval(self._below, self._above, self._share, self._light, self._nodes)

    @property
    def turns(self) -> int:
        """Paths that together have every node once."""
        return self.count // PER_PATH if is_spectral() else 1

    def wavelengths(self, turn):
        """Four nodes of a path, spread over the range. ``turn``: 0..turns-1. None in photometric variants. [nm]"""
        if not is_spectral():
            return None
        made = mi.Spectrum(0.0)
        for k in range(PER_PATH):
            made[k] = dr.gather(mi.Float, self._nodes, turn + k * self.turns)
        return made

    def ratios(self, value, wavelengths) -> list:
        """Spectral irradiance over the mean light, for every wavelength of the path."""
        if not is_spectral():
            return [value[0] if len(value) == 1 else value.x]
        light = self._light_at(wavelengths)
        return [dr.select(light[k] > 0.0, value[k] / light[k], 0.0) for k in range(PER_PATH)]

    def read(self, table, row, wavelengths, active):
        """Spectral irradiance of a row of ratios (rows, nodes), flat."""
        if not is_spectral():
            return mi.Spectrum(dr.gather(mi.Float, table, row, active))
        value = mi.Spectrum(0.0)
        light = self._light_at(wavelengths)
        for k in range(PER_PATH):
            step = _step(wavelengths[k])
            below, above = (
                dr.gather(
                    mi.Float, table, row * self.count + dr.gather(mi.UInt32, node, step), active
                )
                for node in (self._below, self._above)
            )
            value[k] = dr.lerp(below, above, dr.gather(mi.Float, self._share, step)) * light[k]
        return value

    def grey(self, ratio, wavelengths):
        """Spectral irradiance whose ratio to the mean light is the same at all wavelengths."""
        if not is_spectral():
            return mi.Spectrum(ratio)
        return self._light_at(wavelengths) * ratio

    def illuminance(self) -> float:
        """Illuminance of light whose ratio to the mean light is 1 at all wavelengths. [lx]"""
        if not is_spectral():
            return 1.0
        light = self.light / self.light.max()
        return LUMINOUS_EFFICACY * float((light * observer()[:, 1]).sum())

    def luminous(self, some=slice(None)) -> np.ndarray:
        """Weights by which ratios at the nodes, or at some of them, add up to light, up to a factor; sum 1. (count,)"""
        if self.count == 1:
            return np.ones(1)
        weight = self.light * observer()[:, 1]
        places = self.nodes[some] - int(MINIMUM_WAVELENGTH)
        hats = np.stack([np.interp(np.arange(len(GRID)), places, e) for e in np.eye(len(places))])
        made = hats @ weight
        return made / made.sum()

    def _light_at(self, wavelengths):
        return mi.Spectrum(
            *(dr.gather(mi.Float, self._light, _step(wavelengths[k])) for k in range(PER_PATH))
        )


def _step(wavelength):
    return mi.UInt32(dr.clip(wavelength - (MINIMUM_WAVELENGTH - 0.5), 0, len(GRID) - 1))


def choose_nodes(light: np.ndarray) -> np.ndarray:
    """Wavelengths of the nodes: the middles of bands, and lines where bands have some. Whole numbers. (n,) [nm]

    Their number is a multiple of four.
    """
    middles = np.arange(FIRST + 0.5 * WIDTH, LAST, WIDTH)
    nodes = []
    for middle in middles:
        inside = np.flatnonzero(np.abs(GRID - middle + 0.25) < 0.5 * WIDTH)
        brightest = inside[np.argmax(light[inside])]
        here = int(middle - MINIMUM_WAVELENGTH)
        is_line = light[brightest] > LINE * light[here]
        nodes.append(int(GRID[brightest if is_line else here]))
    return np.array(nodes)


def interpolation_error(light: np.ndarray, others: list[np.ndarray]) -> float:
    """Largest relative error of luminance that reading any of the lights between the nodes makes. [-]

    Parameters
    ----------
    light : (471,) array    Mean light.
    others : list of (471,) array    Spectra of the single lights, any scale.
    """
    nodes = choose_nodes(light)
    places = nodes - int(MINIMUM_WAVELENGTH)
    weight = observer()[:, 1]
    worst = 0.0
    for other in others:
        total = float((other * weight).sum())
        if total <= 0.0:
            continue
        ratio = np.where(light > 0.0, other / np.where(light > 0.0, light, 1.0), 0.0)
        read = np.interp(np.arange(len(GRID)), places, ratio[places]) * light
        worst = max(worst, abs(float((read * weight).sum()) / total - 1.0))
    return worst
