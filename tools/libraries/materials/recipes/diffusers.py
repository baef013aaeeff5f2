"""Diffusers and projection screens."""

import numpy as np

from ..coats import Coat
from ..diffusers import Film, GroundGlass, screen_of_gain
from ..grains import Grains
from .buildings import SOURCE as GRAINS
from .mixing import slab
from .recipe import Part, Recipe, both, even, through

FILMS = "Bell's law of direction cosines from the stated angle, Fresnel at both faces"


def _opal(name, title, what, target, reflected, index, *tags) -> Recipe:
    def make():
        made = slab(target, {"carbon black": 0.002}, Coat(index))
        return {**both(Part(made.reflect, made.direct)), **through(Part(made.transmit))}

    return Recipe(
        name, "Diffuser/Opal", title, what, "Kubelka-Munk layer between two dielectric boundaries (Saunderson)",
        ("diffuser", "opal", *tags), make=make, reflectance=reflected, transmittance=target,
    )  # fmt: skip


def _film(name, title, what, x, y, transmitted, reflected, *tags) -> Recipe:
    def make():
        made = Film(np.radians(x), np.radians(y))
        is_grained = x != y
        # What is reflected is weak, and told as for a film that spreads evenly.
        mean = np.sqrt(np.radians(x) * np.radians(y))
        alike = Film(mean, mean)
        coarse = 0.06 if is_grained else 0.04
        return {
            "front_reflection": Part(alike.reflect, tolerance=coarse),
            "back_reflection": Part(alike.reflect_back, alike.direct, tolerance=coarse),
            **through(Part(made.transmit, None, is_grained, coarse)),
        }

    return Recipe(
        name, "Diffuser/Light shaping", title, what, FILMS, ("diffuser", "holographic", "light shaping", *tags),
        make=make, reflectance=reflected, transmittance=transmitted,
    )  # fmt: skip


def _ground(name, title, what, alpha, transmitted, reflected, *tags) -> Recipe:
    def make():
        made = GroundGlass(alpha)
        return {
            "front_reflection": Part(made.reflect),
            "back_reflection": Part(made.reflect_back, made.direct),
            "front_transmission": Part(made.transmit),
            "back_transmission": Part(made.transmit_back),
        }

    return Recipe(
        name, "Diffuser/Ground glass", title, what, "GGX facets that refract (Walter et al. 2007), smooth back by Fresnel",
        ("diffuser", "glass", *tags), make=make, reflectance=reflected, transmittance=transmitted,
    )  # fmt: skip


def _screen(name, title, what, gain, half, target, *tags) -> Recipe:
    def make():
        made = screen_of_gain(gain, np.radians(half), target)
        return both(Part(made.evaluate))

    return Recipe(
        name, "Screen", title, what, "Lambertian ground and GGX facets after gain and half-gain angle",
        ("projection screen", *tags), make=make, reflectance=target, more={"gain": gain, "half_gain_angle_deg": half},
    )  # fmt: skip


def recipes() -> list[Recipe]:
    """Return all diffusers and screens."""
    return [
        _opal("acrylic_opal", "Acrylic, opal", "Cover of luminaires that hides its lamps.", 0.50, 0.49, 1.49, "acrylic",
              "luminaire"),
        _opal("glass_opal", "Opal glass", "Blown flashed opal glass of globes.", 0.40, 0.59, 1.52, "glass", "globe"),
        _film("film_10", "Light shaping film, 10°", "Holographic diffuser; relief in front.", 10.0, 10.0, 0.90, 0.07),
        _film("film_30", "Light shaping film, 30°", "Holographic diffuser; relief in front.", 30.0, 30.0, 0.91, 0.055),
        _film("film_60", "Light shaping film, 60°", "Holographic diffuser; relief in front.", 60.0, 60.0, 0.785, 0.04),
        _film("film_40x10", "Light shaping film, 40° x 10°", "Spreads wide along U; relief in front.", 40.0, 10.0,
              0.90, 0.064, "elliptic", "anisotropic"),
        _ground("glass_etched", "Glass, satin etched", "Acid-etched front, smooth back.", 0.18, 0.895, 0.09, "etched",
                "satin"),
        _ground("glass_ground", "Glass, sandblasted", "Coarse ground front, smooth back.", 0.45, 0.875, 0.084, "ground",
                "sandblasted"),
        _screen("screen_gain_1_8", "Projection screen, gain 1.8", "Pearl screen for bright rooms.", 1.8, 35.0, 0.90,
                "pearl"),
        _screen("screen_silver_2_4", "Projection screen, silver, gain 2.4", "Silver screen of 3D cinemas.", 2.4, 25.0, 0.75,
                "silver"),
        Recipe(
            "screen_matt_white", "Screen", "Projection screen, matt white", "Gain near 1 to all sides.", GRAINS,
            ("projection screen", "white", "matt"), make=lambda: both(Part(Grains(even(0.93), 0.15).evaluate)),
            reflectance=0.93,
        ),
    ]  # fmt: skip
