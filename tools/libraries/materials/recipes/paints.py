"""Paints: walls, lacquers, powder coats, cars."""

import numpy as np

from ..colour import WAVELENGTHS
from ..flakes import Flakes
from ..fresnel import reflectance, stack_reflectance
from ..metals import index_of
from ..pigments import mixture
from .mixing import MATT, POWDER, SILK, SMOOTH, WHITE, paint
from .recipe import Part, Recipe, both

SOURCE = "Kubelka-Munk layer of pigments under a dielectric boundary (Saunderson, GGX); pigment bands drawn by hand"


def _painted(name, kind, title, what, target, fixed, varied, coat, *tags) -> Recipe:
    """A painted surface, the same from both sides."""

    def make():
        made = paint(target, fixed, varied, coat)
        is_smooth = coat.alpha == 0.0
        return both(Part(made.evaluate, made.direct if is_smooth else None))

    return Recipe(
        name, f"Paint/{kind}", title, what, SOURCE, ("paint", *tags), make=make, reflectance=target
    )


def recipes() -> list[Recipe]:
    """Return all paints."""
    tinge = {"yellow iron oxide": 0.1, "carbon black": 0.004}
    grey = {"carbon black": 0.05, "yellow iron oxide": 0.03}
    return [
        _painted(
            "wall_white_matt", "Wall", "White wall paint, matt",
            "Emulsion paint for ceilings and walls, like RAL 9010.",
            0.85, WHITE, tinge, MATT, "wall", "ceiling", "white", "matt", "interior",
        ),
        _painted(
            "wall_white_silk", "Wall", "White wall paint, silk",
            "Latex paint that can be washed, like RAL 9016.",
            0.85, WHITE, {"carbon black": 0.004, "yellow iron oxide": 0.02}, SILK,
            "wall", "white", "silk", "interior",
        ),
        _painted(
            "wall_ivory_matt", "Wall", "Ivory wall paint, matt", "Warm white, like RAL 1015.",
            0.68, WHITE, {"yellow iron oxide": 1.0, "red iron oxide": 0.12}, MATT,
            "wall", "ivory", "warm", "matt", "interior",
        ),
        _painted(
            "wall_grey_matt", "Wall", "Light grey wall paint, matt", "Neutral, like RAL 7035.",
            0.565, WHITE, grey, MATT, "wall", "grey", "matt", "interior",
        ),
        _painted(
            "wall_terracotta_matt", "Wall", "Terracotta wall paint, matt",
            "White with red and yellow iron oxide.",
            0.25, WHITE, {"red iron oxide": 1.0, "yellow iron oxide": 1.6}, MATT,
            "wall", "red", "warm", "matt", "interior",
        ),
        _painted(
            "wall_blue_matt", "Wall", "Pale blue wall paint, matt",
            "White with phthalocyanine blue.",
            0.50, WHITE, {"phthalo blue": 1.0, "carbon black": 0.02}, MATT,
            "wall", "blue", "cold", "matt", "interior",
        ),
        _painted(
            "lacquer_white_gloss", "Gloss", "White lacquer, gloss", "Doors and windows, like RAL 9016.",
            0.86, WHITE, {"carbon black": 0.004, "yellow iron oxide": 0.02}, SMOOTH,
            "lacquer", "white", "gloss",
        ),
        _painted(
            "lacquer_red_gloss", "Gloss", "Red lacquer, gloss", "Traffic red, like RAL 3020.",
            0.13, {"diketopyrrole red": 1.0}, {"titanium white": 1.0}, SMOOTH,
            "lacquer", "red", "gloss",
        ),
        _painted(
            "lacquer_yellow_gloss", "Gloss", "Yellow lacquer, gloss", "Traffic yellow, like RAL 1023.",
            0.52, {"bismuth yellow": 1.0}, {"yellow iron oxide": 1.0, "diketopyrrole red": 0.15}, SMOOTH,
            "lacquer", "yellow", "gloss",
        ),
        _painted(
            "lacquer_blue_gloss", "Gloss", "Blue lacquer, gloss", "Gentian blue, like RAL 5010.",
            0.09, {"phthalo blue": 1.0, "carbon black": 0.03}, {"titanium white": 1.0}, SMOOTH,
            "lacquer", "blue", "gloss",
        ),
        _painted(
            "lacquer_black_gloss", "Gloss", "Black lacquer, gloss", "Piano black, like RAL 9005.",
            0.045, {"carbon black": 1.0}, {"titanium white": 1.0}, SMOOTH, "lacquer", "black", "gloss",
        ),
        _painted(
            "lacquer_green_silk", "Silk", "Green lacquer, silk", "Mint green, like RAL 6029.",
            0.12, {"phthalo green": 1.0, "yellow iron oxide": 0.15}, {"titanium white": 1.0}, SILK,
            "lacquer", "green", "silk",
        ),
        _painted(
            "powder_white", "Powder", "White powder coat", "Bodies of luminaires, ceiling panels, like RAL 9016.",
            0.84, WHITE, {"carbon black": 0.004, "yellow iron oxide": 0.02}, POWDER,
            "powder", "white", "luminaire", "metal ceiling",
        ),
        _painted(
            "powder_anthracite", "Powder", "Anthracite powder coat", "Window frames and masts, like RAL 7016.",
            0.075, {"carbon black": 1.0, "phthalo blue": 0.15}, {"titanium white": 1.0}, POWDER,
            "powder", "grey", "facade", "mast",
        ),
        *_car_paints(),
    ]  # fmt: skip


def _flaky(name, title, what, target, make_flakes, *tags) -> Recipe:
    def make():
        made = make_flakes()
        return both(Part(made.evaluate, made.direct, tolerance=0.06))

    source = (
        "Reflection at flakes in closed form, their slopes normally distributed; aluminium by the index that comes with "
        "Mitsuba, interference by Fresnel's equations of the stack"
    )
    return Recipe(
        name, "Paint/Metallic", title, what, source, ("paint", "car", "metallic", *tags),
        make=make, reflectance=target,
    )  # fmt: skip


def aluminium_flakes(binder: float):
    """Reflectance of aluminium flakes in a binder, by cosines."""
    return lambda cosine: reflectance(cosine[:, None], index_of("Al") / binder)


def pearl_flakes(binder: float):
    """Reflectance of flakes of alumina, 230 nm, with titania, 165 nm, on both faces, by cosines."""
    films = (2.7, 1.77, 2.7), (165.0, 230.0, 165.0)
    return lambda cosine: stack_reflectance(cosine, WAVELENGTHS, *films, binder)


def _car_paints() -> list[Recipe]:
    clear, grey = np.zeros(len(WAVELENGTHS)), np.full(len(WAVELENGTHS), 0.3)

    def blue():
        dye, _ = mixture({"phthalo blue": 0.5})
        return Flakes(aluminium_flakes(1.5), 0.1 * grey, 0.10, 1.6, dye, is_wide=True)

    def pearl():
        dark = np.full(len(WAVELENGTHS), 0.03)
        return Flakes(pearl_flakes(1.45), dark, 0.09, 1.2, clear, 1.45, is_clear=True)

    return [
        _flaky(
            "car_silver", "Silver metallic car paint", "Aluminium flakes under a clear coat, bright when seen steeply.",
            0.67, lambda: Flakes(aluminium_flakes(1.5), grey, 0.10, 2.0, 0.30 + clear, is_wide=True),
            "silver",
        ),
        _flaky(
            "car_blue", "Blue metallic car paint", "Aluminium flakes in a blue binder under a clear coat.",
            0.205, blue, "blue",
        ),
        _flaky(
            "car_pearl", "Pearlescent car paint",
            "Flakes of alumina and titania over black: green-yellow face on, violet at a slant.",
            0.315, pearl, "interference", "pearl",
        ),
    ]  # fmt: skip
