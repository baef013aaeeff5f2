"""OpenEXR files, by a reader of another program."""

import re

import numpy as np
import pytest

from lumenray.engine.errors import FileFormatError
from lumenray.engine.formats import exr

FICHET = re.compile(r"^S0\.(\d+),(\d+)nm$")


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
