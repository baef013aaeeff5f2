"""Points of luminous openings: drawn with the stated density, all over what is seen, also under narrow beams."""

import numpy as np
import pytest
from device_values import LANES, SIGNIFICANCE, from_device, number, random_points, vectors
from luminaire_palettes import CENTRE, interaction, palette_of, visible
from luminaires import (
    DISTRIBUTIONS,
    OPENINGS,
    chi_square,
    flux,
    grid,
    intensity,
    luminaire,
    opening_axes,
    opening_pieces,
    shown_area,
    turn,
)

from lumenray.engine.scene.distribution import SHAPES, Opening
from lumenray.engine.transport import backend

pytestmark = [pytest.mark.mitsuba, pytest.mark.usefixtures("mono")]


def unlike(light, place):
    """Share of directions whose density two ways of computing it may give unlike.

    A direction of single precision says to some 3e-8 times the distance where it meets the opening, and towards the rim of
    round ones the density rises without end.
    """
    if light.opening.shape in {"rectangle", "ellipse", "box"}:
        return 2e-3
    _, half = opening_axes(light.opening)
    return 0.015 + np.sqrt(2e-5 * np.linalg.norm(place - CENTRE) / half.min())


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
