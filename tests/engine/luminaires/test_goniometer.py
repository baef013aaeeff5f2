"""A goniometer about luminaires of real files: what it writes is what was read."""

import numpy as np
import pytest
from folders import WILD
from luminaires import frame_of
from scipy.spatial.transform import Rotation
from small_scenes import session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import LumenrayError, SceneError
from lumenray.engine.luminaires.coordinates import directions
from lumenray.engine.luminaires.distribution import flux, intensity
from lumenray.engine.luminaires.formats.reader import read_luminaire, write_luminaire
from lumenray.engine.luminaires.formats.record import LUMINOUS
from lumenray.engine.luminaires.goniometer import (
    FAR,
    find_intensities,
    place_detectors,
    to_luminaire,
)
from lumenray.engine.scene.light import Luminaire, Output, Quantity
from lumenray.engine.scene.spectrum import Constant

QUICK = ("ies/cu_5.IES", "ies/rp_vee.ies", "ldt/luxpy_Isym2.ldt")
SLOW = (
    "ies/lib_007cfb11e343e2f42e3b476be4ab684e.ies", "ies/lib_1a936937a49c63374e6d4fbed9252b29.ies",
    "ies/cu_archive_4.ies", "ies/eul_Interlab_263x361.ies", "ies/eul_OVNI_60W.ies", "ies/radiance_examp1.ies",
    "ies/pv95_round_opening_with_height.ies", "ldt/eul_FL_MAX_1200W_ASYM.ldt", "ldt/eul_road_luminaire.ldt",
)  # fmt: skip
FILES = (*QUICK, *(pytest.param(name, marks=pytest.mark.slow) for name in SLOW))


def own_angles(file):
    """Angles of a file of type C all around, else an even grid. [rad]"""
    if file.photometric_type == "C" and len(file.distribution.azimuth) == 1:
        return np.zeros(1), file.distribution.polar
    if file.photometric_type == "C" and len(file.distribution.azimuth) < 80:
        around = np.unique(np.round(np.mod(file.distribution.azimuth, 2.0 * np.pi), 9))
        return around, file.distribution.polar
    return np.deg2rad(np.arange(0.0, 360.0, 15.0)), np.deg2rad(np.arange(0.0, 181.0, 5.0))


def measure(file, rotation, end, tmp_path):
    """The file that a goniometer writes of a file's luminaire, turned and far from the origin, and its directions."""
    frame = frame_of((3.0, -2.0, 5.0), rotation)
    light = Luminaire(
        "lamp", "lamp", Output(Quantity.LUMINOUS_FLUX, flux(file.distribution), Constant(1.0)), frame, file.distribution,
        file.opening,
    )  # fmt: skip
    distance = FAR * max(*file.opening.size, 0.1)
    azimuth, polar = own_angles(file)
    detectors = place_detectors(frame, azimuth, polar, distance)
    found = session_of(light).measure(
        detectors.positions,
        detectors.normals,
        StopRule(error=0.0005, samples=1 << 16),
        method="paths",
    )
    made = to_luminaire(
        find_intensities(detectors, found.illuminance, found.standard_error), file.opening.size, {}
    )
    path = tmp_path / f"out{end}"
    write_luminaire(made, path)
    return read_luminaire(path), directions(azimuth[:, None], polar[None])


@pytest.mark.mitsuba
@pytest.mark.parametrize("name", FILES)
def test_what_a_goniometer_writes_is_what_was_read(name, tmp_path):
    path = WILD / name
    if not path.is_file():
        pytest.skip(f"{path.name} is not there")
    file = read_luminaire(path)
    if file.quantity != LUMINOUS:
        pytest.skip("its numbers are no candelas")
    rotation = Rotation.from_euler("xyz", [0.3, -0.5, 1.1]).as_matrix()
    for end in (".ies", ".ldt"):
        try:
            written, ways = measure(file, rotation, end, tmp_path)
        except LumenrayError as error:
            # EULUMDAT needs even planes.
            assert end == ".ldt", error
            continue
        before, after = (intensity(each.distribution, ways) for each in (file, written))
        assert np.abs(after - before).max() < 0.005 * before.max()


def test_planes_that_differ_by_their_noise_are_one():
    detectors = place_detectors(
        np.eye(4), np.deg2rad([0, 90, 180, 270]), np.deg2rad([0, 45, 90]), 10.0
    )
    lux = np.tile([3.0, 2.0, 1.0], (4, 1))
    noise = 0.01 * np.random.default_rng(1).standard_normal((4, 3))
    one = find_intensities(detectors, (lux + noise).ravel(), np.full(12, 0.01))
    assert len(one.distribution.azimuth) == 1
    np.testing.assert_allclose(one.distribution.intensity, [[300.0, 200.0, 100.0]], atol=3.0)
    lux[1] *= 1.2
    lux[:, 0] = 3.0
    four = find_intensities(detectors, lux.ravel(), np.full(12, 0.01))
    np.testing.assert_allclose(np.rad2deg(four.distribution.azimuth), [0, 90, 180, 270, 360])
    np.testing.assert_allclose(four.distribution.intensity[1], [300.0, 240.0, 120.0])
    np.testing.assert_allclose(four.distribution.intensity[4], four.distribution.intensity[0])


def test_detectors_look_at_the_luminaire():
    frame = frame_of((1.0, 2.0, 3.0))
    detectors = place_detectors(frame, [0.0, np.pi / 2], [0.0, np.pi / 2], 5.0)
    np.testing.assert_allclose(detectors.positions[0], [1.0, 2.0, -2.0], atol=1e-12)
    np.testing.assert_allclose(detectors.positions[1], [6.0, 2.0, 3.0], atol=1e-12)
    np.testing.assert_allclose(detectors.positions[3], [1.0, 7.0, 3.0], atol=1e-12)
    np.testing.assert_allclose(detectors.positions + 5.0 * detectors.normals, [[1.0, 2.0, 3.0]] * 4)
    with pytest.raises(SceneError, match="too many"):
        place_detectors(frame, np.zeros(1000), np.zeros(1000), 5.0)
