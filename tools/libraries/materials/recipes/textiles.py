"""Curtains, sun screens, blackout cloth."""

from ..coats import Coat
from ..sheets import Cloth
from .buildings import SOURCE as GRAINS
from .mixing import CHALK, WHITE, grains, paint
from .recipe import Part, Recipe, both, through


def recipes() -> list[Recipe]:
    """Return all textiles."""

    def cloth(name, title, what, openness, fixed, varied, reflected, passed, *tags):
        """``reflected``, ``passed``: luminous, of the whole cloth, light along the normal."""

        def make():
            cover = 1.0 - openness
            yarns = (reflected + passed - openness) / cover
            body = grains(yarns, fixed, varied, 0.0).colour
            share = reflected / cover / yarns
            made = Cloth(openness, share * body, (1.0 - share) * body)
            return {
                **both(Part(made.reflect)),
                **through(Part(made.transmit, made.direct)),
            }

        return Recipe(
            name, "Textile/Curtain", title, what, "Plain weave of round yarns; yarns scatter evenly",
            ("textile", "curtain", *tags), make=make, reflectance=reflected, transmittance=passed,
            more={"openness": openness},
        )  # fmt: skip

    def blackout():
        front = grains(0.50, CHALK, {"carbon black": 0.003, "yellow iron oxide": 0.01}, 0.7)
        back = paint(0.78, WHITE, {"carbon black": 0.01}, Coat(1.5, 0.5))
        return {"front_reflection": Part(front.evaluate), "back_reflection": Part(back.evaluate)}

    white = (WHITE, {"yellow iron oxide": 0.01, "carbon black": 0.0005})
    grey = (CHALK, {"carbon black": 0.01})
    return [
        cloth("curtain_sheer", "Curtain, sheer", "Voile that one sees through.", 0.30, *white, 0.25, 0.65, "sheer", "white"),
        cloth("curtain_linen", "Curtain, linen", "Half transparent curtain, warm white.", 0.06, WHITE,
              {"yellow iron oxide": 0.03, "brown iron oxide": 0.004}, 0.45, 0.32, "linen", "warm"),
        cloth("screen_fabric_white", "Sun screen, white, 3 % open", "Glass-fibre roller blind.", 0.03, *white, 0.70, 0.20,
              "sun screen", "glare", "roller blind", "white"),
        cloth("screen_fabric_grey", "Sun screen, grey, 5 % open", "Glass-fibre roller blind, clear view outside.", 0.05,
              *grey, 0.12, 0.06, "sun screen", "glare", "roller blind", "grey"),
        Recipe(
            "blackout", "Textile/Curtain", "Blackout cloth", "Beige cloth, white coat behind; lets nothing through.",
            GRAINS, ("textile", "curtain", "blackout"), make=blackout, reflectance=0.50, transmittance=0.0,
        ),
    ]  # fmt: skip
