"""What is baked: fronts and backs of objects, their charts on pages, and the lumels there."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..atlas.arrange import arrange, find_all_charts
from ..atlas.finder import LumelFinder
from ..atlas.layout import Atlas, Charts
from ..atlas.lumels import LumelTable
from ..atlas.texture_density import texture_density
from ..errors import SceneError
from ..scene.mesh import Mesh
from ..scene.scene import Scene
from .notes import Notes
from .order import BakeOrder


@dataclass(frozen=True)
class BakedSurface:
    """One side of an object, which gets a layout of its own.

    Parameters
    ----------
    key : str    Id of the object.
    mesh : Mesh
    density : float    That is asked for. [lumel/m]
    is_back : bool
    """

    key: str
    mesh: Mesh
    density: float
    is_back: bool


@dataclass(frozen=True)
class Ground:
    """All surfaces of a bake with their lumels.

    Parameters
    ----------
    surfaces : list of BakedSurface
    atlas : Atlas    A layout for each surface.
    table : LumelTable
    """

    surfaces: list[BakedSurface]
    atlas: Atlas
    table: LumelTable

    @cached_property
    def owners(self) -> np.ndarray:
        """Number of the surface of every lumel. (n,) int32"""
        counts = self.table.counts
        layouts = [self.table.layout(number) for number in range(len(counts))]
        return np.repeat(np.array(layouts, dtype=np.int32), counts)

    def finder(self, compiled) -> LumelFinder:
        """Return what finds the lumel at a place of the compiled scene."""
        keys, meshes = zip(*((each.key, each.mesh) for each in self.surfaces), strict=True)
        return LumelFinder(compiled, list(keys), list(meshes), self.atlas, self.table)

    def find_missed(self, compiled) -> np.ndarray | None:
        """Lumels on which traced light never lands: no light meets them, or they only mirror. (n,) bool; None: none."""
        met = {
            key
            for key, _, material in compiled.parts()
            if not (material.surface.is_purely_specular or material.surface.is_mirror)
        }
        missed = np.array([each.key not in met for each in self.surfaces], dtype=bool)
        return missed[self.owners] if missed.any() else None


def find_surfaces(order: BakeOrder, scene: Scene, notes: Notes) -> list[BakedSurface]:
    """Fronts of all objects, then backs of those that are baked on both sides.

    Raises
    ------
    SceneError    There are none.
    """
    surfaces = []
    for key in order.objects:
        if key not in scene.meshes:
            notes.depart(
                key, "the object has no surface that is rendered", "it is not baked", is_error=True
            )
            continue
        mesh = scene.mesh(key)
        if len(mesh.triangles) == 0 or not mesh.areas().sum() > 0.0:
            notes.depart(
                mesh.name, "the object has no surface to bake", "it is not baked", is_error=True
            )
            continue
        density = order.densities.get(key, order.density)
        if order.from_textures:
            density = max(density, texture_density(mesh, scene.materials))
        surfaces.append(BakedSurface(key, mesh, density, False))
    if not surfaces:
        raise SceneError("nothing to bake: none of the objects has a surface that is rendered")
    wanted = set(order.two_sided)
    return surfaces + [replace(each, is_back=True) for each in surfaces if each.key in wanted]


def find_charts(
    surfaces: list[BakedSurface], order: BakeOrder, cancelled, notes: Notes
) -> tuple[Charts, ...]:
    """Unwrap the fronts."""
    fronts = [each for each in surfaces if not each.is_back]
    return find_all_charts(
        [each.mesh for each in fronts],
        [each.density for each in fronts],
        cone=order.cone,
        progress=lambda done, count: notes.name_stage(f"laying out {done} of {count}"),
        cancelled=cancelled,
    )


def arrange_charts(
    surfaces: list[BakedSurface], charts: tuple[Charts, ...], order: BakeOrder, factors=None
) -> Atlas:
    """Put the charts on pages; ``factors`` on their densities, as of `halve_even_charts`."""
    fronts = [each for each in surfaces if not each.is_back]
    place = {each.key: number for number, each in enumerate(fronts)}
    return arrange(
        [each.mesh for each in fronts],
        charts,
        [each.density for each in fronts],
        largest=order.largest,
        pages=order.pages,
        margin=order.margin,
        two_sided=tuple(place[each.key] for each in surfaces if each.is_back),
        factors=factors,
    )


def find_lumels(
    surfaces: list[BakedSurface], atlas: Atlas, compiled, seed: int, cancelled, notes: Notes
) -> Ground:
    """Find the lumels of an atlas, and where light can reach them.

    Raises
    ------
    SceneError    There are none.
    """
    notes.name_stage("finding lumels")
    table = LumelTable([each.mesh for each in surfaces], atlas)
    if sum(table.counts) == 0:
        raise SceneError("no lumel lies on the surfaces of the objects; raise the lumels per metre")

    def report(number: int, count: int) -> None:
        notes.name_stage(f"finding lumels, {100 * number // count} %")

    table.validate(compiled, cancelled, report, seed)
    if not table.survey.valid.any():
        raise SceneError("all lumels lie inside solids: nothing of the objects can be seen")
    return Ground(surfaces, atlas, table)
