"""Metals: brushed, satin, perforated, polished."""

import numpy as np

from ..colour import WAVELENGTHS
from ..metals import Metal, index_of
from ..microfacets import Facets, smooth_to_rough
from ..sheets import Perforated
from .mixing import POWDER, WHITE, paint
from .recipe import Part, Recipe, both, through

SOURCE = "GGX facets with the complex refractive index that comes with Mitsuba"


def recipes() -> list[Recipe]:
    """Return all metals."""

    def rough(name, kind, title, what, target, metal, facets, *tags, **more):
        def make():
            is_grained = facets.along != facets.across
            # Tables with a grain are large; grey metals do with the index at 550 nm.
            index = index_of(metal)[WAVELENGTHS == 550.0] if is_grained else index_of(metal)
            made = Metal(index, facets, **more)
            return both(Part(made.evaluate, None, is_grained, 0.06 if is_grained else 0.04))

        return Recipe(
            name,
            f"Metal/{kind}",
            title,
            what,
            SOURCE,
            ("metal", *tags),
            make=make,
            reflectance=target,
        )

    return [
        rough(
            "aluminium_brushed", "Brushed", "Aluminium, brushed", "Fine grooves along U.", 0.83, "Al",
            Facets(0.14, 0.34), "aluminium", "anisotropic",
        ),
        rough(
            "steel_brushed", "Brushed", "Stainless steel, brushed",
            "Grooves along U, as of lifts and kitchens; chromium's index stands for that of the alloy.",
            0.536, "Cr", Facets(0.14, 0.34), "steel", "stainless", "anisotropic", clearness=0.9,
        ),
        rough(
            "copper_satin", "Satin", "Copper, satin", "Ground sheet without patina.", 0.635, "Cu",
            smooth_to_rough(0.25), "copper",
        ),
        rough(
            "aluminium_anodised", "Satin", "Aluminium, anodised satin", "Profiles and panels, etched before anodising.",
            0.68, "Al", smooth_to_rough(0.30), "aluminium", "satin", clearness=0.84, haze=0.08,
        ),
        rough(
            "aluminium_semi_specular", "Satin", "Aluminium, semi-specular", "Bright strip of reflectors and louvres.",
            0.85, "Al", smooth_to_rough(0.14), "aluminium", "reflector", "louvre", clearness=0.95, haze=0.02,
        ),
        *_perforated(),
        *_mirrors(),
    ]  # fmt: skip


def _perforated() -> list[Recipe]:
    def sheet(name, title, what, target, passed, openness, depth, make_solid, *tags):
        def make():
            made = Perforated(make_solid(), openness, depth)

            def nothing(wi, wo):
                return np.zeros((len(wi), 1))

            passing = Part(nothing, lambda incidences: made.open_share(incidences)[:, None])
            return {**both(Part(made.reflect)), **through(passing)}

        return Recipe(
            name, "Metal/Perforated", title, what,
            "Sheet with round holes: circles that overlap at a slant; light in the holes' walls is lost",
            ("metal", "perforated", *tags), make=make, reflectance=target, transmittance=passed,
        )  # fmt: skip

    return [
        sheet(
            "ceiling_perforated", "Metal ceiling, perforated", "White powder coat, holes of 2.5 mm in 0.6 mm, 16 % open.",
            0.70, 0.153, 0.16, 0.24,
            lambda: paint(0.84, WHITE, {"carbon black": 0.004, "yellow iron oxide": 0.02}, POWDER).evaluate,
            "ceiling", "white", "acoustic",
        ),
        sheet(
            "steel_perforated", "Steel, perforated", "Anthracite powder coat, holes of 5 mm in 1.5 mm, 46 % open.",
            0.04, 0.435, 0.46, 0.30,
            lambda: paint(0.075, {"carbon black": 1.0}, {"titanium white": 1.0}, POWDER).evaluate,
            "screen", "facade", "grey",
        ),
    ]  # fmt: skip


def _mirrors() -> list[Recipe]:
    def mirror(metal, title, what, target, roughness=0.05):
        return Recipe(
            f"{title.split(',')[0].lower()}_polished", "Metal/Polished", title, what,
            "Complex refractive index that comes with Mitsuba", ("metal", "polished", "mirror"),
            {"model": "CONDUCTOR", "metal": metal, "roughness": roughness}, reflectance=target,
        )  # fmt: skip

    return [
        mirror("Al", "Aluminium, polished", "Bare metal without oxide.", 0.92),
        mirror("Ag", "Silver, polished", "Bare metal without tarnish.", 0.96),
        mirror("Au", "Gold, polished", "Pure gold.", 0.80),
        mirror("Cu", "Copper, polished", "Bare metal without patina.", 0.70),
        mirror("Cr", "Chromium, polished", "Taps and fittings.", 0.66),
        mirror("Ni_palik", "Nickel, polished", "Plated fittings, warm grey.", 0.61),
        mirror("W", "Tungsten, polished", "Dark grey metal.", 0.50),
    ]
