"""Luminaires where numbers are at their ends: sizes, distances, places and intensities that files and scenes hold."""

import gc
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from luminaires import OPENINGS, illuminance, intensity, luminaire, turn
from luminaires import flux as flux_of
from small_scenes import session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.distribution import Opening

pytestmark = pytest.mark.mitsuba


def measured(lights, positions, normals, samples=256):
    made = session_of(*lights).measure(
        np.asarray(positions, float), np.asarray(normals, float), StopRule(samples=samples)
    )
    assert np.isfinite(made.illuminance).all()
    assert np.isfinite(made.standard_error).all()
    assert (made.illuminance >= 0.0).all()
    return made


def by_point(light, positions, normals):
    """Illuminance of a point by I cos / d^2. [lx]"""
    away = positions - light.frame[:3, 3]
    distance = np.linalg.norm(away, axis=1)
    direction = away / distance[:, None]
    scale = light.output.value / flux_of(light.distribution)
    value = intensity(light.distribution, direction @ light.frame[:3, :3]) * scale
    return value / distance**2 * np.maximum(-(direction * normals).sum(axis=1), 0.0)


@pytest.mark.parametrize("name", OPENINGS)
def test_receivers_in_on_and_beside_an_opening(name):
    light = luminaire("batwing", OPENINGS[name], (0.0, 0.0, 2.0), turn(3))
    inside = light.frame[:3, 3]
    shifts = np.array([[0.0, 0.0, 0.0], [1e-4, 1e-4, 1e-4], [0.0, 0.0, -0.26], [0.31, 0.0, 0.0]])
    places = inside + shifts
    normals = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]])
    made = measured([light], places, normals, 1024)
    # No place can get more than from a body of its largest luminance all around; in the plane of a flat opening that shines
    # along itself this has no bound.
    assert made.illuminance[1:].max() < 1e6


@pytest.mark.parametrize("gap", [1e-3, 0.02])
def test_a_millimetre_off_an_opening(gap):
    # The exitance of a face below its middle, and a sphere's by the square of the distance.
    face = luminaire("lambertian", Opening("rectangle", (0.6, 0.3, 0.0)), lumens=900.0)
    ball = luminaire("even", OPENINGS["sphere"], lumens=900.0)
    for light, height, expected in (
        (face, gap, 900.0 / 0.18),
        (ball, 0.2 + gap, 900.0 / (4.0 * np.pi * (0.2 + gap) ** 2)),
    ):
        made = measured([light], [[0.0, 0.0, -height]], [[0.0, 0.0, 1.0]], 1 << 14)
        assert made.standard_error[0] < 0.01 * expected
        assert made.illuminance[0] == pytest.approx(expected, rel=0.025)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("name", ["rectangle", "sphere", "cylinder"])
@pytest.mark.parametrize(("size", "distance"), [(1e-3, 1.0), (1e-3, 3000.0), (1.0, 10_000.0)])
def test_far_away_any_opening_is_a_point(name, size, distance):
    whole = OPENINGS[name]
    opening = Opening(whole.shape, tuple(size * x for x in whole.size), whole.axis)
    light = luminaire("asymmetric", opening, (0.0, 0.0, 0.0), turn(5), 1e6)
    towards = np.random.default_rng(1).normal(size=(24, 3))
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    places = distance * towards
    expected = by_point(light, places, -towards)
    made = measured([light], places, -towards)
    np.testing.assert_allclose(made.illuminance, expected, rtol=5e-3, atol=1e-3 * expected.max())


def test_an_opening_of_a_hundred_metres():
    opening = Opening("rectangle", (100.0, 100.0, 0.0), "z")
    light = luminaire("lambertian", opening, (0.0, 0.0, 3.0), lumens=1e6)
    made = measured([light], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]], 4096)
    # Below so large a Lambertian face there is almost its exitance.
    assert made.illuminance[0] == pytest.approx(1e6 / 1e4, rel=0.01)


def test_far_from_the_origin():
    shift, place = np.array([1e6, -2e6, 3e5]), np.array([0.0, 0.0, 2.0])
    rng = np.random.default_rng(2)
    places = rng.uniform(-3, 3, (40, 3)) - [0, 0, 3]
    normals = np.tile([0.0, 0.0, 1.0], (40, 1))
    near = luminaire("asymmetric", OPENINGS["box"], place, turn(2))
    far = luminaire("asymmetric", OPENINGS["box"], shift + place, turn(2))
    here = measured([near], places, normals, 1024)
    there = measured([far], places + shift, normals, 1024)
    error = np.hypot(here.standard_error, there.standard_error)
    difference = np.abs(here.illuminance - there.illuminance)
    assert (difference <= 5.0 * error + 1e-3 * here.illuminance.max()).all()


@pytest.mark.parametrize("name", ["pencil", "spike"])
def test_sharp_beams_from_a_large_opening(name):
    light = luminaire(name, Opening("rectangle", (0.6, 0.6, 0.0), "z"), (0.0, 0.0, 3.0))
    places = np.random.default_rng(4).uniform(-0.35, 0.35, (24, 3)) * [1, 1, 0]
    normals = np.tile([0.0, 0.0, 1.0], (24, 1))
    made = measured([light], places, normals, 4096)
    expected = illuminance(light, places, normals, 400)
    allowed = 5.0 * made.standard_error + 0.01 * expected.max()
    assert (np.abs(made.illuminance - expected) <= allowed).all()


def test_light_that_only_goes_up_leaves_the_floor_dark():
    light = luminaire("only up", OPENINGS["ellipse"], (0.0, 0.0, 2.0))
    made = measured([light], [[0, 0, 0], [0, 0, 4]], [[0, 0, 1], [0, 0, -1]])
    assert made.illuminance[0] == 0.0
    assert made.illuminance[1] > 0.0


def test_receivers_at_a_grazing_angle():
    light = luminaire("even", Opening("rectangle", (0.5, 0.5, 0.0), "z"), (0.0, 0.0, 2.0))
    places = np.array([[3.0, 0.0, 2.0], [3.0, 0.0, 2.0 - 1e-4], [3.0, 0.0, 2.0 - 1e-2]])
    made = measured([light], places, np.tile([-1.0, 0.0, 0.0], (3, 1)), 1024)
    # An even distribution is as bright from the side, however thin the face looks.
    expected = 1000.0 / (4.0 * np.pi) / 9.0
    np.testing.assert_allclose(made.illuminance[1:], expected, rtol=0.05)


@pytest.mark.parametrize("name", ["tiny", "huge"])
def test_only_proportions_of_intensities_count(name):
    light = luminaire(name, Opening(), (0.0, 0.0, 2.0), turn(7))
    rng = np.random.default_rng(6)
    places, normals = rng.uniform(-2, 2, (24, 3)), np.tile([0.0, 0.0, 1.0], (24, 1))
    made = measured([light], places, normals)
    expected = by_point(light, places + 1e-4 * normals, normals)
    np.testing.assert_allclose(made.illuminance, expected, rtol=2e-3, atol=1e-4 * expected.max())


def test_three_hundred_luminaires():
    names = ["batwing", "spot", "lambertian", "type A", "asymmetric"]
    lights = [
        luminaire(names[i % 5], Opening(), (2.0 * (i % 20), 2.0 * (i // 20), 4.0), key=f"l{i}")
        for i in range(300)
    ]
    rng = np.random.default_rng(8)
    places = np.column_stack([rng.uniform(0, 38, 60), rng.uniform(0, 28, 60), np.zeros(60)])
    normals = np.tile([0.0, 0.0, 1.0], (60, 1))
    made = measured(lights, places, normals, 1 << 14)
    expected = sum(by_point(light, places + 1e-4 * normals, normals) for light in lights)
    assert (np.abs(made.illuminance - expected) <= 5.0 * made.standard_error + 1e-3).all()
    assert made.illuminance.mean() == pytest.approx(expected.mean(), rel=0.02)


@pytest.mark.parametrize(
    "opening",
    [
        Opening("rectangle", (0.5, 0.0, 0.0), "z"),
        Opening("box", (0.5, 0.2, 0.0)),
        Opening("cylinder", (0.0, 0.0, 0.5)),
        Opening("ellipsoid", (0.2, -0.2, 0.2)),
        Opening("ellipse", (0.2, float("nan"), 0.0)),
        Opening("rectangle", (0.2, 0.2, 0.1), "z"),
        Opening("globe", (0.2, 0.2, 0.2)),
    ],
)
def test_an_impossible_opening_is_refused_with_its_size(opening):
    with pytest.raises(SceneError, match=r"luminaire 'a' has an opening.*expected"):
        measured([luminaire("batwing", opening)], [[0, 0, -1]], [[0, 0, 1]])


def test_old_scenes_do_not_end_the_process():
    # An emitter that Python frees while a kernel is made would: gc may run at any moment.
    for seed in range(4):
        lights = [luminaire("batwing", Opening(), (0.0, 0.0, 2.0), turn(seed))]
        measured(lights, [[0, 0, 0]], [[0, 0, 1]], 16)
        threshold = gc.get_threshold()
        gc.set_threshold(1)
        try:
            measured(lights, [[0, 0, 0]], [[0, 0, 1]], 16)
        finally:
            gc.set_threshold(*threshold)


GARBAGE = """
import gc, sys
sys.path.insert(0, sys.argv[1])
import numpy as np
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.transport import backend
backend.start(spectral=False)
from lumenray.engine.transport.paths import next_event
from luminaires import OPENINGS, luminaire
from small_scenes import session_of

def light_up(height):
    session = session_of(luminaire("batwing", OPENINGS["box"], (0.0, 0.0, height)))
    return session, session.measure([[0, 0, 0]], [[0, 0, 1]], StopRule(samples=16))

cycles = []
for height in (1.0, 2.0, 3.0):
    cycles.append(list(light_up(height)))
    cycles[-1].append(cycles[-1])
# Old objects are looked at only when many new ones have come.
gc.collect()
cycles.clear()
sample_emitter = next_event.sample_emitter

def sample_beside_garbage(*values):
    made = sample_emitter(*values)
    # As many objects as let Python look for garbage of its own accord.
    [[] for _ in range(1_000_000)]
    return made

next_event.sample_emitter = sample_beside_garbage
print(light_up(4.0)[1].illuminance[0] > 0.0)
"""


@pytest.mark.slow
def test_garbage_of_a_caller_does_not_end_the_process():
    # Dr.Jit ends the process when emitters are freed while a kernel is made, so this one is another.
    made = subprocess.run(
        [sys.executable, "-c", GARBAGE, str(Path(__file__).parents[1] / "helpers")],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert made.stdout.strip() == "True", made.stderr[-500:]
