"""Lists of sensors: with and without a heading, and what is refused."""

import numpy as np
import pytest
from text_files import written

from lumenray.engine.errors import FileFormatError
from lumenray.engine.formats import sensors
from lumenray.engine.formats.spd import read_spectrum


def test_sensor_lists_come_with_or_without_a_heading(tmp_path):
    plain = sensors.read_sensors(written(tmp_path, "1,2,3,0,0,1\n4,5,6,1,0,0\n"))
    named = sensors.read_sensors(
        written(tmp_path, "id,nx,ny,nz,x,y,z\na,0,0,1,1,2,3\nb,1,0,0,4,5,6\n")
    )
    assert np.array_equal(plain, named)
    assert plain.tolist() == [[1, 2, 3, 0, 0, 1], [4, 5, 6, 1, 0, 0]]


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("1,2,3,0,0,1\n1,2,3\n", 2, "6 columns, found 3"),
        ("x,y,z,nx,ny,nz\n1,2,oops,0,0,1\n", 2, "number for z, found 'oops'"),
        ("1,2,3,0,0,0\n", 1, "normal is 0,0,0"),
        ("1,2,inf,0,0,1\n", 1, "number for z"),
        ("x,y,z\n1,2,3\n", 1, "no column nx, ny, nz"),
        ("\n\n", None, "no sensor"),
    ],
)
def test_a_bad_sensor_list_is_refused_with_its_line(tmp_path, text, line, words):
    with pytest.raises(FileFormatError, match=words) as caught:
        sensors.read_sensors(written(tmp_path, text))
    assert caught.value.line == line


def test_readers_survive_any_bytes(tmp_path):
    rng = np.random.default_rng(0)
    seeds = [
        b"400 1\n500 2\n",
        b"x,y,z,nx,ny,nz\n1,2,3,0,0,1\n",
        b"<?xml version='1.0'?><IESTM2714></IESTM2714>",
    ]
    for i in range(300):
        data = bytearray(seeds[i % 3] * 3)
        for _ in range(rng.integers(1, 12)):
            data[rng.integers(len(data))] = rng.integers(256)
        path = written(tmp_path, bytes(data), "fuzz.bin")
        for read in (read_spectrum, sensors.read_sensors):
            try:
                read(path)
            except FileFormatError as error:
                assert str(path) in str(error)
