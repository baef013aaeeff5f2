"""The library's ray sets: light through bodies of revolution against optics' closed forms, and the files themselves."""

import numpy as np
import pytest

from lumenray.engine.raysets.reader import read_rayset
from lumenray.engine.raysets.survey import survey_rays
from lumenray.libraries.raysets import FOLDER
from lumenray.tools.libraries.raysets.lathe import Profile, meet, pass_through
from lumenray.tools.libraries.raysets.models import (
    ACRYLIC,
    MODELS,
    collimator_profile,
    dome_profile,
    lambertian,
)


def fan(count, rng, widest=80.0):
    """Directions within a cone about +z."""
    cosine = 1.0 - rng.random(count) * (1.0 - np.cos(np.deg2rad(widest)))
    turn = 2.0 * np.pi * rng.random(count)
    sine = np.sqrt(1.0 - cosine**2)
    return np.stack([sine * np.cos(turn), sine * np.sin(turn), cosine], axis=1)


def test_rays_meet_a_sphere_where_they_do():
    rng = np.random.default_rng(1)
    profile = dome_profile(1.0, 2000)
    direction = fan(500, rng)
    start = np.concatenate([0.3 * rng.random((500, 2)), np.full((500, 1), 0.1)], axis=1)
    way, normal = meet(profile, start, direction)
    b = (start * direction).sum(axis=1)
    exact = -b + np.sqrt(b**2 - (start**2).sum(axis=1) + 1.0)
    np.testing.assert_allclose(way, exact, atol=1e-5)
    np.testing.assert_allclose(normal, start + exact[:, None] * direction, atol=2e-3)


def test_from_the_middle_of_a_dome_rays_pass_straight_but_for_what_fresnel_mirrors():
    rng = np.random.default_rng(2)
    direction = fan(40_000, rng, 60.0)
    start = np.zeros_like(direction)
    position, sent, number = pass_through(dome_profile(1.0), 1.5, start, direction, rng)
    straight = (sent * direction[number]).sum(axis=1) > 1.0 - 1e-6
    passed = straight & (np.linalg.norm(position, axis=1) > 0.9)
    # The others go back through the middle and out below.
    assert passed.mean() == pytest.approx(1.0 - (0.5 / 2.5) ** 2, abs=0.004)


def test_a_prism_of_plates_obeys_snell():
    """A flat plate: from inside, the sine grows by the index; beyond the critical angle nothing leaves on top."""
    plate = Profile(np.array([[50.0, 0.0], [50.0, 1.0], [0.0, 1.0]]))
    rng = np.random.default_rng(3)
    direction = fan(20_000, rng, 85.0)
    start = np.tile([0.0, 0.0, 0.5], (20_000, 1))
    position, sent, number = pass_through(plate, 1.5, start, direction, rng)
    left = (position[:, 2] > 0.999) & (sent[:, 2] > 0.0)
    before = np.hypot(direction[number, 0], direction[number, 1])[left]
    after = np.hypot(sent[:, 0], sent[:, 1])[left]
    np.testing.assert_allclose(after, 1.5 * before, atol=1e-6)
    assert before.max() < 1.0 / 1.5


def test_the_collimator_makes_light_of_one_point_parallel():
    rng = np.random.default_rng(4)
    direction = fan(4000, rng, 75.0)
    start = np.zeros_like(direction)
    _, sent, _ = pass_through(collimator_profile(), ACRYLIC, start, direction, rng)
    forward = np.degrees(np.arccos(np.clip(sent[:, 2], -1.0, 1.0)))
    # Fresnel mirrors some 8 % at two surfaces; the edges of the profile's pieces bend by parts of a degree.
    assert (forward < 2.0).mean() > 0.8


def test_lambertian_directions_follow_the_cosine():
    rng = np.random.default_rng(5)
    normal = np.tile([[0.6, 0.0, 0.8]], (50_000, 1))
    cosine = (lambertian(normal, rng) * normal).sum(axis=1)
    # The square of the cosine is even.
    counts = np.histogram(cosine**2, bins=20, range=(0.0, 1.0))[0]
    assert (
        (counts - 2500.0) ** 2 / 2500.0
    ).sum() < 43.8  # chi-square, 19 degrees of freedom, 0.1 %


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.entry.name)
def test_files_hold_what_the_models_make(model):
    file = read_rayset(FOLDER / f"{model.entry.name}.tm25ray")
    survey = survey_rays(file)
    assert file.format == "TM-25-13"
    assert survey.rays == 10_000
    assert survey.luminous_flux == pytest.approx(model.entry.luminous_flux, rel=1e-5)
    assert not survey.remarks
    assert file.metadata["SOURCE"] == model.entry.title


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("led_dome", 0.55, 0.75),
        ("led_collimator", 0.9, 1.0),
        ("filament", -0.05, 0.05),
        ("tube_t8_18w", -0.05, 0.05),
    ],
)
def test_light_goes_where_such_lamps_send_it(name, low, high):
    """Mean of the direction's z: 2/3 for a flat Lambertian source, near 1 in a beam, 0 all around."""
    assert low < survey_rays(read_rayset(FOLDER / f"{name}.tm25ray")).axis[2] < high
