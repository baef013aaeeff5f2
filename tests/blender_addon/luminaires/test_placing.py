"""The surface under the mouse."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from lumenray.blender_addon.luminaires import placing

pytestmark = pytest.mark.usefixtures("extension")


@pytest.mark.parametrize("is_perspective", [True, False])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_mouse_finds_the_surface_under_it(side, is_perspective):
    """Looking at a plane in z = 1 from above or below, with a view that is 2 units high there."""
    bpy.ops.mesh.primitive_plane_add(size=10.0, location=(0.0, 0.0, 1.0))
    bpy.context.view_layer.update()
    eye = Matrix.Translation((0.0, 0.0, 1.0 + 4.0 * side))
    if side < 0.0:
        eye = eye @ Matrix.Rotation(np.pi, 4, "X")
    lens = Matrix.Diagonal((1.0, 1.0, -0.1, 1.0))
    if is_perspective:
        lens = Matrix(((4, 0, 0, 0), (0, 4, 0, 0), (0, 0, -1, -0.2), (0, 0, -1, 0)))
    view = SimpleNamespace(
        view_matrix=eye.inverted(),
        perspective_matrix=lens @ eye.inverted(),
        window_matrix=lens,
        is_perspective=is_perspective,
        view_perspective="PERSP" if is_perspective else "ORTHO",
    )
    context = SimpleNamespace(
        region=SimpleNamespace(width=200, height=200),
        region_data=view,
        scene=bpy.context.scene,
        evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get,
    )
    mount = placing.mount_under(context, 150, 100)
    assert mount.is_surface
    assert mount.point == pytest.approx((0.5, 0.0, 1.0), abs=1e-4)
    # A ceiling is lit from, not through: the plane's own normal points up.
    assert mount.normal == pytest.approx((0.0, 0.0, side), abs=1e-6)
    view.view_matrix = Matrix.Translation((0.0, 0.0, -90.0)) @ eye.inverted()
    bpy.context.scene.cursor.location = (7.0, 8.0, 9.0)
    bpy.data.objects.remove(bpy.data.objects["Plane"])
    assert placing.mount_under(context, 150, 100) == placing.Mount((7.0, 8.0, 9.0))
    context.region_data = None
    assert placing.mount_under(context, 150, 100) == placing.Mount((7.0, 8.0, 9.0))
