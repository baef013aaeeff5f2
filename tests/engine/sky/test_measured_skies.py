"""Measured skies: patches where Radiance has them, illuminances in closed form, tables and what is wrong with them."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from mutations import mutate
from scipy import stats
from small_scenes import session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.scene.light import CieSky
from lumenray.engine.sky.cie import relative_luminance, sun_direction
from lumenray.engine.sky.measured import (
    PATCHES,
    SkyGrid,
    find_patches,
    horizontal_weights,
    make_grid_world,
    make_patch_world,
    patch_bounds,
    read_measured_sky,
)
from lumenray.engine.sky.picture import find_illuminance
from lumenray.engine.sky.skies import find_luminances

UPWARDS = (0.0, 0.0, 1.0)

UNIFORM = 1000.0
"""[cd/m2]"""


def patch_middles():
    low, high, start, end = np.radians(patch_bounds()).T
    height = np.where(high > np.radians(89.0), 0.5 * np.pi, 0.5 * (low + high))
    return np.array([sun_direction(h, a) for h, a in zip(height, 0.5 * (start + end), strict=True)])


def spots(seed=3):
    return np.random.default_rng(seed).uniform(100.0, 20_000.0, PATCHES)


# ---- patches ----


def test_patches_are_those_of_radiance():
    """By its own file of the Reinhart skies of one division, which are Tregenza's."""
    package = pytest.importorskip("pyradiance")
    home = Path(package.__file__).parent
    if not (home / "bin" / "rcalc").exists():
        pytest.skip("this pyradiance has no rcalc")
    output = "Rbin=recno;$1=Dx;$2=Dy;$3=Dz;$4=Romega"
    text = subprocess.run(
        [home / "bin" / "rcalc", "-e", "MF:1", "-f", "reinsrc.cal", "-e", output],
        input="0\n" * PATCHES,
        capture_output=True,
        text=True,
        check=True,
        env=dict(os.environ, RAYPATH=str(home / "lib")),
    ).stdout
    table = np.array([line.split() for line in text.splitlines()], dtype=np.float64)
    np.testing.assert_array_equal(find_patches(table[:, :3]), np.arange(PATCHES))
    low, high, start, end = np.radians(patch_bounds()).T
    solid = (end - start) * (np.sin(high) - np.sin(low))
    np.testing.assert_allclose(solid, table[:, 3], rtol=1e-5)


def test_first_patch_is_in_the_north_and_the_next_to_the_east():
    north, east = sun_direction(0.1, 0.0), sun_direction(0.1, np.radians(12.0))
    np.testing.assert_array_equal(find_patches([north, east, UPWARDS, (0, 0, -1)]), [0, 1, 144, -1])
    # The first is as wide to the west.
    assert find_patches(sun_direction(0.1, np.radians(-5.9))) == 0
    assert find_patches(sun_direction(0.1, np.radians(-6.1))) == 29


def test_patches_cover_the_sky():
    assert horizontal_weights().sum() == pytest.approx(np.pi, rel=1e-12)
    rng = np.random.default_rng(1)
    directions = rng.normal(size=(100_000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    directions[:, 2] = np.abs(directions[:, 2])
    counts = np.bincount(find_patches(directions), minlength=PATCHES)
    low, high, start, end = np.radians(patch_bounds()).T
    shares = (end - start) * (np.sin(high) - np.sin(low)) / (2.0 * np.pi)
    assert stats.chisquare(counts, 100_000 * shares).pvalue > 1e-3


def test_picture_has_each_patch_where_it_is():
    values = spots()
    world = make_patch_world(values, 0.2)
    height, width = world.image.pixels.shape[:2]
    for patch, direction in enumerate(patch_middles()):
        u = 0.5 - np.arctan2(direction[1], direction[0]) / (2 * np.pi)
        v = 0.5 + np.arctan2(direction[2], np.hypot(direction[0], direction[1])) / np.pi
        row, column = min(int(v * height), height - 1), int(u * width) % width
        assert world.image.pixels[row, column, 0] == np.float32(values[patch])


def test_horizontal_illuminance_of_patches_is_the_closed_form():
    values = spots()
    expected = horizontal_weights() @ values
    world = make_patch_world(values, 0.3)
    assert find_illuminance(world.image, world.rotation, UPWARDS) == pytest.approx(
        expected, rel=1e-4
    )
    # What is below is a matt ground.
    below = find_illuminance(world.image, world.rotation, (0.0, 0.0, -1.0))
    assert below == pytest.approx(0.3 * expected, rel=1e-4)


@pytest.mark.mitsuba
def test_one_bright_patch_lights_planes_by_the_closed_form():
    """Patch 40 alone: its light comes from its middle, nearly."""
    values = np.zeros(PATCHES)
    values[40] = 1e5
    middle = patch_middles()[40]
    low, high, start, end = np.radians(patch_bounds()[40])
    width, tall = end - start, high - low
    # Integral of the direction over the patch.
    plan = 0.5 * (tall + 0.5 * (np.sin(2 * high) - np.sin(2 * low)))
    turn = np.array([np.cos(start) - np.cos(end), np.sin(end) - np.sin(start)])
    vector = 1e5 * np.array([*(plan * turn), width * 0.5 * (np.sin(high) ** 2 - np.sin(low) ** 2)])
    normals = np.array([UPWARDS, middle, -middle])
    expected = np.maximum(normals @ vector, 0.0)
    session = session_of(make_patch_world(values))
    made = session.measure(
        np.zeros((3, 3)), normals, StopRule(samples=1 << 14), transport="mono", seed=2
    )
    bound = 3.9 * made.standard_error + 1e-4 * expected
    assert (np.abs(made.illuminance - expected) <= bound).all()


# ---- grids ----


def test_an_even_grid_is_an_even_sky():
    grid = SkyGrid(np.array([10.0, 40.0]), np.array([5.0, 100.0, 250.0]), np.full((2, 3), UNIFORM))
    world = make_grid_world(grid)
    illuminance = find_illuminance(world.image, world.rotation, UPWARDS)
    assert illuminance == pytest.approx(np.pi * UNIFORM, rel=1e-4)


def test_fine_grid_of_a_sky_gives_its_illuminances():
    towards = sun_direction(np.radians(40.0), np.radians(70.0))
    sky = CieSky(12, towards, 10_000.0)
    elevations, azimuths = np.arange(0.0, 90.1, 2.0), np.arange(0.0, 360.0, 2.0)
    directions = np.array(
        [[sun_direction(np.radians(e), np.radians(a)) for a in azimuths] for e in elevations]
    )
    world = make_grid_world(SkyGrid(elevations, azimuths, find_luminances(sky, directions)))
    assert find_illuminance(world.image, world.rotation, UPWARDS) == pytest.approx(1e4, rel=3e-3)
    # Upright planes: the sun's side is the bright one, so the azimuth runs the right way.
    fine = 720
    sine = (np.arange(fine) + 0.5) / fine
    turn = 2.0 * np.pi * (np.arange(fine) + 0.5) / fine
    plan = np.sqrt(1.0 - sine**2)[:, None]
    cells = np.stack(
        np.broadcast_arrays(plan * np.sin(turn), plan * np.cos(turn), sine[:, None]), axis=-1
    )
    values = find_luminances(sky, cells)
    for normal in [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)]:
        expected = (values * np.maximum(cells @ np.array(normal), 0.0)).sum() * 2 * np.pi / fine**2
        found = find_illuminance(world.image, world.rotation, normal)
        assert found == pytest.approx(expected, rel=5e-3)


def test_sky_goes_on_beyond_the_grid():
    """Below the lowest row as it is there, to the mean of the highest at the zenith."""
    luminances = np.array([[1000.0, 3000.0]])
    world = make_grid_world(SkyGrid(np.array([45.0]), np.array([90.0, 270.0]), luminances))
    pixels = world.image.pixels[..., 0]
    assert pixels[180, 360] == pytest.approx(1000.0, rel=0.01)
    assert pixels[180, 0] == pytest.approx(3000.0, rel=0.01)
    np.testing.assert_allclose(pixels[-1], 2000.0, rtol=0.01)
    assert (pixels[:180] == 0.0).all()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: make_patch_world(np.ones(144)), r"shape \(144,\), expected \(145,\)"),
        (lambda: make_patch_world(np.full(PATCHES, np.nan)), "not within 0 to 1e"),
        (lambda: make_patch_world(np.full(PATCHES, -1.0)), "not within 0 to 1e"),
        (lambda: make_patch_world(np.ones(PATCHES), 1.1), "reflectance of the ground is 1.1"),
        (lambda: grid_of([10, 10], [0, 90]), "elevations do not ascend"),
        (lambda: grid_of([10, 91], [0, 90]), "elevations do not ascend"),
        (lambda: grid_of([10, 20], [0, 360]), "azimuths do not ascend"),
        (lambda: grid_of([], []), "elevations do not ascend"),
    ],
)
def test_what_cannot_be_is_refused(call, words):
    with pytest.raises(SceneError, match=words):
        call()


def grid_of(elevations, azimuths):
    shape = (len(elevations), len(azimuths))
    return make_grid_world(SkyGrid(np.array(elevations), np.array(azimuths), np.ones(shape)))


# ---- tables ----


def grid_text(elevations=(0, 30, 60, 90), azimuths=(0, 90, 180, 270)):
    towards = sun_direction(0.7, 2.0)
    rows = ["# elevation azimuth luminance"]
    for a in azimuths:
        for e in elevations:
            direction = sun_direction(np.radians(e), np.radians(a))
            rows.append(f"{e} {a} {1000.0 * relative_luminance(12, direction, towards):.2f}")
    return "\n".join(rows) + "\n"


def test_tables_are_read(tmp_path):
    path = tmp_path / "sky.txt"
    values = np.round(spots(), 1)
    path.write_text("luminance\n" + "".join(f"{value}\n" for value in values))
    np.testing.assert_array_equal(read_measured_sky(path), values)
    path.write_text(grid_text())
    grid = read_measured_sky(path)
    assert grid.luminances.shape == (4, 4)
    towards, direction = sun_direction(0.7, 2.0), sun_direction(np.radians(30.0), np.radians(180.0))
    expected = 1000.0 * relative_luminance(12, direction, towards)
    assert grid.luminances[1, 2] == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "has no numbers"),
        ("words\n", "has no numbers"),
        ("1\n" * 144, "has 144 luminances, expected those of 145 patches"),
        ("1 2\n", "line 1: has 2 columns"),
        ("1\n" * 10 + "1 2\n", "line 11: has 2 numbers, expected 1"),
        ("1\n" * 10 + "-3\n", "line 11: has the luminance -3, expected 0 to 1e+07"),
        ("nan\n" * 145, "has the luminance nan"),
        ("95 0 5\n", "line 1: has the elevation 95"),
        ("5 360 5\n", "the azimuth 360, expected 0 to 90 and 0 to less than 360"),
        ("5 0 5\n6 90 5\n", "has 2 places, expected 2 elevations times 2 azimuths"),
        ("5 0 5\n5 0 5\n6 90 5\n6 0 3\n", "nothing at the elevation 5 and the azimuth 90"),
    ],
)
def test_faults_are_refused_in_one_sentence(tmp_path, text, words):
    path = tmp_path / "sky.txt"
    path.write_text(text)
    with pytest.raises(FileFormatError) as caught:
        read_measured_sky(path)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_damaged_tables_are_read_or_refused(tmp_path):
    rng, path, count = np.random.default_rng(145), tmp_path / "sky.txt", 0
    for k in range(300):
        text = grid_text() if k % 2 else "".join(f"{value:.1f}\n" for value in spots())
        path.write_bytes(mutate(text.encode(), rng))
        try:
            sky = read_measured_sky(path)
        except FileFormatError as error:
            assert "\n" not in str(error)
            continue
        count += 1
        world = make_grid_world(sky) if isinstance(sky, SkyGrid) else make_patch_world(sky)
        assert np.isfinite(world.image.pixels).all()
    assert 0 < count < 300
