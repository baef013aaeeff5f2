"""Files of equirectangular pictures: read, written, and refused with a sentence."""

import numpy as np
import pytest
from radiance_files import write_picture

from lumenray.engine.environment.map_file import read_map, write_map
from lumenray.engine.errors import FileFormatError

PIXELS = np.random.default_rng(3).random((8, 16, 3)).astype(np.float32) * 50.0


def test_a_radiance_picture_is_divided_by_its_exposure(tmp_path):
    path = tmp_path / "a.hdr"
    path.write_bytes(write_picture(PIXELS, ["EXPOSURE=4", "EXPOSURE=0.5"], packed=True))
    image, remarks = read_map(path)
    assert image.pixels == pytest.approx(PIXELS / 2.0, abs=0.3)
    assert "EXPOSURE 2" in remarks[0]
    assert not image.pixels.flags.writeable


@pytest.mark.mitsuba
def test_what_is_written_is_read_again(tmp_path):
    path = write_map(tmp_path / "a.exr", PIXELS)
    image, remarks = read_map(path)
    assert np.array_equal(image.pixels, PIXELS)
    assert remarks == ()
    grey = write_map(tmp_path / "grey.exr", PIXELS[..., :1])
    assert np.array_equal(read_map(grey)[0].pixels, np.repeat(PIXELS[..., :1], 3, axis=2))
    with pytest.raises(FileFormatError, match=r"ends in \.exr"):
        write_map(tmp_path / "a.hdr", PIXELS)


@pytest.mark.mitsuba
def test_damaged_files_are_refused_with_a_sentence(tmp_path):
    whole = write_map(tmp_path / "whole.exr", PIXELS).read_bytes()
    radiance = write_picture(PIXELS, packed=True)
    for number, content in enumerate(
        (b"", b"P6 1 1", whole[: len(whole) // 2], whole[:40], radiance[:-20], radiance[:30])
    ):
        path = tmp_path / f"{number}.exr"
        path.write_bytes(content)
        with pytest.raises(FileFormatError) as error:
            read_map(path)
        assert str(error.value).startswith(str(path))
        assert "\n" not in str(error.value)
    with pytest.raises(FileFormatError):
        read_map(tmp_path / "none.exr")


def test_a_picture_that_is_no_full_sphere_is_told(tmp_path):
    path = tmp_path / "square.hdr"
    path.write_bytes(write_picture(PIXELS[:, :8]))
    assert "twice as wide" in read_map(path)[1][0]
