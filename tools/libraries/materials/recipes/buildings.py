"""Buildings and streets: plaster, brick, floors, paper, asphalt."""

import numpy as np

from ..coats import Coat, Paint, Slab
from ..colour import WAVELENGTHS, luminous, solve
from ..pigments import layer, mixture
from ..roads import asphalt_of_class
from .mixing import CHALK, grains, paint
from .paints import SOURCE as PAINT
from .recipe import Part, Recipe, both, through

SOURCE = (
    "Oren-Nayar facets (EON), pigments by Kubelka-Munk; luminous reflectance as usual for the kind"
)


def _rough(name, kind, title, what, target, fixed, varied, roughness, *tags) -> Recipe:
    return Recipe(
        name, kind, title, what, SOURCE, tags,
        make=lambda: both(Part(grains(target, fixed, varied, roughness).evaluate)),
        reflectance=target,
    )  # fmt: skip


def recipes() -> list[Recipe]:
    """Return all of buildings and streets."""

    def oak():
        coat = Coat(1.5, 0.25)
        brown = {"brown iron oxide": 0.03, "yellow iron oxide": 0.12}
        return both(Part(paint(0.28, {"chalk": 1.0, "titanium white": 0.05}, brown, coat).evaluate))

    def linoleum():
        made = paint(0.25, CHALK, {"carbon black": 0.01, "phthalo green": 0.002}, Coat(1.5, 0.35))
        return both(Part(made.evaluate))

    def wet():
        film = Coat(1.33)
        made = Paint(film, np.full(len(WAVELENGTHS), 0.06) * (WAVELENGTHS / 550.0) ** 0.15)
        return both(Part(made.evaluate, made.direct))

    def dry():
        colour = (WAVELENGTHS / 550.0) ** 0.15
        return both(Part(asphalt_of_class(0.07, 1.11, colour, 0.5, 0.6).evaluate))

    def paper():
        k, s = mixture({"chalk": 1.0, "titanium white": 0.004})
        k = 0.4 * k
        amount = solve(lambda x: luminous(layer(x * k, x * s)[1]), 0.11, 1.0, 1000.0)
        made = Slab(Coat(1.0), *layer(amount * k, amount * s))
        return {
            **both(Part(made.reflect)),
            **through(Part(made.transmit)),
        }

    return [
        _rough(
            "plaster_white", "Building/Plaster", "White lime plaster, fine", "Rendered wall or ceiling, unpainted.",
            0.75, {"chalk": 1.0, "titanium white": 0.1}, {"yellow iron oxide": 0.01, "carbon black": 0.0005}, 0.5,
            "plaster", "wall", "white", "rough",
        ),
        _rough(
            "plaster_sand", "Building/Plaster", "Sand plaster, coarse", "Facade with a coarse mineral render.",
            0.45, CHALK, {"yellow iron oxide": 0.02, "brown iron oxide": 0.006}, 0.9,
            "plaster", "facade", "rough",
        ),
        _rough(
            "brick_red", "Building/Brick", "Red brick", "Facing brick without its joints.",
            0.16, {"red iron oxide": 0.3, "yellow iron oxide": 0.1, "brown iron oxide": 0.05}, CHALK, 0.8,
            "brick", "wall", "facade", "red",
        ),
        _rough(
            "concrete_grey", "Building/Concrete", "Concrete, cast", "Fair-faced concrete, dry.",
            0.30, CHALK, {"carbon black": 0.01, "phthalo blue": 0.002}, 0.6,
            "concrete", "wall", "floor", "grey",
        ),
        Recipe(
            "asphalt_dry", "Road/Surface", "Asphalt, dry, class R3",
            "Road surface with Q0 = 0.07 and S1 = 1.11 for a driver who looks 1 degree down.",
            "Oren-Nayar facets (EON) partly covered by GGX facets, fitted to Q0 and S1 of CIE 144",
            ("road", "asphalt", "street", "R3"), make=dry, reflectance=0.102,
            more={"luminance_coefficient_Q0": 0.07, "specular_factor_S1": 1.11},
        ),
        Recipe(
            "asphalt_wet", "Road/Surface", "Asphalt under water", "Road under a smooth film of water: a dark mirror.",
            "Lambertian ground under a boundary of the index 1.33 (Saunderson)",
            ("road", "asphalt", "street", "wet"), make=wet, reflectance=0.052,
        ),
        Recipe(
            "wood_oak_varnish", "Building/Floor", "Oak floor, varnished", "Mean of a parquet floor, silk varnish; no grain.",
            PAINT, ("wood", "floor", "parquet", "furniture", "silk"), make=oak, reflectance=0.28,
        ),
        Recipe(
            "linoleum_grey", "Building/Floor", "Linoleum, grey-green", "Floor of offices and schools, silk.",
            PAINT, ("floor", "linoleum", "grey"), make=linoleum, reflectance=0.25,
        ),
        _rough(
            "carpet_grey", "Building/Floor", "Carpet, grey", "Velour carpet of an office.",
            0.15, CHALK, {"carbon black": 0.01, "phthalo blue": 0.003}, 1.0, "carpet", "floor", "textile", "grey",
        ),
        Recipe(
            "paper_office", "Building/Paper", "Office paper, one sheet", "Uncoated white paper, 80 g/m².",
            "Kubelka-Munk layer in air", ("paper", "white", "translucent", "matt"), make=paper,
            reflectance=0.806, transmittance=0.11,
        ),
    ]  # fmt: skip
