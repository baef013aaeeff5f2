"""Luminaires inside kernels: values, densities and drawn directions are those of the stated distribution and opening."""

import gc
import re

import numpy as np
import pytest
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.luminaires import distribution as host
from lumenray.engine.photometry.spectra import GRID, luminous_efficiency, photometric_density
from lumenray.engine.photometry.units import LUMINOUS_EFFICACY
from lumenray.engine.scene.distribution import SHAPES, IntensityDistribution, Opening
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Blackbody, Rgb
from lumenray.engine.transport import backend
from luminaires import (
    DISTRIBUTIONS,
    OPENINGS,
    bin_fluxes,
    chi_square,
    flux,
    grid,
    grid_angles,
    intensity,
    luminaire,
    opening_axes,
    opening_pieces,
    quantile_edges,
    shown_area,
    turn,
)
from scipy import stats
from small_scenes import session_of

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
    from lumenray.engine.luminaires.emitters import plugins

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
    return next(streams(seed, lanes))


def streams(seed, lanes=LANES):
    """Independent points in the unit square, one after the other; those of neighbouring seeds are not."""
    import mitsuba as mi

    stream = mi.PCG32(size=lanes, initstate=seed)
    while True:
        yield mi.Point2f(stream.next_float32(), stream.next_float32())


# ---- distributions ----


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


# ---- openings ----


def palette_of(lights):
    """Palette that holds luminaires, row by row as they are given."""
    from lumenray.engine.luminaires.emitters.palette import LuminairePalette, Row
    from lumenray.engine.luminaires.emitters.tables import distribution_digest

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
                photometric_density(light.output.spectrum),
            )
        )
    made.commit(rows)
    return made


@pytest.fixture(scope="module")
def palette():
    """A luminaire of every opening, turned at random, without narrow beams."""
    backend.start(spectral=False)
    lights = {
        name: luminaire("irregular", opening, CENTRE, turn(seed))
        for seed, (name, opening) in enumerate(OPENINGS.items())
    }
    made = palette_of(list(lights.values()))
    assert not made.has_narrow
    return made, lights


def unlike(light, place):
    """Share of directions whose density two ways of computing it may give unlike.

    A direction of single precision says to some 3e-8 times the distance where it meets the opening, and towards the rim of
    round ones the density rises without end.
    """
    if light.opening.shape in {"rectangle", "ellipse", "box"}:
        return 2e-3
    _, half = opening_axes(light.opening)
    return 0.015 + np.sqrt(2e-5 * np.linalg.norm(place - CENTRE) / half.min())


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

    def __init__(self, place, light, around=12, rise=12):
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


def visible(light, place, count=320):
    """Directions from a place to points all over the side of an opening that it sees, and the solid angle of each."""
    rotation = light.frame[:3, :3]
    directions, angles = [], []
    if light.opening.shape == "box":
        count //= 2
    for points, elements in opening_pieces(light.opening, count, is_scattered=True):
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
    lanes = LANES // 8
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

        # Both strategies of the paths must know the same density of a direction.
        ratio = density(direction) / pdf
        assert (np.abs(ratio - 1.0) > 2e-3).mean() < unlike(light, place)
        assert ratio.mean() == pytest.approx(1.0, abs=5e-3)


@pytest.mark.parametrize("name", OPENINGS)
def test_what_an_opening_shows_is_its_silhouette(name):
    import drjit as dr
    import mitsuba as mi
    from lumenray.engine.luminaires.emitters.opening_sampling import projected_area

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


@pytest.mark.parametrize("name", ["ellipse", "sphere", "ellipsoid", "cylinder", "oval cylinder"])
def test_far_round_openings_are_met_by_the_rays_that_meet_them(palette, name):
    import mitsuba as mi

    made, lights = palette
    light, row = lights[name], list(lights).index(name)
    axes, half = opening_axes(light.opening)
    rotation = light.frame[:3, :3] @ axes
    rng = np.random.default_rng(8)
    for towards in ([0.0, 0.0, 1.0], [0.6, -0.5, 0.2], [1.0, 0.1, 0.05]):
        away = rotation @ (np.array(towards) / np.linalg.norm(towards))
        place = CENTRE + 1000.0 * half.max() * away
        # What the engine calls its place is a number of single precision.
        place = place.astype(np.float32).astype(np.float64)
        direction, angle = visible(light, place, 300)
        chosen = rng.choice(len(direction), 1 << 15, p=angle / angle.sum())
        density = made.density_at(
            number(row), interaction(place).p, vectors(direction[chosen]), mi.Bool(True)
        )
        density = np.array(density, dtype=np.float64)
        assert (density > 0.0).mean() > 0.999
        # Its mean over the directions is 1 over their solid angle.
        assert density.mean() * angle.sum() == pytest.approx(1.0, abs=0.05)


# ---- narrow beams from large openings: candidates ----

NARROW_OPENINGS = {
    "rectangle": Opening("rectangle", (0.6, 0.6, 0.0), "z"),
    "box": Opening("box", (0.6, 0.4, 0.1)),
    "sphere": Opening("ellipsoid", (0.3, 0.3, 0.3)),
    "cylinder": Opening("cylinder", (0.3, 0.5, 0.2), "z"),
}


def across_the_seam(azimuth, polar):
    """Even, and a hundred times as bright in a beam that leaves slantwise, across C = 0."""
    return 1.0 + 100.0 * np.exp(-50.0 * ((np.cos(azimuth) - 1.0) ** 2 + (polar - 1.0) ** 2))


BEAMS = {
    # 6 degrees between half values.
    "spot": (
        DISTRIBUTIONS["spot"],
        [[0.0, 0.0, -3.0], [0.35, 0.05, -3.0], [0.1, 0.1, -0.4], [1.0, 0.0, -60.0]],
    ),
    "seam": (
        grid(np.arange(0, 361, 5), np.arange(0, 181, 5), across_the_seam),
        [[1.6, 0.02, -1.1], [0.8, -0.3, -0.3], [0.1, 0.0, 3.0], [-1.0, 1.0, 0.2]],
    ),
}
"""Distributions with narrow beams, and receivers in the luminaire's axes, in them and beside."""


@pytest.fixture(scope="module", params=BEAMS)
def beams(request):
    """Narrow beams from openings that fill far more than their width."""
    backend.start(spectral=False)
    distribution, places = BEAMS[request.param]
    lights = {
        name: luminaire(distribution, opening, CENTRE, turn(20 + seed))
        for seed, (name, opening) in enumerate(NARROW_OPENINGS.items())
    }
    made = palette_of(list(lights.values()))
    assert made.has_narrow
    return made, lights, np.array(places)


@pytest.mark.parametrize("row", range(len(NARROW_OPENINGS)), ids=NARROW_OPENINGS)
@pytest.mark.slow
def test_what_is_kept_of_candidates_gives_every_part_of_the_opening_its_light(beams, row):
    import mitsuba as mi

    made, lights, local = beams
    light = list(lights.values())[row]
    rotation, lanes = light.frame[:3, :3], LANES // 8
    scale = light.output.value / flux(light.distribution)

    def radiance(direction):
        away = -direction @ rotation
        return scale * intensity(light.distribution, away) / shown_area(light.opening, away)

    for seed, place in enumerate(local @ rotation.T + CENTRE):
        it = interaction(place)
        ds, value = made.receive(number(row), it, random_points(60 + seed, lanes), mi.Bool(True))
        direction, pdf = from_device(ds.d), np.array(ds.pdf, dtype=np.float64)
        value = np.array(value[0], dtype=np.float64)
        assert np.isfinite(value).all()
        assert (value >= 0.0).all()

        # Both strategies of the paths must know the same density of a direction.
        lit = value > 0.0
        again = made.density_at(number(row), it.p, ds.d, mi.Bool(True))
        ratio = np.array(again, dtype=np.float64)[lit] / pdf[lit]
        assert (np.abs(ratio - 1.0) > 2e-3).mean() < unlike(light, place)

        # What is kept stands for all of the light, bin by bin.
        cap = Cap(place, light, 6, 6)
        towards, angle = visible(light, place)
        arriving = radiance(towards)
        expected, _ = cap.histogram(towards, arriving * angle)
        mean, error = means(cap, direction, value)
        # The edges of the bins cut the quadrature's cells.
        slack = 5e-3 * expected + 1e-4 * expected.sum()
        assert (np.abs(mean - expected) < 4.5 * error + slack).all()
        total, error = value.mean(), value.std() / np.sqrt(lanes)
        assert abs(total - expected.sum()) < 4.0 * error + 1e-3 * total

        # And times density over radiance for that density, if it is the candidates' own.
        density = made.density_at(number(row), it.p, vectors(towards), mi.Bool(True))
        density = np.array(density, dtype=np.float64)
        assert (density * angle).sum() < 1.0 + 5e-3
        bright = 0.1 * arriving.max()
        expected, _ = cap.histogram(towards, density * angle * (arriving > bright))
        kept = radiance(direction)
        share = np.where(kept > bright, value * pdf / np.maximum(kept, bright), 0.0)
        mean, error = means(cap, direction, share)
        slack = 0.01 * expected + 1e-4 * expected.sum()
        assert (np.abs(mean - expected) < 4.5 * error + slack).all()


def means(cap, direction, value):
    """Mean in each bin of what directions bring, over all of them, and its standard error."""
    count = len(value)
    sums, outside = cap.histogram(direction, value)
    squares, _ = cap.histogram(direction, value**2)
    assert outside == 0.0
    mean = sums / count
    # No bin knows its mean better than by one sample.
    least = value.max() / count
    return mean, np.sqrt(np.maximum(squares / count - mean**2, 0.0) / count + least**2)


# ---- light tracing ----


def outwards(opening, points):
    """Outward normals (n, 3) of the surface at points (n, 3), and how far off it they lie, both in the opening's axes."""
    _, half = opening_axes(opening)
    h = np.where(half > 0.0, half, 1.0)
    x = points / h
    if opening.shape in {"rectangle", "ellipse"}:
        inside = (
            np.abs(x[:, :2]).max(axis=1) if opening.shape == "rectangle" else np.hypot(*x.T[:2])
        )
        return None, np.maximum(inside - 1.0, np.abs(points[:, 2]))
    if opening.shape == "ellipsoid":
        return x / h, np.abs(np.linalg.norm(x, axis=1) - 1.0)
    if opening.shape == "box":
        face = np.argmax(np.abs(x), axis=1)
        normal = np.zeros_like(x)
        normal[np.arange(len(x)), face] = np.sign(x[np.arange(len(x)), face])
        return normal, np.abs(np.abs(x).max(axis=1) - 1.0)
    flat = np.hypot(x[:, 0], x[:, 1])
    on_end = np.abs(x[:, 2]) > flat
    wall = np.stack([x[:, 0] / h[0], x[:, 1] / h[1], np.zeros(len(x))], axis=1)
    ends = np.stack([np.zeros(len(x)), np.zeros(len(x)), np.sign(x[:, 2])], axis=1)
    return np.where(on_end[:, None], ends, wall), np.abs(np.maximum(np.abs(x[:, 2]), flat) - 1.0)


@pytest.mark.parametrize("row", range(len(OPENINGS)), ids=OPENINGS)
def test_emitted_light_leaves_the_opening_in_the_stated_directions(palette, row):
    import mitsuba as mi

    made, lights = palette
    light = list(lights.values())[row]
    distribution, rotation = light.distribution, light.frame[:3, :3]
    points = streams(70 + row)
    start, direction, normal = made.emit(number(row), next(points), next(points), mi.Bool(True))
    start, direction, normal = from_device(start), from_device(direction), from_device(normal)

    edges = quantile_edges(distribution, 16)
    counts, *_ = np.histogram2d(*grid_angles(distribution, direction @ rotation), edges)
    expected = bin_fluxes(distribution, *edges) / flux(distribution) * LANES
    assert chi_square(counts, expected) > SIGNIFICANCE

    axes, _ = opening_axes(light.opening)
    axes = rotation @ axes
    expected, off = outwards(light.opening, (start - CENTRE) @ axes)
    assert off.max() < 1e-5
    assert ((normal * direction).sum(axis=1) > -1e-5).all()
    if expected is not None:
        expected /= np.linalg.norm(expected, axis=1, keepdims=True)
        same = (expected * (normal @ axes)).sum(axis=1)
        # Right at an edge, rounding may take one face for the other.
        assert (same > 1.0 - 1e-4).mean() > 0.999


@pytest.mark.parametrize("row", range(len(OPENINGS)), ids=OPENINGS)
def test_emitted_light_and_next_event_light_a_plane_close_by_alike(palette, row):
    import mitsuba as mi

    made, lights = palette
    light = list(lights.values())[row]
    axes, half = opening_axes(light.opening)
    axes = light.frame[:3, :3] @ axes
    side, cells = 0.3, 4
    lanes = 4 * LANES
    # A plane that just clears the opening, seen from it at an angle.
    across = turn(90 + row)
    up = across @ [0.0, 0.0, 1.0]
    middle = CENTRE - (np.linalg.norm(half) + 0.02) * up

    points = streams(100 + row, lanes)
    start, direction, _ = made.emit(number(row), next(points), next(points), mi.Bool(True))
    start, direction = from_device(start), from_device(direction)
    fall = -direction @ up
    along = ((start - middle) @ up) / np.where(fall > 1e-6, fall, np.inf)
    hit = (start + along[:, None] * direction - middle) @ across
    use = (fall > 1e-6) & (along > 0.0)
    bins = [np.linspace(-side, side, cells + 1)] * 2
    counts, *_ = np.histogram2d(hit[use, 0], hit[use, 1], bins)
    area = (2.0 * side / cells) ** 2
    traced = light.output.value * counts / lanes / area
    traced_error = light.output.value * np.sqrt(counts) / lanes / area

    place = np.random.default_rng(120 + row).uniform(-side, side, (LANES, 2))
    it = interaction(middle)
    it.p = mi.Point3f(vectors(middle + place @ across[:, :2].T))
    ds, value = made.receive(number(row), it, random_points(130 + row), mi.Bool(True))
    arriving = np.array(value[0], dtype=np.float64) * np.maximum(from_device(ds.d) @ up, 0.0)
    many, *_ = np.histogram2d(*place.T, bins)
    sums, *_ = np.histogram2d(*place.T, bins, weights=arriving)
    squares, *_ = np.histogram2d(*place.T, bins, weights=arriving**2)
    received = sums / many
    error = np.hypot(traced_error, np.sqrt((squares / many - received**2) / many))
    assert (error < 0.03 * received).all()
    deviation = (traced - received) / error
    assert np.abs(deviation).max() < 4.5
    assert stats.chi2.sf((deviation**2).sum(), cells**2) > SIGNIFICANCE


@pytest.mark.parametrize("is_spectral", [False, True], ids=["mono", "spectral"])
def test_rays_of_the_plug_in_carry_the_flux(is_spectral):
    backend.start(spectral=is_spectral)
    from lumenray.engine.luminaires.emitters import plugins

    plugins.register()
    import drjit as dr
    import mitsuba as mi
    from lumenray.engine.luminaires.emitters.palette import make_emitter

    lights = [
        luminaire("batwing", lumens=500.0, spectrum=Blackbody(2700.0)),
        luminaire("type A", OPENINGS["box"], CENTRE, turn(1), 2000.0, spectrum=Rgb(0.2, 0.4, 1.0)),
    ]
    made = palette_of(lights)
    emitter = make_emitter(made)
    pointer = mi.EmitterPtr(emitter)
    lanes = 1 << 16
    u = (dr.arange(mi.Float, lanes) + 0.5) / lanes
    points = streams(5, lanes)
    place, angle = next(points), next(points)
    # Where emitters of scenes that have gone live on, calls of this one are no part of the kernel, and round otherwise.
    gc.collect()
    for row, light in enumerate(lights):
        ray, weight = pointer.sample_ray(mi.Float(row), u, place, angle, mi.Bool(True))
        start, direction, _ = made.emit(number(row), place, angle, mi.Bool(True))
        np.testing.assert_allclose(from_device(ray.o), from_device(start), atol=1e-6)
        np.testing.assert_allclose(from_device(ray.d), from_device(direction), atol=1e-6)
        weight = np.array(weight, dtype=np.float64)
        if not is_spectral:
            np.testing.assert_allclose(weight, light.output.value, rtol=1e-6)
            continue
        # The weight is the spectral flux over the density of its wavelength.
        wavelengths = np.array(ray.wavelengths, dtype=np.float64)
        spectrum = light.output.value * photometric_density(light.output.spectrum)
        span = GRID[-1] - GRID[0]
        expected = np.interp(wavelengths, GRID, spectrum) * span
        np.testing.assert_allclose(weight, expected, rtol=1e-3, atol=1e-4 * expected.max())
        evenly, _ = np.histogram(wavelengths, 47, (GRID[0], GRID[-1]))
        np.testing.assert_allclose(evenly, wavelengths.size / 47, rtol=1e-3, atol=8)
        seen = np.interp(wavelengths, GRID, luminous_efficiency()) * LUMINOUS_EFFICACY
        assert (weight * seen).mean() == pytest.approx(light.output.value, rel=1e-3)


# ---- what cannot be a luminaire ----

WRONG_OPENINGS = {
    "no width": (Opening("rectangle", (0.0, 0.5, 0.0)), "size of 0 m along x"),
    "a flat body": (Opening("box", (0.3, 0.3, 0.0)), "size of 0 m along z"),
    "a flat ball": (Opening("ellipsoid", (0.3, 0.0, 0.3)), "size of 0 m along y"),
    "a cylinder of no length": (Opening("cylinder", (0.0, 0.3, 0.3), "x"), "size of 0 m along x"),
    "a thick disk": (Opening("ellipse", (0.3, 0.3, 0.1)), "expected 0 m"),
    "below nothing": (Opening("box", (0.3, -0.3, 0.3)), "size of -0.3 m along y"),
    "not a number": (Opening("ellipse", (np.nan, 0.3, 0.0)), "size of nan m along x"),
    "without end": (Opening("cylinder", (0.3, 0.3, np.inf)), "size of inf m along z"),
    "beyond the horizon": (Opening("rectangle", (5e4, 1.0, 0.0)), "to 10000 m"),
    "finer than light": (Opening("ellipsoid", (1e-6, 1e-6, 1e-6)), "1e-05 to"),
    "unheard of": (Opening("star", (1.0, 1.0, 1.0)), "shape 'star'"),
    "an axis too many": (Opening("cylinder", (1.0, 1.0, 1.0), "w"), "about 'w'"),
}


@pytest.mark.parametrize("name", WRONG_OPENINGS)
def test_what_is_no_opening_is_refused_in_words(name):
    opening, words = WRONG_OPENINGS[name]
    session = session_of(luminaire("lambertian", opening, key="kitchen"))
    said = f"(?=.*expected)luminaire 'kitchen' has an opening .*{re.escape(words)}"
    with pytest.raises(SceneError, match=said):
        session.measure([[0, 0, -1]], [[0, 0, 1]], StopRule(samples=16))


def test_a_scaled_frame_is_refused_in_words():
    light = luminaire("lambertian", OPENINGS["box"], rotation=2.0 * np.eye(3), key="hall")
    with pytest.raises(SceneError, match="'hall' is scaled or sheared"):
        session_of(light).measure([[0, 0, -1]], [[0, 0, 1]], StopRule(samples=16))


def test_luminaires_that_go_and_come_back_shine_as_before():
    place, up, rule = [[0.2, 0.1, -1.0]], [[0, 0, 1]], StopRule(samples=256)
    lights = [
        luminaire("batwing", OPENINGS["cylinder"], key="a"),
        luminaire("type B", place=(0.0, 0.5, 0.0), key="b"),
    ]
    session = session_of(*lights)
    first = session.measure(place, up, rule).illuminance
    for _ in range(3):
        session.apply(SceneDelta(removed=("a", "b")))
        gc.collect()
        assert session.measure(place, up, rule).illuminance == 0.0
        session.apply(SceneDelta(changed=tuple(lights)))
        gc.collect()
        np.testing.assert_array_equal(session.measure(place, up, rule).illuminance, first)
