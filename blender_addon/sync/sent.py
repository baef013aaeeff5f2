"""What a sync has sent to the engine: the instances and the world as they were, and the tables of what they are made of."""

from dataclasses import dataclass

import numpy as np

from ...engine.scene.light import Light, SunLight
from ...engine.scene.mesh import Placement
from ...engine.scene.modelling import Modelling
from ...engine.scene.spectrum import Rgb
from ..foundation.report import ConversionReport
from .images.cache import ImageCache
from .tables.geometries import GeometryTable
from .tables.materials import MaterialTable
from .tables.pictures import PictureTable


@dataclass
class Shown:
    """What was made of one instance.

    Parameters
    ----------
    source : int    Session uid of the object that it shows.
    is_own : bool    Whether it is the object itself, not an instance that something makes of it.
    key, name : str    Engine id, and name for people.
    item : Placement, Light or None    As it was sent last.
    digest : bytes    Of the item, if it is a light.
    matrix : bytes    World matrix that it was made with, in Blender units.
    data : int    Session uid of the object's data.
    shading : frozenset of int    Node trees and images that a light reads, and objects that materials ask for.
    is_mapped : bool    Whether lux maps and charts of pictures can be laid over it, which are not over strands and points.
    is_dark : bool    Whether it is a light that is hidden or emits nothing.
    charts : frozenset of (int, bool)    Slots whose materials are made for its surface, and whether each is the last.
    is_placed : bool    Whether it has materials that are made for it.
    follows_scene : bool    Whether these ask for properties of the scene.
    is_far : bool    Whether it is an object that was left out because of where it is.
    is_anchored : bool    Whether it is an object whose shape depends on where it stands.
    towards_sun : (3,) array or None    Where it shines from, if it is a Sun light itself and no instance of one.
    walk : int    Number of the walk that saw it last.
    """

    source: int
    is_own: bool
    key: str = ""
    name: str = ""
    item: Placement | Light | None = None
    digest: bytes = b""
    matrix: bytes = b""
    data: int = 0
    shading: frozenset[int] = frozenset()
    is_mapped: bool = True
    is_dark: bool = False
    charts: frozenset = frozenset()
    is_placed: bool = False
    follows_scene: bool = False
    is_far: bool = False
    is_anchored: bool = False
    towards_sun: np.ndarray | None = None
    report: ConversionReport | None = None
    walk: int = 0


@dataclass
class SentWorld:
    """The world as it was sent last; ``source`` 0: there was none; ``sun``: what counted of Sun light and frame.

    ``gives_light``: whether it lights anything, and is not there for the camera alone; ``colour``: of its light if that is
    the same from everywhere; ``suns``: the lights that are its suns; ``plane``: the items
    that show the shadows on its ground.
    """

    source: int = -1
    key: str = ""
    sun: bytes = b""
    digest: bytes = b""
    shading: frozenset[int] = frozenset()
    report: ConversionReport | None = None
    gives_light: bool = False
    colour: Rgb | None = None
    suns: tuple[SunLight, ...] = ()
    plane: tuple = ()


class Sent:
    """What the engine has of a scene from a sync.

    Parameters
    ----------
    final, texels    As of `SceneSync`.

    Attributes
    ----------
    shown : dict    Of `Shown`, by what tells instances apart.
    wishes : Modelling    What the user wants of simplifications; that of an empty scene is not sent.
    scale, efficacy : float    Metres per unit and lumens per watt as they were.
    filters : tuple or None    Whether the view layer showed surfaces, session uid of the material in place of all, or 0, and
        what its collections are there for.
    walks, last_visit : int    Walks so far, and the number of the last one that looked at the instances.
    """

    def __init__(self, final: bool, texels: int | None = None):
        self.shown: dict[object, Shown] = {}
        self.geometries = GeometryTable()
        self.images, self.pictures = ImageCache(), PictureTable()
        self.materials = MaterialTable(self.images, self.pictures, final, texels)
        self.world, self.wishes = SentWorld(), Modelling()
        self.scale = self.efficacy = 0.0
        self.filters: tuple[bool, int, bytes] | None = None
        self.walks = self.last_visit = 0

    def ids(self) -> set[str]:
        """Ids of all items."""
        held = {shown.key for shown in self.shown.values() if shown.item is not None}
        held |= {*self.geometries, *self.materials, *self.pictures}
        held |= {item.id for item in (*self.world.suns, *self.world.plane)}
        held |= {self.wishes.id} if self.wishes != Modelling() else set()
        return held | ({self.world.key} if self.world.digest else set())
