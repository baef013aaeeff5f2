"""Bodies of luminaires: closed, of the housing's size, and around the opening."""

import bpy
import numpy as np
import pytest

from lumenray.blender_addon.luminaires import body

pytestmark = pytest.mark.usefixtures("extension")


def test_bodies_have_the_size_of_the_housing_in_the_scenes_unit(write_photometry):
    bpy.context.scene.unit_settings.scale_length = 0.01
    bpy.ops.lumenray.add_luminaire(filepath=write_photometry())
    size = bpy.context.object.instance_collection.objects[0].dimensions
    assert tuple(size) == pytest.approx((120.0, 30.0, 0.1), rel=1e-5)


@pytest.mark.parametrize(
    ("shape", "size", "axis", "area"),
    [
        ("rectangle", (0.4, 0.2, 0.0), "z", 0.08),
        ("ellipse", (0.4, 0.0, 0.4), "y", np.pi * 0.04),
        ("box", (0.4, 0.2, 0.1), "z", 0.08),
        ("cylinder", (1.2, 0.1, 0.1), "x", 0.12),
        ("ellipsoid", (0.3, 0.3, 0.3), "z", np.pi * 0.0225),
    ],
)
def test_bodies_are_closed_and_face_outwards(shape, size, axis, area):
    import bmesh

    from lumenray.engine.scene.distribution import Opening

    class Plain:
        opening = Opening(shape, size, axis)
        housing = None

    mesh = bmesh.new()
    mesh.from_mesh(body.build_body(Plain, "body", 1.0))
    assert all(edge.is_manifold for edge in mesh.edges)
    volume = mesh.calc_volume(signed=True)
    assert volume > 0.0
    down = sum(f.calc_area() * max(-f.normal.z, 0.0) for f in mesh.faces)
    assert down == pytest.approx(max(area if axis != "y" else 0.4 * body.THIN, 0.0), rel=0.02)


def test_a_housing_ends_with_the_opening():
    from lumenray.engine.scene.distribution import Opening

    class Round:
        opening = Opening("ellipse", (0.2, 0.2, 0.0))
        housing = (0.3, 0.0, 0.1)

    least, largest = body.body_extent(Round)
    np.testing.assert_allclose(least, (-0.15, -0.15, -0.5 * body.THIN))
    np.testing.assert_allclose(largest, (0.15, 0.15, 0.1 - 0.5 * body.THIN))
