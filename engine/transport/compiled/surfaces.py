"""Materials of the scene description as Mitsuba BSDF dictionaries."""

import numpy as np

from ...materials.pane_table import check_table
from ...scattering.data.surface import is_grained, parts_of, usable
from ...scene.material import (
    Black,
    Cauchy,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Glossy,
    Measured,
    Mix,
    TabulatedPane,
    ThinGlass,
    Transparent,
)
from ...scene.scattering import ScatterTable
from ...scene.texture import ImageTexture
from .textures import TextureMaker, is_spectral, number, refractive_index

SMOOTH_ROUGHNESS = 0.03
"""Below this roughness (microfacet alpha 0.0009) a surface is computed as an ideal mirror."""

SODIUM_D = 589.3
"""Wavelength that stands for the visible range where one refractive index must do. [nm]"""


PALETTE_STEPS = 471
"""Wavelengths of a palette's spectra: every full nanometre from 360 to 830, as those of lights."""


def is_matt(surface) -> bool:
    """Tell whether a surface is a diffuse base, with or without a coat, that reflects only."""
    return isinstance(surface, Coated) or (
        isinstance(surface, Diffuse) and surface.transmittance is None
    )


def is_plain(surface) -> bool:
    """Tell whether a surface can join a palette: matt, and the same all over."""
    return is_matt(surface) and not isinstance(surface.reflectance, ImageTexture)


def palette(surfaces: list, make: TextureMaker) -> dict[str, np.ndarray]:
    """Rows of parameters of plain or textured matt surfaces, as `coated_class` takes them."""
    coats = [s if isinstance(s, Coated) else Coated(s.reflectance, 1.5, 1.0, 0.0) for s in surfaces]
    return {
        "alpha": np.array([alpha(c.roughness) for c in coats]),
        "eta": np.array([max(c.ior, 1.0001) for c in coats]),
        "specular": np.array(
            [np.clip(c.specular, 0.0, 1.0) if c.ior > 1.001 else 0.0 for c in coats]
        ),
        "spectra": np.stack([_row_spectrum(c.reflectance, make) for c in coats]),
    }


def _row_spectrum(colour, make: TextureMaker) -> np.ndarray:
    if isinstance(colour, ImageTexture):
        return np.zeros(1)
    return make.spectrum(colour, PALETTE_STEPS)


def _coated(surface, make: TextureMaker):
    """A plug-in of its own, for surfaces with a picture or inside a mixture."""
    import mitsuba as mi

    made = {"type": "lumenray_coated"}
    if isinstance(surface.reflectance, ImageTexture):
        made["reflectance"] = make.picture(surface.reflectance)
    plugin = mi.load_dict(made)
    plugin.set_palette(**palette([surface], make))
    return plugin


def alpha(roughness: float) -> float:
    """Width of the microfacet distribution from Blender's roughness. [-]"""
    return max(float(roughness) ** 2, 1e-4)


def bsdf(surface, make: TextureMaker) -> dict:
    """Return the Mitsuba dictionary of a surface; reflecting models act on both sides."""
    match surface:
        case Diffuse() | Coated() if is_matt(surface):
            return _coated(surface, make)
        case Diffuse():
            made = {"type": "lumenray_sheet", "reflectance": make.reflectance(surface.reflectance)}
            if surface.transmittance is not None:
                made["transmittance"] = make.reflectance(surface.transmittance)
            return made
        case Black():
            return {"type": "lumenray_sheet", "reflectance": number(0.0)}
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
        case TabulatedPane():
            return _tabulated_pane(surface)
        case Transparent():
            return {
                "type": "lumenray_transparent",
                "transmittance": make.reflectance(surface.transmittance),
            }
        case Measured():
            return _measured(surface, make)
        case Mix():
            return {
                "type": "lumenray_mix",
                "first": bsdf(surface.first, make),
                "second": bsdf(surface.second, make),
                "factor": make.scalar(surface.factor),
            }
    raise TypeError(f"not a surface: {surface!r}")


def _tabulated_pane(surface: TabulatedPane):
    import mitsuba as mi

    check_table(surface)
    plugin = mi.load_dict({"type": "lumenray_tabulated_pane"})
    plugin.set_table(surface.angles, surface.transmittance, surface.reflectance)
    return plugin


def _measured(surface: Measured, make: TextureMaker):
    import mitsuba as mi

    plugin = mi.load_dict({"type": "lumenray_measured"})
    plugin.set_surface(usable(surface), make.weigh)
    return plugin


def _two_sided(made: dict) -> dict:
    return {"type": "twosided", "nested": made}


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
    index = max(float(refractive_index(surface.ior, SODIUM_D)), 1.0001)
    if smooth:
        disperses &= is_spectral()
        ior = make.refractive_index(surface.ior) if disperses else number(index)
        return {"type": "lumenray_glass", "ior": ior, "tint": tint, "disperses": disperses}
    return {
        "type": "roughdielectric",
        "distribution": "ggx",
        "alpha": alpha(surface.roughness),
        "int_ior": index,
        "specular_transmittance": tint,
    }


def passes_straight(surface) -> bool:
    """Tell whether light can pass a surface without changing its direction, so that shadows see through it."""
    match surface:
        case ThinGlass() | TabulatedPane() | Transparent():
            return True
        case Measured():
            return _passes_directly(surface)
        case Mix():
            return passes_straight(surface.first) or passes_straight(surface.second)
    return False


def _passes_directly(surface: Measured) -> bool:
    parts = (surface.front_transmission, surface.back_transmission)
    return any(
        isinstance(part, ScatterTable) and part.direct is not None and part.direct.any()
        for part in parts
    )


def has_grain(surface) -> bool:
    """Tell whether a surface has a direction of its own, which follows U."""
    match surface:
        case Measured():
            return is_grained(surface)
        case Mix():
            return has_grain(surface.first) or has_grain(surface.second)
    return False


def is_window(surface) -> bool:
    """Tell whether daylight enters by a surface, so that samples of the sky are aimed at it: a pane or an opening."""
    match surface:
        case ThinGlass() | TabulatedPane():
            return True
        case Measured():
            return _passes_directly(surface)
        case Transparent():
            return not isinstance(surface.transmittance, ImageTexture)
    return False


def is_mirror(surface) -> bool:
    """Tell whether a surface is an ideal mirror all over and nothing else."""
    match surface:
        case Glossy() | Conductor():
            roughness = surface.roughness
            return not isinstance(roughness, ImageTexture) and roughness < SMOOTH_ROUGHNESS
    return False


def is_mirroring_pane(surface) -> bool:
    """Tell whether a surface is a pane all over and reflects some of the light as a mirror does."""
    match surface:
        case ThinGlass():
            return surface.ior != 1.0
        case TabulatedPane():
            return bool(np.any(np.asarray(surface.reflectance) > 0.0))
    return False


def is_purely_specular(surface) -> bool:
    """Tell whether a surface has no spread-out part: nothing to measure illuminance on."""
    match surface:
        case Dielectric():
            return surface.roughness < SMOOTH_ROUGHNESS
        case ThinGlass() | TabulatedPane() | Transparent():
            return True
        case Measured():
            return not any(part is not None and part.values.any() for part in parts_of(surface))
        case Mix():
            return is_purely_specular(surface.first) and is_purely_specular(surface.second)
    return False


def approximations(surface) -> list[str]:
    """Say what a surface is computed as where that differs from what it states."""
    match surface:
        case Mix():
            return approximations(surface.first) + approximations(surface.second)
        case Measured() if usable(surface) is not surface:
            return ["its data send out more light than comes, and are scaled down where they do"]
        case Dielectric() if surface.roughness >= SMOOTH_ROUGHNESS and (
            not isinstance(surface.ior, Cauchy) or surface.ior.b != 0.0
        ):
            return ["rough glass is computed without dispersion, with its index at 589 nm"]
    return []
