"""Baked scenes as glTF: the format's rules, the geometry's places, limits, and what is refused."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from baked_rooms import (
    DENSITY,
    WHITE,
    bake,
    lamp_light,
    look_up,
    make_map,
    make_page,
    make_result,
    materials,
    places_inside,
    room,
    without_pages,
    write_room,
)
from gltf_files import GltfFile
from small_scenes import box, quad

from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.formats.gltf import GltfLimits, write_gltf
from lumenray.engine.scene.material import Diffuse, Material
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.spectrum import Constant


def test_a_scene_far_off_the_origin_keeps_its_shape(tmp_path):
    offset = np.array([12345.678, -9876.543, 432.1])
    sheets, lamp = room(offset)
    file = write_room(tmp_path, sheets, lamp)
    for node, primitive in file.primitives():
        sheet = next(s for s in sheets if s.mesh.name == node["name"])
        places, _ = file.corners(node, primitive)
        x, y, z = np.moveaxis(places, -1, 0)
        back = np.stack([x, -z, y], axis=-1)
        expected = sheet.mesh.vertices[sheet.mesh.triangles]
        # Single precision alone has steps of 1 mm there.
        assert np.abs(back - expected).max() < 2e-6
        assert all(np.float32(v) == v for v in node["translation"])


def test_triangles_look_to_the_same_side_and_normals_too(tmp_path):
    mesh = box(2.0, 3.0, 4.0, "grey", inwards=False)
    normals = np.repeat(face_normals(mesh)[:, None], 3, axis=1).astype(np.float32)
    mesh = replace(mesh, corner_normals=normals)
    file = write_box(tmp_path, mesh)
    ((node, primitive),) = file.primitives()
    places, _ = file.corners(node, primitive)
    outwards = np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0])
    centre = np.array([1.0, 2.0, -1.5])
    assert (((places.mean(axis=1) - centre) * outwards).sum(axis=1) > 0.0).all()
    normals = file.array(primitive["attributes"]["NORMAL"])[file.array(primitive["indices"])]
    outwards /= np.linalg.norm(outwards, axis=1, keepdims=True)
    assert np.allclose(normals.reshape(-1, 3, 3), outwards[:, None], atol=1e-6)
    # The faces are apart because of their normals, their own two triangles are not: 6 faces of 4 corners.
    assert file.json["accessors"][primitive["attributes"]["POSITION"]]["count"] == 24
    assert "doubleSided" not in file.material(primitive)


def face_normals(mesh):
    corners = mesh.vertices[mesh.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def write_box(tmp_path, mesh, page=None, pages=1, shown=None):
    """Write a mesh whose corners all lie on the same place of their page."""
    count = len(mesh.triangles)
    uv = np.full((count, 3, 2), 0.5)
    page = np.zeros(count) if page is None else page
    made = [
        make_page(
            i, np.full((16, 16), 100.0, np.float32), np.ones((16, 16), bool), np.zeros((16, 16))
        )
        for i in range(pages)
    ]
    lux_map = make_map(mesh, 0, made[0].illuminance, uv, page)
    path = tmp_path / "box.glb"
    shown = shown or materials()
    write_gltf(path, [mesh], shown, make_result([lux_map], made), white=WHITE)
    file = GltfFile(path)
    file.check()
    return file


def test_a_scene_of_black_surfaces_is_black(tmp_path):
    black = Material("grey", "grey", Diffuse(Constant(0.0)))
    mesh = box(2.0, 3.0, 4.0, "grey", inwards=False)
    file = write_box(tmp_path, mesh, shown={"grey": black})
    ((_, primitive),) = file.primitives()
    factor = file.material(primitive)["pbrMetallicRoughness"]["baseColorFactor"]
    assert factor == [0.0, 0.0, 0.0, 1.0]


def test_open_sheets_are_seen_from_both_sides(tmp_path):
    file = write_room(tmp_path, *room())
    assert all(
        file.material(p, v)["doubleSided"]
        for _, p in file.primitives()
        for v in (None, "illuminance")
    )


def test_charts_on_several_pages_and_materials_become_parts(tmp_path):
    mesh = box(1.0, 1.0, 1.0, "grey")
    mesh = replace(
        mesh,
        materials=("grey", "red"),
        material_index=np.array([0, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 1], np.int32),
    )
    page = np.array([0] * 4 + [1] * 4 + [-1] * 4)
    file = write_box(tmp_path, mesh, page, pages=2)
    parts = [len(file.array(p["indices"])) // 3 for _, p in file.primitives()]
    assert parts == [5, 3]  # both pages fit on one texture; triangles without a place are left away
    factors = [
        file.material(p)["pbrMetallicRoughness"]["baseColorFactor"] for _, p in file.primitives()
    ]
    # The brightest material, red at 0.6, is 1.
    assert factors[0] == pytest.approx([0.4 / 0.6] * 3 + [1.0])
    assert factors[1] == pytest.approx([1.0, 0.25, 1.0 / 6.0, 1.0])


def flat_sheets(values, side=32):
    """Sheets of even light, each on a page of its own."""
    sheets = [
        quad(f"sheet {i}", (2 * i, 0, 0), (1, 0, 0), (0, 1, 0), "grey") for i in range(len(values))
    ]
    pages = [
        make_page(
            i,
            np.full((side, side), v, np.float32),
            np.ones((side, side), bool),
            np.zeros((side, side)),
        )
        for i, v in enumerate(values)
    ]
    maps = [
        make_map(s, i, pages[i].illuminance, 0.05 + 0.9 * s.uv_maps["UV"], np.full(2, i))
        for i, s in enumerate(sheets)
    ]
    return sheets, make_result(maps, pages)


@pytest.mark.parametrize(
    ("limits", "textures", "side", "factor"),
    [
        (GltfLimits(16, 2048), 1, 160, 1),  # five pages of 32 in a row
        (GltfLimits(16, 32), 5, 32, 1),
        (GltfLimits(4, 64), 2, 64, 1),  # two for each look, of four pages each
        (GltfLimits(2, 64), 1, 64, 2),
        (GltfLimits(4, 32), 2, 32, 2),
        (GltfLimits(2, 32), 1, 32, 4),
    ],
)
def test_limits_of_number_and_size_are_kept_and_light_stays_in_place(
    tmp_path, limits, textures, side, factor
):
    values = [510.0, 400.0, 300.0, 200.0, 100.0]
    sheets, result = flat_sheets(values)
    write_gltf(
        tmp_path / "s.glb", sheets, materials(), result, white=WHITE, limits=limits, top=510.0
    )
    file = GltfFile(tmp_path / "s.glb")
    file.check()
    assert len(file.json["textures"]) == 2 * textures <= limits.textures
    sizes = [file.picture(i).size for i in range(2 * textures)]
    assert max(max(size) for size in sizes) == side <= limits.size
    assert file.json["asset"]["extras"]["lumels_per_texel"] == factor
    for (node, primitive), lux in zip(file.primitives(), values, strict=True):
        number = file.material(primitive, "illuminance")["pbrMetallicRoughness"]["baseColorTexture"]
        codes = np.asarray(file.picture(number["index"]))
        for _, uv in places_inside(file, primitive, node):
            assert look_up(codes, uv) == round(lux / 2.0)


def test_what_does_not_fit_is_refused_in_one_sentence(tmp_path):
    sheets, result = flat_sheets([100.0] * 5, side=64)
    with pytest.raises(SceneError, match=r"5 pages .* 1 textures of 8 x 8 texels"):
        write_gltf(
            tmp_path / "s.glb", sheets, materials(), result, white=1.0, limits=GltfLimits(2, 8)
        )
    with pytest.raises(SceneError, match="2 looks need as many textures"):
        write_gltf(
            tmp_path / "s.glb", sheets, materials(), result, white=1.0, limits=GltfLimits(1, 64)
        )
    assert not (tmp_path / "s.glb").exists()


def test_one_look_needs_no_variants(tmp_path):
    sheets, lamp = room()
    file = write_room(tmp_path, sheets, lamp, variants=False)
    assert file.json["extensionsUsed"] == ["KHR_materials_unlit"]
    assert "extensions" not in file.json
    both = write_room(tmp_path, sheets, lamp, look="false_colour")
    names = [v["name"] for v in both.json["extensions"]["KHR_materials_variants"]["variants"]]
    assert names == ["illuminance", "light"]
    _, primitive = next(iter(both.primitives()))
    assert both.material(primitive) == both.material(primitive, "illuminance")


def test_files_state_where_they_come_from_and_how_right_they_are(tmp_path):
    sheets, lamp = room()
    file = write_room(tmp_path, sheets, lamp)
    asset = file.json["asset"]
    assert asset["generator"].startswith("Lumenray ")
    assert asset["extras"]["scene_hash"] == "c0ffee"
    assert asset["extras"]["seed"] == 7
    assert asset["extras"]["relative_standard_error"] == 0.01
    for node, _ in file.primitives():
        sheet = next(s for s in sheets if s.mesh.name == node["name"])
        u, v = ((np.arange(n) + 0.5) / n for n in (int(s) for s in sheet.size))
        shares = np.stack(np.meshgrid(u, v), axis=-1)
        mean = lamp_light(sheet.points(shares), sheet.normal, lamp).mean()
        assert node["extras"]["mean_lux"] == pytest.approx(mean, rel=1e-6)
        assert node["extras"]["lumels_per_metre"] == DENSITY


def test_unknown_errors_are_null(tmp_path):
    sheets, result = flat_sheets([100.0])
    lux_map = replace(result.maps[0], relative_standard_error=math.inf)
    write_gltf(
        tmp_path / "s.glb", sheets, materials(), replace(result, maps=(lux_map,)), white=WHITE
    )
    extras = GltfFile(tmp_path / "s.glb").json["nodes"][0]["extras"]
    assert extras["relative_standard_error"] is None


def test_the_same_result_gives_the_same_bytes(tmp_path):
    first, second = (write_room(tmp_path, *room(), name).bytes for name in ("a.glb", "b.glb"))
    assert first == second
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


def test_many_vertices_get_wide_indices_and_are_shared(tmp_path):
    side = 300
    x, y = np.meshgrid(np.arange(side + 1.0), np.arange(side + 1.0))
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    low = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    triangles = np.concatenate(
        [
            np.stack([low, low + 1, low + side + 2], axis=1),
            np.stack([low, low + side + 2, low + side + 1], axis=1),
        ]
    ).astype(np.int32)
    mesh = Mesh("grid", "grid", vertices, triangles, ("grey",), np.zeros(len(triangles), np.int32))
    uv = vertices[triangles][..., :2] / side
    page = make_page(0, np.full((8, 8), 50.0, np.float32), np.ones((8, 8), bool), np.zeros((8, 8)))
    result = make_result(
        [make_map(mesh, 0, page.illuminance, uv, np.zeros(len(triangles)))], [page]
    )
    write_gltf(tmp_path / "grid.glb", [mesh], materials(), result, white=WHITE)
    file = GltfFile(tmp_path / "grid.glb")
    file.check()
    ((_, primitive),) = file.primitives()
    assert file.json["accessors"][primitive["attributes"]["POSITION"]]["count"] == (side + 1) ** 2
    assert file.array(primitive["indices"]).dtype == np.uint32


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"white": 0.0}, "luminance of white"),
        ({"white": math.nan}, "luminance of white"),
        ({"look": "pretty"}, "unknown look"),
        ({"top": -1.0}, "top of the scale"),
        ({"limits": GltfLimits(0, 1)}, "at least one texel"),
    ],
)
def test_options_that_make_no_sense_are_refused(tmp_path, change, sentence):
    with pytest.raises(SceneError, match=sentence):
        write_room(tmp_path, *room(), **change)


def test_unfit_input_is_refused(tmp_path):
    sheets, lamp = room()
    result, meshes = bake(sheets, lamp), [sheet.mesh for sheet in sheets]
    path = tmp_path / "x.glb"

    def refuse(sentence, meshes=meshes, paints=None, result=result, path=path, kind=SceneError):
        with pytest.raises(kind, match=sentence):
            write_gltf(path, meshes, paints or materials(), result, white=WHITE)
        assert not path.is_file()

    refuse("in files only", result=without_pages(result))
    refuse("does not hold", paints={"grey": materials()["grey"]})
    refuse("nothing to write", meshes=[])
    refuse("ends in .glb or .gltf", path=tmp_path / "x.obj", kind=FileFormatError)
    (tmp_path / "taken").write_text("")
    refuse("cannot be written", path=tmp_path / "taken" / "x.glb", kind=FileFormatError)
    turned = replace(meshes[0], triangles=meshes[0].triangles[:, [1, 2, 0]])
    refuse("bake it anew", meshes=[turned])
    broken = result.pages[0].illuminance.copy()
    broken[10, 10] = np.nan
    pages = (replace(result.pages[0], illuminance=broken), result.pages[1])
    refuse("not finite", result=replace(result, pages=pages))
    refuse("no page 1", result=replace(result, pages=result.pages[:1]))


def test_names_of_files_beside_are_quoted(tmp_path):
    write_room(tmp_path, *room(), "Zimmer 1, Süd.gltf")
    content = json.loads((tmp_path / "Zimmer 1, Süd.gltf").read_text())
    uris = [content["buffers"][0]["uri"], *(image["uri"] for image in content["images"])]
    assert all(uri.isascii() and " " not in uri for uri in uris)
