"""Baked scenes as glTF: the format's rules, the geometry's places, and the colours and lux that a viewer gets."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from baked_rooms import (
    COLOURS,
    DENSITY,
    bake,
    lamp_light,
    make_map,
    make_page,
    make_result,
    materials,
    room,
    without_pages,
)
from gltf_files import GltfFile
from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.formats.gltf import GltfLimits, write_gltf
from lumenray.engine.formats.gltf_colour import flatten
from lumenray.engine.scene.material import (
    Conductor,
    Diffuse,
    Emission,
    Material,
    Mix,
    ThinGlass,
    Transparent,
)
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.spectrum import Blackbody, Constant, Rgb, Tabulated
from lumenray.engine.scene.texture import ImageTexture
from small_scenes import box, quad

WHITE = 150.0

TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
"""From linear Rec. 709 to X, Y, Z. (IEC 61966-2-1)"""

XYZ = {name: TO_XYZ @ rgb for name, rgb in COLOURS.items()}
"""Reflectances of the room."""


def write(tmp_path, sheets, lamp, name="room.glb", **options):
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


def to_linear(code):
    """IEC 61966-2-1, decoding."""
    code = np.asarray(code, float) / 255.0
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


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


def shown_luminance(file, node, primitive, place, uv):
    """Linear colour that a viewer shows of the light."""
    shading = file.material(primitive, "light")["pbrMetallicRoughness"]
    picture = np.asarray(file.picture(shading["baseColorTexture"]["index"]).convert("RGB"))
    return to_linear(look_up(picture, uv)) * shading["baseColorFactor"][:3]


@pytest.mark.parametrize("name", ["room.glb", "a room.gltf"])
def test_every_place_shows_the_luminance_of_the_light_that_falls_on_it(tmp_path, name):
    sheets, lamp = room()
    file = write(tmp_path, sheets, lamp, name)
    by_name = {sheet.mesh.name: sheet for sheet in sheets}
    for node, primitive in file.primitives():
        sheet = by_name[node["name"]]
        reflectance = np.array(COLOURS[sheet.mesh.materials[0]])
        for place, uv in places_inside(file, primitive, node):
            lux = lamp_light(place, sheet.normal, lamp)
            expected = np.minimum(reflectance * min(lux / math.pi / WHITE, 1.0 / 0.6), 1.0)
            shown = shown_luminance(file, node, primitive, place, uv)
            # One code is up to 0.9 % of white; half a lumel of 1/32 m shifts the light by some per cent.
            assert shown == pytest.approx(expected, rel=0.04, abs=0.005), (node["name"], place)


def test_false_colours_give_the_lux_back(tmp_path):
    sheets, lamp = room()
    file = write(tmp_path, sheets, lamp, top=1000.0)
    by_name = {sheet.mesh.name: sheet for sheet in sheets}
    for node, primitive in file.primitives():
        material = file.material(primitive, "illuminance")
        number = material["pbrMetallicRoughness"]["baseColorTexture"]["index"]
        assert material["pbrMetallicRoughness"]["baseColorFactor"] == [1.0, 1.0, 1.0, 1.0]
        extras = file.json["textures"][number]["extras"]
        assert extras["unit"] == "lx"
        picture = file.picture(number)
        assert picture.mode == "P"
        sheet = by_name[node["name"]]
        for place, uv in places_inside(file, primitive, node):
            lux = look_up(np.asarray(picture), uv) / 255.0 * extras["at_code_255"]
            assert lux == pytest.approx(lamp_light(place, sheet.normal, lamp), rel=0.04, abs=3.0)


def test_exitance_shows_in_its_colour(tmp_path):
    sheets, lamp = room()
    file = write(tmp_path, sheets, lamp, colour=XYZ, white=400.0)
    by_name = {sheet.mesh.name: sheet for sheet in sheets}
    for node, primitive in file.primitives():
        sheet = by_name[node["name"]]
        for place, uv in places_inside(file, primitive, node):
            shown = TO_XYZ @ shown_luminance(file, node, primitive, place, uv)
            lux = lamp_light(place, sheet.normal, lamp)
            expected = lux * XYZ[sheet.mesh.materials[0]] / math.pi / 400.0
            assert shown == pytest.approx(expected, rel=0.04, abs=0.004)


def test_brighter_than_white_keeps_its_hue(tmp_path):
    sheets, lamp = room()
    file = write(tmp_path, sheets, lamp, colour=XYZ, white=5.0)
    node, primitive = next(x for x in file.primitives() if x[0]["name"] == "back wall")
    shown = np.array(
        [
            shown_luminance(file, node, primitive, place, uv)
            for place, uv in places_inside(file, primitive, node)
        ]
    )
    red, green, blue = COLOURS["red"]
    assert shown[:, 0] == pytest.approx(1.0)
    assert shown[:, 1] == pytest.approx(green / red, abs=0.02)
    assert shown[:, 2] == pytest.approx(blue / red, abs=0.02)


def test_a_scene_far_off_the_origin_keeps_its_shape(tmp_path):
    offset = np.array([12345.678, -9876.543, 432.1])
    sheets, lamp = room(offset)
    file = write(tmp_path, sheets, lamp)
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


def write_box(tmp_path, mesh, page=None, pages=1):
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
    write_gltf(path, [mesh], materials(), make_result([lux_map], made), white=WHITE)
    file = GltfFile(path)
    file.check()
    return file


def test_open_sheets_are_seen_from_both_sides(tmp_path):
    file = write(tmp_path, *room())
    assert all(
        file.material(p, v)["doubleSided"]
        for _, p in file.primitives()
        for v in (None, "illuminance")
    )


def test_backs_with_maps_of_their_own_show_their_own_light(tmp_path):
    front = quad("leaf", (0, 0, 0), (1, 0, 0), (0, 1, 0), "grey")
    front = replace(front, corner_normals=np.tile(np.float32([0, 0, 1]), (2, 3, 1)))
    back = replace(front, triangles=np.ascontiguousarray(front.triangles[:, ::-1]))
    lux = np.full((16, 32), 100.0, np.float32)
    lux[:, 16:] = 300.0
    page = make_page(0, lux, np.ones(lux.shape, bool), np.zeros(lux.shape, np.int32))
    left = front.uv_maps["UV"] * (0.5, 1.0)
    maps = [
        make_map(front, 0, lux[:, :16], left, np.zeros(2)),
        make_map(back, 0, lux[:, 16:], np.add(left, (0.5, 0.0))[:, ::-1], np.zeros(2)),
    ]
    path = tmp_path / "leaf.glb"
    write_gltf(path, [front], materials(), make_result(maps, [page]), white=WHITE, top=510.0)
    file = GltfFile(path)
    file.check()
    ((node, primitive),) = file.primitives()
    assert "doubleSided" not in file.material(primitive)
    places, uv = file.corners(node, primitive)
    up = np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0])[:, 1] > 0.0
    normals = file.array(primitive["attributes"]["NORMAL"])[file.array(primitive["indices"])]
    assert (normals[:, 1].reshape(-1, 3) == np.where(up, 1.0, -1.0)[:, None]).all()
    number = file.material(primitive, "illuminance")["pbrMetallicRoughness"]["baseColorTexture"]
    codes = np.asarray(file.picture(number["index"]))
    found = [look_up(codes, centre) for centre in uv.mean(axis=1)]
    assert [int(code) for code in np.array(found)[up]] == [50, 50]
    assert [int(code) for code in np.array(found)[~up]] == [150, 150]


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


@pytest.mark.parametrize("rim", [0, 4])
def test_halving_does_not_darken_the_rims_of_charts(tmp_path, rim):
    """A chart in the middle of an empty page: no texel that its triangles see may hold the emptiness."""
    lux = np.zeros((64, 64), np.float32)
    covered = np.zeros((64, 64), bool)
    covered[21:42, 21:42] = True
    lux[21 - rim : 42 + rim, 21 - rim : 42 + rim] = 300.0
    mesh = quad("tile", (0, 0, 0), (1, 0, 0), (0, 1, 0), "grey")
    uv = (21.0 + 21.0 * mesh.uv_maps["UV"]) / 64.0
    chart = np.where(lux > 0.0, 0, -1)
    result = make_result(
        [make_map(mesh, 0, lux, uv, np.zeros(2))], [make_page(0, lux, covered, chart)]
    )
    for size in (64, 32, 16):
        path = tmp_path / f"{size}.glb"
        write_gltf(
            path, [mesh], materials(), result, white=WHITE, limits=GltfLimits(2, size), top=510.0
        )
        file = GltfFile(path)
        # All around it goes on with the chart's light, so that a viewer's smaller copies are right too.
        assert (np.asarray(file.picture(1)) == 150).all()


def test_one_look_needs_no_variants(tmp_path):
    sheets, lamp = room()
    file = write(tmp_path, sheets, lamp, variants=False)
    assert file.json["extensionsUsed"] == ["KHR_materials_unlit"]
    assert "extensions" not in file.json
    both = write(tmp_path, sheets, lamp, look="false_colour")
    names = [v["name"] for v in both.json["extensions"]["KHR_materials_variants"]["variants"]]
    assert names == ["illuminance", "light"]
    _, primitive = next(iter(both.primitives()))
    assert both.material(primitive) == both.material(primitive, "illuminance")


def test_files_state_where_they_come_from_and_how_right_they_are(tmp_path):
    sheets, lamp = room()
    file = write(tmp_path, sheets, lamp)
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
    first, second = (write(tmp_path, *room(), name).bytes for name in ("a.glb", "b.glb"))
    assert first == second
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


def test_lamps_and_panes_need_no_map_and_unknown_light_is_not_made_up(tmp_path):
    sheets, lamp = room()
    panel = quad("panel", (1, 1, 2), (0, 1, 0), (1, 0, 0), "glow")
    pane = quad("pane", (4, 0, 0), (0, 3, 0), (0, 0, 2), "glass")
    chair = quad("chair", (2, 2, 0), (1, 0, 0), (0, 1, 0), "grey")
    hidden = replace(
        quad("hidden", (2, 2, 0), (1, 0, 0), (0, 1, 0), "glow"), visible_to_camera=False
    )
    file = write(tmp_path, sheets, lamp, more=(panel, pane, chair, hidden))
    parts = {node["name"]: primitive for node, primitive in file.primitives()}
    assert set(parts) == {"floor", "back wall", "left wall", "panel", "pane"}
    assert file.json["asset"]["extras"]["not_baked"] == ["chair"]
    # 90 cd/m2, white being 150. An equal-energy light is a little red in daylight's white, of the same luminance.
    glow = file.material(parts["panel"])["pbrMetallicRoughness"]["baseColorFactor"][:3]
    assert np.dot(glow, (0.2126, 0.7152, 0.0722)) == pytest.approx(0.6, rel=1e-3)
    # Clear glass of n = 1.5 lets 92.3 % pass: T = (1 - r) / (1 + r), r = 0.04.
    glass = file.material(parts["pane"])
    assert glass["alphaMode"] == "BLEND"
    assert 1.0 - glass["pbrMetallicRoughness"]["baseColorFactor"][3] == pytest.approx(0.96 / 1.04)


@pytest.mark.parametrize(
    ("surface", "reflected", "passing"),
    [
        (Diffuse(Constant(0.3)), (0.3, 0.3, 0.3), 0.0),
        (Diffuse(Tabulated(np.array([400.0, 700.0]), np.array([0.6, 0.6]))), (0.6, 0.6, 0.6), 0.0),
        (Mix(Diffuse(Rgb(0.8, 0.4, 0.2)), Transparent(), 0.25), (0.6, 0.3, 0.15), 0.25),
        (ThinGlass(1.5, Constant(0.5)), (0, 0, 0), 0.5 * 0.96**2 / (1 - 0.02**2)),
        # Reflectance of gold head-on: P. B. Johnson, R. W. Christy, Phys. Rev. B 6 (1972), as linear Rec. 709.
        (Conductor("Au"), (1.0, 0.78, 0.34), 0.0),
    ],
)
def test_flat_colours_are_those_of_the_surface(surface, reflected, passing):
    flat = flatten(Material("m", "m", surface))
    assert flat.reflected == pytest.approx(np.array(reflected, float), abs=0.01)
    assert flat.passing == pytest.approx(passing, abs=1e-6)


def test_a_picture_counts_with_its_mean_and_a_lamp_with_its_luminance():
    pixels = np.zeros((2, 2, 3), np.float32)
    pixels[0, 0] = (1.0, 0.5, 0.25)
    surface = Diffuse(ImageTexture(pixels))
    flat = flatten(Material("m", "m", surface, Emission(Blackbody(2856.0), 250.0)))
    assert flat.reflected == pytest.approx(pixels[0, 0] / 4.0)
    assert flat.emitted @ (0.2126, 0.7152, 0.0722) == pytest.approx(250.0, rel=1e-3)
    assert flat.emitted[0] > flat.emitted[1] > flat.emitted[2]


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
        write(tmp_path, *room(), **change)


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
    write(tmp_path, *room(), "Zimmer 1, Süd.gltf")
    content = json.loads((tmp_path / "Zimmer 1, Süd.gltf").read_text())
    uris = [content["buffers"][0]["uri"], *(image["uri"] for image in content["images"])]
    assert all(uri.isascii() and " " not in uri for uri in uris)
