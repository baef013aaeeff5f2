"""Layers of a bake added up at other levels, from its files."""

import json

import numpy as np
import pytest

from lumenray.engine.baking.files import write_page
from lumenray.engine.baking.mixed_maps import mix_maps
from lumenray.engine.baking.order import AtlasPage
from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.formats.exr import read_channels
from lumenray.engine.light_mix import Level, LightMix

pytestmark = pytest.mark.mitsuba

CEILING, DESK = 300.0, 40.0


@pytest.fixture
def baked(tmp_path):
    """Folder of a bake of a floor of 8 lumels and a desk of 4, by the lamps of two groups."""
    folder = tmp_path / "lux"
    folder.mkdir()
    number = np.full((4, 6), -1, np.int32)
    number[:2, :4], number[2:, :2] = 0, 1
    covered = number >= 0
    ceiling = np.where(covered, CEILING, 0.0).astype(np.float32)
    desk = np.where(number == 1, DESK * np.arange(6), 0.0).astype(np.float32)
    area = np.where(number == 0, 0.5, 0.1).astype(np.float32)
    error = np.full((4, 6), 2.0, np.float32)
    page = AtlasPage(
        0, 6, 4, ceiling + desk, error, covered, area, number, number,
        {"Ceiling lamps": ceiling, "desk": desk}, None, 8, 7.0,
    )  # fmt: skip
    write_page(folder, page, {}, 500.0, has_arrays=True)
    rows = [
        {"name": name, "mean": mean, "mean_standard_error": 0.5}
        for name, mean in (("Floor", CEILING), ("Desk", CEILING + 0.5 * DESK))
    ]
    (folder / "report.json").write_text(json.dumps({"quantities": rows}))
    return folder


def test_a_mix_is_the_sum_of_the_layers_by_object(baked, tmp_path):
    out = tmp_path / "mixed"
    mix = LightMix((Level("Ceiling lamps", 0.5), Level("desk", 2.0)))
    (floor, desk), files = mix_maps(baked, mix, out)
    assert floor.mean == pytest.approx(0.5 * CEILING)
    assert desk.mean == pytest.approx(0.5 * CEILING + 2.0 * 0.5 * DESK)
    assert (desk.least, desk.largest) == (0.5 * CEILING, 0.5 * CEILING + 2.0 * DESK)
    assert desk.uniformity == pytest.approx(150.0 / 190.0)
    # Two hundred per cent of the desk's light may double the error of the whole, not more.
    assert desk.mean_error == pytest.approx(1.0)
    page = read_channels(out / "illuminance.1001.exr")
    shown = page["covered.Y"] > 0.5
    expected = 0.5 * read_channels(baked / "illuminance_Ceiling_lamps.1001.exr")["Y"]
    expected += 2.0 * read_channels(baked / "illuminance_desk.1001.exr")["Y"]
    np.testing.assert_allclose(page["Y"][shown], expected[shown], rtol=1e-6)
    assert (page["standard_error.Y"] == 4.0).all()
    content = json.loads((out / "mix.json").read_text())
    assert content["light_groups"] == {"Ceiling_lamps": 0.5, "desk": 2.0}
    assert content["quantities"][0]["mean"] == pytest.approx(150.0)
    assert {path.name for path in files} == {"illuminance.1001.exr", "mix.json"}


def test_a_group_that_is_off_leaves_the_others(baked, tmp_path):
    (floor, desk), _ = mix_maps(
        baked, LightMix((Level("Ceiling lamps", 0.0, is_on=False),)), tmp_path
    )
    assert floor.mean == 0.0
    assert floor.uniformity == 0.0
    assert desk.mean == pytest.approx(0.5 * DESK)


def test_what_is_missing_is_told(baked, tmp_path):
    with pytest.raises(SceneError, match="no light group 'Hall'; it has Ceiling_lamps, desk"):
        mix_maps(baked, LightMix((Level("Hall", 2.0),)), tmp_path / "a")
    (baked / "illuminance_desk.1001.exr").unlink()
    with pytest.raises(FileFormatError, match="so one is missing"):
        mix_maps(baked, LightMix((Level("Ceiling lamps", 2.0),)), tmp_path / "a")
    (baked / "report.json").write_text("{}")
    with pytest.raises(FileFormatError, match="is no report of a bake"):
        mix_maps(baked, LightMix((Level("Ceiling lamps", 2.0),)), tmp_path / "a")
    with pytest.raises(FileFormatError, match="bake with layers"):
        mix_maps(tmp_path, LightMix(), tmp_path / "a")


def test_mixes_pass_through_the_engines_process():
    """Levels go there and figures come back as they are."""
    from lumenray.engine.baking.mixed_maps import MixedMap
    from lumenray.engine.worker.codec import decode, encode

    sent = (
        LightMix((Level("desk", 2.0),)),
        MixedMap("Floor", 150.0, float("nan"), 1.0, 2.0, 300.0),
    )
    tree, parts, size = encode(sent)
    levels, made = decode(json.loads(json.dumps(tree)), b"\0" * size)
    assert not parts
    assert levels == sent[0]
    assert (made.mean, made.before, np.isnan(made.mean_error)) == (150.0, 300.0, True)


def test_arrays_hold_what_pictures_hold(baked):
    """Every page and its layers once more as arrays, which programs without OpenEXR read."""
    for name in ("illuminance", "illuminance_Ceiling_lamps", "illuminance_desk"):
        array = np.load(baked / f"{name}.1001.npy", allow_pickle=False)
        assert array.dtype == np.float32
        np.testing.assert_array_equal(array, read_channels(baked / f"{name}.1001.exr")["Y"])
    whole = read_channels(baked / "illuminance.1001.exr")
    for name in ("standard_error", "covered"):
        np.testing.assert_array_equal(np.load(baked / f"{name}.1001.npy"), whole[f"{name}.Y"])
