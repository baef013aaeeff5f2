"""Relief of surfaces as pure data: normals by place that stand for shapes finer than the mesh."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from .texture import ImageTexture


class Axes(Enum):
    """What vectors of a picture of normals refer to.

    TANGENT: along U, across it in the surface, along the surface's normal. OBJECT, WORLD: x, y and z of those.
    """

    TANGENT = "tangent"
    OBJECT = "object"
    WORLD = "world"


@dataclass(frozen=True, eq=False)
class Normals:
    """Normals by place.

    Parameters
    ----------
    vectors : ImageTexture    (height, width, 3); they may be negative and need not be of length 1.
    axes : Axes
    strength : float    Which part of the way from the surface's own normal is gone; 1: all. [-]
    """

    vectors: ImageTexture
    axes: Axes = Axes.TANGENT
    strength: float = 1.0

    @property
    def below(self) -> None:
        """They take the place of what they lie on."""
        return None


@dataclass(frozen=True, eq=False)
class Heights:
    """Heights by place over a surface: their slope turns the normal.

    Seen from the back of a surface they rise towards the eye too, as in Blender.

    Parameters
    ----------
    heights : ImageTexture    (height, width, 1), along the normal. [m], or in units of the object where those count
    strength : float    Which part of the way from the normal below is gone; 1: all. [-]
    in_object : bool    Whether heights are stated in units of the object, whose scale they follow.
    is_shape : bool    Whether they stand for the shape of the mesh, as Blender's displacement does: what lies on them takes
        their normal for that of the mesh.
    below : Relief or None    Relief that these heights are added to; None: the surface itself.
    """

    heights: ImageTexture
    strength: float = 1.0
    in_object: bool = False
    is_shape: bool = False
    below: Relief | None = None


Relief = Normals | Heights


def layers(relief: Relief) -> list[Relief]:
    """Parts of a relief, the one next to the surface first."""
    found = []
    while relief is not None:
        found.append(relief)
        relief = relief.below
    return found[::-1]


def picture_of(layer: Relief) -> ImageTexture:
    """Picture of one part."""
    return layer.heights if isinstance(layer, Heights) else layer.vectors
