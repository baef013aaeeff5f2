"""Skies by formula: reference values, mixtures of clear and overcast, and the engine against the formula."""

import json

import numpy as np
import pytest
from folders import WILD
from scipy import stats
from small_scenes import session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.light import CieSky, CloudySky, PerezSky
from lumenray.engine.sky import cie
from lumenray.engine.sky.cie import horizontal_ratio, relative_luminance, sun_direction
from lumenray.engine.sky.skies import check_sky, find_luminances, mean_luminance, zenith_luminance

REFERENCE = WILD.parent / "validation" / "reference.json"

TOWARDS = sun_direction(np.radians(35.0), np.radians(140.0))

SKIES = {
    "clear": CieSky(12, TOWARDS, 12_000.0, 0.2),
    "overcast": CieSky(16, TOWARDS, 12_000.0, 0.2),
    "cloudy": CloudySky(0.35, TOWARDS, 12_000.0, 0.2),
    "all-weather": PerezSky(2.1, 0.3, TOWARDS, 12_000.0, 0.2),
    "all-weather, clear": PerezSky(7.0, 0.08, TOWARDS, 12_000.0, 0.2),
}

PLANES = np.array([[0, 0, 1.0], [1, 0, 0], [0, -1, 0], [-0.48, 0.64, 0.6], [0, 0, -1.0]])


def sphere(rows=720, columns=720):
    """Directions of small cells of equal solid angle, and that. (rows columns, 3) [sr]"""
    sine = 2.0 * (np.arange(rows) + 0.5) / rows - 1.0
    azimuth = 2.0 * np.pi * (np.arange(columns) + 0.5) / columns
    plan = np.sqrt(1.0 - sine**2)[:, None]
    made = np.stack(
        np.broadcast_arrays(plan * np.cos(azimuth), plan * np.sin(azimuth), sine[:, None]), axis=-1
    )
    return made.reshape(-1, 3), 4.0 * np.pi / (rows * columns)


# ---- reference values ----


def reference():
    if not REFERENCE.exists():
        pytest.skip("no reference values beside this checkout")
    groups = json.loads(REFERENCE.read_text(encoding="utf-8"))["references"]
    return {group["id"]: group for group in groups}


def test_skies_of_the_cie_have_the_reference_ratios():
    groups = reference()
    for key, elevation in [("C11.Eh60", 60.0), ("C11.Eh20", 20.0)]:
        towards = sun_direction(np.radians(elevation), np.pi)
        for point, value in zip(groups[key]["points"], groups[key]["values"], strict=True):
            kind = int(point["label"].split()[1])
            assert horizontal_ratio(kind, towards) == pytest.approx(value, rel=1e-6)


COMPASS = {"N": 0.0, "E": 0.5 * np.pi, "S": np.pi}
"""Azimuths by name. [rad]"""


def looking(label):
    """Direction by a label of the reference: ``zenith``, ``sun (el 60, az S)`` or ``el 45 E``."""
    if label == "zenith":
        return sun_direction(0.5 * np.pi, 0.0)
    if label.startswith("sun"):
        return sun_direction(np.radians(60.0), np.pi)
    _, elevation, azimuth = label.split()
    return sun_direction(np.radians(float(elevation)), COMPASS[azimuth])


def test_skies_of_the_cie_have_the_reference_luminances():
    groups = reference()
    towards = sun_direction(np.radians(60.0), np.pi)
    for kind in range(1, 17):
        group = groups[f"C11.lum{kind}"]
        labels = [point["label"] for point in group["points"]]
        assert len(labels) == 7
        found = relative_luminance(kind, np.array([looking(label) for label in labels]), towards)
        np.testing.assert_allclose(found, group["values"], rtol=1e-6)


@pytest.mark.parametrize("wall", ["vertS", "vertN", "vertE"])
def test_skies_of_the_cie_have_the_reference_walls(wall):
    """By a plain sum over cells, which the steep luminances near the horizon leave 0.1 % of."""
    group = reference()[f"C11.{wall}"]
    azimuth = COMPASS[wall[-1]]
    normal = np.array([np.sin(azimuth), np.cos(azimuth), 0.0])
    directions, solid = sphere(900, 720)
    weights = np.maximum(directions @ normal, 0.0) * (directions[:, 2] > 0.0) * solid
    towards = sun_direction(np.radians(60.0), np.pi)
    for point, value in zip(group["points"], group["values"], strict=True):
        kind = int(point["label"].split()[1])
        found = weights @ relative_luminance(kind, directions, towards)
        assert found / horizontal_ratio(kind, towards) == pytest.approx(value, rel=1e-3)


# ---- cloudiness ----


@pytest.mark.parametrize(("cloudiness", "kind"), [(0.0, cie.CLEAR), (1.0, cie.OVERCAST)])
def test_ends_of_cloudiness_are_the_clear_and_the_overcast_sky(cloudiness, kind):
    directions, _ = sphere(20, 30)
    mixed = CloudySky(cloudiness, TOWARDS, 9000.0, 0.3)
    pure = CieSky(kind, TOWARDS, 9000.0, 0.3)
    np.testing.assert_allclose(
        find_luminances(mixed, directions), find_luminances(pure, directions), rtol=1e-10
    )


def test_cloudiness_is_the_share_of_light_of_the_overcast_sky():
    directions, _ = sphere(20, 30)
    clear, overcast = (
        find_luminances(CieSky(k, TOWARDS, 9000.0, 0.3), directions) for k in (12, 16)
    )
    mixed = find_luminances(CloudySky(0.3, TOWARDS, 9000.0, 0.3), directions)
    np.testing.assert_allclose(mixed, 0.7 * clear + 0.3 * overcast, rtol=1e-7)


@pytest.mark.parametrize("cloudiness", [-0.01, 1.01, np.nan])
def test_cloudiness_beyond_0_to_1_is_refused(cloudiness):
    with pytest.raises(SceneError, match=r"cloudiness is .*, expected 0 to 1"):
        check_sky(CloudySky(cloudiness, TOWARDS, 1.0))


# ---- integrals ----


@pytest.mark.parametrize("name", SKIES)
def test_means_and_levels_by_a_plain_sum(name):
    sky = SKIES[name]
    directions, solid = sphere()
    values = find_luminances(sky, directions)
    assert values.mean() == pytest.approx(mean_luminance(sky), rel=2e-3)
    up = directions[:, 2] > 0.0
    horizontal = (values * np.maximum(directions[:, 2], 0.0)).sum() * solid
    assert horizontal == pytest.approx(sky.illuminance, rel=2e-3)
    np.testing.assert_allclose(values[~up], 0.2 * sky.illuminance / np.pi)
    assert find_luminances(sky, (0.0, 0.0, 1.0)) == pytest.approx(zenith_luminance(sky), rel=1e-12)


# ---- the engine ----


@pytest.mark.mitsuba
@pytest.mark.parametrize("name", ["cloudy", "all-weather", "all-weather, clear"])
def test_planes_under_the_sky_have_the_illuminance_of_the_formula(name):
    sky = SKIES[name]
    directions, solid = sphere()
    values = find_luminances(sky, directions) * solid
    expected = values @ np.maximum(directions @ PLANES.T, 0.0)
    session = session_of(sky)
    places = np.zeros((len(PLANES), 3))
    made = session.measure(places, PLANES, StopRule(samples=1 << 15), transport="mono", seed=3)
    # Five planes, 99.9 % together; the sum over cells is off by up to 2e-3.
    factor = stats.norm.ppf(1.0 - 0.0005 / len(PLANES))
    bound = factor * made.standard_error + 1e-3 * expected
    assert (np.abs(made.illuminance - expected) < bound).all()
    assert (made.standard_error < 0.01 * expected).all()


@pytest.mark.mitsuba
def test_rays_see_the_luminance_of_the_formula_through_edits_of_the_sky():
    """Skies of all kinds take each other's place in one emitter, and none leaves anything behind."""
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.scene.scene import SceneDelta

    directions = np.random.default_rng(4).normal(size=(4000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    session = session_of(SKIES["clear"])
    for name in ("clear", "all-weather", "cloudy", "overcast", "all-weather, clear", "clear"):
        session.apply(SceneDelta((SKIES[name],)))
        session.measure([[0, 0, 0]], [[0, 0, 1.0]], StopRule(samples=4), transport="mono")
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.wi = mi.Vector3f(*(-directions.T).astype(np.float32))
        found = np.array(session._compiled.surroundings.eval(si)).ravel()
        np.testing.assert_allclose(found, find_luminances(SKIES[name], directions), rtol=2e-4)
