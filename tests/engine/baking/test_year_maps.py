"""Figures of a year on lumels: beside sensors at the same places, and where they lie on pages."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_years import open_coefficients
from small_scenes import paint, quad
from weather_files import sunny_year

from lumenray.blender_addon.daylight_year.job import SUN_ANGLE, Places, YearJob
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.lumel_sheet import LumelSheet, SheetSurface
from lumenray.engine.baking.order import BakeOrder, Layout
from lumenray.engine.baking.year_figures import KINDS
from lumenray.engine.baking.year_maps import find_coverage, make_year_maps
from lumenray.engine.daylight.blinds import FixedTimes
from lumenray.engine.daylight.coefficients import DaylightOrder
from lumenray.engine.daylight.replicated import MetricEstimate
from lumenray.engine.daylight.study import Question, judge, shade
from lumenray.engine.daylight.year import make_year
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.scene import Scene, SceneDelta
from lumenray.engine.session import Session
from lumenray.engine.sky.clock_range import ClockRange
from lumenray.engine.sky.weather_file import read_weather


@pytest.fixture(scope="module")
def year(tmp_path_factory):
    path = tmp_path_factory.mktemp("weather") / "made_up.epw"
    path.write_text(sunny_year(), encoding="latin-1")
    return make_year(read_weather(path), ground_reflectance=0.2)


def made_up_sheet():
    """Two objects on a page of 6 by 4: three lumels of which one is inside a solid, and two."""
    layout = Layout(np.zeros((0, 3, 2), np.float32), *([np.zeros(0, np.int32)] * 2), None, 0)
    return LumelSheet(
        np.array([[6, 4]]),
        tuple(SheetSurface(name, name, layout, 2.0) for name in ("floor", "wall")),
        np.array([0, 0, 0, 1, 1], np.int32),
        np.zeros(5, np.int32),
        np.array([0, 1, 2, 16, 17]),
        np.array([0, 0, 0, 1, 1], np.int32),
        np.array([1.0, 1.0, 1.0, 2.0, 6.0]),
        np.array([1, 1, 0, 1, 1], bool),
        np.zeros((5, 6)),
    )


def test_lumels_follow_the_blinds_that_the_grid_has_moved(year):
    """Sensors 0 and 1 are the grid, the others the lumels, in the order of the objects."""
    parts = (0.3, 0.02, 0.3, 0.004, 0.02, 0.1)
    opened, closed = (open_coefficients(year, f * np.array(parts)) for f in (1.0, 0.05))
    question = Question(blinds=(FixedTimes(ClockRange((4, 9))),))
    whole = judge(shade(year, opened, (closed,), None, question), question).sensors
    grid = [open_coefficients(year, f * np.array(parts[:2])) for f in (1.0, 0.05)]
    light = shade(year, grid[0], (grid[1],), None, question)
    made = make_year_maps(made_up_sheet(), (opened, closed), 2, light, question, 1)
    (page,) = made.pages
    own = page.values["mean_lx"].reshape(-1)
    np.testing.assert_allclose(own[[0, 1, 16, 17]], whole["mean_lx"].value[2:], rtol=1e-5)
    autonomy = page.values["daylight_autonomy"].reshape(-1)
    np.testing.assert_allclose(
        autonomy[[0, 1, 16, 17]], whole["daylight_autonomy"].value[2:], rtol=1e-5
    )
    # The lumel inside a solid has the mean of its neighbours, and is told.
    assert own[2] == pytest.approx(own[1])
    assert page.covered.reshape(-1).nonzero()[0].tolist() == [0, 1, 16, 17]
    floor, wall = made.objects
    assert (floor.lumels, floor.filled, wall.lumels, wall.filled) == (2, 1, 2, 0)
    # By area: the second lumel of the wall counts three times as much.
    light = whole["mean_lx"].value
    assert wall.figures.area["mean_lx"].value == pytest.approx(
        0.25 * light[4] + 0.75 * light[5], rel=1e-5
    )
    assert set(page.values) == set(page.errors) == {kind.name for kind in KINDS}


def test_the_blinds_of_a_grid_are_moved_by_the_grid_alone(year):
    """Lumels in full sun beside a grid in the shade: no blind closes."""
    opened = open_coefficients(year, (0.01, 0.01, 1.0, 1.0, 1.0, 1.0))
    closed = open_coefficients(year, (0.0, 0.0, 0.1, 0.1, 0.1, 0.1))
    grid = [open_coefficients(year, part) for part in ((0.01, 0.01), (0.0, 0.0))]
    light = shade(year, grid[0], (grid[1],))
    assert not light.is_closed.any()
    made = make_year_maps(made_up_sheet(), (opened, closed), 2, light, Question(), 0)
    expected = judge(shade(year, open_coefficients(year), ()), Question()).sensors["mean_lx"].value
    assert made.pages[0].values["mean_lx"].flat[0] == pytest.approx(expected[0], rel=1e-5)


def test_coverage_says_how_sure_it_is():
    values = np.array([0.9, 0.5, 0.49, 0.1])
    found = find_coverage(MetricEstimate(values, np.full(4, 0.01), 9.0))
    assert found.value.tolist() == [1.0, 1.0, 0.0, 0.0]
    # One standard error below the bound it has enough with a probability of 15.87 %.
    np.testing.assert_allclose(
        found.standard_error, [0.0, 0.5, np.sqrt(0.1587 * 0.8413), 0.0], atol=1e-3
    )


def job_of(year, floor, places, density, samples=2000):
    wall = quad("wall", [0, 3, -1], [4, 0, 0], [0, 0, 4], "paint")
    scene = Scene()
    scene.apply(SceneDelta(changed=(paint(0.5), floor, wall)))
    order = DaylightOrder(year.suns, SUN_ANGLE, StopRule(samples=samples), year.steps)
    maps = BakeOrder((floor.id, "wall"), StopRule(samples=1), density=density, margin=2)
    sensors = np.column_stack([places, np.tile([0.0, 0.0, 1.0], (len(places), 1))])
    return YearJob(
        scene, [], Places(sensors, np.ones(len(places))), year, Question(), order, maps=maps
    )


@pytest.mark.mitsuba
def test_a_map_has_what_a_grid_has_at_the_same_places(year):
    """A floor beside a wall; the grid stands in the middles of the lumels, which are squares of half a metre."""
    floor = quad("floor", [0, 0, 0], [4, 0, 0], [0, 3, 0], "paint")
    x, y = np.meshgrid(0.25 + 0.5 * np.arange(8), 0.25 + 0.5 * np.arange(6))
    job = job_of(year, floor, np.column_stack([x.ravel(), y.ravel(), 0.0 * x.ravel()]), 2.0)
    session = Session()
    job.run(session)
    maps, figures = job.answer.maps, job.answer.figures
    floor, wall = maps.objects
    assert floor.surface.name == "floor"
    assert floor.lumels == 48
    assert wall.lumels == 64
    sheet = session.find_lumels(job.maps)
    places, order = sheet.sensors[sheet.owner == 0], np.lexsort((x.ravel(), y.ravel()))
    same = np.lexsort(places[:, :2].round(3).T)
    np.testing.assert_allclose(places[same][:, :3], job.places.sensors[:, :3][order], atol=1e-6)
    for name in ("daylight_autonomy", "mean_lx", "useful_enough", "daylight_factor"):
        grid, own = figures.sensors[name], floor.figures.sensors[name]
        apart = own.value[same] - grid.value[order]
        error = np.hypot(own.standard_error[same], grid.standard_error[order])
        assert (np.abs(apart) <= 4.5 * error + 1e-9).all(), name
    mean = floor.figures.area["mean_lx"]
    reach = 3.0 * np.hypot(mean.standard_error, figures.area["mean_lx"].standard_error)
    assert mean.value == pytest.approx(float(figures.area["mean_lx"].value), abs=float(reach))
    # The page of the floor's lumels has those numbers.
    (page,) = maps.pages
    assert page.covered.sum() == 48 + 64
    own = np.concatenate([each.figures.sensors["mean_lx"].value for each in maps.objects])
    np.testing.assert_allclose(
        np.sort(page.values["mean_lx"][page.covered]), np.sort(own), rtol=1e-5
    )


@pytest.mark.mitsuba
def test_too_many_lumels_are_refused(year):
    floor = quad("floor", [0, 0, 0], [4, 0, 0], [0, 3, 0], "paint")
    job = job_of(year, floor, np.zeros((1, 3)), 200.0)
    with pytest.raises(SceneError, match="fewer lumels per metre"):
        job.run(Session())
    job = replace(job, maps=replace(job.maps, objects=("attic",)))
    with pytest.raises(SceneError, match="none of the objects"):
        job.run(Session())
