"""Rays that luminaires emit: in the stated directions, with the light that next-event estimation gives."""

import numpy as np
import pytest
from device_values import LANES, SIGNIFICANCE, from_device, number, random_points, streams, vectors
from luminaire_palettes import CENTRE, interaction
from luminaires import (
    OPENINGS,
    bin_fluxes,
    chi_square,
    flux,
    grid_angles,
    opening_axes,
    quantile_edges,
    turn,
)
from scipy import stats

pytestmark = [pytest.mark.mitsuba, pytest.mark.usefixtures("mono")]


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
