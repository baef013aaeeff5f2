"""Colours and lux that a viewer gets of a baked scene in glTF."""

import math
from dataclasses import replace

import numpy as np
import pytest
from baked_rooms import (
    COLOURS,
    WHITE,
    lamp_light,
    look_up,
    make_map,
    make_page,
    make_result,
    materials,
    places_inside,
    room,
    write_room,
)
from gltf_files import GltfFile
from small_scenes import quad

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
from lumenray.engine.scene.spectrum import Blackbody, Constant, Rgb, Tabulated
from lumenray.engine.scene.texture import ImageTexture

TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
"""From linear Rec. 709 to X, Y, Z. (IEC 61966-2-1)"""

XYZ = {name: TO_XYZ @ rgb for name, rgb in COLOURS.items()}
"""Reflectances of the room."""


def to_linear(code):
    """IEC 61966-2-1, decoding."""
    code = np.asarray(code, float) / 255.0
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


def shown_luminance(file, node, primitive, place, uv):
    """Linear colour that a viewer shows of the light."""
    shading = file.material(primitive, "light")["pbrMetallicRoughness"]
    picture = np.asarray(file.picture(shading["baseColorTexture"]["index"]).convert("RGB"))
    return to_linear(look_up(picture, uv)) * shading["baseColorFactor"][:3]


@pytest.mark.parametrize("name", ["room.glb", "a room.gltf"])
def test_every_place_shows_the_luminance_of_the_light_that_falls_on_it(tmp_path, name):
    sheets, lamp = room()
    file = write_room(tmp_path, sheets, lamp, name)
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
    file = write_room(tmp_path, sheets, lamp, top=1000.0)
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
    file = write_room(tmp_path, sheets, lamp, colour=XYZ, white=400.0)
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
    file = write_room(tmp_path, sheets, lamp, colour=XYZ, white=5.0)
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


def test_lamps_and_panes_need_no_map_and_unknown_light_is_not_made_up(tmp_path):
    sheets, lamp = room()
    panel = quad("panel", (1, 1, 2), (0, 1, 0), (1, 0, 0), "glow")
    pane = quad("pane", (4, 0, 0), (0, 3, 0), (0, 0, 2), "glass")
    chair = quad("chair", (2, 2, 0), (1, 0, 0), (0, 1, 0), "grey")
    hidden = replace(
        quad("hidden", (2, 2, 0), (1, 0, 0), (0, 1, 0), "glow"), visible_to_camera=False
    )
    file = write_room(tmp_path, sheets, lamp, more=(panel, pane, chair, hidden))
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
