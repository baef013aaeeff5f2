"""Textures and materials of a baked scene: its light, or its illuminance in false colours."""

import math
from dataclasses import dataclass, field

import numpy as np

from ..analysis.false_colour import STOPS
from ..analysis.tone import limit_to_white
from .gltf_colour import FlatColour
from .gltf_pages import TexturePlan, compose, encode_colour, encode_grey, encode_scale
from .gltf_scene import NOWHERE, ShownScene

LOOKS = {"light": "light", "false_colour": "illuminance"}
"""Looks by the name of their variant in the file."""


class Light:
    """From light to display values, white being 1.

    Where the exitance is known the textures hold all. Else they hold the illuminance, and the materials its factor.
    """

    def __init__(self, scene: ShownScene, white: float):
        self.white = white
        self.is_coloured = bool(scene.pages) and all(p.exitance is not None for p in scene.pages)
        lit = [
            colour.reflected.max()
            for shown in scene.objects
            for colour in shown.colours
            if colour.needs_light
        ]
        # Where nothing reflects any light, the look is black at any scale.
        self.brightest = float(max(lit, default=1.0)) or 1.0

    @property
    def top(self) -> float:
        """Illuminance [lx] or luminous exitance [lm/m2] of the highest code: M = pi L."""
        return math.pi * self.white / (1.0 if self.is_coloured else self.brightest)

    def factor(self, colour: FlatColour) -> list[float]:
        """Factor of a material on its texture. (4,)"""
        opacity = 1.0 - colour.passing
        if self.is_coloured:
            return [1.0, 1.0, 1.0, opacity]
        # What is seen through is weighed by 1 - opacity, what is reflected must not be weighed by opacity.
        share = colour.reflected / (self.brightest * opacity)
        return [*(float(v) for v in np.minimum(share, 1.0)), opacity]

    def flat(self, colour: FlatColour, illuminance: float) -> list[float]:
        """Display colour of a glowing or see-through surface in even light. [lx] (4,)"""
        luminance = colour.emitted + colour.reflected * illuminance / math.pi
        shown = limit_to_white(luminance / self.white)
        return [*(float(v) for v in shown), 1.0 - colour.passing]


class Textures:
    """Pictures of all looks, and the entries that name them. A look's textures follow one another."""

    def __init__(self, scene, plan: TexturePlan, looks: list[str], light: Light, top: float):
        self.plan = plan
        self.starts = {look: i * len(plan.extents) for i, look in enumerate(looks)}
        self.pictures: list[tuple[str, bytes]] = []
        self.entries: list[dict] = []
        quantities = {
            "light": "exitance" if light.is_coloured else "illuminance",
            "false_colour": "illuminance",
        }
        for look in looks:
            for number in range(len(plan.extents)):
                quantity = quantities[look]
                values = compose(plan, scene.pages, number, quantity)
                if look == "false_colour":
                    data, extras = encode_scale(values, top), _describe_scale(top)
                elif light.is_coloured:
                    data = encode_colour(values, light.white)
                    extras = _describe_codes("luminous exitance", "lm/m2", light.top)
                else:
                    data = encode_grey(values, light.top)
                    extras = _describe_codes("illuminance", "lx", light.top)
                name = f"{LOOKS[look]}_{number}"
                pages = [plan.numbers[i] for i in np.flatnonzero(plan.texture == number)]
                self.entries.append(
                    {
                        "name": name,
                        "sampler": 0,
                        "source": len(self.pictures),
                        "extras": {**extras, "pages": pages, "lumels_per_texel": plan.factor},
                    }
                )
                self.pictures.append((name, data))


def _describe_codes(quantity: str, unit: str, top: float) -> dict:
    return {"quantity": quantity, "unit": unit, "transfer": "sRGB", "at_code_255": top}


def _describe_scale(top: float) -> dict:
    stops = ["#" + bytes(np.round(255.0 * stop).astype(np.uint8)).hex() for stop in STOPS]
    # The palette's index counts, so that a reader of the picture gets the illuminance back.
    return {
        "quantity": "illuminance",
        "unit": "lx",
        "transfer": "linear in the palette's index",
        "at_code_255": top,
        "colours": stops,
    }


@dataclass
class Palette:
    """Materials, each written once."""

    textures: Textures
    light: Light
    materials: list[dict] = field(default_factory=list)
    has_variants: bool = False
    _numbers: dict[tuple, int] = field(default_factory=dict)

    def fields(self, colour: FlatColour, texture: int, illuminance: float, is_double: bool) -> dict:
        """Return the fields of a primitive that say how it looks."""
        made = {}
        for place, look in enumerate(self.textures.starts):
            if look == "false_colour" and texture != NOWHERE:
                key = (look, texture, (1.0, 1.0, 1.0, 1.0), is_double)
            elif texture != NOWHERE and colour.needs_light:
                key = ("light", texture, tuple(self.light.factor(colour)), is_double)
            else:
                flat = tuple(self.light.flat(colour, illuminance))
                key = ("light", NOWHERE, flat, is_double)
            made[place] = self._number(*key)
        first, *others = made.values()
        if all(other == first for other in others):
            return {"material": first}
        self.has_variants = True
        mappings = [{"material": number, "variants": [place]} for place, number in made.items()]
        return {
            "material": first,
            "extensions": {"KHR_materials_variants": {"mappings": mappings}},
        }

    def _number(self, look: str, texture: int, factor: tuple, is_double: bool) -> int:
        key = (look, texture, factor, is_double)
        if key not in self._numbers:
            self._numbers[key] = len(self.materials)
            self.materials.append(self._make(look, texture, factor, is_double))
        return self._numbers[key]

    def _make(self, look: str, texture: int, factor: tuple, is_double: bool) -> dict:
        # What a viewer without the extension falls back to is as matt as can be.
        shading = {"baseColorFactor": list(factor), "metallicFactor": 0.0, "roughnessFactor": 1.0}
        made = {
            "name": f"{LOOKS[look]} {len(self.materials)}",
            "pbrMetallicRoughness": shading,
            "extensions": {"KHR_materials_unlit": {}},
        }
        if texture != NOWHERE:
            shading["baseColorTexture"] = {"index": self.textures.starts[look] + texture}
        if factor[3] < 1.0:
            made["alphaMode"] = "BLEND"
        if is_double:
            made["doubleSided"] = True
        return made
