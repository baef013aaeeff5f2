"""Luminaires that are added and dropped: where they hang, which way they shine, and what is refused."""

import bpy
import numpy as np
import pytest
from blender_luminaires import body_of, extent_of
from conversion import converted_light
from photometric_files import FOUR

from lumenray.blender_addon.luminaires import body, placing

pytestmark = pytest.mark.usefixtures("extension")


def test_a_luminaire_is_added_at_the_cursor_shining_down(write_photometry):
    bpy.context.scene.cursor.location = (1.0, 2.0, 3.0)
    assert bpy.ops.lumenray.add_luminaire(filepath=write_photometry()) == {"FINISHED"}
    empty = bpy.context.object
    assert empty.type == "EMPTY"
    assert empty.name == "even"
    assert empty.select_get()
    light, _ = converted_light(empty)
    np.testing.assert_allclose(light.frame[:3, 3], (1, 2, 3))
    np.testing.assert_allclose(-light.frame[:3, 2], (0, 0, -1), atol=1e-7)
    assert placing.has_body(empty)
    least = np.min([v.co for v in empty.instance_collection.objects[0].data.vertices], axis=0)
    np.testing.assert_allclose(least[:2], (-0.6, -0.15), atol=1e-6)


def test_a_refused_file_adds_nothing(write_photometry):
    count = len(bpy.data.objects)
    with pytest.raises(RuntimeError, match="is not an IES LM-63 file"):
        bpy.ops.lumenray.add_luminaire(filepath=write_photometry("nothing"))
    good = write_photometry()
    with pytest.raises(RuntimeError, match=r"bad\.ies"):
        bpy.ops.lumenray.drop_luminaire(
            directory=good.removesuffix("even.ies"),
            files=[{"name": "even.ies"}, {"name": "bad.ies"}],
        )
    assert len(bpy.data.objects) == count
    assert not bpy.data.texts


def test_dropped_on_a_ceiling_several_hang_side_by_side(write_photometry, tmp_path):
    write_photometry()
    write_photometry(FOUR, "four.ies")
    done = bpy.ops.lumenray.drop_luminaire(
        directory=str(tmp_path),
        files=[{"name": "even.ies"}, {"name": "four.ies"}],
        point=(1.0, 0.0, 2.7),
        normal=(0.0, 0.0, -1.0),
        on_surface=True,
    )
    assert done == {"FINISHED"}
    first, second = sorted(bpy.context.selected_objects, key=lambda o: o.location.x)
    assert (first.name, second.name) == ("even", "four")
    for empty in (first, second):
        corners = [empty.matrix_world @ v.co for v in body_of(empty).vertices]
        top = max(corner.z for corner in corners)
        assert top == pytest.approx(2.7 - placing.CLEARANCE, abs=1e-6)
    gap = extent_of(second)[0] - extent_of(first)[1]
    assert gap == pytest.approx(placing.GAP, abs=1e-5)


@pytest.mark.parametrize(
    "normal", [(0, 0, -1), (0, 0, 1), (1, 0, 0), (0.6, -0.8, 0), (0, 0.6, 0.8)]
)
def test_dropped_on_a_surface_it_shines_along_the_normal(normal, write_photometry):
    bpy.ops.lumenray.drop_luminaire(
        filepath=write_photometry(), point=(1.0, 2.0, 3.0), normal=normal, on_surface=True
    )
    frame = converted_light(bpy.context.object)[0].frame
    np.testing.assert_allclose(-frame[:3, 2], normal, atol=1e-6)
    away = (frame[:3, 3] - (1, 2, 3)) @ normal
    assert away == pytest.approx(0.5 * body.THIN + placing.CLEARANCE, abs=1e-6)
    if abs(normal[2]) < 0.9:
        # On a wall the luminaire's y is up.
        assert frame[2, 1] > 0.5


def test_dropped_beside_everything_it_comes_to_the_cursor(write_photometry):
    bpy.context.scene.cursor.location = (4.0, 5.0, 6.0)
    bpy.ops.lumenray.drop_luminaire(filepath=write_photometry())
    assert tuple(bpy.context.object.location) == (4.0, 5.0, 6.0)


def test_luminaires_are_dropped_by_blenders_file_handler():
    handler = bpy.types.FileHandler.bl_rna_get_subclass_py("LUMENRAY_FH_luminaire")
    assert handler.bl_import_operator == "lumenray.drop_luminaire"
    assert handler.bl_file_extensions == ".ies;.ldt;.xml"
