"""A baked room without a bake: walls and a floor laid out by hand, with illuminance in closed form."""

from dataclasses import replace

import numpy as np
from gltf_files import GltfFile
from small_scenes import quad

from lumenray.engine.accuracy.extremes import Extreme
from lumenray.engine.accuracy.history import History
from lumenray.engine.baking.order import AtlasPage, BakeResult, Layout, LuxMap, Seams
from lumenray.engine.formats.gltf import write_gltf
from lumenray.engine.scene.material import Diffuse, Emission, Material, ThinGlass
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.provenance import Provenance
from lumenray.engine.scene.spectrum import Constant, Rgb

DENSITY = 32.0
"""Lumels per metre."""

MARGIN = 4
"""Free rim of charts. [lumel]"""

INTENSITY = 2000.0
"""Of the lamp, the same in all directions. [cd]"""

COLOURS = {"red": (0.6, 0.15, 0.1), "green": (0.2, 0.5, 0.25), "grey": (0.4, 0.4, 0.4)}
"""Reflectances, linear Rec. 709."""

PROVENANCE = Provenance("0.1.0", "llvm_spectral", "c0ffee", 7, 4096, 12.5)


def lamp_light(points, normal, lamp):
    """Illuminance from a lamp that shines alike in all directions: E = I cos / d^2. [m -> lx]"""
    away = np.asarray(lamp) - points
    distance = np.linalg.norm(away, axis=-1)
    return INTENSITY * np.maximum(away @ np.asarray(normal, float), 0.0) / distance**3


class Sheet:
    """One mesh of a single rectangle: where it stands, and which page it lies on."""

    def __init__(self, name, corner, edge_u, edge_v, material, page):
        self.mesh = quad(name, corner, edge_u, edge_v, material)
        self.corner, self.u, self.v = (np.asarray(x, float) for x in (corner, edge_u, edge_v))
        normal = np.cross(self.u, self.v)
        self.normal = normal / np.linalg.norm(normal)
        self.page = page
        self.size = np.array([np.linalg.norm(self.u), np.linalg.norm(self.v)]) * DENSITY

    def points(self, shares):
        """Places in the world of shares (..., 2) of the edges."""
        return self.corner + shares[..., :1] * self.u + shares[..., 1:] * self.v


def room(offset=(0.0, 0.0, 0.0)):
    """Floor and two walls; the floor on page 0, the walls on page 1."""
    o = np.asarray(offset, float)
    return [
        Sheet("floor", o, (4, 0, 0), (0, 3, 0), "grey", 0),
        Sheet("back wall", np.add(o, (0, 3, 0)), (4, 0, 0), (0, 0, 2.5), "red", 1),
        Sheet("left wall", o, (0, 3, 0), (0, 0, 2.5), "green", 1),
    ], np.add(o, (1.5, 1.2, 2.0))


def bake(sheets, lamp, colour=None, size=(160, 256)):
    """Lay rectangles out one above the other on their pages and fill in the lamp's light.

    Parameters
    ----------
    colour : dict of str to (3,) or None    X, Y, Z reflectance by material, for the exitance.
    """
    width, height = size
    count = max(sheet.page for sheet in sheets) + 1
    lux = np.zeros((count, height, width), np.float32)
    covered = np.zeros(lux.shape, bool)
    charts = np.full(lux.shape, -1, np.int32)
    exitance = np.zeros((*lux.shape, 3), np.float32) if colour else None
    free, maps = [MARGIN] * count, []
    for number, sheet in enumerate(sheets):
        left, bottom = MARGIN, free[sheet.page]
        columns, rows = (int(n) for n in sheet.size)
        free[sheet.page] += rows + 2 * MARGIN
        # The rim has what the surface would have there.
        x, y = np.meshgrid(np.arange(-MARGIN, columns + MARGIN), np.arange(-MARGIN, rows + MARGIN))
        values = lamp_light(
            sheet.points(np.stack([x + 0.5, y + 0.5], -1) / sheet.size), sheet.normal, lamp
        )
        rim = (sheet.page, slice(bottom - MARGIN, bottom + rows + MARGIN), slice(0, x.shape[1]))
        lux[rim] = values
        charts[rim] = number
        covered[sheet.page, bottom : bottom + rows, left : left + columns] = True
        if colour:
            exitance[rim] = values[..., None] * np.asarray(colour[sheet.mesh.materials[0]])
        inner = values[MARGIN:-MARGIN, MARGIN:-MARGIN]
        uv = (np.array([left, bottom]) + sheet.mesh.uv_maps["UV"] * sheet.size) / size
        maps.append(make_map(sheet.mesh, number, inner, uv, np.full(2, sheet.page)))
    pages = tuple(
        make_page(i, lux[i], covered[i], charts[i], None if exitance is None else exitance[i])
        for i in range(count)
    )
    return make_result(maps, pages)


def make_map(mesh: Mesh, number, values, uv, page):
    """Lux map of a mesh with one lumel per value."""
    layout = Layout(
        uv.astype(np.float32), page.astype(np.int32), mesh.triangles, None, len(mesh.vertices)
    )
    return LuxMap(
        id=mesh.id,
        name=mesh.name,
        number=number,
        lumels=values.size,
        charts=1,
        mean=float(values.mean()),
        least=Extreme(float(values.min()), 0.9 * float(values.min()), 1.1 * float(values.min())),
        largest=Extreme(float(values.max()), 0.9 * float(values.max()), 1.1 * float(values.max())),
        relative_standard_error=0.01,
        mean_standard_error=0.5,
        bias=0.0,
        bias_error=0.0,
        samples=4096.0,
        density=DENSITY,
        requested_density=DENSITY,
        area=values.size / DENSITY**2,
        invalid=0,
        provenance=PROVENANCE,
        layout=layout,
    )


def make_page(number, lux, covered, chart, exitance=None):
    """Page of given values."""
    height, width = lux.shape
    return AtlasPage(
        number=number,
        width=width,
        height=height,
        illuminance=lux,
        standard_error=0.01 * lux,
        covered=covered,
        area=covered / np.float32(DENSITY**2),
        object=np.where(covered, 0, -1).astype(np.int32),
        chart=chart,
        layers={},
        exitance=exitance,
        replicates=16,
        freedom=27.0,
    )


def make_result(maps, pages):
    """Result of a bake."""
    return BakeResult(
        maps=tuple(maps),
        pages=tuple(pages),
        departures=(),
        files=(),
        history=History(),
        relative_standard_error=0.01,
        quadratic_relative_error=0.01,
        mean=float(np.mean([made.mean for made in maps])),
        shrink=1.0,
        seams=Seams(0, 0.0, 0.0, 0.0),
    )


def materials():
    """Materials of the room, by id, with a glowing one and a pane."""
    paints = [Material(name, name, Diffuse(Rgb(*rgb))) for name, rgb in COLOURS.items()]
    lamp = Material("glow", "glow", Diffuse(Constant(0.0)), Emission(Constant(1.0), 90.0))
    return {m.id: m for m in (*paints, lamp, Material("glass", "glass", ThinGlass()))}


def without_pages(result):
    """Return the result as a bake leaves it that keeps its pages in files."""
    return replace(
        result,
        pages=tuple(replace(p, illuminance=None, covered=None, chart=None) for p in result.pages),
    )


WHITE = 150.0
"""Luminance that is shown as white. [cd/m2]"""


def write_room(tmp_path, sheets, lamp, name="room.glb", **options):
    """Write a baked room as glTF and return what a reader makes of it."""
    result = bake(sheets, lamp, options.pop("colour", None))
    more = options.pop("more", ())
    path = tmp_path / name
    meshes = [sheet.mesh for sheet in sheets] + list(more)
    files = write_gltf(path, meshes, materials(), result, **{"white": WHITE, **options})
    assert files[0] == path
    assert all(file.exists() for file in files)
    file = GltfFile(path)
    file.check()
    return file


def look_up(picture, uv):
    """Value of the texel that a coordinate falls on; glTF counts v downwards from the first row."""
    height, width = picture.shape[:2]
    return picture[int(uv[1] * height), int(uv[0] * width)]


def places_inside(file, primitive, node, count=40):
    """Yield world places (Z up) inside a primitive's triangles, with their coordinates on the texture."""
    generator = np.random.default_rng(1)
    places, uv = file.corners(node, primitive)
    for _ in range(count):
        i = generator.integers(len(places))
        weights = generator.dirichlet((1.0, 1.0, 1.0))
        x, y, z = weights @ places[i]
        yield np.array([x, -z, y]), weights @ uv[i]
