"""From where on a ray set is a point: its virtual focus, its error by distance, and how near objects come."""

import numpy as np
import pytest

from lumenray.benchmarks.common.ray_sources import RADIUS, disk, even_numbers, numbers, sphere
from lumenray.engine.analysis.explanation import explain_rays
from lumenray.engine.raysets.beam_cells import BeamCells
from lumenray.engine.raysets.cloud import Drawn
from lumenray.engine.raysets.emission import FAR, NEAR, far_errors, find_focus, near_distance
from lumenray.engine.raysets.record import Rays
from lumenray.engine.scene.distribution import IntensityDistribution
from lumenray.engine.scene.light import Luminaire, Output, Quantity
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.nearness import box_distance, mesh_distance
from lumenray.engine.scene.ray_emission import DirectionWeight, RayBody, RayEmission
from lumenray.engine.scene.scene import Scene, SceneDelta

SIZE = 2.0 * RADIUS


def rays_of(position, direction):
    return Rays(position, direction, np.ones(len(position), np.float32))


# ---- focus ----


def test_the_focus_of_rays_on_a_dome_is_where_they_come_from():
    """Rays of a point that are told where they cross a sphere about another place."""
    position, direction = sphere(even_numbers(4000, 1))
    direction = position + np.array([0.0, 0.0, 0.3 * RADIUS], np.float32)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    focus = find_focus(rays_of(position, direction))
    np.testing.assert_allclose(focus, [0.0, 0.0, -0.3 * RADIUS], atol=0.01 * RADIUS)


def test_parallel_rays_leave_the_focus_in_their_middle():
    position, direction = disk(even_numbers(4000, 1))
    direction = np.tile(np.array([[0.0, 0.0, 1.0]], np.float32), (4000, 1))
    focus = find_focus(rays_of(position + np.float32(0.01), direction))
    np.testing.assert_allclose(focus, 0.01, atol=0.01 * RADIUS)


# ---- the error of a point ----


def drawn(source, count=1 << 20):
    # As generated rays are: their scatter is that of chance.
    position, direction = (each.astype(np.float64) for each in source(numbers(count, 1)))
    return [Drawn(position, direction, np.full(count, 1.0 / count), None)]


@pytest.mark.slow
def test_a_sphere_is_a_point_everywhere_and_a_disk_as_the_formula_says():
    """Outside a Lambertian sphere its light is a point's. The disk's falls with the square of the distance."""
    distances = np.array([1.0, 2.0, 4.0]) * SIZE
    # 2700 rays a cell leave 1 % of chance.
    assert far_errors(drawn(sphere), np.zeros(3), distances).max() < 0.015
    errors = far_errors(drawn(disk), np.zeros(3), distances)
    # Relative to a point, on the axis: 1 / (1 + (R / d)^2), so 5.9 % too much at two sizes; towards the rim too little.
    assert 0.01 < errors[1] < 0.059
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.25)


@pytest.mark.slow
def test_narrow_beams_are_near_for_long():
    """A beam of a few degrees from a disk: at five sizes the light has the disk's shape still."""
    pieces = drawn(disk)
    narrow = pieces[0].direction * np.array([0.05, 0.05, 1.0])
    narrow /= np.linalg.norm(narrow, axis=1, keepdims=True)
    beam = [Drawn(pieces[0].position, narrow, pieces[0].flux, None)]
    distances = np.array(FAR) * SIZE
    errors = far_errors(beam, np.zeros(3), distances)
    assert errors[FAR.index(5.0)] > 0.3
    near = near_distance(distances, errors)
    # What is left beyond 20 sizes falls with the square at most, whatever chance says of it.
    late = errors[FAR.index(20.0)]
    assert near >= 20.0 * SIZE * np.sqrt(late / 0.01) * 0.999


def test_the_near_distance_lies_between_five_sizes_and_the_last_distance():
    distances = np.array(FAR)
    assert near_distance(distances, np.full(len(FAR), 1e-4)) == NEAR
    assert near_distance(distances, np.full(len(FAR), 0.5)) == FAR[-1]
    # An error that falls with the square is 1 % at sqrt(2.5) x 10 sizes.
    assert near_distance(distances, 2.5 / distances**2) == pytest.approx(np.sqrt(250.0), rel=1e-6)


def test_cells_of_a_beam_have_equal_light_however_narrow():
    for squeeze in (1.0, 0.02):
        position, direction = disk(even_numbers(1 << 16, 1))
        direction = direction * np.array([squeeze, squeeze, 1.0], np.float32)
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        weight = np.ones(len(position))
        cells = BeamCells(position, direction, weight, np.zeros(3), np.inf, 6, 8)
        share = cells.shares(position, direction, weight, np.inf)
        np.testing.assert_allclose(share, 1.0 / 48.0, rtol=0.05)


# ---- how near objects come ----


def patch(name, corner, u, v):
    corner, u, v = (np.asarray(each, float) for each in (corner, u, v))
    vertices = np.stack([corner, corner + u, corner + u + v, corner + v])
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    return Mesh(name, name, vertices, triangles, ("paint",), np.zeros(2, np.int32))


def test_distances_to_triangles_are_those_of_their_nearest_points():
    rng = np.random.default_rng(1)
    for _ in range(40):
        mesh = patch("p", *rng.standard_normal((3, 3)))
        point = rng.standard_normal(3) * 2.0
        u, v = (x.ravel()[:, None] for x in np.meshgrid(*[np.linspace(0, 1, 300)] * 2))
        first, second, _, fourth = mesh.vertices
        places = first + u * (second - first) + v * (fourth - first)
        brute = np.linalg.norm(places - point, axis=1).min()
        found = mesh_distance(point, mesh)
        assert found <= brute + 1e-12
        assert found == pytest.approx(brute, abs=0.01)
        assert box_distance(point, mesh) <= found + 1e-12


def test_triangles_without_area_count_by_their_edges():
    mesh = patch("p", (1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0))
    assert mesh_distance(np.zeros(3), mesh) == pytest.approx(1.0)


def test_a_scene_is_explained_object_by_object():
    zeros = np.zeros(3)
    rays = RayEmission(
        position=np.zeros((1, 3), np.float32),
        direction=np.array([[0, 0, -1]], np.float32),
        factor=np.zeros((1, 6, 6), np.float32),
        threshold=np.ones(1, np.float32),
        other=np.zeros(1, np.uint32),
        wavelength=None,
        body=RayBody("plane", zeros, zeros, True, 0.0, np.zeros((0, 5), np.float32)),
        axis=None,
        weight=DirectionWeight.even(),
        size=0.1,
        half=np.full(3, 0.05),
        near=0.5,
        information_error=0.03,
        far_distances=np.array([0.1, 1.0]),
        far_errors=np.array([0.1, 0.001]),
    )
    frame = np.eye(4)
    frame[2, 3] = 1.0
    even = IntensityDistribution(np.zeros(1), np.array([0.0, np.pi]), np.ones((1, 2)))
    lamp = Luminaire("lamp", "Lamp", Output(Quantity.LUMINOUS_FLUX, 5.0), frame, even, rays=rays)
    scene = Scene()
    near = patch("near", (-1, -1, 0.8), (2, 0, 0), (0, 2, 0))
    far = patch("far", (-1, -1, 0.0), (2, 0, 0), (0, 2, 0))
    scene.apply(SceneDelta(changed=(near, far, lamp)))
    first, second = explain_rays(scene)
    assert (first.receiver, first.method, second.receiver, second.method) == (
        "near",
        "rays",
        "far",
        "point",
    )
    assert first.nearest == pytest.approx(0.2)
    assert first.sizes == pytest.approx(2.0)
    assert first.error == 0.03
    # On the line through the logarithms: 0.1 at 0.1 m, 0.001 at 1 m.
    assert first.point_error == pytest.approx(0.1 * (0.2 / 0.1) ** -2)
    assert second.error == second.point_error == pytest.approx(0.001)
    assert float(rays.point_errors(0.01)) == pytest.approx(0.1)
