"""What Blender said has changed, by session uid, until a walk looks at it."""

from dataclasses import dataclass, field

_GEOMETRIES = {"MESH", "CURVE", "CURVES", "META", "LATTICE", "POINTCLOUD", "VOLUME"}
_SHADING = {"LIGHT", "MATERIAL", "WORLD", "NODETREE", "IMAGE", "TEXTURE"}


@dataclass
class Tags:
    """Session uids of what changed.

    Parameters
    ----------
    objects : set of int    Objects with any change at all.
    geometry : set of int    Objects and their data whose shape may differ.
    shading : set of int    Lights, materials, worlds, node trees and images.
    scene : bool    Something else that a walk may show: visibility, collections, units, the active world.
    """

    objects: set[int] = field(default_factory=set)
    geometry: set[int] = field(default_factory=set)
    shading: set[int] = field(default_factory=set)
    scene: bool = False

    def __bool__(self) -> bool:
        """Whether there is anything to look at."""
        return bool(self.objects or self.geometry or self.shading or self.scene)

    def add(self, updates) -> None:
        """Note what a dependency graph reports (`bpy.types.DepsgraphUpdate`)."""
        for update in updates:
            block = update.id.original
            kind = block.id_type
            if kind == "OBJECT":
                self.objects.add(block.session_uid)
                if update.is_updated_geometry:
                    self.geometry.add(block.session_uid)
            elif kind in _GEOMETRIES:
                # Their shading flag comes with every edit of a material that they use.
                if update.is_updated_geometry:
                    self.geometry.add(block.session_uid)
            elif kind in _SHADING:
                self.shading.add(block.session_uid)
            elif kind in {"SCENE", "COLLECTION"}:
                self.scene = True
