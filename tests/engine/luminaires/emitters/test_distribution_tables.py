"""Intensity distributions on the device: evaluated as on the host, drawn in proportion."""

import numpy as np
import pytest
from device_values import LANES, SIGNIFICANCE, from_device, number, random_points, vectors
from luminaires import (
    DISTRIBUTIONS,
    bin_fluxes,
    chi_square,
    flux,
    grid_angles,
    intensity,
    quantile_edges,
)

from lumenray.engine.errors import SceneError
from lumenray.engine.luminaires import distribution as host
from lumenray.engine.scene.distribution import IntensityDistribution
from lumenray.engine.transport import backend

pytestmark = [pytest.mark.mitsuba, pytest.mark.usefixtures("mono")]

ANGLE = 2e-6
"""Single precision of an angle. [rad]"""


@pytest.fixture(scope="module")
def tables():
    """All distributions in one table, and their numbers."""
    backend.start(spectral=False)
    from lumenray.engine.luminaires.emitters.tables import DistributionTables

    made = DistributionTables()
    numbers = made.commit(list(DISTRIBUTIONS.values()))
    return made, dict(zip(DISTRIBUTIONS, numbers, strict=True))


def probes(distribution, count=1 << 14):
    """Directions of the grid's axes in single precision: everywhere, and many of them beside nodes. (n, 3) float32"""
    rng = np.random.default_rng(5)
    low, high = distribution.polar[0], distribution.polar[-1]
    polar = rng.uniform(low - 0.05, high + 0.05, count)
    azimuth = rng.uniform(0.0, 2.0 * np.pi, count)
    some = count // 4
    polar[:some] = rng.choice(distribution.polar, some) + 1e-4 * rng.normal(size=some)
    azimuth[some // 2 : -some] = rng.choice(distribution.azimuth, count - some // 2 - some)
    azimuth[some // 2 : -some] += 1e-4 * rng.normal(size=count - some // 2 - some)
    polar = np.clip(polar, 0.0, np.pi)
    flat = np.sin(polar)
    made = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), -np.cos(polar)], axis=1)
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    return np.concatenate([made, axes]).astype(np.float32)


def beside_a_jump(distribution, azimuth, polar):
    """Whether a direction lies where the grid ends but not the sphere, within what rounding may move."""
    made = np.zeros(len(polar), dtype=bool)
    if not host.is_closed(distribution):
        made |= np.sin(polar) < 1e-6
    for end in distribution.polar[[0, -1]]:
        if 1e-9 < end < np.pi - 1e-9:
            made |= np.abs(polar - end) < 2e-5
    if not host.is_closed(distribution):
        for end in distribution.azimuth[[0, -1]]:
            away = np.mod(azimuth - end + np.pi, 2.0 * np.pi) - np.pi
            made |= np.abs(away) < 2e-5
    return made


@pytest.mark.parametrize("name", DISTRIBUTIONS)
def test_the_device_evaluates_what_the_host_does(tables, name):
    distribution = DISTRIBUTIONS[name]
    made, numbers = tables
    probe = probes(distribution)
    found = np.array(made.density(number(numbers[name]), vectors(probe)), dtype=np.float64)
    probe = probe.astype(np.float64)
    azimuth = np.arctan2(probe[:, 1], probe[:, 0])
    polar = np.arctan2(np.hypot(probe[:, 0], probe[:, 1]), -probe[:, 2])
    total = host.flux(distribution)
    shifts = np.linspace(-ANGLE, ANGLE, 9)
    near = np.array(
        [
            host.intensity_at(distribution, azimuth + a, np.clip(polar + p, 0.0, np.pi)) / total
            for a in shifts
            for p in shifts
        ]
    )
    low, high = near.min(axis=0), near.max(axis=0)
    # Between the shifts a node may be higher or lower still.
    slack = 0.1 * (high - low) + 2e-6 * distribution.intensity.max() / total
    sure = ~beside_a_jump(distribution, azimuth, polar)
    assert sure.mean() > 0.9
    assert (found >= low - slack)[sure].all()
    assert (found <= high + slack)[sure].all()


@pytest.mark.parametrize("name", DISTRIBUTIONS)
def test_the_host_evaluates_and_integrates_what_others_do(name):
    distribution = DISTRIBUTIONS[name]
    probe = probes(distribution).astype(np.float64)
    azimuth, polar = grid_angles(distribution, probe @ distribution.frame.T)
    sure = ~beside_a_jump(distribution, azimuth, polar)
    direction = probe @ distribution.frame.T
    found, expected = host.intensity(distribution, direction), intensity(distribution, direction)
    bound = 2e-5 * distribution.intensity.max()
    np.testing.assert_allclose(found[sure], expected[sure], rtol=0, atol=bound)
    assert host.flux(distribution) == pytest.approx(flux(distribution), rel=1e-11)


@pytest.mark.parametrize("name", DISTRIBUTIONS)
def test_directions_are_drawn_in_proportion_to_the_intensity(tables, name):
    distribution = DISTRIBUTIONS[name]
    made, numbers = tables
    drawn = from_device(made.draw(number(numbers[name]), random_points(3)))
    np.testing.assert_allclose(np.linalg.norm(drawn, axis=1), 1.0, atol=1e-6)
    azimuth, polar = grid_angles(distribution, drawn @ distribution.frame.T)
    for edges in (
        quantile_edges(distribution, 8),
        quantile_edges(distribution, 24),
        [np.linspace(e[0], e[-1], 41) for e in quantile_edges(distribution, 2)],
    ):
        # Rounding may carry a direction of the outermost bin across the end of the grid.
        counts, *_ = np.histogram2d(
            np.clip(azimuth, edges[0][0], edges[0][-1]),
            np.clip(polar, edges[1][0], edges[1][-1]),
            edges,
        )
        expected = bin_fluxes(distribution, *edges) / flux(distribution) * LANES
        assert chi_square(counts, expected) > SIGNIFICANCE


def test_the_inside_of_a_spike_is_drawn_right(tables):
    distribution = DISTRIBUTIONS["spike"]
    made, numbers = tables
    drawn = from_device(made.draw(number(numbers["spike"]), random_points(4)))
    azimuth, polar = grid_angles(distribution, drawn)
    around = np.linspace(distribution.azimuth[21], distribution.azimuth[24], 31)
    up = np.linspace(distribution.polar[8], distribution.polar[11], 31)
    expected = bin_fluxes(distribution, around, up) / flux(distribution) * LANES
    counts, *_ = np.histogram2d(azimuth, polar, [around, up])
    assert expected.sum() > 0.95 * LANES
    # The rest is one more bin.
    counts = np.append(counts.ravel(), LANES - counts.sum())
    expected = np.append(expected.ravel(), LANES - expected.sum())
    assert chi_square(counts, expected) > SIGNIFICANCE


def test_equal_distributions_are_held_once_and_the_order_does_not_count():
    from lumenray.engine.luminaires.emitters.tables import DistributionTables

    a, b = DISTRIBUTIONS["batwing"], DISTRIBUTIONS["type A"]
    again = IntensityDistribution(a.azimuth.copy(), a.polar.copy(), a.intensity.copy())
    made = DistributionTables()
    first = made.commit([a, b, again])
    assert first[0] == first[2] != first[1]
    assert made.commit([again, b]) == first[:2]
    assert made.commit([b, a]) == first[1::-1]


@pytest.mark.parametrize("value", [0.0, np.nan, np.inf])
def test_a_distribution_without_a_flux_is_refused(value):
    from lumenray.engine.luminaires.emitters.tables import DistributionTables

    nothing = IntensityDistribution(
        np.array([0.0]), np.deg2rad([0.0, 90.0]), np.full((1, 2), value)
    )
    with pytest.raises(SceneError, match="flux"):
        DistributionTables().commit([nothing])
