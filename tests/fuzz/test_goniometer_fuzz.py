"""Damaged scattering files: whatever stands in them, they are read or refused in one sentence, with little memory."""

import functools
import struct

import numpy as np
import pytest
from goniometer_files import about_mirror, about_normal, e1392, in_plane, lobe
from instruments import measure, paint
from memory import peak_memory
from mutations import mutate
from tensor_files import measured_like

from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.scattering.data.table import check_table
from lumenray.engine.scattering.measuring.calibration import calibrate
from lumenray.engine.scattering.measuring.processing import process_measurement
from lumenray.engine.scattering.measuring.raw_measurement import (
    is_raw_measurement,
    read_raw_measurement,
)
from lumenray.engine.scattering.readers.goniometer import is_goniometer, read_goniometer
from lumenray.engine.scattering.readers.merl import SHAPE, SIZE, is_merl, read_merl
from lumenray.engine.scattering.readers.tensor_file import (
    SIGNATURE,
    is_tensor_file,
    parse_tensor_file,
    read_tensor_file,
)

ROUNDS = 350
"""Damages of every kind of file."""

MOST_MEMORY = 192 << 20
"""That damaged files of some kilobytes may make the process grow. [byte]"""

FEW = np.arange(0.0, 81.0, 20.0), np.arange(0.0, 181.0, 60.0)


@functools.cache
def raw_text() -> bytes:
    bands = np.array([450.0, 650.0])
    raw = measure(paint(bands), bands, np.radians([20.0]), radials=np.radians([0.0, 10.0, 40.0]))
    lines = [
        "# lumenray raw measurement 1",
        "# white brdf: 0.31",
        "# readout: 3",
        "# resolution: 1",
    ]
    lines.append("sigma theta phi wavelength sample sample_reference white white_reference")
    piece = raw.slices[0]
    channels = piece.sample, piece.sample_reference, piece.white, piece.white_reference
    for d in range(len(piece.radial)):
        angles = np.degrees([piece.incidence, piece.radial[d], piece.azimuth[d]])
        for w, band in enumerate(bands):
            row = [*angles, band, *(counts[d, w] for counts in channels)]
            lines.append(" ".join(f"{value:.6g}" for value in row))
    return "\n".join(lines).encode()


TEXTS = {
    "normal": about_normal(lobe, (0, 50), polars=FEW[0], azimuths=FEW[1]),
    "unstated": about_normal(lobe, (30,), polars=FEW[0], azimuths=FEW[1], quantity=None),
    "mirror": about_mirror(lobe, (10, 60), radials=FEW[0], azimuths=FEW[1]),
    "anisotropic": about_mirror(lobe, (0, 60), (0, 90), radials=FEW[0], azimuths=FEW[1]),
    "plane": in_plane(lobe, (10, 60), np.arange(-80.0, 81.0, 20.0)),
    "e1392": e1392(lobe),
}

SMALL = {"incidences": (0.1, 1.0), "wavelengths": (450.0, 650.0), "side": 4}

TENSORS = {
    "isotropic": measured_like(**SMALL),
    "anisotropic": measured_like(np.linspace(-np.pi, 0.0, 4), **SMALL),
    "colours": measured_like(is_rgb=True, **SMALL),
}


def damage_binary(data: bytes, rng) -> bytes:
    """Damage of bytes, or of numbers of four or eight bytes in the head."""
    if rng.random() < 0.4:
        return mutate(data, rng)
    changed = bytearray(data)
    values = (0, 1, 2, 255, 0x7FFFFFFF, 0xFFFFFFFF, 1 << 40, (1 << 64) - 1, 0x7FC00000, 0x7F800000)
    for _ in range(rng.integers(1, 4)):
        # The list of fields takes some 400 bytes.
        size = 400 if rng.random() < 0.8 else len(changed)
        width = int(rng.choice([1, 2, 4, 8]))
        at = int(rng.integers(12, max(size - width, 13)))
        value = values[rng.integers(len(values))] & ((1 << 8 * width) - 1)
        changed[at : at + width] = value.to_bytes(width, "little")
    return bytes(changed)


def try_all(data: bytes, damage, read, seed: int) -> int:
    """How many of the damaged files were read; all others are refused in a sentence."""
    rng = np.random.default_rng(seed)
    count, before = 0, peak_memory()
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        for _ in range(ROUNDS):
            try:
                read(damage(data, rng))
            except FileFormatError as error:
                assert "\n" not in str(error)
                continue
            count += 1
    assert peak_memory() - before < MOST_MEMORY
    return count


@pytest.mark.parametrize("name", TEXTS)
@pytest.mark.slow
def test_damaged_texts_are_read_or_refused(name):
    def read(data):
        is_goniometer(data)
        file = read_goniometer(data, "sample.txt", tolerance=0.5)
        for table in file.sides.values():
            check_table(table)
        assert all(str(remark) for remark in file.remarks)

    read(TEXTS[name])
    count = try_all(TEXTS[name], mutate, read, list(TEXTS).index(name))
    # Both happen, or the damage is of the wrong size.
    assert 0 < count < ROUNDS


@pytest.mark.parametrize("name", TENSORS)
def test_damaged_tensor_files_are_read_or_refused(name):
    rng = np.random.default_rng(3)
    z, turn = rng.uniform(0.1, 1.0, (2, 20)), rng.uniform(0.0, 2.0 * np.pi, (2, 20))
    sine = np.sqrt(1.0 - z**2)
    wi, wo = np.stack([sine * np.cos(turn), sine * np.sin(turn), z], axis=2)

    def read(data):
        is_tensor_file(data)
        values = parse_tensor_file(data, "material.bsdf").evaluate(wi, wo)
        assert np.isfinite(values).all()
        assert values.min() >= 0.0

    count = try_all(TENSORS[name], damage_binary, read, 10 + list(TENSORS).index(name))
    assert 0 < count < ROUNDS


def test_damaged_counts_are_read_or_refused():
    def read(data):
        is_raw_measurement(data)
        raw = read_raw_measurement(data, "raw.csv")
        for piece in calibrate(raw):
            assert np.nanmin(np.nan_to_num(piece.values, nan=1.0)) > 0.0
            assert np.isfinite(piece.variance[np.isfinite(piece.values)]).all()

    count = try_all(raw_text(), mutate, read, 20)
    assert 0 < count < ROUNDS


def test_damaged_counts_that_are_read_become_tables_or_are_refused():
    rng = np.random.default_rng(21)
    made = 0
    for _ in range(12):
        try:
            done = process_measurement(read_raw_measurement(mutate(raw_text(), rng), "raw.csv"))
        except (FileFormatError, SceneError) as error:
            assert "\n" not in str(error)
            continue
        check_table(done.table)
        made += 1
    assert made > 0


def test_damaged_heads_of_merl_files_are_refused():
    rng = np.random.default_rng(30)
    head = struct.pack("<3i", *SHAPE)
    before = peak_memory()
    for _ in range(ROUNDS):
        data = mutate(head + rng.bytes(int(rng.integers(200))), rng)
        is_merl(data)
        with pytest.raises(FileFormatError) as caught:
            read_merl(data, "material.binary")
        assert "\n" not in str(caught.value)
    assert peak_memory() - before < MOST_MEMORY


@pytest.mark.slow
def test_merl_files_of_noise_are_read_or_refused():
    """Of the right size, with any bits as numbers: what is no data is filled, and nothing becomes infinite."""
    rng = np.random.default_rng(31)
    data = struct.pack("<3i", *SHAPE) + rng.bytes(SIZE - 12)
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        table = read_merl(data, "x", tolerance=1e3).sides["front_reflection"]
    check_table(table)


@pytest.mark.parametrize(
    ("data", "read"),
    [
        (
            SIGNATURE + struct.pack("<BBIH7sHBQ2Q", 1, 0, 1, 7, b"spectra", 2, 10, 64, 1 << 15, 1 << 15),
            read_tensor_file,
        ),
        (
            SIGNATURE + struct.pack("<BBIH7sHBQ2Q", 1, 0, 1, 7, b"spectra", 2, 10, 1 << 63, 1 << 40, 0),
            read_tensor_file,
        ),
        (struct.pack("<3i", 1024, 1024, 512), read_merl),
        (struct.pack("<3i", *SHAPE), read_merl),
        (b"NUM_POINTS 4000000000\nVARS theta_i,phi_i,theta_s,phi_s,450nm\n0,0,0,0,0.1\n", read_goniometer),
    ],
)  # fmt: skip
def test_claims_of_gigabytes_take_no_memory(data, read):
    before = peak_memory()
    with pytest.raises(FileFormatError):
        read(data, "claim")
    assert peak_memory() - before < 16 << 20


def test_a_long_line_takes_no_time():
    for text in (b"# " + b" a" * 500_000, b"# a" + b" " * 1_000_000 + b"x", b"theta_i " * 100_000):
        with pytest.raises(FileFormatError):
            read_goniometer(text, "long")
