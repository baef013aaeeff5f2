"""Skies by cloudiness, by weather files and by measurement, and all by the level that is stated, in Blender's world."""

import math

import bpy
import numpy as np
import pytest
from blender_skies import add_sun, compass, measure_sky, new_sky, rotation_of
from conversion import converted_scene
from kept_scenes import KeptScene
from weather_files import epw, epw_record

from lumenray.blender_addon.daylight import following
from lumenray.blender_addon.daylight.moment import find_moment
from lumenray.blender_addon.daylight.readout import describe_sky
from lumenray.blender_addon.daylight.weather import weather_mean, weather_moment
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.skies import convert_sky
from lumenray.engine.photometry.spectra import evaluate_emission, luminous_weight
from lumenray.engine.scene.light import CloudySky, ImageWorld, PerezSky, SunLight
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Daylight
from lumenray.engine.sky import clear_sky
from lumenray.engine.sky.measured import find_patches, horizontal_weights
from lumenray.engine.sky.skies import find_luminances, zenith_luminance


@pytest.fixture
def world():
    """Return a world with a sky, on a morning of July near Mannheim."""
    world = new_sky()
    world.lumenray.place.city = "Mannheim, Germany"
    time = world.lumenray.time
    time.month, time.day, time.hour = 7, 3, 10.5
    return world


@pytest.fixture
def weather(tmp_path, world):
    """Let the sky be that of a weather file with three hours of four days, and return the file."""
    path = tmp_path / "weather.epw"
    records = [
        epw_record(2005, 7, day, hour, dni=100 * day, dhi=90, dew=11.0)
        for day in (1, 2, 3, 4)
        for hour in (9, 10, 11)
    ]
    path.write_text(epw(records))
    world.lumenray.sky.kind = "WEATHER"
    world.lumenray.sky.weather_file = str(path)
    return path


def converted():
    """Return the sky, None without one, and the texts of the report."""
    made = converted_scene()
    skies = [
        i
        for i in made.delta.changed
        if isinstance(i, CloudySky | ImageWorld | PerezSky) or hasattr(i, "towards_sun")
    ]
    return (skies[0] if skies else None), [row.text() for row, _ in made.report.rows]


def test_cloudiness_is_taken_over_with_its_sun(world):
    sky = world.lumenray.sky
    sky.kind, sky.cloudiness, sky.illuminance = "CLOUDINESS", 0.25, 20000.0
    add_sun(rotation=rotation_of(30, 200))
    made, _ = converted()
    assert isinstance(made, CloudySky)
    assert (made.cloudiness, made.illuminance) == (0.25, 20000.0)
    np.testing.assert_allclose(made.towards_sun, compass(30, 200), atol=1e-6)
    assert made.spectrum == Daylight(6500.0)
    sky.cloudiness = 1.0
    np.testing.assert_array_equal(converted()[0].towards_sun, (0, 0, 1))


def test_place_and_time_go_before_sun_light_and_angles(world):
    sky = world.lumenray.sky
    sky.type, sky.use_place = "12", True
    add_sun(rotation=rotation_of(30, 200))
    np.testing.assert_allclose(
        converted()[0].towards_sun, find_moment(world, 1).towards_sun, atol=1e-9
    )
    world.lumenray.time.hour = 2.0
    made, told = converted()
    assert made.towards_sun[2] == 0.0
    assert any("degrees below the horizon" in text for text in told)


def test_a_level_can_be_the_zeniths(world):
    sky = world.lumenray.sky
    for kind in ("CIE", "CLOUDINESS"):
        sky.kind, sky.type, sky.level, sky.zenith_luminance = kind, "12", "ZENITH", 2500.0
        made, _ = converted()
        assert zenith_luminance(made) == pytest.approx(2500.0, rel=1e-9)
    sky.zenith_luminance = 0.0
    assert converted()[0] is None


def test_a_total_level_leaves_the_sky_what_the_sun_does_not_give(world):
    sky = world.lumenray.sky
    sky.level, sky.total_illuminance = "TOTAL", 70000.0
    assert converted()[0].illuminance == 70000.0
    following.add_lamp(bpy.context.scene, None)
    sun = world.lumenray.sun
    sun.amount, sun.illuminance = "GIVEN", 50000.0
    height = math.radians(find_moment(world, 1).elevation)
    made, _ = converted()
    assert made.illuminance == pytest.approx(70000.0 - 50000.0 * math.sin(height), rel=1e-6)
    sky.total_illuminance = 10000.0
    made, told = converted()
    assert made is None
    assert any("the sun alone gives" in text for text in told)
    assert "the sun alone gives" in describe_sky(world, None, bpy.context.scene).problem


def test_a_sun_that_goes_leaves_the_total_to_the_sky(world):
    sky = world.lumenray.sky
    sky.level, sky.total_illuminance = "TOTAL", 70000.0
    lamp = following.add_lamp(bpy.context.scene, None)
    kept = KeptScene.started()
    before = kept.scene.world.illuminance
    world.lumenray.sun.turbidity = 6.0
    kept.sent()
    assert before < kept.scene.world.illuminance < 70000.0
    bpy.data.objects.remove(lamp)
    kept.sent()
    assert kept.scene.world.illuminance == 70000.0


def test_sky_and_sun_together_give_the_total(world, session):
    sky = world.lumenray.sky
    sky.type, sky.use_place = "12", True
    sky.level, sky.total_illuminance = "TOTAL", 70000.0
    following.add_lamp(bpy.context.scene, None)
    suns = [i.id for i in converted_scene().delta.changed if isinstance(i, SunLight)]
    value, error = measure_sky(session, [(0, 0, 1)])
    assert error[0] < 0.01 * 70000.0
    assert abs(value[0] - 70000.0) < 4 * error[0] + 1e-3 * 70000.0
    # The session is that of other tests, too.
    bpy.data.objects.remove(bpy.data.objects["Sun"])
    session.apply(SceneDelta(removed=tuple(suns)))


def test_the_hour_of_a_weather_file_gives_sky_and_sun(world, weather):
    made, told = converted()
    assert isinstance(made, PerezSky)
    np.testing.assert_allclose(made.towards_sun, find_moment(world, 1).towards_sun, atol=1e-9)
    # Skies give 100 to 170 lm/W, the bluest most; the sun gives about 100.
    assert 90 * 100 < made.illuminance < 90 * 170
    assert any("record of 07-03 09:30, UTC+1" in text for text in told)
    lamp = following.add_lamp(bpy.context.scene, None)
    world.lumenray.sun.amount = "WEATHER"
    assert 300 * 85 < lamp.data.lumenray.value < 300 * 115
    world.lumenray.time.day = 1
    assert 100 * 85 < lamp.data.lumenray.value < 100 * 115
    assert converted()[0].clearness < made.clearness
    world.lumenray.sky.use_file_level = False
    assert converted()[0].illuminance == 10000.0
    world.lumenray.sky.kind = "CIE"
    assert lamp.data.lumenray.value == 0.0


def test_the_mean_of_a_month_is_brighter_than_its_dullest_day_and_turns_with_north(world, weather):
    world.lumenray.sky.weather_mean = "MONTH"
    made, told = converted()
    assert isinstance(made, ImageWorld)
    assert any("mean of 4 days" in text for text in told)
    np.testing.assert_allclose(made.rotation, np.eye(3))
    lamp = following.add_lamp(bpy.context.scene, None)
    world.lumenray.sun.amount = "WEATHER"
    assert 250 * 85 < lamp.data.lumenray.value < 250 * 115
    world.lumenray.place.north = math.radians(90)
    # +y of the scene is the compass's east.
    np.testing.assert_allclose(converted()[0].rotation @ (0, 1, 0), (1, 0, 0), atol=1e-6)


def test_the_mean_of_hours_holds_the_sun_that_a_lamp_cannot(world, weather, session):
    """Four days of July at 9 and 10 h have 100 to 400 W/m2 of direct irradiance."""
    sky = world.lumenray.sky
    sky.weather_mean = "RANGE"
    sky.mean_first_month = sky.mean_last_month = 7
    made, told = converted()
    assert isinstance(made, ImageWorld)
    assert any("mean of" in text and "month 7, 8 to 18 h, UTC+1" in text for text in told)
    mean = weather_mean(world, find_moment(world, 1))
    assert mean.direct_horizontal > 0.0
    value, error = measure_sky(session, [(0, 0, 1)])
    expected = mean.diffuse_horizontal + mean.direct_horizontal
    assert abs(value[0] - expected) < 4 * error[0] + 3e-3 * expected
    sky.use_mean_sun = False
    value, error = measure_sky(session, [(0, 0, 1)])
    assert abs(value[0] - mean.diffuse_horizontal) < 4 * error[0] + 3e-3 * expected
    # The lamp of the weather file is dark, as the sun is in the sky; one that shines all the same is told.
    lamp = following.add_lamp(bpy.context.scene, None)
    world.lumenray.sun.amount = "WEATHER"
    assert lamp.data.lumenray.value == 0.0
    assert not any("shines besides" in text for text in converted()[1])
    world.lumenray.sun.amount = "TURBIDITY"
    assert any("shines besides" in text for text in converted()[1])
    sky.mean_start = sky.mean_end
    made, told = converted()
    assert made is None
    assert any("two different ones" in text for text in told)


def test_a_clear_sky_has_its_spectrum_and_keeps_the_level(world, session):
    sky = world.lumenray.sky
    sky.type, sky.use_place, sky.spectrum, sky.turbidity = "12", True, "CLEAR", 2.5
    made, _ = converted()
    sun = float(np.degrees(np.arcsin(made.towards_sun[2])))
    expected = clear_sky.find_spectrum(sun, 2.5, sky.ground_reflectance)
    np.testing.assert_allclose(made.spectrum.values, expected.values)
    # The illuminance is that which is stated, or the model's own.
    value, error = measure_sky(session, [(0, 0, 1)])
    assert abs(value[0] - 10000.0) < 4 * error[0] + 1e-3 * 10000.0
    sky.level = "MODEL"
    own = clear_sky.find_illuminance(sun, 2.5, sky.ground_reflectance)
    value, error = measure_sky(session, [(0, 0, 1)])
    assert abs(value[0] - own) < 4 * error[0] + 1e-3 * own


def test_a_cloudy_sky_takes_its_clouds_part_of_the_light_from_daylight(world):
    sky = world.lumenray.sky
    sky.kind, sky.cloudiness, sky.use_place, sky.spectrum = "CLOUDINESS", 0.3, True, "CLEAR"
    made, _ = converted()
    sun = float(np.degrees(np.arcsin(made.towards_sun[2])))
    parts = [clear_sky.find_spectrum(sun, 3.0, sky.ground_reflectance), Daylight(6500.0)]
    blue = [
        float(evaluate_emission(s, 450.0)) / luminous_weight(s) for s in (*parts, made.spectrum)
    ]
    assert blue[2] == pytest.approx(0.7 * blue[0] + 0.3 * blue[1], rel=1e-4)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"type": "16"}, "type 16 has clouds"),
        ({"type": "7"}, "types 11 to 15"),
        ({"kind": "CLOUDINESS", "level": "MODEL"}, "has no level of a clear sky's own"),
        ({"type": "12", "use_place": False, "use_sun_lamp": False, "elevation": 0.0}, "a sun 0.0 degrees"),
        ({"type": "12", "spectrum": "TEMPERATURE", "level": "MODEL"}, "its spectrum is not that of one"),
        ({"kind": "MEASURED"}, "not known for measured skies"),
        (
            {"kind": "MEASURED", "spectrum": "TEMPERATURE", "level": "MODEL", "use_file_level": False},
            "a picture has no level",
        ),
    ],
)  # fmt: skip
def test_where_there_is_no_clear_sky_its_spectrum_is_refused(world, settings, words):
    sky = world.lumenray.sky
    sky.use_place, sky.spectrum = True, "CLEAR"
    sky.measured_text = measured_text(patches()[1])
    for name, value in settings.items():
        setattr(sky, name, value)
    made, told = converted()
    assert made is None
    assert any(words in text and "left out" in text for text in told), told


def test_a_record_with_clouds_has_no_clear_skys_spectrum(world, weather):
    """The fourth day has the most sun beside the same diffuse light."""
    world.lumenray.sky.spectrum = "CLEAR"
    world.lumenray.time.day = 4
    made, told = converted()
    clearness = weather_moment(world, find_moment(world, 1)).clearness
    assert (made is not None) == (clearness >= 4.5), (clearness, told)
    world.lumenray.time.day = 1
    assert any("expected 4.5 at least" in text for text in converted()[1])


def test_a_weather_file_of_another_place_is_told(world, weather):
    assert not any("is of Test" in text for text in converted()[1])
    world.lumenray.place.city = "Madrid, Spain"
    assert any("weather file is of Test" in text for text in converted()[1])


def test_what_is_wrong_with_a_weather_file_leaves_the_sky_out(world, weather):
    sky = world.lumenray.sky
    for path, part in (
        ("", "no weather file is chosen"),
        (str(weather.parent / "missing.epw"), "cannot be read"),
        (__file__, "is no weather file"),
    ):
        sky.weather_file = path
        made, told = converted()
        assert made is None
        assert any(part in text and "left out" in text for text in told), told
        assert part in describe_sky(world, None, bpy.context.scene).problem
    assert any(row.is_missing for row, _ in converted_scene().report.rows)
    sky.weather_file = str(weather)
    world.lumenray.time.month = 1
    assert any("no record of 01-03" in text for text in converted()[1])


def patches():
    """Luminances of the patches, brighter to the east, and their table."""
    directions = [
        compass(6 + 12 * row, 360 / count * k)
        for row, count in enumerate((30, 30, 24, 24, 18, 12, 6))
        for k in range(count)
    ]
    values = [3000.0 + 2000.0 * x for x, _, _ in [*directions, (0, 0, 1)]]
    return np.array(values), "\n".join(f"{value:.6f}" for value in values)


def measured_text(content):
    text = bpy.data.texts.new("Scan")
    text.write(content)
    return text


def test_a_measured_sky_shines_as_its_table_says(world, session):
    values, content = patches()
    sky = world.lumenray.sky
    sky.kind, sky.measured_text = "MEASURED", measured_text(content)
    made, _ = converted()
    assert isinstance(made, ImageWorld)
    expected = float(horizontal_weights() @ values)
    value, error = measure_sky(session, [(0, 0, 1), (1, 0, 0), (-1, 0, 0)])
    assert abs(value[0] - expected) < 4 * error[0] + 1e-3 * expected
    assert value[1] > 1.3 * value[2]
    # Where +y points east, north is to the left, and the bright east ahead.
    world.lumenray.place.north = math.radians(90)
    value, error = measure_sky(session, [(0, 1, 0), (0, -1, 0)])
    assert value[0] > 1.3 * value[1]
    lines = dict(describe_sky(world, None, bpy.context.scene).lines)
    assert lines["Zenith luminance"] == "3\u2009000 cd/m²"


def test_a_measured_sky_can_be_levelled_and_coloured(world, session, tmp_path):
    _, content = patches()
    path = tmp_path / "scan.txt"
    path.write_text(content)
    sky = world.lumenray.sky
    sky.kind, sky.measured_file, sky.use_file_level = "MEASURED", str(path), False
    sky.illuminance, sky.colour_temperature = 8000.0, 12000.0
    made = convert_sky(world, "", ConversionReport(), None)
    mean = made.image.pixels.reshape(-1, 3).mean(axis=0)
    assert mean[2] > 1.2 * mean[0]
    value, error = measure_sky(session, [(0, 0, 1)])
    assert abs(value[0] - 8000.0) < 4 * error[0] + 2e-3 * 8000.0
    sky.level, sky.zenith_luminance = "ZENITH", 1234.0
    lines = dict(describe_sky(world, None, bpy.context.scene).lines)
    assert lines["Zenith luminance"] == "1\u2009234 cd/m²"


def test_what_is_wrong_with_a_table_leaves_the_sky_out(world):
    sky = world.lumenray.sky
    sky.kind = "MEASURED"
    assert any("no table of a measured sky is chosen" in text for text in converted()[1])
    sky.measured_text = measured_text("1\n2\n-3\n")
    made, told = converted()
    assert made is None
    assert any("Scan, line 3" in text for text in told)


def test_the_patches_of_the_table_are_those_of_the_engine():
    values, _ = patches()
    east = find_patches(np.array(compass(6, 90)))
    assert values[east] == values.max()


@pytest.mark.parametrize(
    ("name", "value"),
    [("cloudiness", 0.75), ("level", "ZENITH"), ("kind", "CIE"), ("use_place", True)],
)
def test_an_edit_sends_the_sky(world, name, value):
    sky = world.lumenray.sky
    sky.kind = "CLOUDINESS"
    kept = KeptScene.started()
    setattr(sky, name, value)
    assert len(kept.sent()[0]) == 1
    assert kept.sent() == ([], 0)


def test_a_weather_sky_follows_the_clock_and_the_frames(world, weather):
    kept = KeptScene.started()
    world.lumenray.time.hour = 11.5
    assert kept.sent() == (["PerezSky"], 0)
    time = world.lumenray.time
    time.follows_frames, time.minutes_per_frame = True, -10.0
    kept.sent()
    bpy.context.scene.frame_set(4)
    assert kept.sent() == (["PerezSky"], 0)
    time.follows_frames = False
    kept.sent()
    bpy.context.scene.frame_set(5)
    assert kept.sent() == ([], 0)


def test_luminances_of_the_weather_sky_are_those_of_the_model(world, weather):
    """The engine's own function of the whole hour, with the sun in the middle of the record."""
    from lumenray.engine.sky.hour import find_daylight_hours, make_hour
    from lumenray.engine.sky.weather import find_hours
    from lumenray.engine.sky.weather_file import read_weather

    world.lumenray.time.use_refraction = False
    whole = read_weather(weather)
    hours = find_hours(whole, 2026)
    index = int(np.flatnonzero((whole.day == 3) & (whole.hour == 9.5))[0])
    expected, _ = make_hour(hours, find_daylight_hours(whole, hours), index)
    made, _ = converted()
    directions = np.array([compass(h, a) for h in (5, 30, 60, 90) for a in (0, 80, 170, 260)])
    # The city lies 0.03 degrees from the file's place.
    np.testing.assert_allclose(
        find_luminances(made, directions), find_luminances(expected, directions), rtol=0.02
    )
