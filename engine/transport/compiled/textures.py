"""Spectra and pictures of the scene description as Mitsuba textures, in the active variant."""

import mitsuba as mi
import numpy as np

from ...photometry.spectra import GRID, evaluate_reflectance, luminous_efficiency
from ...photometry.units import MAXIMUM_WAVELENGTH, MINIMUM_WAVELENGTH
from ...scene.material import Cauchy, IorTable
from ...scene.spectrum import Constant
from ...scene.texture import ImageTexture
from .bitmaps import Bitmaps


def is_spectral() -> bool:
    """Tell whether the active variant carries wavelengths."""
    return "spectral" in mi.variant()


def table(values: np.ndarray) -> dict:
    """Texture of a spectrum given on the 1 nm grid, (471,)."""
    return {
        "type": "regular",
        "wavelength_min": MINIMUM_WAVELENGTH,
        "wavelength_max": MAXIMUM_WAVELENGTH,
        "values": " ".join(f"{v:.9g}" for v in values),
    }


def number(value: float) -> dict:
    """Texture of the same number everywhere."""
    return {"type": "uniform", "value": float(value)}


class TextureMaker:
    """Makes textures for one scene.

    Parameters
    ----------
    light : (471,) array    Mean spectrum of the scene's lights; photometric variants weigh reflectances by it.
    bitmaps : Bitmaps or None    Textures of pictures that are there already; pictures do not depend on the light.
    """

    def __init__(self, light: np.ndarray, bitmaps: Bitmaps | None = None):
        self.bitmaps = Bitmaps() if bitmaps is None else bitmaps
        weight = light * luminous_efficiency()
        self._weight = (
            weight / weight.sum() if weight.sum() > 0.0 else np.full(len(GRID), 1.0 / len(GRID))
        )

    def reflectance(self, colour):
        """Texture of a reflectance or transmittance in [0, 1]."""
        if isinstance(colour, ImageTexture):
            return self.picture(colour)
        # Constants too: what differs in the kind of its textures is another model to a kernel. A table must not be empty.
        values = np.clip(evaluate_reflectance(colour, GRID), 0.0, 1.0)
        if is_spectral() and values.any():
            return table(values)
        return number(float(values @ self._weight))

    def spectrum(self, colour, steps: int) -> np.ndarray:
        """Reflectance at even steps from 360 to 830 nm, or the one photometric value. (steps,) or (1,)"""
        if isinstance(colour, Constant):
            values = np.full(steps, np.clip(colour.value, 0.0, 1.0))
        else:
            grid = np.linspace(MINIMUM_WAVELENGTH, MAXIMUM_WAVELENGTH, steps)
            values = np.clip(evaluate_reflectance(colour, grid), 0.0, 1.0)
        if is_spectral():
            return values
        full = np.clip(evaluate_reflectance(colour, GRID), 0.0, 1.0)
        return np.array([float(full @ self._weight)])

    def weigh(self, values: np.ndarray, wavelengths: np.ndarray) -> np.ndarray:
        """Values (..., w), linear between wavelengths, as the variant needs them: as they are, or one (..., 1)."""
        if len(wavelengths) == 1 or is_spectral():
            return values
        below = np.clip(
            np.searchsorted(wavelengths, GRID, side="right") - 1, 0, len(wavelengths) - 2
        )
        step = wavelengths[below + 1] - wavelengths[below]
        share = np.clip((GRID - wavelengths[below]) / step, 0.0, 1.0)
        weight = np.bincount(below, self._weight * (1.0 - share), len(wavelengths))
        weight += np.bincount(below + 1, self._weight * share, len(wavelengths))
        return (values @ weight.astype(values.dtype))[..., None]

    def picture(self, texture: ImageTexture, largest: float = 1.0):
        """Texture of a picture."""
        return self.bitmaps.texture(texture, largest)

    def row(self, texture: ImageTexture) -> int:
        """Row of a picture in the table of pictures, for a reflectance."""
        return self.bitmaps.row(texture)

    def relief(self, texture: ImageTexture) -> int:
        """Row of a picture of vectors or heights, whose numbers stay as they are."""
        return self.bitmaps.row(texture, largest=np.inf)

    def scalar(self, value, power: float = 1.0):
        """Texture of a plain number or one-channel picture, raised to ``power``."""
        if isinstance(value, ImageTexture):
            return self.bitmaps.texture(value, power=power)
        return number(float(value) ** power)

    def metal(self, name: str) -> dict:
        """Properties of Mitsuba's conductors for the complex refractive index of a metal; ``none``: a perfect mirror."""
        known = mi.traverse(mi.load_dict({"type": "conductor", "material": name}))
        # Files of metals have entries at their own wavelengths, whose number is part of a model.
        parts = {part: _on_grid(known, part) for part in ("eta", "k")}
        if is_spectral():
            return {part: table(values) for part, values in parts.items()}
        return {part: number(float(values @ self._weight)) for part, values in parts.items()}

    def refractive_index(self, ior) -> dict:
        """Texture of a refractive index by wavelength."""
        return table(refractive_index(ior, GRID))


def _on_grid(known, part: str) -> np.ndarray:
    """Spectrum among a plug-in's parameters at every nanometre. (471,)"""
    if f"{part}.value" in known:
        # A table must not be empty, and this much changes no digit of a mirror's reflectance.
        return np.full(len(GRID), max(np.array(known[f"{part}.value"]).item(), 1e-9))
    return np.interp(
        GRID, np.array(known[f"{part}.wavelengths"]), np.array(known[f"{part}.values"])
    )


def refractive_index(ior, wavelengths) -> np.ndarray:
    """Evaluate a refractive index. [nm -> -]"""
    if isinstance(ior, Cauchy):
        return ior.a + ior.b / (np.asarray(wavelengths) * 1e-3) ** 2
    if isinstance(ior, IorTable):
        return np.interp(wavelengths, ior.wavelengths, ior.values)
    raise TypeError(f"not a refractive index: {ior!r}")
