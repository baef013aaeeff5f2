"""Materials of the scene description as Mitsuba BSDF dictionaries."""

import numpy as np

from ...materials.albedo import limits
from ...materials.facets import MINIMUM_ALPHA
from ...materials.grain import GrainOfFacets
from ...photometry.spectra import GRID, evaluate_reflectance
from ...scattering.data.surface import usable
from ...scene.colour import largest_of
from ...scene.material import (
    SMOOTH_ROUGHNESS,
    Black,
    Blend,
    Catcher,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Fabric,
    Glossy,
    Grain,
    Holdout,
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
from ...scene.relief import layers, picture_of
from ...scene.spectrum import Constant, Tabulated
from ...scene.texture import ImageTexture
from .films import film_on_glass, film_on_metal, film_on_paint, lay_film
from .textures import TextureMaker, is_spectral, number, refractive_index

SODIUM_D = 589.3
"""Wavelength that stands for the visible range where one refractive index must do. [nm]"""

NOTHING = Diffuse(Constant(0.0))
"""What a black surface is to light, and what the palette holds before there are plain materials."""

BY_ANGLE = (
    "its parts are weighed by the angle or the side that it is seen from, as in Blender; with light and eye exchanged it is "
    "another surface"
)
"""What is said of a blend that is not reciprocal."""

LEAST_INDEX = 1.05
"""Refractive index from which on a boundary says how facets along a direction share its light out."""

PALETTE_STEPS = 471
"""Wavelengths of a palette's spectra: every full nanometre from 360 to 830, as those of lights."""


def is_plain(surface: Surface) -> bool:
    """Tell whether a surface can join a palette: a diffuse base with or without a coat, or black."""
    plain = _as_plain(surface)
    return plain is not None and plain.grain is None and plain.film is None


def _as_plain(surface: Surface) -> Coated | None:
    return NOTHING.as_coated if isinstance(surface, Black) else surface.as_coated


def palette(surfaces: list[Surface], make: TextureMaker) -> dict[str, np.ndarray]:
    """Rows of parameters of diffuse surfaces, coated or not, as `coated_class` takes them."""
    coats = [_as_plain(surface) for surface in surfaces]
    return {
        "alpha": np.array([alpha(c.roughness) for c in coats]),
        "eta": np.array([max(c.ior, 1.0001) for c in coats]),
        "specular": np.array(
            [np.clip(c.specular, 0.0, 1.0) if c.ior > 1.001 else 0.0 for c in coats]
        ),
        "sigma": np.array([np.clip(c.base_roughness, 0.0, 1.0) for c in coats]),
        "tints": np.stack([make.spectrum(c.tint or Constant(1.0), PALETTE_STEPS) for c in coats]),
        "spectra": np.stack([_row_spectrum(c.reflectance, make) for c in coats]),
    }


def _row_spectrum(colour, make: TextureMaker) -> np.ndarray:
    if isinstance(colour, ImageTexture):
        # Every row is as long as all others.
        colour = Constant(0.0)
    return make.spectrum(colour, PALETTE_STEPS)


def picture_row(surface: Surface, make: TextureMaker) -> int:
    """Row of the picture of a palette's surface in the table of pictures plus 1; 0: it is the same all over."""
    colour = _as_plain(surface).reflectance
    return make.row(colour) + 1 if isinstance(colour, ImageTexture) else 0


def _coated(surface, make: TextureMaker):
    """A plug-in of its own, for surfaces inside a mixture."""
    import mitsuba as mi

    properties = {"type": "lumenray_coated"}
    if isinstance(surface.reflectance, ImageTexture):
        properties["reflectance"] = make.picture(surface.reflectance)
    plugin = mi.load_dict(properties)
    plugin.set_palette(**palette([surface], make))
    plain = _as_plain(surface)
    grain, film = plain.grain, plain.film
    if grain is not None and film is None:
        row = palette([surface], make)
        tint = 1.0 if surface.tint is None else largest_of(surface.tint)
        numbers = (float(row[name][0]) for name in ("alpha", "eta", "specular"))
        plugin.set_grain(_grain(grain, make), *numbers, min(tint, 1.0), float(grain.stretch))
    if film is not None:
        plugin.set_film(film_on_paint(surface, make), float(np.clip(surface.specular, 0.0, 1.0)))
        if grain is not None:
            index = max(float(surface.ior), float(film.ior), LEAST_INDEX)
            width = _width(surface.roughness)
            plugin.set_grain_of_film(_grain(grain, make), width, index, float(grain.stretch))
    return plugin


def _grain(grain: Grain, make: TextureMaker) -> GrainOfFacets:
    import mitsuba as mi

    grain.check()
    rotation = make.scalar(grain.rotation)
    if isinstance(rotation, dict):
        rotation = mi.load_dict(rotation, optimize=False)
    return GrainOfFacets(float(grain.stretch), rotation, grain.axis)


def alpha(roughness: float) -> float:
    """Width of the microfacet distribution from Blender's roughness. [-]"""
    return max(float(roughness) ** 2, 1e-4)


def bsdf(surface: Surface, make: TextureMaker):
    """Return the plug-in of a surface, or its Mitsuba dictionary; reflecting models act on both sides."""
    return MAKERS[type(surface)](surface, make)


def _diffuse(surface: Diffuse, make: TextureMaker):
    if surface.is_opaque:
        return _coated(surface, make)
    return {
        "type": "lumenray_sheet",
        "reflectance": make.reflectance(surface.reflectance),
        "transmittance": make.reflectance(surface.transmittance),
    }


def _fabric(surface: Fabric, make: TextureMaker) -> dict:
    surface.check()
    return {
        "type": "lumenray_fabric",
        "openness": float(surface.openness),
        "reflectance": make.reflectance(surface.reflectance),
        "transmittance": make.reflectance(surface.transmittance),
    }


def _black(_surface: Black, make: TextureMaker):
    return _coated(NOTHING, make)


def _glossy(surface: Glossy, make: TextureMaker) -> dict:
    colour = make.reflectance(surface.reflectance)
    properties = {**make.metal("none"), "specular_reflectance": colour}
    return _mirror_like(properties, surface, make)


def _conductor(surface: Conductor, make: TextureMaker) -> dict:
    # With what a glossy surface has, so that both are one model.
    properties = {
        **make.metal(surface.metal),
        "specular_reflectance": make.reflectance(Constant(1.0)),
    }
    return _mirror_like(properties, surface, make)


def _thin_glass(surface: ThinGlass, make: TextureMaker) -> dict:
    return {
        "type": "lumenray_pane",
        "ior": float(surface.ior),
        "transmittance": make.reflectance(surface.transmittance),
    }


def _transparent(surface: Transparent, make: TextureMaker) -> dict:
    return {
        "type": "lumenray_transparent",
        "transmittance": make.reflectance(surface.transmittance),
    }


def _mix(surface: Mix, make: TextureMaker) -> dict:
    return {
        "type": "lumenray_mix",
        "first": bsdf(surface.first, make),
        "second": bsdf(surface.second, make),
        "factor": make.scalar(surface.factor),
    }


def _toon(surface: Toon, make: TextureMaker) -> dict:
    return {
        "type": "lumenray_toon",
        "reflectance": make.reflectance(surface.reflectance),
        "size": float(surface.size),
        "edge": float(surface.edge),
        "is_glossy": surface.is_glossy,
    }


def _blend(surface: Blend, make: TextureMaker):
    import mitsuba as mi

    surface.check()
    by_colour, by_angle = limits(surface, _most_by_wavelength)
    properties = {
        "type": "lumenray_blend",
        "first": bsdf(surface.first, make),
        "second": bsdf(surface.second, make),
        "limit": make.reflectance(Tabulated(GRID, by_colour)),
    }
    plugin = mi.load_dict(properties, optimize=False)
    plugin.set_weights(surface.weights * by_angle[:, None])
    return plugin


def _most_by_wavelength(colour) -> np.ndarray:
    """Values of a colour at every nanometre, for a picture the most that any place may have. (471,) [-]"""
    if not isinstance(colour, ImageTexture):
        return np.clip(evaluate_reflectance(colour, GRID), 0.0, 1.0)
    pixels = colour.pixels
    is_grey = pixels.ndim == 2 or pixels.shape[2] == 1 or not np.ptp(pixels, axis=2).any()
    return np.full(len(GRID), float(pixels.max()) if is_grey else 1.0)


def _varnish(surface: Varnish, make: TextureMaker):
    import mitsuba as mi

    properties = {
        "type": "lumenray_varnish",
        "base": bsdf(surface.base, make),
        "weight": make.scalar(surface.weight),
        "tint": make.reflectance(surface.tint),
    }
    plugin = mi.load_dict(properties, optimize=False)
    plugin.set_coat(alpha(surface.roughness), max(surface.ior, 1.0001), _facets(surface.base))
    return plugin


def _sheen(surface: Sheen, make: TextureMaker):
    import mitsuba as mi

    properties = {
        "type": "lumenray_sheen",
        "base": bsdf(surface.base, make),
        "weight": make.scalar(surface.weight),
        "tint": make.reflectance(surface.tint),
    }
    plugin = mi.load_dict(properties, optimize=False)
    most, facets = min(largest_of(surface.tint), 1.0), _facets(surface.base)
    plugin.set_fibres(surface.roughness, surface.is_velvet, most, facets)
    return plugin


def _facets(base: Surface) -> tuple | None:
    """Width, index and scale of the facets over an opaque base's diffuse light; None: light passes."""
    if not base.is_opaque:
        return None
    if isinstance(base, Varnish) and not isinstance(base.weight, ImageTexture):
        # What its coat mirrors goes where it comes from, unlike what lies below.
        return _width(base.roughness), round(max(base.ior, 1.0001), 4), float(base.weight)
    if isinstance(base, Varnish | Sheen):
        return _facets(base.base)
    if isinstance(base, Glossy | Conductor):
        roughness = base.roughness
        if isinstance(roughness, ImageTexture):
            roughness = np.sqrt(np.mean(np.square(roughness.pixels, dtype=np.float64)))
        return _width(roughness), np.inf, 1.0
    coated = _as_plain(base)
    if coated is None or coated.ior <= 1.001 or coated.specular <= 0.0:
        return MINIMUM_ALPHA, np.inf, 0.0
    return _width(coated.roughness), round(float(coated.ior), 4), float(min(coated.specular, 1.0))


def _width(roughness) -> float:
    return round(float(max(alpha(roughness), MINIMUM_ALPHA)), 4)


def _raised(surface: Raised, make: TextureMaker):
    import mitsuba as mi

    surface.check()
    properties = {"type": "lumenray_relief", "nested": bsdf(surface.surface, make)}
    plugin = mi.load_dict(properties, optimize=False)
    parts = layers(surface.relief)
    plugin.set_layers(make.bitmaps.table, parts, [make.relief(picture_of(p)) for p in parts])
    return plugin


def _tabulated_pane(surface: TabulatedPane, _make: TextureMaker):
    import mitsuba as mi

    surface.check()
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


def _mirror_like(properties: dict, surface: Glossy | Conductor, make: TextureMaker):
    roughness, edge = surface.roughness, getattr(surface, "edge", None)
    if surface.is_mirror:
        return _two_sided({"type": "conductor", **properties})
    is_even = not isinstance(roughness, ImageTexture)
    made = {
        "type": "lumenray_rough_metal",
        "alpha": alpha(roughness) if is_even else make.scalar(roughness, power=2.0),
        "rise": 0.0 if edge is None else 1.0,
        "edge": make.reflectance(Constant(1.0) if edge is None else edge),
        **properties,
    }
    film = getattr(surface, "film", None)
    if surface.grain is None:
        return made if film is None else lay_film(made, film_on_metal(surface, make))
    import mitsuba as mi

    plugin = mi.load_dict(made, optimize=False)
    if film is not None:
        plugin.set_film(film_on_metal(surface, make))
    width = float(np.clip(made["alpha"], MINIMUM_ALPHA, 1.0)) if is_even else None
    plugin.set_grain(_grain(surface.grain, make), float(surface.grain.stretch), width)
    return plugin


def _dielectric(surface: Dielectric, make: TextureMaker) -> dict:
    surface.check()
    tint, body = make.reflectance(surface.tint), {}
    if surface.internal is not None:
        body = {
            "internal": make.reflectance(surface.internal),
            "thickness": float(surface.thickness),
        }
    index = max(float(refractive_index(surface.ior, SODIUM_D)), 1.0001)
    if not surface.reflects:
        return _refraction(surface, index, tint, body)
    mirror = None if surface.mirror_tint is None else make.reflectance(surface.mirror_tint)
    if surface.is_smooth:
        disperses = surface.is_dispersive and is_spectral()
        ior = make.refractive_index(surface.ior) if disperses else number(index)
        made = {"type": "lumenray_glass", "ior": ior, "tint": tint, "disperses": disperses, **body}
        if mirror is not None:
            made["mirror_tint"] = mirror
        return _under_film(made, surface, index, make)
    width = alpha(surface.roughness)
    nested = {
        "type": "roughdielectric",
        "distribution": "ggx",
        "alpha": width,
        "int_ior": index,
        "specular_transmittance": tint,
    }
    if mirror is not None:
        nested["specular_reflectance"] = mirror
    made = {
        "type": "lumenray_rough_glass",
        "alpha": width,
        "index": index,
        "nested": nested,
        **body,
    }
    return _under_film(made, surface, index, make)


def _under_film(made: dict, surface: Dielectric, index: float, make: TextureMaker):
    if surface.film is None:
        return made
    return lay_film(made, film_on_glass(surface, index, make))


def _refraction(surface: Dielectric, index: float, tint, body: dict) -> dict:
    if surface.is_smooth:
        return {"type": "lumenray_refraction", "ior": number(index), "tint": tint, **body}
    nested = {
        "type": "roughdielectric",
        "distribution": "ggx",
        "alpha": alpha(surface.roughness),
        "int_ior": index,
        "specular_transmittance": tint,
    }
    return {"type": "lumenray_rough_refraction", "index": index, "nested": nested, **body}


MAKERS = {
    Diffuse: _diffuse,
    Coated: _coated,
    Fabric: _fabric,
    Glossy: _glossy,
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
    Toon: _toon,
    Raised: _raised,
}
"""What makes the plug-in of a kind of surface, or its Mitsuba dictionary."""


def approximations(surface: Surface) -> list[str]:
    """Say what a surface is computed as where that differs from what it states."""
    match surface:
        case Mix():
            return approximations(surface.first) + approximations(surface.second)
        case Blend():
            notes = approximations(surface.first) + approximations(surface.second)
            return notes if surface.is_reciprocal else [BY_ANGLE, *notes]
        case Toon():
            about = "the mirror direction" if surface.is_glossy else "its normal"
            where = "evenly" if surface.is_glossy else "wherever light comes from"
            return [f"it shines about {about} {where}, as in Blender"]
        case Varnish() | Sheen():
            return approximations(surface.base)
        case Raised():
            return approximations(surface.surface)
        case Measured() if usable(surface) is not surface:
            return ["its data send out more light than comes, and are scaled down where they do"]
        case Dielectric() if surface.is_dispersive and not surface.is_smooth:
            return ["rough glass is computed without dispersion, with its index at 589 nm"]
        case Glossy() if surface.film is not None:
            return _notes_of_film(surface)
        case Glossy() if surface.edge is not None and surface.is_mirror:
            return ["an ideal mirror reflects from all sides what it reflects along its normal"]
    return []


def _notes_of_film(surface: Glossy) -> list[str]:
    notes = []
    if not isinstance(surface.roughness, ImageTexture) and surface.roughness < SMOOTH_ROUGHNESS:
        notes.append(f"a mirror under a thin film has a roughness of {MINIMUM_ALPHA**0.5:.2g}")
    if any(isinstance(colour, ImageTexture) for colour in surface.colours):
        notes.append("a metal under a thin film has the mean of its colours")
    return notes
