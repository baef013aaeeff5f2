"""Reference values of skies by weather and by measurement: closed forms, another program, and the same values again."""

import re
import tempfile
from pathlib import Path

import numpy as np
import pytest

from lumenray.benchmarks.common.radiance import run_program
from lumenray.engine.scene.light import CloudySky, ImageWorld, PerezSky
from lumenray.engine.scene.texture import ImageTexture
from lumenray.validation import sky_values
from lumenray.validation.bench import Bench, CannotStateError
from lumenray.validation.cases import all_cases
from lumenray.validation.peers.contents import sort_items
from lumenray.validation.peers.cycles_scene import describe
from lumenray.validation.peers.radiance import Radiance
from lumenray.validation.peers.radiance_scene import write_scene
from lumenray.validation.peers.skies import luminance_scale, relative_luminance
from lumenray.validation.reference import groups_of
from lumenray.validation.runner import run_case
from lumenray.validation.sky_formulas import (
    PATCH_COUNTS,
    direction,
    grid_sky,
    patch_sky,
    perez_letters,
)

pytestmark = pytest.mark.validation


def values_of(case, name):
    group = groups_of(case)[f"{case}.{name}"]
    return dict(zip(group.labels, group.values, strict=True)), group.tables["sky"]


def test_open_sensors_under_patches_have_the_closed_form():
    """A patch between elevations and azimuths: integral of the direction, cut off behind a vertical plane."""
    found, sky = values_of("C48", "open.patches")
    horizontal, south = 0.0, 0.0
    numbers = iter(sky["luminances"])
    for row, count in enumerate(PATCH_COUNTS):
        low, high = np.radians([12.0 * row, min(12.0 * (row + 1), 90.0)])
        tall = 0.5 * (high - low) + 0.25 * (np.sin(2.0 * high) - np.sin(2.0 * low))
        for k in range(count):
            luminance = next(numbers)
            start, end = 2.0 * np.pi * (np.array([k - 0.5, k + 0.5]) / count)
            if count == 1:
                start, end = 0.0, 2.0 * np.pi
            horizontal += luminance * (end - start) * 0.5 * (np.sin(high) ** 2 - np.sin(low) ** 2)
            start, end = np.clip([start, end], 0.5 * np.pi, 1.5 * np.pi)
            south += luminance * tall * (np.sin(start) - np.sin(end))
    ground = 0.3 * horizontal / np.pi
    assert found["horizontal"] == pytest.approx(horizontal, rel=1e-5)
    assert found["south"] == pytest.approx(south + 0.5 * np.pi * ground, rel=1e-5)


def test_overcast_skies_have_the_closed_form():
    """Moon and Spencer: a wall has (1/2 pi + 4/3) / 3 of the zenith's luminance, a roof 7 pi / 9."""
    found, _ = values_of("C46", "open.c1")
    wall = (0.5 * np.pi + 4.0 / 3.0) / 3.0 / (7.0 * np.pi / 9.0)
    for label in ("north", "east", "south", "west"):
        assert found[label] == pytest.approx(100.0 * (wall + 0.15), rel=1e-5)
    assert found["horizontal"] == pytest.approx(100.0, rel=1e-9)


def test_cloudiness_is_linear_in_the_light_of_both():
    low, middle, high = (values_of("C46", f"room.{name}")[0] for name in ("c0", "c0.75", "c1"))
    for label, value in middle.items():
        assert value == pytest.approx(0.25 * low[label] + 0.75 * high[label], rel=1e-7)


def test_the_values_are_those_that_the_module_computes():
    """With coarser cells, on the skies that vary most."""
    wanted = {"C46.room.c0.25", "C47.open.class8", "C47.room.class4", "C48.room.table"}
    for key in wanted:
        case, kind, _ = key.split(".", 2)
        group = groups_of(case)[key]
        plain = sky_values.luminance_of(group.tables["sky"])
        flat = sky_values.integrate(plain, (0.0, 0.0, 1.0), 120)
        level = 1.0 if case == "C48" else 100.0 / flat
        ground = 0.3 * level * flat / np.pi
        for label, value in zip(group.labels, group.values, strict=True):
            if kind == "open":
                normal = sky_values.NORMALS[label]
                made = level * sky_values.integrate(plain, normal, 120)
                made += sky_values.of_ground(normal, ground)
            else:
                place = sky_values.ROOM[label]
                made = sky_values.through_opening(lambda x: level * plain(x), ground, *place, 120)  # noqa: B023 - called at once
            assert made == pytest.approx(value, rel=1e-3), (key, label)


@pytest.mark.parametrize("sky", sky_values.PEREZ, ids=[f"class {k}" for k in range(1, 9)])
def test_letters_are_those_of_gendaylit(sky):
    """Irradiances that make the sky: its brightness tells the diffuse one, its clearness the one by the sun."""
    pytest.importorskip("pyradiance")
    clearness, brightness, elevation, azimuth = sky
    zenith = np.radians(90.0 - elevation)
    mass = 1.0 / (np.cos(zenith) + 0.15 * (93.885 - np.degrees(zenith)) ** -1.253)
    # The sun's distance is that of the day that gendaylit takes where it is told none.
    near = 1.00011 + 0.034221 * np.cos(2 * np.pi / 365) - 0.00128 * np.sin(2 * np.pi / 365)
    near += 0.000719 * np.cos(4 * np.pi / 365) - 0.000077 * np.sin(4 * np.pi / 365)
    diffuse = brightness * 1367.0 * near / mass
    direct = (clearness - 1.0) * (1.0 + 1.041 * zenith**3) * diffuse
    with tempfile.TemporaryDirectory() as folder:
        text = run_program(
            Path(folder), "gendaylit", "-ang", str(elevation), str(azimuth - 180.0),
            "-W", f"{direct:.9g}", f"{diffuse:.9g}",
        ).decode()  # fmt: skip
    numbers = [float(word) for word in re.search(r"\n10 (.*)\n", text)[1].split()]
    np.testing.assert_allclose(
        perez_letters(clearness, brightness, elevation), numbers[2:7], atol=2e-4
    )
    np.testing.assert_allclose(direction(elevation, azimuth), numbers[7:], atol=1e-6)


def test_patches_and_tables_are_where_they_say():
    luminances = np.arange(1.0, 146.0)
    looks = direction(
        np.array([6.0, 6.0, 6.0, 18.0, 90.0, 30.0]), np.array([0.0, 12.0, 353.0, 0.0, 0.0, 15.0])
    )
    np.testing.assert_array_equal(patch_sky(looks, luminances), [1, 2, 30, 31, 145, 62])
    table = np.array([[1.0, 2.0, 3.0, 4.0], [5.0, 5.0, 5.0, 5.0]])
    place = [0.0, 90.0], [0.0, 90.0, 180.0, 270.0]
    looks = direction(np.array([0.0, 0.0, 0.0, 45.0]), np.array([0.0, 45.0, 315.0, 90.0]))
    np.testing.assert_allclose(grid_sky(looks, *place, table), [1.0, 1.5, 2.5, 3.5], atol=1e-9)


# ---- the peers ----


def test_radiance_answers_for_skies_of_every_kind():
    try:
        peer = Radiance(rays=150_000)
    except CannotStateError as error:
        pytest.skip(str(error))
    wanted = frozenset({"C46.open.c0.25", "C47.open.class1", "C48.open.patches", "C48.open.table"})
    for key in ("C46", "C47", "C48"):
        for found in run_case(all_cases()[key], Bench(peer, wanted)):
            # One patch has most of the light of the walls that it shines on.
            np.testing.assert_allclose(found.values, found.group.values, rtol=0.03)


def test_levels_of_peers_are_the_horizontal_illuminance():
    sun = direction(40.0, 200.0)
    # Evenly in the square of the sine, which weighs by the cosine to the zenith.
    height = np.degrees(np.arcsin(np.sqrt((np.arange(100) + 0.5) / 100)))
    directions = direction(height[:, None], (np.arange(180) + 0.5) * 2.0)
    for sky in (CloudySky(0.3, sun, 5000.0), PerezSky(2.0, 0.25, sun, 5000.0)):
        given = np.pi * luminance_scale(sky) * relative_luminance(sky, directions).mean()
        assert given == pytest.approx(5000.0, rel=2e-3)


@pytest.mark.parametrize("interpolation", ["linear", "closest"])
def test_what_peers_cannot_show_is_refused(interpolation):
    pixels = np.ones((4, 8, 3), np.float32)
    pixels[0, 0, 0] = 2.0
    contents = sort_items((ImageWorld(ImageTexture(pixels, interpolation=interpolation), 1.0),))
    place = np.zeros((1, 3))
    with pytest.raises(CannotStateError, match="pictures of the surroundings with colours"):
        write_scene(contents, place, np.zeros(3), 1.0, False, False)
    with pytest.raises(CannotStateError, match="not translated for Cycles"):
        describe(contents, np.zeros(3), 1.0)
