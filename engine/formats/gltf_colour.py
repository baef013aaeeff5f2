"""What a material looks like in one flat colour, for viewers that have no light of their own to fall on it."""

from dataclasses import dataclass
from functools import lru_cache
from importlib.machinery import PathFinder
from pathlib import Path

import numpy as np

from ..errors import BackendError
from ..materials.fibres import sent_on
from ..photometry.colour import REC709_LUMINANCE, scene_linear
from ..photometry.spectra import GRID, evaluate_emission, evaluate_reflectance, illuminant, observer
from ..scattering.data.evaluation import total
from ..scene.material import (
    Black,
    Blend,
    Catcher,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Emission,
    Fabric,
    Glossy,
    Holdout,
    Material,
    Measured,
    Mix,
    Raised,
    Sheen,
    Surface,
    TabulatedPane,
    ThinGlass,
    Toon,
    Transparent,
    Varnish,
)
from ..scene.spectrum import Constant, Rgb
from ..scene.texture import ImageTexture
from .spd import read_spectrum


@dataclass(frozen=True)
class FlatColour:
    """A surface as it is seen head-on, colours in linear Rec. 709.

    Parameters
    ----------
    reflected : (3,) array    Share of the light that is reflected; mirrors and metals count as if they were matt. [-]
    passing : float    Share of the light that passes without being scattered. [-]
    emitted : (3,) array    Luminance of its own. [cd/m2]
    """

    reflected: np.ndarray
    passing: float
    emitted: np.ndarray

    @property
    def needs_light(self) -> bool:
        """Whether it is seen by the light on it: it reflects, or is black, and does not glow."""
        return bool(self.reflected.any() or self.passing == 0.0) and not self.emitted.any()


def flatten(material: Material) -> FlatColour:
    """Reduce a material to its flat colour; of pictures the mean counts.

    Raises
    ------
    SceneError    A spectrum cannot be evaluated.
    BackendError    A metal's refractive index is wanted and Mitsuba, which has it, is not installed.
    """
    reflected, passing = _look(material.surface)
    return FlatColour(np.clip(reflected, 0.0, 1.0), passing, _emitted(material.emission))


def _look(surface: Surface) -> tuple[np.ndarray, float]:
    """Colour that a surface reflects (3,), and the share that passes."""
    return LOOKS[type(surface)](surface)


def _by_reflectance(surface: Diffuse | Coated | Glossy | Toon):
    return _colour(surface.reflectance), 0.0


def _fabric(surface: Fabric):
    return _colour(surface.reflectance), float(surface.openness)


def _conductor(surface: Conductor):
    return _metal(surface.metal), 0.0


def _dielectric(surface: Dielectric):
    face = _face(float(_index(surface.ior)))
    return np.zeros(3), _luminous(surface.tint) ** 2 * (1.0 - face) ** 2


def _thin_glass(surface: ThinGlass):
    body, face = _luminous(surface.transmittance), _face(surface.ior)
    # All paths to and fro in the pane. (EN 410, geometric series)
    return np.zeros(3), body * (1.0 - face) ** 2 / (1.0 - (body * face) ** 2)


def _tabulated_pane(surface: TabulatedPane):
    return np.zeros(3), float(np.interp(0.0, surface.angles, surface.transmittance))


def _transparent(surface: Transparent):
    return np.zeros(3), _luminous(surface.transmittance)


def _black(_surface: Black):
    return np.zeros(3), 0.0


def _measured(surface: Measured):
    reflected, passed = (
        np.zeros(3)
        if part is None
        else _daylit(np.interp(GRID, part.wavelengths, surface.factor * total(part, 0.0)))
        for part in (
            surface.front_reflection or surface.back_reflection,
            surface.front_transmission or surface.back_transmission,
        )
    )
    return reflected, float(np.clip(passed @ REC709_LUMINANCE, 0.0, 1.0))


def _mix(surface: Mix):
    factor = surface.factor
    share = _mean(factor).mean() if isinstance(factor, ImageTexture) else float(factor)
    share = min(max(float(share), 0.0), 1.0)
    (first, through), (second, beyond) = _look(surface.first), _look(surface.second)
    return (1.0 - share) * first + share * second, (1.0 - share) * through + share * beyond


def _varnish(surface: Varnish):
    weight = surface.weight
    weight = _mean(weight).mean() if isinstance(weight, ImageTexture) else float(weight)
    weight = min(max(float(weight), 0.0), 1.0)
    reflected, passing = _look(surface.base)
    left = 1.0 - weight + weight * (1.0 - _face(surface.ior)) * _colour(surface.tint)
    return reflected * left, passing * float(left @ REC709_LUMINANCE)


def _sheen(surface: Sheen):
    weight = surface.weight
    weight = _mean(weight).mean() if isinstance(weight, ImageTexture) else float(weight)
    sent = min(max(float(weight), 0.0), 1.0) * sent_on(surface.roughness, surface.is_velvet)[-1]
    own = sent * _colour(surface.tint)
    reflected, passing = _look(surface.base)
    left = 1.0 - float(own.max())
    return own + reflected * left, passing * left


def _blend(surface: Blend):
    first, second = surface.weights[0, :, -1]
    (one, through), (other, beyond) = _look(surface.first), _look(surface.second)
    return first * one + second * other, float(first * through + second * beyond)


def _raised(surface: Raised):
    return _look(surface.surface)


LOOKS = {
    Diffuse: _by_reflectance,
    Coated: _by_reflectance,
    Fabric: _fabric,
    Glossy: _by_reflectance,
    Conductor: _conductor,
    Dielectric: _dielectric,
    ThinGlass: _thin_glass,
    TabulatedPane: _tabulated_pane,
    Transparent: _transparent,
    Black: _black,
    Holdout: _black,
    Catcher: _black,
    Measured: _measured,
    Mix: _mix,
    Varnish: _varnish,
    Sheen: _sheen,
    Blend: _blend,
    Toon: _by_reflectance,
    Raised: _raised,
}
"""What a kind of surface reflects and lets pass head-on, for `_look`."""


def _colour(quantity) -> np.ndarray:
    """Colour of a reflectance in daylight (D65). (3,)"""
    match quantity:
        case ImageTexture():
            return np.broadcast_to(_mean(quantity), (3,))
        case Constant():
            return np.full(3, quantity.value)
        case Rgb():
            return np.array([quantity.red, quantity.green, quantity.blue])
    return _daylit(evaluate_reflectance(quantity, GRID))


def _daylit(reflectance: np.ndarray) -> np.ndarray:
    """Colour of a reflectance on the 1 nm grid in daylight (D65), an ideal white being 1. (471,) -> (3,)"""
    light = illuminant(GRID, "D65")[:, None] * observer()
    linear = scene_linear(reflectance @ light, light[:, 1].sum())
    # The white point is rounded in the colour space's definition; an ideal white must be exactly white.
    return linear / scene_linear(light.sum(axis=0), light[:, 1].sum())


def _luminous(quantity) -> float:
    """Share of daylight. [-]"""
    return float(np.clip(_colour(quantity) @ REC709_LUMINANCE, 0.0, 1.0))


def _mean(picture: ImageTexture) -> np.ndarray:
    """Mean of a picture's channels, (1,) or (3,)."""
    return picture.mean()


def _face(ior: float) -> float:
    """Reflectance of one face head-on. (Fresnel)"""
    return ((ior - 1.0) / (ior + 1.0)) ** 2


def _index(ior) -> float:
    """Refractive index at the d line, 587.6 nm."""
    nm = 587.6
    if hasattr(ior, "wavelengths"):
        return np.interp(nm, ior.wavelengths, ior.values)
    return ior.a + ior.b / (nm * 1e-3) ** 2


@lru_cache
def _metal(name: str) -> np.ndarray:
    """Reflectance of a polished metal head-on, from the refractive indices that come with Mitsuba. (3,)"""
    # Asked of the files: once loaded, the module itself does not tell.
    found = PathFinder.find_spec("mitsuba")
    if found is None:
        raise BackendError("Mitsuba, which has the refractive indices of metals, is not installed")
    folder = Path(found.submodule_search_locations[0]) / "data" / "ior"
    n, k = (
        evaluate_reflectance(read_spectrum(folder / f"{name}.{part}.spd").table, GRID)
        for part in ("eta", "k")
    )
    return _daylit(((n - 1.0) ** 2 + k**2) / ((n + 1.0) ** 2 + k**2))


def _emitted(emission: Emission | None) -> np.ndarray:
    """Luminance by colour; a pattern counts with its mean. (3,) [cd/m2]"""
    if emission is None or emission.luminance <= 0.0:
        return np.zeros(3)
    spectrum = emission.spectrum
    if isinstance(spectrum, Rgb):
        linear = np.array([spectrum.red, spectrum.green, spectrum.blue])
        linear = linear / max(float(linear @ REC709_LUMINANCE), 1e-30)
    else:
        tristimulus = evaluate_emission(spectrum, GRID) @ observer()
        linear = scene_linear(tristimulus, max(float(tristimulus[1]), 1e-30))
    pattern = 1.0 if emission.pattern is None else _mean(emission.pattern)
    return emission.luminance * np.asarray(linear, dtype=np.float64) * pattern
