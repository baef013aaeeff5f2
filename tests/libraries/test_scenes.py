"""The bundled scenes build, are sound geometry, and are stated in physical units."""

from itertools import pairwise

import bpy
import numpy as np
import pytest
from mathutils import Vector

from lumenray.libraries.scenes import NAMES, scene_path
from lumenray.tools.libraries.scenes import build

pytestmark = pytest.mark.usefixtures("empty_file")

BAKED = {"Ceiling", "Floor", "Desk Top A", "Desk Top B"} | {
    f"Wall {side}" for side in ("North", "East", "South", "West")
}


@pytest.fixture(scope="module")
def saved(registered, tmp_path_factory):
    """Build and save all scenes once; each test opens the file it needs."""
    folder = tmp_path_factory.mktemp("scenes")
    return {path.stem: path for path in build.save_scenes(folder=folder)}


@pytest.fixture(params=build.BUILDERS)
def scene(request, saved):
    return _opened(saved, request.param)


@pytest.fixture
def office(saved):
    return _opened(saved, "office")


def _opened(saved, name):
    bpy.ops.wm.open_mainfile(filepath=str(saved[name]))
    bpy.context.view_layer.update()
    return bpy.context.scene


def _meshes(scene):
    return [item for item in scene.objects if item.type == "MESH"]


def _triangles(item):
    mesh = item.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    mesh.calc_loop_triangles()
    corners = np.empty(len(mesh.loop_triangles) * 3, np.int32)
    mesh.loop_triangles.foreach_get("vertices", corners)
    points = np.empty(len(mesh.vertices) * 3)
    mesh.vertices.foreach_get("co", points)
    return points.reshape(-1, 3)[corners.reshape(-1, 3)]


def _shapes_of(mesh):
    """Yield the faces of each connected shape of an open bmesh."""
    seen = set()
    for start in mesh.faces:
        if start in seen:
            continue
        shape, front = [], [start]
        seen.add(start)
        while front:
            face = front.pop()
            shape.append(face)
            beside = {f for edge in face.edges for f in edge.link_faces} - seen
            seen |= beside
            front += beside
        yield shape


def test_every_named_scene_has_a_builder():
    assert set(NAMES) == set(build.BUILDERS)
    assert all(scene_path(name).name == f"{name}.blend" for name in NAMES)


def test_unknown_scene_is_refused():
    with pytest.raises(KeyError):
        scene_path("cathedral")


@pytest.mark.slow
def test_every_scene_has_a_camera_and_a_light(scene):
    assert scene.camera is not None
    assert any(item.type == "LIGHT" for item in scene.objects)


def test_every_object_has_a_material_and_a_uv_map(scene):
    for item in _meshes(scene):
        assert item.data.materials, item.name
        assert all(item.data.materials), item.name
        assert item.data.uv_layers, item.name


def test_every_light_is_stated_in_photometric_units(scene):
    for item in scene.objects:
        if item.type == "LIGHT":
            assert item.data.lumenray.use_physical, item.name
            assert item.data.lumenray.value > 0.0, item.name


def test_every_image_is_packed(scene):
    images = [image for image in bpy.data.images if image.type == "IMAGE"]
    assert all(image.packed_file for image in images)
    assert all(max(image.size) <= 1024 for image in images)


def test_every_triangle_is_finite_and_has_an_area(scene):
    for item in _meshes(scene):
        triangles = _triangles(item)
        assert np.isfinite(triangles).all(), item.name
        edges = triangles[:, 1:] - triangles[:, :1]
        areas = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
        # A tenth of a millimetre squared; the keys and the mouse have the smallest faces.
        assert areas.min() > 1e-8, item.name


def test_normals_of_closed_shapes_point_outwards(scene):
    import bmesh

    for item in _meshes(scene):
        mesh = bmesh.new()
        mesh.from_mesh(item.data)
        for shape in _shapes_of(mesh):
            if any(len(edge.link_faces) != 2 for face in shape for edge in face.edges):
                continue
            base = shape[0].verts[0].co
            volume = 0.0
            for face in shape:
                a, *others = [vertex.co - base for vertex in face.verts]
                for b, c in pairwise(others):
                    volume += a.dot(b.cross(c))
            assert volume > 0.0, item.name
        mesh.free()


def test_office_has_the_size_that_was_planned(office):
    count = sum(len(_triangles(item)) for item in _meshes(office))
    assert 50_000 <= count <= 200_000
    assert len(office.objects) < 250


def test_office_file_is_small(saved):
    assert saved["office"].stat().st_size < 6e6


def test_office_marks_what_is_to_be_baked(office):
    baked = bpy.data.collections["Bake"].objects
    assert {item.name for item in baked} == BAKED
    for item in baked:
        triangles = _triangles(item)
        edges = triangles - np.roll(triangles, 1, axis=1)
        # No slivers: the shortest height of a triangle is wider than a centimetre.
        area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
        longest = np.linalg.norm(edges, axis=2).max(axis=1)
        assert (2.0 * area / longest).min() > 0.01, item.name


def test_office_surfaces_face_the_room(office):
    middle = Vector((2.7, 2.1, 1.4))
    for name in BAKED - {"Desk Top A", "Desk Top B"}:
        face = bpy.data.objects[name].data.polygons[0]
        assert face.normal.dot(middle - face.center) > 0.0, name


def test_office_panels_shine_down_unobstructed(office):
    graph = bpy.context.evaluated_depsgraph_get()
    panels = [item for item in office.objects if item.type == "LIGHT" and item.data.type == "AREA"]
    assert len(panels) == 4
    for item in panels:
        start = item.matrix_world.translation
        down = item.matrix_world.to_3x3() @ Vector((0.0, 0.0, -1.0))
        assert down.z < -0.999
        hit, at, *_ = office.ray_cast(graph, start, down)
        assert hit
        assert (at - start).length > 0.3, item.name


def test_office_lights_are_in_the_room_and_clear_of_geometry(office):
    graph = bpy.context.evaluated_depsgraph_get()
    for item in office.objects:
        if item.type != "LIGHT":
            continue
        at = item.matrix_world.translation
        assert 0.0 < at.x < 5.4, item.name
        assert 0.0 < at.y < 4.2, item.name
        assert 0.0 < at.z < 2.81, item.name
        if item.data.type != "POINT":
            continue
        for direction in np.random.default_rng(3).normal(size=(400, 3)):
            hit, point, *_ = office.ray_cast(graph, at, Vector(direction).normalized())
            if hit:
                assert (point - at).length > item.data.shadow_soft_size + 0.003, item.name


def test_office_lets_no_light_in_but_through_the_window(office):
    graph = bpy.context.evaluated_depsgraph_get()
    rng = np.random.default_rng(9)
    for start in ((2.7, 1.0, 1.5), (0.5, 3.9, 1.9), (4.7, 1.2, 0.4)):
        for direction in rng.normal(size=(1500, 3)):
            hit, at, *_ = office.ray_cast(graph, Vector(start), Vector(direction).normalized())
            assert hit
            assert -0.01 < at.x < 5.53, at
            assert -0.01 < at.y < 4.44, at
            assert -0.01 < at.z < 3.16, at


@pytest.mark.slow
def test_two_builds_of_the_office_are_alike(saved):
    prints = []
    for _ in range(2):
        build.build_scene("office")
        total = {item.name: _triangles(item).sum() for item in _meshes(bpy.context.scene)}
        prints.append(total)
    assert prints[0] == prints[1]


def test_point_is_a_metre_above_the_receiver(saved):
    scene = _opened(saved, "inverse_square")
    point = scene.objects["Point"]
    assert point.data.lumenray.value == 100.0
    assert point.location.z - scene.objects["Receiver"].location.z == 1.0


def test_box_is_closed(saved):
    scene = _opened(saved, "closed_box")
    graph = bpy.context.evaluated_depsgraph_get()
    start = scene.objects["Point"].location
    for direction in np.random.default_rng(1).normal(size=(500, 3)):
        hit, at, normal, *_ = scene.ray_cast(graph, start, Vector(direction).normalized())
        assert hit
        assert normal.dot(start - at) > 0.0
