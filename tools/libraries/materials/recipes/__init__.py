"""All materials of the library: what they are made of, and what the catalogue says of them.

None is measured and none is a product's: they are computed from the physics of their kind, with numbers stated here.
"""

from . import buildings, diffusers, glasses, metals, paints, signs, textiles
from .recipe import Part, Recipe

__all__ = ["Part", "Recipe", "recipes"]


def recipes() -> list[Recipe]:
    """Return all, in the order in which they are written."""
    rooms = (paints, buildings, metals, glasses, diffusers, textiles, signs)
    return [recipe for room in rooms for recipe in room.recipes()]
