"""Sensors by cells against sensors by full paths, and which of the two is chosen."""

import re

import numpy as np
import pytest
from small_pictures import ROOMS
from small_scenes import session_of

from lumenray.benchmarks.common.interiors import build_cabin
from lumenray.engine.accuracy.estimate import Estimate
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.sensor import SensorKind
from lumenray.engine.transport.sensors import method
from lumenray.engine.transport.sensors.cell_job import Bias

pytestmark = pytest.mark.mitsuba

Z = 4.5
CELLS_SHARE = 0.005
"""What cells may change of a reading, beside noise, relative to it. [-]"""

SEEDS = 16


def places_in_room(count, seed=3):
    """Places between things, and directions to all sides. (n, 3) [m]"""
    draw = np.random.default_rng(seed)
    places = draw.uniform((0.3, 0.3, 0.1), (2.7, 3.7, 2.0), (count, 3))
    normals = draw.normal(size=(count, 3))
    return places, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def measure(room, samples, by, seed, count=8, **more):
    places, normals = places_in_room(count)
    return session_of(*ROOMS[room]).measure(
        places, normals, StopRule(samples=samples), seed, method=by, **more
    )


def assert_alike(cells, paths):
    errors = np.hypot(cells.standard_error, paths.standard_error)
    gaps = np.abs(cells.illuminance - paths.illuminance) - CELLS_SHARE * paths.illuminance
    assert (gaps < Z * errors).all(), gaps / errors
    # The errors must be small enough to find anything.
    assert np.median(errors / paths.illuminance) < 0.02
    assert "read from cells" in cells.method and cells.method in cells.provenance.decisions
    assert any("cells instead of full paths" in each for each in cells.provenance.notes)


def test_cells_give_what_paths_give():
    cells = measure("matt", 1 << 12, "cells", 1, transport="mono")
    assert_alike(cells, measure("matt", 1 << 15, "paths", 2, transport="mono"))


@pytest.mark.slow
@pytest.mark.parametrize("kind", SensorKind)
@pytest.mark.parametrize("room", ["matt", "coats", "mirror", "pane"])
def test_cells_give_what_paths_give_in_every_kind_of_room(room, kind, transport):
    more = {"kind": kind, "transport": transport}
    assert_alike(
        measure(room, 1 << 14, "cells", 1, **more), measure(room, 1 << 17, "paths", 2, **more)
    )


@pytest.mark.slow
def test_colour_is_that_of_paths():
    cells = measure("matt", 1 << 14, "cells", 1, colour=True, transport="spectral")
    paths = measure("matt", 1 << 16, "paths", 2, colour=True, transport="spectral")
    errors = np.hypot(cells.tristimulus_error, paths.tristimulus_error)
    gaps = np.abs(cells.tristimulus - paths.tristimulus) - CELLS_SHARE * paths.tristimulus
    assert (gaps < Z * errors).all()
    assert_alike(cells, paths)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_readings():
    made = [measure("matt", 1 << 10, "cells", 5, transport="mono") for _ in range(2)]
    np.testing.assert_array_equal(made[0].illuminance, made[1].illuminance)
    np.testing.assert_array_equal(made[0].standard_error, made[1].standard_error)


@pytest.mark.slow
@pytest.mark.parametrize("room", ["matt", "mirror"])
def test_the_stated_error_of_readings_by_cells_is_the_true_one(room):
    """Readings of many seeds scatter about their mean as much as they say.

    What errors hold of the bias is no scatter, and is taken out.
    """
    made = [measure(room, 1 << 10, "cells", seed, 24, transport="mono") for seed in range(SEEDS)]
    values = np.array([each.illuminance for each in made])
    mean = values.mean(axis=0)
    true = ((values / mean - 1.0) ** 2).sum() / (SEEDS - 1) / len(mean)
    stated = np.array([(each.standard_error / mean) ** 2 - held_by(each) ** 2 for each in made])
    assert 0.85 < np.sqrt(stated.mean() / true) < 1.15


def held_by(made) -> float:
    """What errors hold of the bias, as the note tells it. [-]"""
    found = [re.search(r"errors hold (\S+) % for it", each) for each in made.provenance.notes]
    return next(0.01 * float(each[1]) for each in found if each)


def test_what_the_comparison_cannot_tell_is_held():
    """Rare paths: nothing is sure, and that is all that is known."""
    unknown = Bias(mean=-0.0096, error=0.009, beyond=0.0, checks=1 << 20)
    assert unknown.held == pytest.approx(np.hypot(0.002, 0.009))
    assert Bias(0.004, 1e-5, 0.004, 1 << 20).held == pytest.approx(0.004, rel=1e-4)


def test_an_error_that_would_be_held_for_the_most_part_is_left_to_paths():
    session = session_of(*ROOMS["matt"])
    choice = method.Choice(session._prepare("mono", False), StopRule(error=0.01), 64, "auto", None)
    choice.error = 0.01
    assert choice.most_held == pytest.approx(0.007)
    choice.refuse(Bias(0.001, 0.008, 0.0, 1 << 20))
    assert choice.uses_cells is False
    assert "may be off by 0.82 % for all that could be told" in choice.reason


@pytest.mark.slow
def test_what_cells_are_off_by_in_a_cabin_is_held_or_refused(monkeypatch):
    """Lamps in coves: light that few paths find, and cells whose light is steep."""
    # So few sensors would go by full paths.
    monkeypatch.setattr(method, "FEWEST_PATHS", 1 << 21)
    line = np.linspace(0.6, 11.4, 24), np.linspace(-1.2, 1.2, 14)
    places = np.stack([*np.meshgrid(*line), np.full((14, 24), 0.62)], axis=-1).reshape(-1, 3)
    up = np.tile([0.0, 0.0, 1.0], (len(places), 1))
    session = session_of(*build_cabin())
    cells = session.measure(places, up, StopRule(error=0.012), 1, witness=False)
    is_refused = "cells would be off" in cells.method or "cells may be off" in cells.method
    assert is_refused or "read from cells" in cells.method
    paths = session.measure(places, up, StopRule(samples=1 << 15), 2, method="paths", witness=False)
    size = paths.illuminance.mean()
    own = np.sqrt((paths.standard_error**2).sum()) / len(places) / size
    if is_refused:
        held = np.sqrt((cells.standard_error**2).sum()) / len(places) / size
    else:
        held = held_by(cells)
    apart = cells.illuminance.mean() / size - 1.0
    assert abs(apart) < (3.5 if is_refused else 2.0) * np.hypot(held, own)
    true = np.sqrt(((cells.illuminance - paths.illuminance) ** 2).mean()) / size
    stated = np.sqrt((cells.standard_error**2 + paths.standard_error**2).mean()) / size
    assert true < 1.25 * stated


@pytest.mark.parametrize("asked", [{"error": 0.0018}, {"each": 0.0019}])
def test_cells_that_have_to_be_read_end_where_more_samples_do_not_help(asked):
    """Errors hold 0.2 % and more for what cells change: less cannot be reached, which the result says by its error."""
    places, normals = places_in_room(4)
    session = session_of(*ROOMS["matt"])
    rule = StopRule(**asked, seconds=240.0)
    made = session.measure(places, normals, rule, 1, method="cells", witness=False)
    scatter = np.sqrt(made.standard_error**2 - made.floors**2)
    (goal,) = asked.values()
    size = made.illuminance.mean() if "error" in asked else made.illuminance
    assert (scatter < 2.0 * goal * size).all()
    assert made.provenance.seconds < 200.0
    stated = Estimate(made.illuminance, made.standard_error, made.provenance.samples)
    told = rule.shortfall(stated.relative_error(), each=stated.largest_error())
    assert f"{100.0 * goal:.3g} % was not reached" in told


def test_few_sensors_and_few_samples_get_full_paths():
    assert "so few sensors" in measure("matt", 1 << 12, "auto", 0).method
    assert "so few are needed" in measure("matt", 1 << 12, "auto", 0, 64).method
    assert "asked for" in measure("matt", 1 << 10, "paths", 0).method


def test_reflections_are_counted_by_full_paths_whatever_is_asked_for():
    made = measure("matt", 1 << 12, "cells", 0, reflections=1)
    assert "how often light was reflected" in made.method
    same = measure("matt", 1 << 12, "paths", 0, reflections=1)
    np.testing.assert_array_equal(made.illuminance, same.illuminance)


def test_a_method_that_is_none_is_refused():
    with pytest.raises(SceneError, match="method is 'fast', expected auto or cells or paths"):
        measure("matt", 1 << 10, "fast", 0)


@pytest.mark.slow
def test_many_sensors_are_read_from_cells_and_exact_ones_by_paths(monkeypatch):
    """As soon as they need so many paths; in so plain a room these are few."""
    monkeypatch.setattr(method, "FEWEST_PATHS", 1 << 16)
    monkeypatch.setattr(method, "BELIEVED", 1 << 8)
    places, normals = places_in_room(200)
    session = session_of(*ROOMS["matt"])
    loose = session.measure(places, normals, StopRule(error=0.0055), 1)
    assert "read from cells" in loose.method
    assert np.sqrt((loose.standard_error**2).mean()) <= 0.0055 * loose.illuminance.mean()
    exact = session.measure(places[:40], normals[:40], StopRule(samples=1 << 17), 1)
    assert "more than cells can promise" in exact.method
    errors = np.hypot(loose.standard_error[:40], exact.standard_error)
    apart = (loose.illuminance[:40] - exact.illuminance) / errors
    assert 0.7 < np.sqrt((apart**2).mean()) < 1.35
