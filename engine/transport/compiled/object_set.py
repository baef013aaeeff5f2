"""Objects at work, kept under their ids: what an edit of an object or of its materials changes of their shapes."""

from ...scene.material import CATCHER, HOLDOUT, Material
from ...scene.mesh import Mesh
from ...scene.scene import Scene
from ..layers import Layer
from .bodies import Body, Part, check_mesh, make_body, needs_new_shape, reglow
from .changes import Changes
from .material_palette import MaterialPalette
from .pool import SurfacePool


class ObjectSet:
    """Objects of a compiled scene.

    Parameters
    ----------
    origin : (3,) array    Of the scene's frame, in the world. [m]
    pool : SurfacePool
    palette : MaterialPalette
    solid, transparent, shown : Layer    As of `CompiledScene`.

    Attributes
    ----------
    bodies : dict    Of `Body`, by the objects' ids.
    """

    def __init__(
        self,
        origin,
        pool: SurfacePool,
        palette: MaterialPalette,
        solid: Layer,
        transparent: Layer,
        shown: Layer,
    ):
        self._origin, self._pool, self._material_palette = origin, pool, palette
        self._solid, self._transparent, self._shown = solid, transparent, shown
        self.bodies: dict[str, Body] = {}
        self._users: dict[str, dict[str, None]] = {}

    def commit(self, scene: Scene, named: list[str], changes: Changes) -> None:
        """Bring the objects up to date that ids name, and those of the geometries and materials that ids name."""
        moved = self._changed_meshes(scene, named)
        rebuilt = self._commit_materials(scene, named, changes)
        for key in dict.fromkeys([*moved, *rebuilt]):
            self._commit_mesh(scene, key, key in rebuilt, changes)
        self._drop_unused_materials()

    def materials(self):
        """Yield every material that objects are made of, and what the camera sees in its place."""
        for key in self._users:
            item = self._material_palette.item(key)
            if item is not None:
                yield item
                if item.seen is not None:
                    yield item.seen

    def parts(self) -> list[tuple[Body, Part]]:
        """Parts of all objects."""
        return [(body, part) for body in self.bodies.values() for part in body.parts]

    def _commit_materials(self, scene: Scene, named, changes: Changes) -> dict[str, None]:
        """Take in the named materials; returns the ids of objects whose shapes must be built anew."""
        rebuilt: dict[str, None] = {}
        for key in named:
            new, old = scene.materials.get(key), self._material_palette.item(key)
            if new is None or new is old or (old is None and key not in self._users):
                continue
            self._take_in(new, old)
            changes.surfaces += 1
            if old is None:
                continue
            users = self._users.get(key, {})
            if needs_new_shape(old, new):
                rebuilt |= users
                continue
            for part in self._parts_of(users, key):
                reglow(part, old, new)
            if new.seen is not None:
                for part in self._parts_of(users, new.seen.id):
                    reglow(part, old.seen, new.seen)
        return rebuilt

    def _take_in(self, new: Material, old: Material | None = None) -> None:
        """Take a material in, with what the camera sees in its place. ``old``: as it was."""
        palette = self._material_palette
        palette.put(new)
        if new.seen is not None:
            palette.put(new.seen)
        elif old is not None and old.seen is not None:
            palette.drop(old.seen.id)

    def _parts_of(self, bodies, material: str):
        for key in bodies:
            for part in self.bodies[key].parts if key in self.bodies else ():
                if part.material == material:
                    yield part

    def _drop_unused_materials(self) -> None:
        for key in [k for k, users in self._users.items() if not users]:
            del self._users[key]
            item = self._material_palette.item(key)
            self._material_palette.drop(key)
            if item is not None and item.seen is not None:
                self._material_palette.drop(item.seen.id)

    def _changed_meshes(self, scene: Scene, named) -> list[str]:
        changed = [key for key in named if key in scene.meshes or key in self.bodies]
        geometries = {key for key in named if key in scene.geometries}
        if geometries:
            changed += [
                key
                for key, item in scene.meshes.items()
                if not isinstance(item, Mesh) and item.geometry in geometries
            ]
        return changed

    def _commit_mesh(self, scene: Scene, key: str, is_stale: bool, changes: Changes) -> None:
        item, old = scene.meshes.get(key), self.bodies.get(key)
        if item is None:
            if old is not None:
                self._remove_body(key)
                changes.removed += 1
            return
        geometry = None if isinstance(item, Mesh) else scene.geometries.get(item.geometry)
        if old is not None and not is_stale and not old.is_moved(item, geometry):
            self._redress(scene, key, item, changes)
            if self.bodies[key].item is item:
                return
        mesh = scene.mesh(key)
        check_mesh(mesh, scene.materials)
        if old is not None:
            self._remove_body(key)
        for material in mesh.materials:
            self._users.setdefault(material, {})[key] = None
            if self._material_palette.item(material) is not scene.materials[material]:
                self._take_in(scene.materials[material])
        for is_wanted, seen in ((item.is_holdout, HOLDOUT), (item.is_catcher, CATCHER)):
            if is_wanted and self._material_palette.item(seen.id) is None:
                self._material_palette.put(seen)
        body = make_body(item, geometry, mesh, self._origin, self._material_palette, self._pool)
        lit: dict[int, int] = {}
        for part in body.parts:
            # What the camera sees in place of what light meets has the same triangles.
            twin = 0 if part.meets_light else lit.get(part.slot, 0)
            self._layer_of(part).add(part.shape, part.number, part.triangles, twin)
            if part.meets_light:
                lit[part.slot] = part.number
        self.bodies[key] = body
        changes.built += 1

    def _redress(self, scene: Scene, key: str, item, changes: Changes) -> None:
        """Change what an object is made of or how it shows, where its shapes can stay; sets the body's item if so."""
        body = self.bodies[key]
        if item.materials != body.item.materials:
            if len(item.materials) != len(body.item.materials) or body.is_split:
                return
            for part in body.parts:
                new = scene.materials.get(item.materials[part.slot])
                if new is None or needs_new_shape(self._material_palette.item(part.material), new):
                    return
            if any(getattr(scene.materials.get(key), "seen", None) for key in item.materials):
                return
            for old, new in zip(body.item.materials, item.materials, strict=True):
                if new not in scene.materials:
                    return
                self._users.setdefault(new, {})[key] = None
                if self._material_palette.item(new) is not scene.materials[new]:
                    self._take_in(scene.materials[new])
                if old not in item.materials:
                    self._users[old].pop(key, None)
            for part in body.parts:
                new = item.materials[part.slot]
                reglow(
                    part,
                    self._material_palette.item(part.material),
                    self._material_palette.item(new),
                )
                part.material = part.owner = new
            changes.surfaces += 1
        body.item = item

    def _remove_body(self, key: str) -> None:
        body = self.bodies.pop(key)
        for part in body.parts:
            self._layer_of(part).remove(part.number)
            self._pool.remove(part.number)
        for material in body.item.materials:
            self._users[material].pop(key, None)

    def _layer_of(self, part: Part) -> Layer:
        if not part.meets_light:
            return self._shown
        return self._transparent if part.is_transparent else self._solid
