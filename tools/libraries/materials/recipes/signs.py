"""Retroreflective sheeting of road signs."""

import numpy as np

from ..coats import Paint
from ..retroreflection import sheeting_of_class
from .mixing import POWDER, WHITE, paint
from .recipe import Part, Recipe, even


def recipes() -> list[Recipe]:
    """Return all signs."""
    source = "R_A of EN 12899-1, tables 3 and 4, as exponential falls with the angle of observation; matt ground besides"

    def sign(name, title, what, observed, entered, factor, *tags):
        def make():
            made = sheeting_of_class(
                [(np.radians(angle), value) for angle, value in observed],
                [(np.radians(angle), value) for angle, value in entered],
                even(factor),
            )
            return {"front_reflection": made, "back_reflection": Part(_zinc().evaluate)}

        return Recipe(
            name, "Road/Signs", title, what, source, ("road", "sign", "retroreflective", "white", *tags), make=make,
            more={"retroreflection_cd_per_lx_m2": observed[1][1], "observation_deg": 0.33, "entrance_deg": 5.0},
        )  # fmt: skip

    return [
        sign(
            "sign_ra1", "Sign sheeting RA1, white", "Glass beads: 50 cd/(lx m²) at 0.33°, light 5° off the normal.",
            ((0.2, 70.0), (0.33, 50.0), (2.0, 5.0)), ((5.0, 70.0), (30.0, 30.0), (40.0, 10.0)), 0.35, "glass beads", "RA1",
        ),
        sign(
            "sign_ra2", "Sign sheeting RA2, white", "Prisms: 180 cd/(lx m²) at 0.33°, light 5° off the normal.",
            ((0.2, 250.0), (0.33, 180.0), (2.0, 5.0)), ((5.0, 250.0), (30.0, 150.0), (40.0, 110.0)), 0.30, "prisms", "RA2",
        ),
    ]  # fmt: skip


def _zinc() -> Paint:
    """Grey back of signs."""
    return paint(0.35, WHITE, {"carbon black": 0.05}, POWDER)
