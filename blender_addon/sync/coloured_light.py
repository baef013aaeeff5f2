"""Coloured light on coloured surfaces: told where spectra make another luminance of it than Blender's three channels."""

import numpy as np

from ...engine.photometry.three_channels import excess_over_channels
from ...engine.scene.light import UniformWorld
from ...engine.scene.material import Material
from ...engine.scene.spectrum import Rgb
from ...engine.scene.texture import ImageTexture

LEAST, LEAST_BESIDE_WHITE = 0.01, 0.02
"""Relative differences of a reflection from which on it is told: where all light is coloured, and where some is not. [-]"""

DARK = 0.1
"""Share of the brightest colour of a slide up to which others are dark. [-]"""

MOST = 8
"""Colours of lights, and of surfaces, that are compared: the most saturated ones."""


def paints_of(material: Material) -> tuple[Rgb, ...]:
    """Colours of what a material reflects or lets through; the means of its pictures."""
    found = []
    for colour in material.surface.colours:
        if isinstance(colour, Rgb):
            found.append(colour)
        elif isinstance(colour, ImageTexture) and colour.pixels.shape[2] == 3:
            found.append(Rgb(*np.clip(colour.mean(), 0.0, 1.0).tolist()))
    return tuple(found)


def colour_of_light(item) -> Rgb | None:
    """Colour of a light, a uniform world or a material that glows; None of all that states a spectrum or gives no light."""
    if isinstance(item, Material):
        glow = item.emission
        given = None if glow is None or glow.luminance <= 0.0 else glow.spectrum
    elif isinstance(item, UniformWorld):
        given = item.spectrum if item.luminance > 0.0 else None
    else:
        output = getattr(item, "output", None)
        slide = getattr(getattr(item, "distribution", None), "colours", None)
        if slide is not None and output.value > 0.0:
            return _most_coloured(slide)
        given = output.spectrum if output is not None and output.value > 0.0 else None
    return given if isinstance(given, Rgb) else None


def _most_coloured(slide: np.ndarray) -> Rgb:
    """The most saturated colour of a slide among those that are not dark. (a, p, 3)"""
    values = np.asarray(slide, np.float64).reshape(-1, 3)
    largest = values.max(axis=1)
    values = values[largest > DARK * largest.max()]
    share = values / values.max(axis=1, keepdims=True)
    return Rgb(*share[np.argmin(share.min(axis=1))].tolist())


def tell_coloured_light(lights, paints, has_white: bool, name: str, report) -> None:
    """Note what the first reflection of coloured light from coloured surfaces changes, at the pair where it is most.

    Parameters
    ----------
    lights, paints : iterable of (str, Rgb)    With the names that people know them by.
    has_white : bool    Whether other light falls on the surfaces, too.
    name : str    Of the scene.
    report : ConversionReport
    """
    pairs = [
        (excess_over_channels(light, paint), lamp, material)
        for lamp, light in _most_saturated(lights)
        for material, paint in _most_saturated(paints)
    ]
    excess, lamp, material = max(pairs, key=lambda pair: abs(pair[0]), default=(0.0, "", ""))
    if abs(excess) < (LEAST_BESIDE_WHITE if has_white else LEAST):
        return
    change = "darker" if excess < 0.0 else "brighter"
    report.info(
        name,
        f"coloured light of '{lamp}' falls on coloured '{material}': Blender multiplies three numbers, spectra are "
        "multiplied here",
        f"it is reflected {100.0 * abs(excess):.2g} % {change} than Blender shows it, other colours less so, and more so "
        "with every further reflection",
    )


def _most_saturated(named) -> list[tuple[str, Rgb]]:
    """Different colours, the most saturated ones, with the first of their names."""
    found: dict[Rgb, str] = {}
    for name, colour in named:
        found.setdefault(colour, name)
    order = sorted(found.items(), key=lambda entry: (-_saturation(entry[0]), entry[1]))
    return [(name, colour) for colour, name in order[:MOST] if _saturation(colour) > 0.0]


def _saturation(colour: Rgb) -> float:
    values = (colour.red, colour.green, colour.blue)
    return 1.0 - min(values) / max(values) if max(values) > 0.0 else 0.0
