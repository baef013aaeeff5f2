"""Tensor files: evaluated like Mitsuba's own plug-in does, written for it, and refused where they are wrong."""

import struct

import numpy as np
import pytest
from scattering_models import directions
from tensor_files import measured_like

from lumenray.engine.errors import FileFormatError
from lumenray.engine.scattering.data.evaluation import albedo, evaluate
from lumenray.engine.scattering.readers.marginal_warp import MarginalWarp, Slices
from lumenray.engine.scattering.readers.tensor_file import (
    SIGNATURE,
    TensorMaterial,
    is_tensor_file,
    pack_fields,
    parse_tensor_file,
    read_tensor_file,
    write_tensor_file,
)

PI = np.pi

WAVELENGTHS = [400.0, 450.0, 550.0, 690.0]
"""At which Mitsuba is asked. [nm]"""

AZIMUTHS = {
    "isotropic": (0.0,),
    "whole turn": np.linspace(-PI, PI, 9),
    "half turn": np.linspace(-PI, 0.0, 7),
    "quarter turn": np.linspace(-PI, -0.5 * PI, 5),
}


def lobe(width_degrees, matt=0.1):
    """Matt and a bell of the half vector's angle, coloured."""

    def values(wi, wo):
        half = (wi + wo) / np.linalg.norm(wi + wo, axis=1, keepdims=True)
        angle = np.arccos(np.clip(half[:, 2], -1.0, 1.0))
        f = matt + 1.5 * np.exp(-0.5 * (angle / np.radians(width_degrees)) ** 2)
        return f[:, None] * np.array([1.0, 0.5, 0.25])

    return values


@pytest.fixture
def mitsuba():
    """Mitsuba with spectra; the variant of other tests is set again afterwards."""
    mi = pytest.importorskip("mitsuba")
    before = mi.variant()
    mi.set_variant("scalar_spectral")
    yield mi
    if before is not None:
        mi.set_variant(before)


def ask_mitsuba(mi, path, wi, wo):
    """Values of its plug-in at `WAVELENGTHS`: BRDF times the cosine. (n, 4)"""
    material = mi.load_dict({"type": "measured", "filename": str(path)})
    place, context = mi.SurfaceInteraction3f(), mi.BSDFContext()
    place.wavelengths = WAVELENGTHS
    found = []
    for towards, away in zip(wi, wo, strict=True):
        place.wi = mi.Vector3f(towards)
        found.append(list(material.eval(context, place, mi.Vector3f(away))))
    return np.array(found)


# ---- against Mitsuba ----


@pytest.mark.mitsuba
@pytest.mark.parametrize("name", AZIMUTHS)
@pytest.mark.parametrize("has_facets", [True, False])
def test_values_are_those_of_mitsuba(tmp_path, mitsuba, name, has_facets):
    data = measured_like(
        AZIMUTHS[name], roughness=(0.3, 0.2), jacobian=np.full(1, has_facets, np.uint8)
    )
    path = tmp_path / "material.bsdf"
    path.write_bytes(data)
    wi, wo = directions(2000, 1, 0.02), directions(2000, 2, 0.02)
    expected = ask_mitsuba(mitsuba, path, wi, wo)
    f = parse_tensor_file(data, path).evaluate(wi, wo) * wo[:, 2:]
    # The file has 400, 500, 550 and 700 nm; between them spectra are linear.
    mine = np.stack([np.interp(WAVELENGTHS, [400.0, 500.0, 550.0, 700.0], row) for row in f])
    np.testing.assert_allclose(mine, expected, rtol=1e-3)


@pytest.mark.mitsuba
def test_mitsuba_reads_what_is_written_and_chooses_directions_well(tmp_path, mitsuba):
    """With 64 x 64 points: below 1 % root mean square, and nearly constant weights (the specification's figures)."""
    path, true = tmp_path / "written.bsdf", lobe(8.7)
    theta = np.radians([0.0, 10, 20, 30, 40, 50, 60, 70, 80, 85, 89])
    data = write_tensor_file(path, true, theta, [400.0, 550.0, 690.0], 64, "made for a test")
    assert path.read_bytes() == data
    rng = np.random.default_rng(4)
    tilt = rng.choice(theta[1:8], 1500)
    wi = np.stack([np.sin(tilt), 0.0 * tilt, np.cos(tilt)], axis=1)
    wo = directions(1500, 5, 0.2)
    found = ask_mitsuba(mitsuba, path, wi, wo)[:, [0, 2, 3]]
    expected = true(wi, wo) * wo[:, 2:]
    relative = (found - expected) / (expected + 0.02 * wo[:, 2:])
    assert np.sqrt((relative**2).mean()) < 0.01
    # Weights of sampled directions: their mean is the albedo, and none is much larger.
    material = mitsuba.load_dict({"type": "measured", "filename": str(path)})
    place, context = mitsuba.SurfaceInteraction3f(), mitsuba.BSDFContext()
    place.wavelengths, place.wi = WAVELENGTHS, mitsuba.Vector3f(0.5, 0.0, np.sqrt(0.75))
    weights = np.array(
        [list(material.sample(context, place, 0.5, list(u))[1]) for u in rng.random((2000, 2))]
    )[:, 0]
    share = albedo(read_tensor_file(data, path, tolerance=0.05).sides["front_reflection"], PI / 6)
    assert weights.mean() == pytest.approx(share[0], rel=0.02)
    assert weights.max() < 2.5 * share[0]


# ---- the warp ----


def test_a_density_that_is_known_is_made_even():
    """Of (1 + x)(1 + 2 y) the integrals are (x + x^2 / 2) / 1.5 and (y + y^2) / 2."""
    x, y = np.meshgrid(np.linspace(0.0, 1.0, 4), np.linspace(0.0, 1.0, 3))
    warp = MarginalWarp(((1.0 + x) * (1.0 + 2.0 * y))[None, None], Slices([[0.0], [0.0]]))
    rng = np.random.default_rng(3)
    x, y = rng.random((2, 500))
    u, v = warp.make_even(x, y, warp.slices.corners((np.zeros(500), np.zeros(500))))
    np.testing.assert_allclose(u, (x + 0.5 * x**2) / 1.5, rtol=1e-12)
    np.testing.assert_allclose(v, (y + y**2) / 2.0, rtol=1e-12)


# ---- tables ----


def test_a_table_is_what_was_written():
    true = lobe(25.0)
    theta = np.radians([0.0, 10, 20, 30, 40, 50, 60, 70, 80, 89])
    data = write_tensor_file(None, true, theta, [400.0, 550.0, 690.0], 80)
    assert is_tensor_file(data)
    file = read_tensor_file(data, "made.bsdf", tolerance=0.04)
    table = file.sides["front_reflection"]
    np.testing.assert_allclose(np.degrees(file.incidences), np.degrees(theta), atol=1e-4)
    assert table.error < 0.05
    wi, wo = directions(3000, 6, 0.2), directions(3000, 7, 0.2)
    relative = evaluate(table, wi, wo) / true(wi, wo) - 1.0
    assert np.sqrt((relative**2).mean()) < 0.03


def test_light_from_all_sides_is_told_by_the_symmetry_of_the_file():
    flat = {
        "jacobian": np.zeros(1, np.uint8),
        "vndf": np.ones((7, 5, 2, 2)),
        "spectra": np.full((7, 5, 4, 16, 16), 0.2),
    }
    file = read_tensor_file(measured_like(AZIMUTHS["half turn"], **flat), "x", tolerance=0.5)
    table = file.sides["front_reflection"]
    np.testing.assert_allclose(np.degrees(table.rotations), np.arange(0.0, 360.0, 30.0), atol=1e-3)


def test_greys_of_coloured_files_are_the_same_at_all_wavelengths():
    grey = np.full((1, 5, 3, 16, 16), 0.3)
    file = parse_tensor_file(measured_like(is_rgb=True, rgb=grey), "x")
    wi, wo = directions(200, 8, 0.02), directions(200, 9, 0.02)
    values = file.evaluate(wi, wo)
    np.testing.assert_allclose(values, np.broadcast_to(values[:, :1], values.shape), rtol=1e-5)
    assert "colours" in str(file.remarks[0])


def test_fine_wavelengths_are_read_at_steps_of_ten_nanometres():
    fine = np.linspace(300.0, 1000.0, 281)
    spectra = np.broadcast_to((fine / 1000.0)[:, None, None], (1, 2, 281, 4, 4))
    shape = {"vndf": np.ones((1, 2, 2, 2)), "luminance": np.ones((1, 2, 4, 4))}
    data = measured_like(
        incidences=(0.1, 1.0), wavelengths=fine, spectra=spectra, jacobian=np.zeros(1, np.uint8), **shape
    )  # fmt: skip
    material = parse_tensor_file(data, "x")
    assert material.wavelengths[0] == 360.0
    assert material.wavelengths[-1] == 830.0
    assert np.diff(material.wavelengths).max() <= 10.5
    np.testing.assert_allclose(material.values[0, 0, 0], material.wavelengths / 1000.0, rtol=1e-5)


def test_what_no_table_gets_right_takes_few_evaluations_for_each_value(monkeypatch):
    """A matt surface whose stored density is noise, under which all values lie elsewhere at each angle of incidence."""
    rng = np.random.default_rng(1)
    theta = np.radians([0.0, 15, 30, 45, 60, 75, 89])
    data = measured_like(
        incidences=theta,
        wavelengths=[550.0],
        spectra=rng.uniform(0.05, 0.2, (1, 7, 1, 16, 16)),
        vndf=rng.exponential(size=(1, 7, 2, 40)),
        jacobian=np.zeros(1, np.uint8),
    )
    asked, evaluate_it = [], TensorMaterial.evaluate

    def count(self, wi, wo):
        asked.append(len(wi))
        return evaluate_it(self, wi, wo)

    monkeypatch.setattr(TensorMaterial, "evaluate", count)
    table = read_tensor_file(data, "noise.bsdf").sides["front_reflection"]
    assert table.values.size > 500_000
    assert sum(asked) < 3.0 * table.values.size
    # What it says of itself still holds, and its totals are those of the file.
    material = parse_tensor_file(data, "noise.bsdf")
    wi, wo = directions(20_000, 3, 0.05), directions(20_000, 4, 0.05)
    true = evaluate_it(material, wi, wo)
    relative = (evaluate(table, wi, wo) - true) / (true + 0.05 * true.mean())
    assert np.sqrt((relative**2).mean()) < 1.2 * table.error


# ---- what is wrong ----


def claim(**shapes) -> bytes:
    """A head that claims arrays of shapes, with nothing behind it."""
    head = [SIGNATURE, struct.pack("<BBI", 1, 0, len(shapes))]
    for name, shape in shapes.items():
        head.append(struct.pack("<H", len(name)) + name.encode())
        head.append(struct.pack(f"<HBQ{len(shape)}Q", len(shape), 10, 64, *shape))
    return b"".join(head)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (SIGNATURE, "cut short"),
        (SIGNATURE + b"\2\0" + bytes(4), "version 2, expected 1"),
        (SIGNATURE + b"\1\0" + b"\xff" * 4, "states 4294967295 fields, expected at most 64"),
        (claim(spectra=(1, 8, 195, 1 << 14, 1 << 14)), "cut short: the field 'spectra' ends"),
        (claim(spectra=(1 << 62, 1 << 62)), "cut short"),
        (claim(spectra=(1,) * 9), "of 9 axes"),
        (measured_like()[:-5], "cut short"),
        (measured_like(without=("vndf",)), "lacks the field 'vndf'"),
        (measured_like(without=("spectra",)), "lacks the field 'spectra'"),
        (measured_like(theta_i=[0.1, 0.1, 0.2, 0.3, 0.4]), "'theta_i' that does not ascend"),
        (
            measured_like(wavelengths=[400.0, 500.0, 600.0], spectra=np.ones((1, 5, 4, 4, 4))),
            "expected float32 1 x 5 x 3",
        ),
        (measured_like(vndf=-np.ones((1, 5, 4, 4))), "negative"),
        (measured_like(vndf=np.zeros((1, 5, 4, 4))), "nothing but zeros"),
        (measured_like(spectra=np.full((1, 5, 4, 8, 8), np.nan)), "no numbers"),
        (measured_like(spectra=np.ones((1, 5, 4, 8, 9))), "expected a square"),
        (measured_like(spectra=np.ones((1, 5, 4, 1, 1))), "fewer than two"),
        (measured_like(jacobian=np.ones(2, np.uint8)), "expected one"),
        (measured_like(ndf=np.ones(3)), "expected float32"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(data, message):
    with pytest.raises(FileFormatError, match=message) as caught:
        read_tensor_file(data, "material.bsdf")
    assert "material.bsdf" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_arrays_come_back_as_they_were_packed():
    arrays = {"a": np.arange(7, dtype=np.float32), "long name": np.arange(3, dtype=np.uint8)}
    data = pack_fields(arrays)
    assert data[:14] == SIGNATURE + b"\1\0"
    # Name length, name, axes, type, offset, shape: as the format's description has it.
    assert data[18:20] == b"\1\0"
    axes, kind, offset, count = struct.unpack_from("<HBQQ", data, 21)
    assert (axes, kind, count) == (1, 10, 7)
    assert offset % 8 == 0
    np.testing.assert_array_equal(np.frombuffer(data, "<f4", 7, offset), arrays["a"])
