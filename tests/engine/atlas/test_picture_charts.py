"""Pictures on charts of a mesh: look-ups between texels show what the surface has there, and nothing of other charts."""

import numpy as np
import pytest

from lumenray.engine.atlas.picture_charts import LARGEST, lay_charts
from lumenray.engine.scene.mesh import Mesh

PLACES = 20_000
"""Places of a surface that are looked at."""


def mesh_of(vertices, triangles):
    triangles = np.asarray(triangles, np.int32)
    slots = np.zeros(len(triangles), np.int32)
    return Mesh("mesh", "Mesh", np.asarray(vertices, float), triangles, ("",), slots)


def box():
    corners = np.stack(np.meshgrid([0, 1], [0, 2], [0, 0.3], indexing="ij"), -1).reshape(-1, 3)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return mesh_of(corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def ball(rings=12):
    polar, around = np.meshgrid(
        np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, 2 * rings + 1), indexing="ij"
    )
    vertices = np.stack(
        [np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], -1
    ).reshape(-1, 3)
    width = 2 * rings + 1
    first = (np.arange(rings)[:, None] * width + np.arange(2 * rings)).ravel()
    lower = np.stack([first, first + width, first + width + 1], -1)
    upper = np.stack([first, first + width + 1, first + 1], -1)
    return mesh_of(vertices, np.concatenate([lower, upper]))


def slivers():
    """Long thin triangles, askew, all in one plane."""
    start = np.linspace(0, 1, 41)
    vertices = [(x + 0.4 * y, y * 3.0, 0.0) for y in (0.0, 1.0) for x in start]
    quads = [(k, k + 1, k + 42, k + 41) for k in range(40)]
    return mesh_of(vertices, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def crumbs():
    """Loose triangles of many sizes that face everywhere."""
    random = np.random.default_rng(5)
    size = 10.0 ** random.uniform(-2, 0, (300, 1, 1))
    corners = random.normal(size=(300, 3, 3)) * size + random.normal(size=(300, 1, 3)) * 3
    return mesh_of(corners.reshape(-1, 3), np.arange(900).reshape(300, 3))


SHAPES = {"box": box, "ball": ball, "slivers": slivers, "crumbs": crumbs}


def look_up(picture, charts, triangle, weights):
    """What a picture shows at places of triangles, mixed between texels as the engine does. (n, c)"""
    uv = np.einsum("ncx,nc->nx", charts.texture_coordinates[triangle].astype(float), weights)
    height, width = picture.shape[:2]
    x, y = uv[:, 0] * width - 0.5, uv[:, 1] * height - 0.5
    left, low = np.floor(x).astype(int), np.floor(y).astype(int)
    total = 0.0
    for dx, dy in np.ndindex(2, 2):
        weight = np.abs(1 - dx - (x - left)) * np.abs(1 - dy - (y - low))
        row, column = np.clip(low + dy, 0, height - 1), np.clip(left + dx, 0, width - 1)
        total = total + weight[:, None] * picture[row, column]
    return total


def places(mesh):
    random = np.random.default_rng(7)
    area = mesh.areas()
    triangle = random.choice(len(area), PLACES, p=area / area.sum())
    return triangle, random.dirichlet(np.ones(3), PLACES)


@pytest.mark.parametrize("factor", [1, 4])
@pytest.mark.parametrize("name", SHAPES)
def test_a_value_that_is_linear_on_the_surface_is_seen_as_it_is(name, factor):
    mesh = SHAPES[name]()
    charts = lay_charts(mesh)
    texels = charts.texels(factor)
    corners = mesh.vertices[mesh.triangles].astype(np.float32)
    picture = texels.lay(texels.interpolate(corners))
    triangle, weights = places(mesh)
    seen = look_up(picture, charts, triangle, weights)
    true = np.einsum("ncx,nc->nx", corners[triangle].astype(float), weights)
    step = np.sqrt(mesh.areas().sum() / len(texels))
    # Beside its edge a chart goes on with what it has there: less than a step of a texel is lost.
    assert np.abs(seen - true).max() < 2.0 * step
    assert np.abs(seen - true).mean() < 0.1 * step * (4 if name == "crumbs" else 1)


@pytest.mark.parametrize("factor", [1, 2])
@pytest.mark.parametrize("name", SHAPES)
def test_no_look_up_reads_a_texel_that_nothing_fills(name, factor):
    mesh = SHAPES[name]()
    charts = lay_charts(mesh)
    texels = charts.texels(factor)
    values = np.ones((len(texels), 1), np.float32)
    picture = texels.lay(values)
    empty = np.ones(picture.shape[0] * picture.shape[1], bool)
    empty[texels.index] = False
    picture.reshape(-1)[empty] = -100.0
    seen = look_up(picture, charts, *places(mesh))
    assert seen.min() > 1.0 - 1e-4


def test_nothing_of_other_charts_is_seen():
    mesh = box()
    charts = lay_charts(mesh)
    texels = charts.texels(1)
    corners = mesh.vertices[mesh.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    sides = np.repeat(normal[:, None], 3, axis=1).astype(np.float32)
    triangle, weights = places(mesh)
    seen = look_up(texels.lay(texels.interpolate(sides)), charts, triangle, weights)
    np.testing.assert_allclose(seen, normal[triangle], atol=1e-5)


def test_what_no_look_up_reads_has_the_mean():
    charts = lay_charts(ball())
    texels = charts.texels(1)
    values = np.random.default_rng(1).random((len(texels), 3)).astype(np.float32)
    assert texels.lay(values).mean(axis=(0, 1)) == pytest.approx(values.mean(axis=0), rel=1e-4)


def test_a_mesh_without_area_has_no_charts():
    assert lay_charts(mesh_of(np.zeros((3, 3)), [(0, 1, 2)])) is None


def test_a_page_is_no_larger_than_may_be():
    charts = lay_charts(crumbs())
    assert max(charts.width, charts.height) <= LARGEST
