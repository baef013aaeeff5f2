"""Luminaires inside kernels: values, densities and drawn directions are those of the stated distribution and opening."""

import numpy as np
import pytest
from lumenray.engine.errors import SceneError
from lumenray.engine.luminaires import distribution as host
from lumenray.engine.photometry.spectra import GRID
from lumenray.engine.scene.distribution import SHAPES, IntensityDistribution
from lumenray.engine.transport import backend
from luminaires import (
    DISTRIBUTIONS,
    OPENINGS,
    bin_fluxes,
    chi_square,
    flux,
    grid_angles,
    intensity,
    luminaire,
    opening_axes,
    opening_pieces,
    quantile_edges,
    shown_area,
    turn,
)

pytestmark = pytest.mark.mitsuba

LANES = 1 << 18
SIGNIFICANCE = 1e-3 / 100
"""All chi-square tests of this file together fail a right engine with a probability below one in a thousand."""

ANGLE = 2e-6
"""Single precision of an angle. [rad]"""

CENTRE = np.array([0.3, -0.2, 0.4])


@pytest.fixture(autouse=True)
def _mono():
    backend.start(spectral=False)
    from lumenray.engine.luminaires import plugins

    plugins.register()


def upload(values):
    import mitsuba as mi
    from lumenray.engine.arrays import upload

    return upload(mi.Float, values)


def vectors(values):
    """Vectors on the device. (n, 3)"""
    import mitsuba as mi

    return mi.Vector3f(*(upload(values[:, k]) for k in range(3)))


def from_device(v):
    return np.array(v, dtype=np.float64).T


def number(value):
    """Whole number that kernels take as data."""
    import drjit as dr
    import mitsuba as mi

    return dr.opaque(mi.UInt32, value)


def random_points(seed, lanes=LANES):
    import mitsuba as mi

    stream = mi.PCG32(size=lanes, initstate=seed)
    return mi.Point2f(stream.next_float32(), stream.next_float32())


# ---- distributions ----


@pytest.fixture(scope="module")
def tables():
    """All distributions in one table, and their numbers."""
    backend.start(spectral=False)
    from lumenray.engine.luminaires.tables import DistributionTables

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
    from lumenray.engine.luminaires.tables import DistributionTables

    a, b = DISTRIBUTIONS["batwing"], DISTRIBUTIONS["type A"]
    again = IntensityDistribution(a.azimuth.copy(), a.polar.copy(), a.intensity.copy())
    made = DistributionTables()
    first = made.commit([a, b, again])
    assert first[0] == first[2] != first[1]
    assert made.commit([again, b]) == first[:2]
    assert made.commit([b, a]) == first[1::-1]


@pytest.mark.parametrize("value", [0.0, np.nan, np.inf])
def test_a_distribution_without_a_flux_is_refused(value):
    from lumenray.engine.luminaires.tables import DistributionTables

    nothing = IntensityDistribution(
        np.array([0.0]), np.deg2rad([0.0, 90.0]), np.full((1, 2), value)
    )
    with pytest.raises(SceneError, match="flux"):
        DistributionTables().commit([nothing])


# ---- openings ----


def palette_of(lights):
    """Palette that holds luminaires, row by row as they are given."""
    from lumenray.engine.luminaires.palette import LuminairePalette, Row
    from lumenray.engine.luminaires.tables import distribution_digest

    made = LuminairePalette()
    rows = []
    for light in lights:
        rotation = light.frame[:3, :3]
        axes, half = opening_axes(light.opening)
        rows.append(
            Row(
                light.distribution,
                distribution_digest(light.distribution),
                rotation @ light.distribution.frame,
                SHAPES.index(light.opening.shape),
                rotation @ axes,
                half,
                light.frame[:3, 3],
                light.output.value,
                np.ones(len(GRID)) / len(GRID),
            )
        )
    made.commit(rows)
    return made


@pytest.fixture(scope="module")
def palette():
    """A luminaire of every opening, turned at random."""
    backend.start(spectral=False)
    from lumenray.engine.luminaires import plugins

    plugins.register()
    lights = {
        name: luminaire("asymmetric", opening, CENTRE, turn(seed))
        for seed, (name, opening) in enumerate(OPENINGS.items())
    }
    return palette_of(list(lights.values())), lights


def interaction(position):
    """Interaction at one place, as data. (3,)"""
    import drjit as dr
    import mitsuba as mi

    made = dr.zeros(mi.Interaction3f)
    made.p = mi.Point3f(*(dr.opaque(mi.Float, float(x)) for x in position))
    return made


def receivers(light):
    """Places from which an opening is seen: far, near, beside an edge, low over a face. (k, 3)"""
    axes, half = opening_axes(light.opening)
    rotation = light.frame[:3, :3] @ axes
    flat = half[2] == 0.0
    local = [
        [3.0, 2.0, 5.0],
        [-0.4, 0.5, -0.35],
        half * [0.3, -0.2, 1.0] + [0.0, 0.0, 0.05],
        half * [1.0, 1.0, 0.0] + [0.3, 0.1, 0.02 if flat else 0.0],
        [80.0, -60.0, 20.0],
    ]
    return np.array(local) @ rotation.T + CENTRE


class Cap:
    """Directions around an opening's centre as a square of equal solid angles, cut into bins."""

    def __init__(self, place, light, around=16, rise=16):
        away = CENTRE - place
        distance = np.linalg.norm(away)
        radius = 1.001 * 0.5 * np.linalg.norm(light.opening.size)
        z = away / distance
        x = np.cross(z, [0.0, 0.0, 1.0] if abs(z[2]) < 0.9 else [1.0, 0.0, 0.0])
        x /= np.linalg.norm(x)
        self.axes = np.stack([x, np.cross(z, x), z], axis=1)
        # 1 - cos of the half angle, without loss of digits.
        sine = min(radius / distance, 1.0)
        self.height = 2.0 if sine >= 1.0 else sine**2 / (1.0 + np.sqrt(1.0 - sine**2))
        self.bins = around, rise

    def directions(self, u, v):
        """Directions of places in the unit square."""
        height = self.height * v
        flat = np.sqrt(height * (2.0 - height))
        angle = 2.0 * np.pi * u
        local = np.stack([flat * np.cos(angle), flat * np.sin(angle), 1.0 - height], axis=-1)
        return local @ self.axes.T

    def histogram(self, direction, weight=None):
        """Sum of the weights of the directions in each bin, and outside; how many they are without weights."""
        local = direction @ self.axes
        flat = np.hypot(local[:, 0], local[:, 1])
        height = np.where(local[:, 2] > 0.0, flat**2 / (1.0 + local[:, 2]), 1.0 - local[:, 2])
        u = np.mod(np.arctan2(local[:, 1], local[:, 0]) / (2.0 * np.pi), 1.0)
        v = height / self.height
        inside = v <= 1.0 + 1e-4
        places = [u[inside], np.minimum(v[inside], 1.0)]
        weight = np.ones(len(direction)) if weight is None else weight
        sums, *_ = np.histogram2d(
            *places, self.bins, range=[[0.0, 1.0], [0.0, 1.0]], weights=weight[inside]
        )
        return sums, float(weight[~inside].sum())


def visible(light, place, count=800):
    """Directions from a place to points all over the side of an opening that it sees, and the solid angle of each."""
    rotation = light.frame[:3, :3]
    directions, angles = [], []
    for points, elements in opening_pieces(light.opening, count):
        towards = points @ rotation.T + CENTRE - place
        distance = np.linalg.norm(towards, axis=1)
        towards /= distance[:, None]
        seen = -((elements @ rotation.T) * towards).sum(axis=1)
        use = seen > 0.0
        directions.append(towards[use])
        angles.append((seen / distance**2)[use] / len(points))
    return np.concatenate(directions), np.concatenate(angles)


@pytest.mark.parametrize("row", range(len(OPENINGS)), ids=OPENINGS)
def test_points_of_an_opening_are_drawn_with_the_stated_density(palette, row):
    import mitsuba as mi

    made, lights = palette
    light = list(lights.values())[row]
    lanes = LANES // 4
    for seed, place in enumerate(receivers(light)):
        it = interaction(place)

        def density(direction, it=it):
            found = made.density_at(number(row), it.p, vectors(direction), mi.Bool(True))
            return np.array(found, dtype=np.float64)

        ds, _ = made.receive(number(row), it, random_points(10 + seed, lanes), mi.Bool(True))
        direction, pdf = from_device(ds.d), np.array(ds.pdf, dtype=np.float64)
        assert (pdf > 0.0).mean() > 0.9999

        # The stated density, integrated over the side that is seen, by bins of directions.
        cap = Cap(place, light)
        towards, angle = visible(light, place)
        there = density(towards)
        expected, outside = cap.histogram(towards, there * angle)
        assert outside == 0.0
        # Rounding of far directions loses a rim, over which points of round bodies lie dense.
        assert expected.sum() == pytest.approx(1.0, abs=1e-2)
        assert angle[there == 0.0].sum() < 1e-3 * angle.sum()
        counts, outside = cap.histogram(direction[pdf > 0.0])
        assert outside == 0.0
        assert chi_square(counts, expected / expected.sum() * counts.sum()) > SIGNIFICANCE

        # Nothing beside the opening.
        u, v = np.random.default_rng(seed).random((2, lanes))
        hits = (density(cap.directions(u, v)) > 0.0).mean()
        error = np.sqrt(hits * (1.0 - hits) / lanes)
        share = angle.sum() / (2.0 * np.pi * cap.height)
        assert abs(hits - share) < 4.0 * error + 1e-3 * share

        # Both strategies of the paths must know the same density of a direction; rims and rounding aside.
        ratio = density(direction) / pdf
        assert (np.abs(ratio - 1.0) < 2e-3).mean() > 0.998


@pytest.mark.parametrize("name", OPENINGS)
def test_what_an_opening_shows_is_its_silhouette(name):
    import drjit as dr
    import mitsuba as mi
    from lumenray.engine.luminaires.opening_sampling import projected_area

    opening = OPENINGS[name]
    kind = SHAPES.index(opening.shape)
    axes, half = opening_axes(opening)
    direction = np.random.default_rng(1).normal(size=(64, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    expected = sum(
        np.maximum(elements @ direction.T, 0.0).mean(axis=0)
        for _, elements in opening_pieces(opening, 200)
    )
    found = projected_area(
        number(kind),
        mi.Vector3f(*(dr.opaque(mi.Float, x) for x in half)),
        vectors(direction @ axes),
        {kind},
    )
    np.testing.assert_allclose(np.array(found), expected, rtol=2e-4)
    np.testing.assert_allclose(shown_area(opening, direction), expected, rtol=2e-4)
