"""What skies give usually, and the luminance of measured ones in a direction."""

import numpy as np
import pytest

from lumenray.engine.errors import SceneError
from lumenray.engine.sky.availability import condition_of_type, usual_illuminance
from lumenray.engine.sky.measured import (
    PATCHES,
    SkyGrid,
    find_luminances,
    make_patch_world,
    patch_bounds,
)


def test_overcast_noon_is_brighter_than_a_cloudless_sky():
    assert usual_illuminance("clear", 30.0) == pytest.approx(800.0 + 15_500.0 * 0.5**0.5)
    assert usual_illuminance("overcast", 90.0) == pytest.approx(21_300.0)
    assert usual_illuminance("intermediate", 90.0) == pytest.approx(45_300.0)
    assert usual_illuminance("clear", 0.0) == 800.0
    assert usual_illuminance("clear", -0.1) == 0.0


def test_every_type_has_a_condition():
    kinds = [condition_of_type(kind) for kind in range(1, 17)]
    assert kinds == ["overcast"] * 5 + ["intermediate"] * 5 + ["clear"] * 5 + ["overcast"]


@pytest.mark.parametrize(("condition", "elevation"), [("cloudy", 10.0), ("clear", 91.0)])
def test_what_is_no_sky_is_refused(condition, elevation):
    with pytest.raises(SceneError, match="expected clear, intermediate, overcast"):
        usual_illuminance(condition, elevation)


def directions_at(elevation, azimuth):
    height, turn = np.radians(elevation), np.radians(azimuth)
    parts = np.cos(height) * np.sin(turn), np.cos(height) * np.cos(turn), np.sin(height)
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def test_patches_have_their_luminance_and_the_ground_none():
    luminances = np.arange(1.0, PATCHES + 1)
    low, high, start, end = patch_bounds().T
    middles = directions_at(0.5 * (low + high), 0.5 * (start + end))
    np.testing.assert_array_equal(find_luminances(luminances, middles), luminances)
    assert find_luminances(luminances, directions_at(-1.0, 40.0)) == 0.0


def test_grids_have_the_luminance_of_their_places():
    elevations, azimuths = np.arange(0.0, 91.0, 10.0), np.arange(0.0, 360.0, 15.0)
    values = 1000.0 + 10.0 * elevations[:, None] + 2.0 * azimuths[None]
    grid = SkyGrid(elevations, azimuths, values)
    for elevation, azimuth in [(20.25, 30.25), (45.25, 100.25), (5.25, 344.75)]:
        expected = 1000.0 + 10.0 * elevation + 2.0 * azimuth
        found = find_luminances(grid, directions_at(elevation, azimuth))
        assert found == pytest.approx(expected, abs=1.0)
    assert find_luminances(grid, directions_at(-0.3, 10.0)) == 0.0


def test_patches_as_a_picture_are_the_same():
    rng = np.random.default_rng(8)
    luminances = rng.uniform(100.0, 9000.0, PATCHES)
    pixels = make_patch_world(luminances).image.pixels[..., 0]
    rows, columns = pixels.shape
    row, column = rng.integers(rows // 2, rows, 500), rng.integers(0, columns, 500)
    elevation = (row + 0.5) * 180.0 / rows - 90.0
    azimuth = ((column + 0.5) / columns - 0.25) * 360.0
    found = find_luminances(luminances, directions_at(elevation, azimuth))
    np.testing.assert_allclose(found, pixels[row, column], rtol=1e-6)
