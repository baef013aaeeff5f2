"""Radiance pictures: headers and pixels as Radiance's own programs read them."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from radiance_files import RGBE, XYZE, write_picture

from lumenray.engine.errors import FileFormatError
from lumenray.engine.formats.radiance_picture import decode, read_header

WHITE_EFFICACY = 179.0
"""Radiance's lumens per watt, by which its XYZE pictures are above its others. [lm/W]"""


def program(name):
    """Path of one of Radiance's programs."""
    package = pytest.importorskip("pyradiance")
    path = Path(package.__file__).parent / "bin" / name
    found = str(path) if path.exists() else shutil.which(name)
    if found is None:
        pytest.skip(f"Radiance's {name} is not here")
    return found


def run(*command, data=b""):
    return subprocess.run(command, input=data, stdout=subprocess.PIPE, check=True).stdout


def by_pvalue(data, *options):
    """(height, width, 3) as Radiance states them, row 0 at the bottom; it adds half a step to every component."""
    text = run(program("pvalue"), "-h", "-H", *options, data=data).decode()
    rows = np.array([[float(x) for x in line.split()] for line in text.splitlines()])
    width, height = rows[:, :2].max(axis=0).astype(int) + 1
    made = np.zeros((height, width, 3))
    made[rows[:, 1].astype(int), rows[:, 0].astype(int)] = rows[:, 2:]
    return made


def read(data):
    header = read_header(data, "some.hdr")
    return header, decode(data, header, "some.hdr")


def colours(height=9, width=20, seed=0):
    made = np.random.default_rng(seed).random((height, width, 3)) ** 4 * 30
    made[2:4, 3:15] = (0.5, 0.25, 2.0)
    made[0, 0] = 0.0
    return made


def agree(found, stated):
    """Within the half step that Radiance adds, which depends on the brightest component."""
    step = 2.0 ** np.floor(np.log2(np.maximum(stated.max(axis=-1, keepdims=True), 1e-30))) / 128
    assert (np.abs(found - stated) <= 0.51 * step + 2e-3 * stated).all()


@pytest.mark.parametrize("order", ["-Y +X", "+Y +X", "-Y -X", "+Y -X", "+X -Y", "-X -Y", "-X +Y"])
@pytest.mark.parametrize("packed", [False, True], ids=["flat", "runs"])
def test_pixels_lie_where_radiance_puts_them(order, packed):
    data = write_picture(colours(), order=order, packed=packed)
    header, found = read(data)
    assert header.order == order
    agree(found, by_pvalue(data))


def test_pictures_packed_by_radiance_are_read():
    made = run(program("ra_xyze"), "-r", "-c", data=write_picture(colours(30, 200)))
    assert bytes((2, 2, 0, 200)) in made
    agree(read(made)[1], by_pvalue(made))


def test_the_oldest_way_of_repeating_pixels_is_read():
    flat = np.tile((0.5, 0.25, 1.0), (1, 300, 1))
    head, body = write_picture(flat)[:-1200], write_picture(flat)[-1200:]
    # One pixel, 41 + 256 more of it, and two more.
    data = head + body[:4] + bytes((1, 1, 1, 41)) + bytes((1, 1, 1, 1)) + body[:8]
    header, found = read(data)
    assert header.length == 300
    np.testing.assert_allclose(found, flat, rtol=1e-6)


def test_exposures_multiply_and_are_those_of_radiance():
    lines = ["EXPOSURE=2.0", "\tEXPOSURE=100", "COLORCORR=1 2 4", "EXPOSURE= 4", "COLORCORR=.5 1 1"]
    data = write_picture(colours(), lines)
    header, found = read(data)
    assert header.exposure == 8.0
    assert header.correction == (0.5, 2.0, 4.0)
    agree(found, by_pvalue(data, "-o") * 8.0 * header.correction)


def test_xyze_keeps_the_luminance_and_the_chromaticity():
    xyz = (colours()[..., :1] + 0.3) * (0.9, 1.0, 1.1)
    data = write_picture(xyz, encoding=XYZE)
    _, found = read(data)
    luminance = found @ np.array([0.2126, 0.7152, 0.0722])
    np.testing.assert_allclose(luminance, by_pvalue(data)[..., 1], rtol=0.02)
    # Radiance's own conversion to the same primaries, which divides by its efficacy.
    primaries = ["0.64", "0.33", "0.30", "0.60", "0.15", "0.06", "0.3127", "0.3290"]
    made = run(program("ra_xyze"), "-r", "-o", "-p", *primaries, data=data)
    luminance_there = by_pvalue(made) @ np.array([0.2126, 0.7152, 0.0722]) * WHITE_EFFICACY
    np.testing.assert_allclose(luminance, luminance_there, rtol=0.03)


def test_zeros_for_primaries_say_nothing():
    assert read(write_picture(colours(), ["PRIMARIES=0 0 0 0 0 0 0 0"]))[0].primaries is None
    header, _ = read(
        write_picture(colours(), ["PRIMARIES= .6 .3 .2 .7 .1 .1 .33 .33", "GAMMA=2.2"])
    )
    assert header.primaries == (0.6, 0.3, 0.2, 0.7, 0.1, 0.1, 0.33, 0.33)
    assert header.gamma == 2.2


FAULTY = {
    "no picture": (b"#?RADIANCE\nFORMAT=ascii", "expected a Radiance picture"),
    "exposure of zero": (write_picture(colours(), ["EXPOSURE=0"]), "line 2: EXPOSURE is '0'"),
    "exposure in words": (write_picture(colours(), ["EXPOSURE=bright"]), "'bright', expected 1 number"),
    "nan": (write_picture(colours(), ["EXPOSURE=nan"]), "expected 1 number above 0"),
    "two corrections": (write_picture(colours(), ["COLORCORR=1 2"]), "expected 3 numbers above 0"),
    "exposures without end": (write_picture(colours(), ["EXPOSURE=1e300"] * 2), "no usable number"),
    "two rows": (write_picture(colours(), order="-Y +Y"), "expected a size such as"),
    "spectra": (write_picture(colours(), encoding="Radiance_spectra"), "FORMAT is 'Radiance_spectra'"),
    "cut": (write_picture(colours())[:-30], "end early"),
    "cut run": (write_picture(colours(), packed=True)[:-9], "damaged or end early"),
    "huge": (write_picture(colours()).replace(b"-Y 9 +X 20", b"-Y 16000 +X 16000"), "ends early"),
    "too huge": (write_picture(colours()).replace(b"-Y 9 +X 20", b"-Y 90000 +X 90000"), "expected 1 to"),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTY)
def test_what_is_wrong_is_said_in_a_sentence(name):
    data, expected = FAULTY[name]
    with pytest.raises(FileFormatError, match=r"some\.hdr") as caught:
        read(data)
    assert expected in str(caught.value)


@pytest.mark.parametrize("seed", range(40))
def test_damaged_files_are_read_or_refused(seed):
    chance = np.random.default_rng(seed)
    data = bytearray(write_picture(colours(), ["EXPOSURE=2"], packed=bool(seed % 2)))
    for _ in range(chance.integers(1, 12)):
        data[chance.integers(len(data))] = chance.integers(256)
    try:
        header, found = read(bytes(data[: chance.integers(len(data) // 2, len(data) + 1)]))
    except FileFormatError:
        return
    assert found.shape[0] * found.shape[1] == header.lines * header.length


def test_the_helper_writes_what_radiance_reads():
    agree(by_pvalue(write_picture(colours(), encoding=RGBE)), colours())
