"""Compositions of cloths: what ships can be read, what cannot be is said in one sentence."""

from copy import deepcopy

import numpy as np
import pytest

from lumenray.engine.cloth.reader import parse_cloth, read_cloth
from lumenray.engine.cloth.tubes import CORNERS, lay_out, make_triangles
from lumenray.engine.errors import FileFormatError
from lumenray.libraries import cloths

CLOTH = {
    "lumenray_cloth": 1,
    "name": "Test",
    "warp": {"width_mm": 0.2, "height_mm": 0.1},
    "weft": {"width_mm": 0.2},
    "weave": {"pattern": "plain", "warp_pitch_mm": 0.25, "weft_pitch_mm": 0.25},
}


@pytest.mark.parametrize("name", cloths.presets())
def test_presets_can_be_read(name):
    cloth = read_cloth(cloths.presets()[name])
    assert cloth.name and cloth.content["name"] == cloth.name


@pytest.mark.parametrize("openness", [1, 3, 5, 10])
def test_screens_are_as_open_as_their_names(openness):
    cloth = read_cloth(cloths.presets()[f"screen_{openness}"])
    cover = cloth.warp.width_mm / cloth.weave.warp_pitch_mm
    assert (1.0 - cover) ** 2 == pytest.approx(0.01 * openness, rel=0.01)


@pytest.mark.parametrize(
    "place, value, words",
    [
        (("warp", "width_mm"), 0.3, "warp.width_mm is 0.3, expected 0.25 at most"),
        (("warp", "width_mm"), "thin", "expected a number"),
        (("weave", "pattern"), "knit", "plain"),
        (("weft", "colour"), "red", "colour"),
        (("weave",), {"satin": {"ends": 6, "step": 2}, "warp_pitch_mm": 0.3, "weft_pitch_mm": 0.3}, "from 2 to 4"),
        (("weave",), {"rows": ["X.", "XX"], "warp_pitch_mm": 0.3, "weft_pitch_mm": 0.3}, "end 1 crosses all"),
        (("weave",), {"rows": ["X.", "X"], "warp_pitch_mm": 0.3, "weft_pitch_mm": 0.3}, r"rows\[1\]"),
        (("weave",), {"bitmap": "none.png", "warp_pitch_mm": 0.3, "weft_pitch_mm": 0.3}, "none.png cannot be read"),
        (("warp", "absorption_per_mm"), {"wavelengths_nm": [500, 400], "values": [1, 1]}, "do not ascend"),
    ],
)  # fmt: skip
def test_faults_are_said_in_one_sentence(place, value, words):
    content = deepcopy(CLOTH)
    target = content
    for step in place[:-1]:
        target = target[step]
    target[place[-1]] = value
    with pytest.raises(FileFormatError, match=words):
        parse_cloth(content)


def test_bitmap_is_a_weave(tmp_path):
    from PIL import Image

    Image.fromarray(np.array([[0, 255], [255, 0]], np.uint8)).save(tmp_path / "weave.png")
    content = {
        **CLOTH,
        "weave": {"bitmap": "weave.png", "warp_pitch_mm": 0.3, "weft_pitch_mm": 0.3},
    }
    weave = parse_cloth(content, tmp_path / "cloth.json").weave
    assert weave.is_warp_up.tolist() == [[False, True], [True, False]]


def test_yarns_touch_where_they_cross():
    """The upper one's lower side lies on the lower one's upper side, within the chords of the drawn bodies."""
    cloth = parse_cloth(CLOTH)
    tubes = lay_out(cloth)
    up = cloth.weave.is_warp_up
    ends = np.flatnonzero(tubes.kinds == 0)
    picks = np.flatnonzero(tubes.kinds == 1)
    for end in ends:
        for pick in picks:
            x, y = tubes.centres[end, 0, 0], tubes.centres[pick, 0, 1]
            warp = np.interp(y, tubes.centres[end, :, 1], tubes.centres[end, :, 2])
            weft = np.interp(x, tubes.centres[pick, :, 0], tubes.centres[pick, :, 2])
            i, j = (int(np.floor(place / 0.25)) % 2 for place in (x, y))
            if abs(y) < 0.9 and abs(x) < 0.9:
                assert warp - weft == pytest.approx((1.0 if up[i, j] else -1.0) * 0.15, rel=1e-3)


def test_triangles_of_a_body_all_face_its_axis():
    tubes = lay_out(parse_cloth(CLOTH))
    points, faces = make_triangles(tubes)
    assert faces.max() == len(points) - 1
    rings = tubes.widths.shape[1]
    first = points[faces[: 2 * CORNERS * (rings - 1)]]
    normal = np.cross(first[:, 1] - first[:, 0], first[:, 2] - first[:, 0])
    axis = tubes.centres[0, np.arange(len(first)) // (2 * CORNERS)]
    assert ((first[:, 0] - axis) * normal).sum(axis=1).max() < 0.0
