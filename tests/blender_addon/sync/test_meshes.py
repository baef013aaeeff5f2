"""Objects of the scene: their outsides, what is hidden, and instances."""

import bpy
import numpy as np
import pytest
from blender_objects import add_cube
from conversion import converted_scene

from lumenray.engine.scene.scene import Scene

pytestmark = pytest.mark.usefixtures("extension")


def meshes():
    bpy.context.view_layer.update()
    scene = Scene()
    scene.apply(converted_scene().delta)
    return [scene.mesh(key) for key in scene.meshes]


def signed_volume(mesh):
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0


@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 1, 1), (-1, -1, -1), (2, -3, 1)])
def test_mirrored_objects_keep_their_outside_outside(scale):
    item = add_cube(scale=scale)
    for polygon in item.data.polygons:
        polygon.use_smooth = True
    (mesh,) = meshes()
    assert signed_volume(mesh) == pytest.approx(8.0 * abs(np.prod(scale)))
    corners = mesh.vertices[mesh.triangles]
    assert (np.einsum("tcx,tcx->tc", corners, mesh.corner_normals) > 0).all()


def test_hidden_objects_stay_out_and_instances_come_in():
    hidden = add_cube()
    hidden.hide_render = True
    group = bpy.data.collections.new("Group")
    member = add_cube(location=(5, 0, 0))
    bpy.context.scene.collection.objects.unlink(member)
    group.objects.link(member)
    for i in range(3):
        empty = bpy.data.objects.new(f"Empty {i}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", group
        empty.location = (0, 10.0 * i, 0)
        bpy.context.scene.collection.objects.link(empty)
    made = meshes()
    assert len(made) == 3
    assert len({m.id for m in made}) == 3
    assert sorted(round(m.vertices[:, 1].mean()) for m in made) == [0, 10, 20]
