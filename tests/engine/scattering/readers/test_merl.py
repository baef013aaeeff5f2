"""MERL files: cells lie where the format's own index says, values are in 1/sr, holes are filled, other files are refused."""

import functools
import struct

import numpy as np
import pytest
from scattering_models import directions

from lumenray.engine.errors import FileFormatError
from lumenray.engine.scattering.data.evaluation import albedo, evaluate
from lumenray.engine.scattering.readers.merl import (
    SHAPE,
    SIZE,
    cell_middles,
    directions_of,
    half_angles,
    is_merl,
    parse_merl,
    read_merl,
)

SCALES = 1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0


def pack(rgb) -> bytes:
    """A file of red, green and blue BRDFs of the shape of the cells."""
    planes = [
        np.broadcast_to(values, SHAPE) / scale for values, scale in zip(rgb, SCALES, strict=True)
    ]
    return struct.pack("<3i", *SHAPE) + np.stack(planes).astype("<f8").tobytes()


@functools.cache
def cells():
    """Pairs of directions in the middle of the cells, and which are above the horizon."""
    wi, wo = directions_of(*np.meshgrid(*cell_middles(), indexing="ij", sparse=True))
    return wi, wo, (wi[..., 2] > 0.0) & (wo[..., 2] > 0.0)


def blinn(wi, wo):
    """Matt and a lobe of the half vector's angle, with Fresnel's rise. [1/sr]"""
    half = (wi + wo) / np.linalg.norm(wi + wo, axis=-1, keepdims=True)
    fresnel = 0.1 + 0.9 * (1.0 - np.clip((wi * half).sum(axis=-1), 0.0, 1.0)) ** 5
    return 0.2 / np.pi + 2.0 * fresnel * np.maximum(half[..., 2], 0.0) ** 200


@functools.cache
def glossy() -> bytes:
    wi, wo, above = cells()
    f = np.where(above, blinn(wi, wo), -1.0)
    return pack([f, f, f])


def test_angles_of_the_half_vector_are_those_of_the_directions():
    wi, wo, _ = cells()
    found = half_angles(wi.reshape(-1, 3), wo.reshape(-1, 3))
    for angle, wanted in zip(found, np.meshgrid(*cell_middles(), indexing="ij"), strict=True):
        np.testing.assert_allclose(angle, wanted.ravel(), atol=1e-11)


def test_a_matt_surface_has_the_same_value_and_albedo_everywhere():
    file = read_merl(pack([0.5 / np.pi] * 3), "matt.binary")
    assert is_merl(pack([0.5 / np.pi] * 3))
    table = file.sides["front_reflection"]
    values = evaluate(table, directions(500, 1, 0.1), directions(500, 2, 0.1))
    np.testing.assert_allclose(values, 0.5 / np.pi, rtol=1e-5)
    for angle in (0.0, 0.6, 1.2):
        np.testing.assert_allclose(albedo(table, angle), 0.5, rtol=1e-4)
    assert "primaries" in str(file.remarks[0])


def test_cells_lie_where_the_index_of_the_format_says():
    """phi_d + 180 (theta_d + 90 theta_h), with theta_h index = 90 sqrt(theta_h / 90 degrees)."""
    rng = np.random.default_rng(5)
    flat = np.full(SHAPE, 0.1).ravel()
    chosen = [(12, 30, 40), (40, 10, 150), (3, 60, 89)]
    marks = rng.uniform(1.0, 2.0, len(chosen))
    for (h, d, p), value in zip(chosen, marks, strict=True):
        # The other side of the plane of incidence too, which is taken to be alike.
        flat[p + 180 * (d + 90 * h)] = flat[(179 - p) + 180 * (d + 90 * h)] = value
    material = parse_merl(pack([flat.reshape(SHAPE)] * 3), "x")
    for (h, d, p), value in zip(chosen, marks, strict=True):
        half = np.radians(90.0 * ((h + 0.5) / 90.0) ** 2)
        difference, turn = np.radians(d + 0.5), np.radians(p + 0.5)
        # By hand: the difference turned about y to the half vector, which lies over +x.
        towards = np.array(
            [
                np.sin(difference) * np.cos(turn),
                np.sin(difference) * np.sin(turn),
                np.cos(difference),
            ]
        )
        turned = np.array(
            [[np.cos(half), 0, np.sin(half)], [0, 1, 0], [-np.sin(half), 0, np.cos(half)]]
        )
        wi, wo = turned @ towards, turned @ (towards * [-1.0, -1.0, 1.0])
        np.testing.assert_allclose(material.evaluate(wi[None], wo[None])[0], value, rtol=1e-6)


def test_a_lobe_comes_back_between_cells_and_both_ways():
    material = parse_merl(glossy(), "x")
    assert material.missing == 0.0
    wi, wo = directions(20_000, 3, 0.1), directions(20_000, 4, 0.1)
    # Half of the pairs near each other's mirror direction.
    wo[::2] = wi[::2] * [-1.0, -1.0, 1.0] + 0.1 * (wo[::2] - wi[::2])
    wo /= np.linalg.norm(wo, axis=1, keepdims=True)
    wo[:, 2] = np.abs(wo[:, 2])
    found, true = material.evaluate(wi, wo)[:, 0], blinn(wi, wo)
    np.testing.assert_allclose(found, true, rtol=0.01)
    np.testing.assert_allclose(material.evaluate(wo, wi)[:, 0], found, rtol=1e-5)


@pytest.mark.slow
def test_the_table_of_a_lobe_keeps_its_values_and_its_albedo():
    table = read_merl(glossy(), "x", tolerance=0.04).sides["front_reflection"]
    wi, wo = directions(5000, 6, 0.1), directions(5000, 7, 0.1)
    relative = evaluate(table, wi, wo)[:, 0] / blinn(wi, wo) - 1.0
    assert np.sqrt((relative**2).mean()) < 0.04
    # By the midpoint rule over the hemisphere.
    theta, phi = np.meshgrid(np.arange(0.25, 90.0, 0.5), np.arange(1.0, 360.0, 2.0))
    theta, phi = np.radians(theta.ravel()), np.radians(phi.ravel())
    out = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], 1)
    for angle in (0.2, 0.7, 1.1):
        lit = np.broadcast_to([np.sin(angle), 0.0, np.cos(angle)], out.shape)
        exact = (
            (blinn(lit, out) * np.sin(theta) * np.cos(theta)).sum()
            * np.radians(0.5)
            * np.radians(2)
        )
        assert albedo(table, angle)[0] == pytest.approx(exact, rel=0.01)


def test_colours_become_spectra_of_their_tint():
    table = read_merl(pack([0.5 / np.pi, 0.1 / np.pi, 0.1 / np.pi]), "x").sides["front_reflection"]
    spectrum = np.interp([450.0, 550.0, 650.0], table.wavelengths, np.pi * table.values[0, 0, 0, 0])
    np.testing.assert_allclose(spectrum[:2], 0.1, atol=0.03)
    assert spectrum[2] == pytest.approx(0.5, abs=0.01)


def test_holes_take_the_nearest_data_and_their_share_is_told():
    _, _, above = cells()
    f = np.full(SHAPE, 0.2)
    f[:, 40:60] = -1.0
    f[:, :, 90:120] = np.nan
    wanted = 1.0 - above[f > 0.0].sum() / above.sum()
    file = read_merl(pack([f] * 3), "x")
    np.testing.assert_allclose(file.sides["front_reflection"].values, 0.2, rtol=1e-5)
    told = " ".join(str(each) for each in file.remarks)
    assert f"no data in {100.0 * wanted:.2g} % of the cells" in told


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "has 0 bytes"),
        (struct.pack("<3i", *SHAPE), f"cut short: it has 12 bytes, expected {SIZE}"),
        (struct.pack("<3i", *SHAPE) + bytes(1000), "cut short"),
        (struct.pack("<3i", 90, 90, 360) + bytes(64), "a grid of 90 x 90 x 360 cells"),
        (struct.pack("<3i", 1 << 30, 1 << 30, -1) + bytes(64), "expected 90 x 90 x 180"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(data, message):
    with pytest.raises(FileFormatError, match=message):
        read_merl(data, "material.binary")


def test_files_without_data_are_refused():
    with pytest.raises(FileFormatError, match="has no data"):
        read_merl(pack([-1.0] * 3), "x")
