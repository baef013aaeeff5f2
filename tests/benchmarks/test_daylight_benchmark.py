"""The benchmark of daylight on little: its weather and its room, both programs on them, and how it judges and tells."""

import json
from dataclasses import replace

import numpy as np
import pytest

from lumenray.benchmarks.daylight import run as daylight
from lumenray.benchmarks.daylight import skies, speed, year
from lumenray.benchmarks.daylight.hours import SingleHours, choose_hours
from lumenray.benchmarks.daylight.ours import OurYear
from lumenray.benchmarks.daylight.reach import find_reach
from lumenray.benchmarks.daylight.room import WINDOW, Room, make_room, radiance_text
from lumenray.benchmarks.daylight.scale import measure_scale
from lumenray.benchmarks.daylight.sun import measure_sun
from lumenray.benchmarks.daylight.two_phase import Settings, run_suns, run_two_phase
from lumenray.benchmarks.daylight.weather_year import clear_sky, make_year, write_epw, write_wea
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.daylight.replicated import MetricEstimate
from lumenray.engine.errors import LumenrayError
from lumenray.engine.sky.hour import find_daylight_hours
from lumenray.engine.sky.perez import find_class
from lumenray.engine.sky.weather import find_hours
from lumenray.engine.sky.weather_file import read_weather


@pytest.fixture(scope="module")
def made_up():
    return make_year()


@pytest.fixture(scope="module")
def weather(made_up, tmp_path_factory):
    return write_epw(made_up, tmp_path_factory.mktemp("weather") / "year.epw")


# ---- the sun and skies ----


def test_sun_agrees_with_both_algorithms():
    pytest.importorskip("pyradiance")
    found = measure_sun(60)
    assert set(found["others"]) == {"Meeus", "Michalsky (gensky)"}
    for row in found["others"].values():
        assert 0.0 < row["rms"] < row["max"] < 0.0125
        assert row["count"] >= 59


def test_skies_agree_with_radiance():
    pytest.importorskip("pyradiance")
    found = skies.measure_skies()
    assert skies.largest_difference(found) < 0.002
    assert all(row["luminance"] < 0.004 for row in found["gensky"].values())
    assert {row["class"] for row in found["gendaylit"]} == set(range(1, 9))
    # Radiance's own mean over 145 directions misses the bright sky about the sun.
    assert all(0.96 < row["given"] < 1.0 for row in found["gendaylit"])


def test_hours_of_a_weather_file_cover_the_classes_that_it_has(weather):
    chosen = skies.weather_hours(weather)
    assert len(chosen) == skies.HOURS
    clearness = [
        1.0 + hour.direct / hour.diffuse / (1.0 + 1.041 * np.radians(90.0 - hour.elevation) ** 3)
        for hour in chosen
    ]
    assert set(find_class(clearness)) == set(range(8))


def test_difference_is_of_the_worst_cell_and_spares_what_is_dark():
    theirs = np.array([1.0, 1.0, 1.0, 1e-6])
    assert skies.difference(theirs * [1.0, 1.01, 0.98, 1.0], theirs) == pytest.approx(0.02)
    assert skies.difference(theirs * [1.0, 1.0, 1.0, 11.0], theirs) == pytest.approx(
        1e-5 / (0.01 * theirs.mean())
    )


# ---- the weather ----


def test_weather_reads_without_remarks_and_is_the_same_again(made_up, weather):
    assert len(weather) == 8760
    assert not weather.remarks
    assert not find_hours(weather).remarks
    again = make_year()
    np.testing.assert_array_equal(made_up.direct_normal, again.direct_normal)
    other = make_year(seed=29)
    assert (other.direct_normal != made_up.direct_normal).mean() > 0.3


def test_weather_is_what_its_sun_allows(made_up, weather):
    hours = find_hours(weather)
    is_dark = hours.sun.elevation <= 0.0
    assert not made_up.direct_normal[is_dark].any()
    assert not made_up.global_horizontal[is_dark].any()
    # Rounded numbers of an hour whose sun moves.
    sine = np.sin(np.radians(np.maximum(hours.sun.elevation, 0.0)))
    whole = made_up.direct_normal * sine + made_up.diffuse_horizontal
    is_high = hours.sun.elevation > 15.0
    np.testing.assert_allclose(whole[is_high], made_up.global_horizontal[is_high], atol=8.0)
    # Lisbon has some 1700 kWh/m2 a year, half of it in four months.
    assert 1500.0 < made_up.global_horizontal.sum() / 1000.0 < 2000.0
    summer = np.isin(made_up.month, (5, 6, 7, 8))
    assert 0.4 < made_up.global_horizontal[summer].sum() / made_up.global_horizontal.sum() < 0.6


def test_clear_sky_is_that_of_the_atlas():
    """An air mass of 2 and a turbidity of 3, by hand: the depth of clean air is 1 / (6.6296 + ... ) = 0.1036."""
    elevation = np.array([29.92, -1.0])
    normal, diffuse = clear_sky(elevation, np.ones(2), np.full(2, 3.0))
    depth = 1.0 / (6.6296 + 1.7513 * 2 - 0.1202 * 4 + 0.0065 * 8 - 0.00013 * 16)
    assert normal[0] == pytest.approx(1367.0 * np.exp(-0.8662 * 3.0 * 2.0 * depth), rel=2e-3)
    up = -0.015843 + 0.030543 * 3 + 0.0003797 * 9
    sine = np.sin(np.radians(29.92))
    shape = (0.26463 - 0.184743 + 0.0282672) + (2.0402 + 0.056835 - 0.100449) * sine
    shape += (-1.3025 + 0.117693 + 0.0765711) * sine**2
    assert diffuse[0] == pytest.approx(1367.0 * up * shape, rel=1e-4)
    assert normal[1] == diffuse[1] == 0.0


def test_wea_holds_the_same_year(weather, tmp_path):
    write_wea(weather, tmp_path / "year.wea")
    read = read_weather(tmp_path / "year.wea")
    assert read.place.longitude == weather.place.longitude
    assert read.place.zone == weather.place.zone
    for name in ("direct_normal", "diffuse_horizontal"):
        np.testing.assert_array_equal(read.values[name], weather.values[name])
    np.testing.assert_array_equal(read.hour, weather.hour)


# ---- the room ----


def test_sensors_are_inside_and_radiance_has_the_same_room():
    room = make_room()
    assert room.positions.shape == (200, 3)
    text = radiance_text(room)
    # The pane's corners, and Radiance's name of its material.
    for x in WINDOW[0]:
        assert f"{x:g} 0 {WINDOW[1][0]:g}" in text
    assert text.count("void glass") == 1
    assert "void glow" not in text and "void light" not in text


@pytest.mark.mitsuba
@pytest.mark.slow
def test_both_programs_have_the_same_hours(weather):
    """Next to the window, with Radiance's sun asked for itself, and so high that patches hardly smear what is about it."""
    pytest.importorskip("pyradiance")
    room = make_room(3, 8)
    near = Room(room.items, room.positions[:6], room.normals[:6])
    chosen = choose_hours(weather, 40, seed=3)
    chosen = chosen[find_hours(weather).sun.elevation[chosen] > 35.0][:3]
    part = weather_of(weather, chosen)
    settings = Settings(60_000, 6, 1e-5, 1, has_exact_sun=True)
    theirs, again = (run_two_phase(near, part, each) for each in (settings, settings.again()))
    assert set(theirs.seconds) == {"oconv", "gendaymtx", "rfluxmtx", "dctimestep", "rcontrib"}
    means = 0.5 * (theirs.illuminance + again.illuminance).mean(axis=0)
    noise = np.abs(theirs.illuminance - again.illuminance).mean(axis=0)
    singles = SingleHours(near, weather)
    for k, index in enumerate(chosen):
        ours = singles.measure(int(index), StopRule(samples=1 << 12))
        error = np.sqrt((ours.errors**2).sum()) / len(ours.errors)
        mean = ours.illuminance.mean()
        assert means[k] == pytest.approx(mean, abs=3.0 * error + noise[k] + 0.03 * mean)


def weather_of(weather, chosen):
    arrays = {
        name: getattr(weather, name)[chosen] for name in ("year", "month", "day", "hour", "line")
    }
    return replace(
        weather, values={name: values[chosen] for name, values in weather.values.items()}, **arrays
    )


def test_the_sun_of_radiance_is_the_closed_form(weather):
    """Sensors outside, which nothing shades: the illuminance is that of the sun times the sine of its height."""
    pytest.importorskip("pyradiance")
    room = make_room(2, 2)
    outside = Room(room.items, room.positions - [0.0, 40.0, 0.0], room.normals)
    chosen = choose_hours(weather, 6, seed=4)
    found = run_suns(outside, weather_of(weather, chosen)).illuminance
    hours = find_hours(weather)
    normal = find_daylight_hours(weather, hours).direct_normal[chosen]
    expected = normal * np.sin(np.radians(hours.sun.elevation[chosen]))
    # gendaymtx has a simpler sun (0.3 degrees), and prints four digits.
    for row in found:
        np.testing.assert_allclose(row, expected, rtol=0.03, atol=30.0)


# ---- how it judges ----


def test_errors_that_are_right_hold_as_often_as_they_say():
    rng = np.random.default_rng(3)
    true = rng.uniform(1.0, 2.0, 20_000)
    values = true + 0.1 * rng.standard_normal(true.size)
    exact = MetricEstimate.exact(true)
    held = year.is_held(MetricEstimate(values, np.full(true.size, 0.1), np.inf), exact)
    assert held.mean() == pytest.approx(0.95, abs=0.006)
    small = year.is_held(MetricEstimate(values, np.full(true.size, 0.05), np.inf), exact)
    assert small.mean() < 0.7


def test_bias_is_found_with_its_error():
    rng = np.random.default_rng(4)
    true = rng.uniform(100.0, 200.0, (200, 50))
    shared = 1.0 * rng.standard_normal((200, 1))
    noise = 5.0 * rng.standard_normal(true.shape)
    made = year.compare_values(
        1.01 * true + shared, np.ones(true.shape), true + noise, np.full(true.shape, 5.0)
    )
    assert made["bias"] == pytest.approx(0.01, abs=4.0 * made["bias_error"])
    assert made["bias_error"] == pytest.approx(
        np.hypot(1.0 / 200**0.5, 5.0 / 100.0) / true.mean(), rel=0.02
    )
    assert made["within_2"] > 0.9


def test_noise_and_errors_are_told_apart():
    """Of noise of 10 % and a method that is 20 % off, against two runs of a truth that have noise of 30 %."""
    rng = np.random.default_rng(5)
    true = np.full((200, 400), 100.0)
    first, second = (true * (1.2 + 0.1 * rng.standard_normal(true.shape)) for _ in range(2))
    truths = [true * (1.0 + 0.3 * rng.standard_normal(true.shape)) for _ in range(2)]
    assert speed.noise_of(first, second) == pytest.approx(0.1 / 1.2, rel=0.01)
    assert speed.error_of(first, *truths) == pytest.approx(np.hypot(0.2, 0.1), rel=0.02)


def test_time_to_an_error_counts_what_a_run_costs_at_least():
    """Seconds 5 + w / 1000, errors by noise of 4 / sqrt(w), and by that and a floor of 1 or 3 %."""
    work = np.array([1000.0, 4000.0, 16_000.0])
    seconds, noise = 5.0 + work / 1000.0, 4.0 / np.sqrt(work)
    found = find_reach(work, seconds, noise, 0.02, has_floor=False)
    assert found.seconds == pytest.approx(45.0) and found.is_thought_on
    found = find_reach(work, seconds, np.hypot(noise, 0.01), 0.02, has_floor=True)
    assert found.seconds == pytest.approx(5.0 + 16.0 / 0.0003 / 1000.0)
    assert find_reach(work, seconds, np.hypot(noise, 0.03), 0.02, has_floor=True) is None
    assert find_reach(work, seconds, [0.5, 0.51, 0.5], 0.02, has_floor=True) is None
    # Between runs.
    found = find_reach(work, seconds, noise, 0.05, has_floor=True)
    assert 9.0 < found.seconds < 21.0 and not found.is_thought_on


def test_chains_are_compared_by_their_whole_error_or_else_by_noise():
    def rows(times, noises, errors):
        return [
            {"work": str(k), "amount": t, "seconds": t, "noise": n, "error": e}
            for k, (t, n, e) in enumerate(zip(times, noises, errors, strict=True))
        ]

    coarse = rows([1.0, 4.0, 16.0], [0.16, 0.08, 0.04], [0.52, 0.505, 0.501])
    ours = rows([1.0, 4.0], [0.02, 0.01], [0.02, 0.01])
    found = speed.speedup({"runs": {"MF 1": coarse, speed.OURS: ours}})
    assert found == (pytest.approx(64.0), "MF 1", "noise")
    fine = rows([100.0, 400.0], [0.04, 0.02], [0.04, 0.02])
    found = speed.speedup({"runs": {"MF 1": coarse, "MF 4, exact sun": fine, speed.OURS: ours}})
    assert found == (pytest.approx(400.0), "MF 4, exact sun", "error")
    assert speed.speedup({"runs": {"MF 1": coarse}}) is None


class Even:
    """Engine whose rooms are lit by 100 lx in 10 hours, with errors of 1 % at 1024 paths."""

    def run(self, room, weather, samples, seed, has_metrics=False):
        rng = np.random.default_rng(seed)
        error = (1024.0 / samples) ** 0.5
        values = np.zeros((len(room.positions), len(weather)))
        values[:, :10] = 100.0 + error * rng.standard_normal((len(room.positions), 1))
        means = values[:, :10].mean(axis=1)
        errors = np.where(values > 0.0, error, 0.0)
        metric = MetricEstimate(means, np.full(len(means), error), 1e6)
        told = {"mean": metric, "exact": MetricEstimate.exact(np.ones(3))} if has_metrics else {}
        return OurYear(values, errors, samples / 1024.0, told)


def test_errors_of_metrics_are_judged_by_many_seeds(weather):
    amounts = (256, 1024)
    made = year.judge_errors(Even(), make_room(), weather, 20, amounts, 1 << 20, lambda _line: None)
    np.testing.assert_allclose(made["cover"], 0.95, atol=0.02)
    assert made["metrics"]["mean"]["count"] == 20 * 200
    assert "exact" not in made["metrics"]


def test_races_go_on_where_they_broke_off(weather, monkeypatch):
    asked = []

    class Year:
        illuminance, total, seconds = np.ones((200, 8760)), 2.0, {"rfluxmtx": 2.0}

    def chain(room, weather, settings):
        asked.append(settings.words)
        return Year()

    monkeypatch.setattr(speed, "run_two_phase", chain)
    monkeypatch.setattr(speed, "run_suns", lambda room, weather: Year())
    truth = {"hours": [0, 1], "values": np.ones((2, 200, 2)).tolist()}
    kept = []
    first = speed.measure_speed(
        Even(),
        make_room(),
        weather,
        keep=kept.append,
        earlier={"truth": truth},
        divisions=(100,),
        chains=("MF 1",),
        samples=(),
    )
    assert len(asked) == 2 and kept
    more = json.loads(json.dumps(first))
    speed.measure_speed(
        Even(),
        make_room(),
        weather,
        earlier=more,
        divisions=(100, 200),
        chains=("MF 1",),
        samples=(256,),
    )
    assert len(asked) == 4
    assert [row["work"] for row in more["runs"][speed.OURS]] == ["256 paths"]


def test_many_sensors_are_timed(weather):
    made = measure_scale(Even(), weather, columns=6, rows=5, samples=256)
    assert made["sensors"] == 30
    assert made["processor_minutes"] == pytest.approx(0.25 / 60.0)
    # 2 lx of some 100 lx.
    assert made["error"] == pytest.approx(0.02, rel=0.1)


def whole_result(bias, cover, ratio):
    """Results of all parts of the year."""
    rows = [
        {
            "work": f"-ad {4**k}",
            "amount": 4**k,
            "seconds": 4.0**k,
            "noise": 0.32 / 2**k,
            "error": 0.4,
            "parts": {},
        }
        for k in range(3)
    ]
    ours = [
        {
            "work": "256 paths",
            "amount": 256,
            "seconds": 2.0,
            "noise": 0.02,
            "error": 0.02,
            "parts": {},
        }
    ]
    return {
        "machine": {"cpu": "a processor", "cores": 2, "mitsuba": "3", "lumenray": "0"},
        "weather": "made up",
        "other_load": {"speed": 0.4},
        "unfinished": {},
        "parts": {
            "year": {
                "agreement": {
                    "hours": 50, "bias": bias, "bias_error": 0.001, "within_2": 0.96, "rms": 0.99, "farthest": 3.9,
                },
                "coverage": {
                    "seeds": 20, "amounts": [512, 8192], "cover": [0.8, cover],
                    "metrics": {"room: sda": {"cover": [0.8, cover], "count": 20}},
                },
                "cost": {
                    "year": [(2.0, 0.1), (3.0, 0.05)], "hour": [(1.0, 0.2), (2.0, 0.1)],
                    "year_seconds": 10.0, "hour_seconds": 10.0 / ratio, "ratio": ratio,
                },
            },
            "speed": {
                "truth": {"hours": [1, 2], "values": []},
                "sun_seconds": 0.4,
                "runs": {"MF 1": rows, speed.OURS: ours},
            },
            "scale": {
                "sensors": 10_000, "samples": 1024, "cores": 2, "minutes": 4.2, "processor_minutes": 8.0,
                "error": 0.1,
            },
        },
    }  # fmt: skip


def test_demands_are_judged_and_everything_is_told(tmp_path):
    good = daylight._sum_up(whole_result(-0.002, 0.95, 2.0))
    daylight.write_results(good, tmp_path, None)
    text = (tmp_path / "daylight.md").read_text(encoding="utf-8")
    for words in (
        "-0.200 % off theirs",
        "| room: sda | 20 | 80.0 % | 95.0 % |",
        "10000 sensors on 2 cores take 4.2 minutes",
        "MF 1, takes 128 times as long by its noise",
        "Other processes took part of the machine meanwhile: speed 40%",
    ):
        assert words in text
    verdicts = {bar.demand.split(",")[0]: bar.passed for bar in daylight.check_bars(good)}
    assert verdicts["bias of the year beside its hours"]
    assert verdicts["two-phase chain over ours"]
    assert verdicts["sun's place"] is None
    assert good["hour_bias_percent"] == pytest.approx(0.2)
    bad = daylight.check_bars(daylight._sum_up(whole_result(0.006, 0.89, 3.5)))
    assert [bar.passed for bar in bad[3:]] == [False, False, True, False]


def test_parts_are_measured_alone_told_and_gone_on_with(tmp_path, monkeypatch):
    pytest.importorskip("pyradiance")
    monkeypatch.setattr(daylight, "measure_sun", lambda say: measure_sun(5, say))
    kept = []
    made = daylight.run(["sun"], keep=kept.append)
    assert list(made["parts"]) == ["sun"]
    assert made["sun_max_error_deg"] < 0.02 and made["gendaylit_max_percent"] is None
    path = tmp_path / "daylight.json"
    daylight.write_results(made, tmp_path, path)
    text = (tmp_path / "daylight.md").read_text(encoding="utf-8")
    assert "Michalsky" in text and "not measured" in text
    earlier = daylight.read_results(path)
    monkeypatch.setattr(
        daylight, "measure_skies", lambda given, say: pytest.fail("was not asked for")
    )
    again = daylight.run(["sun"], earlier=earlier)
    assert again["parts"]["sun"]["count"] == 5
    with pytest.raises(LumenrayError, match="there is no part moon; choose from sun, skies"):
        daylight.run(["moon"])
