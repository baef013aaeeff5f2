"""Materials of the scene description as Mitsuba BSDF dictionaries."""

import numpy as np

from ..scene.material import (
    Black,
    Cauchy,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Glossy,
    Mix,
    ThinGlass,
    Transparent,
)
from ..scene.texture import ImageTexture
from .textures import TextureMaker, is_spectral, number, refractive_index

SMOOTH_ROUGHNESS = 0.03
"""Below this roughness (microfacet alpha 0.0009) a surface is computed as an ideal mirror."""

SODIUM_D = 589.3
"""Wavelength that stands for the visible range where one refractive index must do. [nm]"""


def alpha(roughness: float) -> float:
    """Width of the microfacet distribution from Blender's roughness. [-]"""
    return max(float(roughness) ** 2, 1e-4)


def bsdf(surface, make: TextureMaker) -> dict:
    """Return the Mitsuba dictionary of a surface; reflecting models act on both sides."""
    match surface:
        case Diffuse():
            made = {"type": "lumenray_sheet", "reflectance": make.reflectance(surface.reflectance)}
            if surface.transmittance is not None:
                made["transmittance"] = make.reflectance(surface.transmittance)
            return made
        case Black():
            return {"type": "lumenray_sheet", "reflectance": number(0.0)}
        case Coated():
            return _coated(surface, make)
        case Glossy():
            return _mirror_like(
                {"material": "none", "specular_reflectance": make.reflectance(surface.reflectance)},
                surface.roughness,
                make,
            )
        case Conductor():
            return _mirror_like({"material": surface.metal}, surface.roughness, make)
        case Dielectric():
            return _dielectric(surface, make)
        case ThinGlass():
            return {
                "type": "lumenray_pane",
                "ior": float(surface.ior),
                "transmittance": make.reflectance(surface.transmittance),
            }
        case Transparent():
            return {
                "type": "lumenray_transparent",
                "transmittance": make.reflectance(surface.transmittance),
            }
        case Mix():
            return {
                "type": "lumenray_mix",
                "first": bsdf(surface.first, make),
                "second": bsdf(surface.second, make),
                "factor": make.scalar(surface.factor),
            }
    raise TypeError(f"not a surface: {surface!r}")


def _two_sided(made: dict) -> dict:
    return {"type": "twosided", "nested": made}


def _coated(surface: Coated, make: TextureMaker) -> dict:
    made = {
        "int_ior": max(surface.ior, 1.0001),
        "diffuse_reflectance": make.reflectance(surface.reflectance),
        "specular_reflectance": number(np.clip(surface.specular, 0.0, 1.0)),
        "nonlinear": False,
    }
    if surface.roughness < SMOOTH_ROUGHNESS:
        return _two_sided({"type": "plastic", **made})
    return _two_sided(
        {"type": "roughplastic", "distribution": "ggx", "alpha": alpha(surface.roughness), **made}
    )


def _mirror_like(made: dict, roughness, make: TextureMaker) -> dict:
    if isinstance(roughness, ImageTexture):
        width = make.scalar(roughness, power=2.0)
    elif roughness < SMOOTH_ROUGHNESS:
        return _two_sided({"type": "conductor", **made})
    else:
        width = alpha(roughness)
    return _two_sided({"type": "roughconductor", "distribution": "ggx", "alpha": width, **made})


def _dielectric(surface: Dielectric, make: TextureMaker) -> dict:
    disperses = not isinstance(surface.ior, Cauchy) or surface.ior.b != 0.0
    smooth = surface.roughness < SMOOTH_ROUGHNESS
    tint = make.reflectance(surface.tint)
    if disperses and smooth and is_spectral():
        return {"type": "lumenray_dispersive", "ior": make.refractive_index(surface.ior), "tint": tint}
    index = float(refractive_index(surface.ior, SODIUM_D))
    made = {"int_ior": max(index, 1.0001), "specular_transmittance": tint}
    if smooth:
        return {"type": "dielectric", **made}
    return {"type": "roughdielectric", "distribution": "ggx", "alpha": alpha(surface.roughness), **made}


def passes_straight(surface) -> bool:
    """Tell whether light can pass a surface without changing its direction, so that shadows see through it."""
    match surface:
        case ThinGlass() | Transparent():
            return True
        case Mix():
            return passes_straight(surface.first) or passes_straight(surface.second)
    return False


def is_purely_specular(surface) -> bool:
    """Tell whether a surface has no spread-out part: nothing to measure illuminance on."""
    match surface:
        case Dielectric():
            return surface.roughness < SMOOTH_ROUGHNESS
        case ThinGlass() | Transparent():
            return True
        case Mix():
            return is_purely_specular(surface.first) and is_purely_specular(surface.second)
    return False


def approximations(surface) -> list[str]:
    """Say what a surface is computed as where that differs from what it states."""
    match surface:
        case Mix():
            return approximations(surface.first) + approximations(surface.second)
        case Dielectric() if surface.roughness >= SMOOTH_ROUGHNESS and (
            not isinstance(surface.ior, Cauchy) or surface.ior.b != 0.0
        ):
            return ["rough glass is computed without dispersion, with its index at 589 nm"]
    return []
