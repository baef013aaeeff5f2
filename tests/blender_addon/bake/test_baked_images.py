"""What a bake leaves in Blender's file: UV maps, images with their facts, and layers that add up."""

import bpy
import numpy as np
import pytest
from blender_bakes import add_lamp, bake_all
from blender_objects import add_quad, pixels_of
from fake_bakes import ERROR, lay_out, make_map, make_page, make_result

from lumenray.blender_addon.bake import images as baked_images
from lumenray.blender_addon.bake import uv_maps as baked_layout
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.scene.scene import Scene

pytestmark = pytest.mark.usefixtures("extension")


def uv_of(item, name=baked_layout.UV_MAP):
    layer = item.data.uv_layers[name]
    values = np.empty(2 * len(layer.uv), np.float32)
    layer.uv.foreach_get("vector", values)
    return values.reshape(-1, 2)


def test_one_page_becomes_one_image_and_the_uv_map_is_the_layout(fake_engine, tmp_path):
    floor = add_quad("Floor")
    bake_all(tmp_path)
    (mesh,) = [fake_engine.scene.mesh(key) for key in fake_engine.scene.meshes]
    layout = lay_out(mesh, 0)
    uv = uv_of(floor)
    # Corners of the quad by vertex, as its only polygon has each once.
    pairs = zip(layout.triangles.ravel(), layout.uv.reshape(-1, 2), strict=True)
    expected = {int(vertex): tuple(place) for vertex, place in pairs}
    for corner, place in zip(floor.data.loops, uv, strict=True):
        assert place == pytest.approx(expected[corner.vertex_index], abs=1e-6)
    image = floor.lumenray.baked_image
    assert image.name == "Lux atlas"
    assert image.is_float
    assert image.colorspace_settings.name == "Non-Color"
    assert image.packed_file is not None
    np.testing.assert_array_equal(pixels_of(image)[..., 0], make_page(0).illuminance)
    facts = image["lumenray"]
    assert facts["unit"] == "lx"
    assert facts["quantity"] == "illuminance"
    assert facts["scene_hash"] == fake_engine.scene.hash()
    assert facts["relative_standard_error"] == ERROR
    assert facts["samples"] == 64.0


def test_several_pages_become_tiles_that_survive_saving(fake_engine, tmp_path):
    quads = [add_quad(f"Quad {number:02d}", 2.0 * number) for number in range(12)]
    bake_all(tmp_path / "lux")
    image = quads[0].lumenray.baked_image
    assert [tile.number for tile in image.tiles] == [1001 + number for number in range(12)]
    for number, quad in enumerate(quads):
        uv = uv_of(quad)
        assert (np.floor(uv) == (number % 10, number // 10)).all()
    path = tmp_path / "kept.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))
    image = bpy.data.objects["Quad 11"].lumenray.baked_image
    assert len(image.packed_files) == 12
    folder = tmp_path / "unpacked"
    folder.mkdir()
    for packed in image.packed_files:
        (folder / packed.filepath.rpartition("/")[2]).write_bytes(packed.packed_file.data)
    for number in (0, 11):
        (file,) = folder.glob(f"*{1001 + number}.exr")
        loaded = bpy.data.images.load(str(file))
        loaded.colorspace_settings.name = "Non-Color"
        np.testing.assert_array_equal(pixels_of(loaded)[..., 0], make_page(number).illuminance)


def test_layers_and_exitance_become_images_and_add_up(fake_engine, tmp_path):
    scene = bpy.context.scene
    floor = add_quad("Floor")
    add_lamp("Lamp A", "Ceiling")
    add_lamp("Lamp B", "Desk")
    scene.lumenray.bake.layers, scene.lumenray.bake.exitance = "GROUPS", True
    bake_all(tmp_path)
    layers = baked_images.layers_of(floor.lumenray.baked_image)
    assert list(layers) == ["Ceiling", "Desk", "rest"]
    assert layers["Desk"].name == "Lux atlas: Desk"
    total = sum(pixels_of(image)[..., 0] for image in layers.values())
    np.testing.assert_allclose(total, make_page(0).illuminance, rtol=1e-6)
    exitance = pixels_of(bpy.data.images["Exitance atlas"])[..., :3]
    # Equal X : Y : Z as daylight has: white, of the luminance Y.
    np.testing.assert_allclose(
        exitance, make_page(0).illuminance[..., None].repeat(3, 2), rtol=2e-3
    )
    assert exitance @ (0.2126, 0.7152, 0.0722) == pytest.approx(make_page(0).illuminance, rel=1e-3)
    assert [row.name for row in scene.lumenray.look.layers] == ["Ceiling", "Desk", "rest"]


def test_many_layers_are_put_together_without_losing_light(fake_engine, tmp_path):
    floor = add_quad("Floor")
    for number in range(9):
        add_lamp(f"Lamp {number}")
    bpy.context.scene.lumenray.bake.layers = "EACH"
    bake_all(tmp_path)
    layers = baked_images.layers_of(floor.lumenray.baked_image)
    assert len(layers) == baked_images.MOST_LAYERS
    assert baked_images.OTHERS in layers
    total = sum(pixels_of(image)[..., 0] for image in layers.values())
    np.testing.assert_allclose(total, make_page(0).illuminance, rtol=1e-5)
    rows = bpy.context.window_manager.lumenray.rows
    assert any("layers are more than" in row.message for row in rows)


def test_a_second_bake_of_other_objects_leaves_the_first_atlas_where_it_lies(fake_engine, tmp_path):
    first, second = add_quad("First"), add_quad("Second", 3.0)
    for names in ("First", "Second"):
        bpy.ops.lumenray.bake_illuminance(objects=names, folder=str(tmp_path))
    images = [item.lumenray.baked_image for item in (first, second)]
    assert images[0] != images[1]
    bake_all(tmp_path)
    # Nothing lies on the old ones any more.
    assert first.lumenray.baked_image == second.lumenray.baked_image
    assert len([image for image in bpy.data.images if baked_images.facts_of(image)]) == 1


def test_polygons_whose_triangles_lie_apart_are_reported():
    floor = add_quad("Floor")
    order = BakeOrder(("x",), StopRule(samples=1))
    scene = Scene()
    scene.apply(convert_scene(bpy.context.evaluated_depsgraph_get()).delta)
    (mesh,) = [scene.mesh(key) for key in scene.meshes]
    made = make_map(mesh, 0, 0, order)
    made.layout.uv[1] += 0.3
    report = ConversionReport()
    result = make_result([made], [make_page(0)])
    baked_layout.store_layouts(result, {mesh.id: floor}, report)
    assert any("1 faces with more than three corners" in row.message for row, _ in report.rows)


def test_triangles_without_a_place_do_not_spoil_their_neighbours(fake_engine, tmp_path):
    floor = add_quad("Floor")
    scene = Scene()
    scene.apply(convert_scene(bpy.context.evaluated_depsgraph_get()).delta)
    (mesh,) = [scene.mesh(key) for key in scene.meshes]
    layout = lay_out(mesh, 0)
    whole = baked_layout.match_corners(floor.data, layout, layout.uv)
    layout.page[0], layout.uv[0] = -1, 0.0
    part = baked_layout.match_corners(floor.data, layout, layout.uv)
    placed = {int(v) for v in layout.triangles[1]}
    for corner, (a, b) in zip(floor.data.loops, zip(whole.uv, part.uv, strict=True), strict=True):
        if corner.vertex_index in placed:
            assert b == pytest.approx(a)
    assert part.split == 0


def test_a_mesh_without_room_for_a_uv_map_is_reported(fake_engine, tmp_path):
    floor = add_quad("Floor")
    for number in range(8):
        floor.data.uv_layers.new(name=f"Map {number}")
    bake_all(tmp_path)
    rows = bpy.context.window_manager.lumenray.rows
    assert any("8 UV maps already" in row.message for row in rows)
    assert floor.lumenray.baked_image is None
