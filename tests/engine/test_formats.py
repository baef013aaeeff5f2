"""Files in and out: spectra, sensor lists, OpenEXR, reports."""

import json
import re

import numpy as np
import pytest
from lumenray.engine.errors import FileFormatError
from lumenray.engine.formats import exr, sensors
from lumenray.engine.formats.spd import read_spectrum

FICHET = re.compile(r"^S0\.(\d+),(\d+)nm$")


def written(tmp_path, text, name="spectrum.csv"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize(
    "text",
    [
        "400 1\n500 2\n600 3\n",
        "nm,value\n400,1.0\n500,2.0\n600,3.0\n",
        "# heading\n600;3,0\r\n500;2,0\r\n400;1,0\r\n",
        "\ufeffwavelength\tpower\n400\t1e0\n500\t2.0D0\n600\t3\n",
        '<?xml version="1.0"?><IESTM2714 xmlns="iestm2714"><SpectralDistribution>'
        '<SpectralData wavelength="400">1</SpectralData><SpectralData wavelength="500">2</SpectralData>'
        '<SpectralData wavelength="600">3</SpectralData></SpectralDistribution></IESTM2714>',
    ],
)
def test_spectra_are_read_in_all_common_layouts(tmp_path, text):
    made = read_spectrum(written(tmp_path, text)).table
    assert made.wavelengths.tolist() == [400, 500, 600]
    assert made.values.tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("400 1\n500 x\n", 2, "expected wavelength and value"),
        ("400 1\n400 2\n", 2, "stands twice"),
        ("400 1\n500 nan\n", 2, "finite"),
        ("400 1\n500 -1\n", 2, "at least 0"),
        ("0.4 1\n0.5 2\n", None, "nanometres"),
        ("only words\n", None, "at least two rows"),
        ("", None, "at least two rows"),
        (b"\xff\xfe4\x000\x00", None, "UTF-16"),
        ("<?xml version='1.0'?><!DOCTYPE a [<!ENTITY b 'c'>]><IESTM2714/>", 1, "refused"),
        ("<?xml version='1.0'?><IESTM2714>", 1, "well-formed"),
    ],
)
def test_a_bad_spectrum_is_refused_with_file_line_and_expectation(tmp_path, text, line, words):
    path = written(tmp_path, text)
    with pytest.raises(FileFormatError, match=words) as caught:
        read_spectrum(path)
    assert caught.value.line == line
    assert str(path) in str(caught.value)


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


def test_exr_channels_survive_an_independent_reader(tmp_path):
    openexr = pytest.importorskip("OpenEXR")
    values = np.arange(12, dtype=np.float32).reshape(3, 4) * 1000.5
    path = exr.write_channels(tmp_path / "lux.exr", {"Y": values}, {"unit": "lx"})
    with openexr.File(str(path), separate_channels=True) as file:
        # OpenEXR's first row is the top one.
        assert np.array_equal(file.channels()["Y"].pixels[::-1], values)
        assert file.channels()["Y"].pixels.dtype == np.float32
        assert file.header()["unit"] == "lx"


def test_spectral_exr_has_the_published_layout(tmp_path):
    openexr = pytest.importorskip("OpenEXR")
    edges = np.linspace(380.0, 780.0, 6)
    bands = np.random.default_rng(1).random((2, 3, 5)).astype(np.float32)
    path = exr.write_channels(
        tmp_path / "s.exr", exr.spectral_channels(bands, edges), exr.SPECTRAL_ATTRIBUTES
    )
    with openexr.File(str(path), separate_channels=True) as file:
        header, channels = file.header(), file.channels()
        found = {}
        for name in channels:
            whole, part = FICHET.match(name).groups()
            found[float(f"{whole}.{part}")] = channels[name].pixels[::-1]
        assert header["spectralLayoutVersion"] == "1.0"
        assert header["emissiveUnits"] == "W.m^-2.sr^-1"
    assert sorted(found) == [420.0, 500.0, 580.0, 660.0, 740.0]
    for i, nm in enumerate(sorted(found)):
        assert np.array_equal(found[nm], bands[..., i])


def test_an_unwritable_place_is_said(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("x")
    with pytest.raises(FileFormatError, match="cannot be written"):
        exr.write_channels(blocked / "a.exr", {"Y": np.zeros((2, 2), np.float32)})


def test_false_colours_are_ordered_and_round(tmp_path):
    from lumenray.engine.analysis.false_colour import colours, nice_maximum, write_false_colour

    assert nice_maximum(np.array([730.0])) == 800.0
    assert nice_maximum(np.array([0.0])) == 1.0
    ends = colours(np.array([-5.0, 0.0, 100.0, 500.0]), 0.0, 100.0)
    assert np.array_equal(ends[0], ends[1])
    assert np.array_equal(ends[2], ends[3])
    assert not np.array_equal(ends[1], ends[2])
    path = write_false_colour(tmp_path / "m.png", np.ones((4, 5)), np.ones((4, 5), bool), "Floor")
    from PIL import Image

    assert Image.open(path).size[0] > 100


def test_reports_are_json_with_the_stated_fields(tmp_path):
    from lumenray.engine.formats.report import compose, write_json
    from lumenray.engine.session import Provenance

    provenance = Provenance("0.1.0", "llvm_ad_mono", "abc", 3, 64, 1.5)
    path = write_json(tmp_path / "r.json", compose("a.blend", provenance, 2.0, []))
    made = json.loads(path.read_text())
    assert made["engine"] == {"version": "0.1.0", "variant": "llvm_ad_mono"}
    assert made["scene"] == {"file": "a.blend", "hash": "abc"}
    assert made["seed"] == 3


def test_smoothing_removes_noise_but_keeps_edges_and_texture():
    from lumenray.engine.analysis.noise_filter import smooth

    rng = np.random.default_rng(7)
    height, width = 64, 96
    truth = np.full((height, width), 0.5)
    truth[:, 48:] = 0.2
    normal = np.zeros((height, width, 3))
    normal[:, :48, 2] = 1.0
    normal[:, 48:, 0] = 1.0
    albedo = np.where((np.arange(width) // 3 % 2 == 0)[None, :, None], 0.8, 0.2) * np.ones(
        (height, width, 3)
    )
    clean = truth[..., None] * albedo
    sigma = 0.3
    noisy = clean * (1.0 + sigma * rng.normal(size=(height, width, 1)))
    error = np.abs(sigma * (clean @ [0.2126, 0.7152, 0.0722]) * rng.normal(size=(height, width)))
    made = smooth(noisy, error, normal, np.full((height, width), 3.0), albedo)
    before = np.sqrt(((noisy - clean) ** 2).mean())
    assert np.sqrt(((made - clean) ** 2).mean()) < 0.3 * before
    # The step between the two walls and the stripes of the texture stay sharp.
    light = made[..., 0] / albedo[..., 0]
    assert light[:, 46:48].mean() == pytest.approx(0.5, rel=0.05)
    assert light[:, 48:50].mean() == pytest.approx(0.2, rel=0.05)
