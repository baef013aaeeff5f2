"""Images of several tiles (UDIM): what is read of them, and what graphs make of them beside Cycles."""

import os

import bpy
import numpy as np
import pytest
from material_trees import add_texture, evaluate, noise_image

from lumenray.blender_addon.sync.images import tiled
from lumenray.blender_addon.sync.images.cache import ImageCache
from lumenray.blender_addon.sync.nodes import fields, tiles
from lumenray.engine.scene.texture import Tile

pytestmark = pytest.mark.blender

SIDES = {1001: (8, 4), 1002: (4, 4), 1012: (2, 8)}
"""Widths and heights of the tiles."""


def pixels_of(number):
    width, height = SIDES[number]
    return np.random.default_rng(number).random((height, width, 3)).astype(np.float32)


def save_tile(folder, number, pixels=None):
    pixels = pixels_of(number) if pixels is None else pixels
    height, width = pixels.shape[:2]
    made = bpy.data.images.new(f"Part {number}", width, height, float_buffer=True)
    made.colorspace_settings.name = "Non-Color"
    made.pixels.foreach_set(np.concatenate([pixels, np.ones_like(pixels[..., :1])], -1).ravel())
    made.filepath_raw, made.file_format = str(folder / f"wall.{number}.exr"), "OPEN_EXR"
    made.save()
    bpy.data.images.remove(made)


@pytest.fixture
def wall(tmp_path):
    """An image of three tiles on disk."""
    for number in SIDES:
        save_tile(tmp_path, number)
    made = bpy.data.images.load(str(tmp_path / "wall.1001.exr"))
    made.source, made.filepath = "TILED", str(tmp_path / "wall.<UDIM>.exr")
    made.colorspace_settings.name = "Non-Color"
    for number in SIDES:
        if made.tiles.get(number) is None:
            made.tiles.new(number)
    return made


def placed(tree, image, scale=(2.6, 2.5, 1.0), shift=(-0.3, -0.2, 0.0), **how):
    where = tree.add("Mapping", Vector=tree.add("UVMap").outputs[0])
    where.inputs["Scale"].default_value, where.inputs["Location"].default_value = scale, shift
    return add_texture(tree, image, Vector=where.outputs[0], **how).outputs["Color"]


def test_all_tiles_are_read_and_magenta_for_what_is_none(wall):
    reading = ImageCache().read_tiles(wall, False, lambda *words: pytest.fail(str(words)))
    assert set(reading.tiles) == {Tile(0, 0, 8, 4), Tile(1, 0, 4, 4), Tile(1, 1, 2, 8)}
    assert (reading.colour.shape, reading.alpha.shape) == ((1, 65, 3), (1, 65, 1))
    assert reading.colour[0, -1].tolist() == [1.0, 0.0, 1.0]
    start = 0
    for tile in reading.tiles:
        number = 1001 + tile.column + 10 * tile.line
        own = reading.colour[0, start : start + tile.width * tile.height]
        # Files of pictures hold half precision where nothing else is set.
        assert own == pytest.approx(pixels_of(number).reshape(-1, 3), abs=1e-3)
        start += tile.width * tile.height


@pytest.mark.parametrize("extension", ["REPEAT", "EXTEND", "MIRROR"])
def test_places_show_the_tiles_of_cycles(tree, wall, agree, extension):
    """Tiles, what is none between and beyond them, and places just before the first one."""
    output = placed(tree, wall)
    output.node.extension = extension
    ours = agree(tree, output, wrong_share=0.02)
    assert (np.abs(ours - [1.0, 0.0, 1.0]).max(-1) < 1e-6).mean() > 0.2


def test_packed_tiles_are_read_without_their_files(tree, wall, agree, tmp_path):
    wall.pack()
    for file in tmp_path.glob("wall.*.exr"):
        file.unlink()
    agree(tree, placed(tree, wall), wrong_share=0.02)


def test_tiles_times_a_picture_are_both_seen(tree, wall, agree):
    other = add_texture(tree, noise_image(5, shape=(8, 8, 3)), Vector=tree.add("UVMap").outputs[0])
    mixed = tree.add("MixRGB", attributes={"blend_type": "MULTIPLY"}, Fac=1.0)
    links = tree.material.node_tree.links
    links.new(placed(tree, wall, (2.0, 2.0, 1.0), (0.0, 0.0, 0.0)), mixed.inputs[1])
    links.new(other.outputs["Color"], mixed.inputs[2])
    ours, _ = evaluate(tree, mixed.outputs[0])
    # A tile is half of the UV square, on which the other picture has four pixels.
    whole = np.concatenate([pixels_of(1001), pixels_of(1002).repeat(2, axis=1)], axis=1)
    low = whole.repeat(2, axis=0) * noise_of(other)[:8]
    assert ours[:8] == pytest.approx(low, abs=2e-3)


def noise_of(texture):
    pixels = np.array(texture.image.pixels[:]).reshape(8, 8, 4)[..., :3]
    return pixels.repeat(2, axis=0).repeat(2, axis=1)


def test_a_tile_that_is_not_there_is_missing_and_magenta(tree, wall, tmp_path):
    (tmp_path / "wall.1002.exr").unlink()
    ours, report = evaluate(tree, placed(tree, wall, (2.0, 1.0, 1.0), (0.0, 0.0, 0.0)))
    (row,) = report.to_dicts()
    assert "Tile 1002" in row["message"]
    assert row["missing"]
    assert np.abs(ours[:, 8:] - [1.0, 0.0, 1.0]).max() < 1e-6


def test_many_pixels_are_made_coarser_before_they_take_memory(wall, monkeypatch):
    monkeypatch.setattr(tiled, "LARGEST", 40)
    notes = []
    reading = ImageCache().read_tiles(wall, False, lambda *words: notes.append(words))
    assert {tile[2:] for tile in reading.tiles} == {(4, 2), (2, 2), (1, 4)}
    assert "2 x 2" in notes[0][1]
    first = pixels_of(1001).mean(axis=(0, 1))
    start = 0
    for tile in reading.tiles:
        size = tile.width * tile.height
        if tile[:2] == (0, 0):
            own = reading.colour[0, start : start + size].mean(axis=0)
            assert own == pytest.approx(first, abs=1e-3)
        start += size


def test_a_tile_that_is_too_large_by_itself_is_not_read(wall, monkeypatch):
    monkeypatch.setattr(tiled, "LARGEST", 20)
    notes = []
    reading = ImageCache().read_tiles(wall, False, lambda *words: notes.append(words))
    assert any("left out" in remedy for _, remedy in notes)
    assert Tile(0, 0, 8, 4) not in reading.tiles


def test_a_tile_that_is_saved_anew_is_read_anew(wall, tmp_path):
    cache = ImageCache()

    def mean():
        return cache.read_tiles(wall, False, lambda *_: None).colour[0, :-1].mean()

    before = mean()
    assert mean() == before
    save_tile(tmp_path, 1002, np.zeros_like(pixels_of(1002)))
    os.utime(tmp_path / "wall.1002.exr", (1, 1))
    assert mean() < before


def test_the_users_images_stay_as_they_are(wall):
    before = {each.name for each in bpy.data.images}
    ImageCache().read_tiles(wall, False, lambda *_: None)
    assert {each.name for each in bpy.data.images} == before


def test_a_common_picture_of_tiles_is_bounded(monkeypatch):
    monkeypatch.setattr(tiles, "MOST", 100)
    one = fields.Layout("", np.eye(3), tiles=(Tile(0, 0, 16, 16), Tile(1, 0, 16, 16)))
    made, is_whole = tiles.common_layout(one, [one], np.array([4.0, 4.0]))
    assert tiles.count(made.tiles) <= 101
    assert not is_whole
