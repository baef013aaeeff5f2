"""Seams between charts: where they are, how large their steps are, and that matching them bends nothing."""

from dataclasses import replace

import numpy as np
import pytest

from lumenray.engine.atlas.gutters import fill
from lumenray.engine.atlas.layout import Atlas, SurfaceLayout
from lumenray.engine.atlas.lumels import LumelTable
from lumenray.engine.atlas.seams import (
    find_seams,
    join_pairs,
    match_seams,
    measure_steps,
    usable_pairs,
)
from lumenray.engine.scene.mesh import Mesh

SIZE = np.array([[200, 120], [100, 100]])
DENSITY = 12.0


def cylinder(sectors=48, rows=6, radius=1.0, height=3.0, smooth=True):
    turn = np.arange(sectors) / sectors * 2 * np.pi
    z = np.linspace(0.0, height, rows + 1)
    zz, tt = (x.ravel() for x in np.meshgrid(z, turn, indexing="ij"))
    vertices = np.stack([radius * np.cos(tt), radius * np.sin(tt), zz], axis=1)
    i, j = (x.ravel() for x in np.meshgrid(np.arange(rows), np.arange(sectors), indexing="ij"))
    a, b = i * sectors + j, i * sectors + (j + 1) % sectors
    triangles = np.concatenate(
        [np.stack([a, b, b + sectors], axis=1), np.stack([a, b + sectors, a + sectors], axis=1)]
    ).astype(np.int32)
    sector, row = np.concatenate([j, j]), np.concatenate([i, i])
    mesh = Mesh("c", "c", vertices, triangles, ("paint",), np.zeros(len(triangles), np.int32))
    if smooth:
        normals = vertices[triangles] * [1.0, 1.0, 0.0] / radius
        mesh = replace(mesh, corner_normals=normals.astype(np.float32))
    return mesh, sector, row, turn


def split_cylinder(charts=3, **more):
    """Cylinder cut lengthwise into charts, at odd places on the pages and at odd angles of turn; the last on page 1."""
    mesh, sector, _, _ = cylinder(**more)
    sectors = int(sector.max()) + 1
    chart = sector * charts // sectors
    corners = mesh.vertices[mesh.triangles]
    turn = np.arctan2(corners[..., 1], corners[..., 0]) % (2 * np.pi)
    # Corners of the last sector lie at a full turn rather than at none.
    turn = np.where((sector[:, None] == sectors - 1) & (turn < 1e-9), 2 * np.pi, turn)
    flat = np.stack([turn, corners[..., 2]], axis=2)
    uv = np.zeros_like(flat)
    page = np.zeros(len(chart), np.int32)
    for number in range(charts):
        mine = chart == number
        own = flat[mine] - flat[mine].reshape(-1, 2).min(axis=0)
        angle = 0.13 * number
        turned = own @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        turned -= turned.reshape(-1, 2).min(axis=0)
        last = number == charts - 1
        uv[mine] = turned * DENSITY + np.array([5.3 + (0 if last else 46.0 * number), 6.7])
        page[mine] = int(last)
    layout = SurfaceLayout(uv, page, chart.astype(np.int32), DENSITY, DENSITY)
    return mesh, Atlas(SIZE, (layout,), charts, 1.0)


def shade(mesh, atlas, light, noise=0.0, seed=0):
    """Pages of a light on the surface: values, errors, computed lumels and owners of the filled ones."""
    rng = np.random.default_rng(seed)
    table = LumelTable([mesh], atlas)
    pages = [np.full((4, h, w), -1.0) for w, h in atlas.sizes]
    for number in range(len(table.counts)):
        block = table.block(number)
        held = block.receivers
        value = np.add.reduceat(light(held.positions), held.start) / held.count
        flat = pages[block.page].reshape(4, -1)
        flat[0, block.index] = value + noise * rng.normal(size=len(value))
        flat[1, block.index] = noise
        flat[2, block.index] = 1.0
        flat[3, block.index] = block.chart
    filled = [fill(p[:2], p[2] > 0, p[3].astype(np.int32), 4) for p in pages]
    values = [f[0][0] for f in filled]
    errors = [f[0][1] for f in filled]
    return values, errors, [p[2] > 0 for p in pages], [f[1] for f in filled]


def seams_of(mesh, atlas, owners):
    pairs = find_seams(mesh, atlas.layouts[0], atlas.sizes)
    return usable_pairs(pairs, owners)


def corrected(values, changes):
    made = [v.copy() for v in values]
    for page, (index, change) in zip(made, changes, strict=True):
        page.reshape(-1)[index] += change
    return made


def steady(positions):
    return 100.0 + 40.0 * positions[:, 0] + 25.0 * positions[:, 1] + 10.0 * positions[:, 2]


def test_seams_are_found_where_charts_meet_and_on_both_sides_alike():
    mesh, atlas = split_cylinder()
    pairs = find_seams(mesh, atlas.layouts[0], atlas.sizes)
    # Three seams of 3 m at 12 lumels a metre, rounded up edge by edge (six edges of half a metre each).
    assert len(pairs) == 3 * 36
    assert (pairs.chart[:, 0] != pairs.chart[:, 1]).all()
    assert pairs.weight.sum(axis=2) == pytest.approx(1.0)
    counts = {tuple(sorted(row)) for row in pairs.chart.tolist()}
    assert counts == {(0, 1), (1, 2), (0, 2)}
    # Places in space, interpolated from either side by the known unwrapping of a plane function, are one.
    values, _, _, owners = shade(mesh, atlas, lambda p: p[:, 2])
    kept = usable_pairs(pairs, owners)
    assert len(kept) == len(pairs)
    steps, _ = measure_steps(kept, values, [np.zeros_like(v) for v in values])
    # Height is the same on both sides; what is left is what filling does at the rims, under a lumel's height.
    assert np.abs(steps).max() < 1.0 / DENSITY


def test_hard_edges_and_edges_within_a_chart_are_no_seams():
    mesh, atlas = split_cylinder(smooth=False, sectors=24)
    # Facets of 15 degrees.
    assert len(find_seams(mesh, atlas.layouts[0], atlas.sizes)) == 0
    assert len(find_seams(mesh, atlas.layouts[0], atlas.sizes, np.radians(16.0))) == 3 * 36
    mesh, atlas = split_cylinder(charts=1)
    assert len(find_seams(mesh, atlas.layouts[0], atlas.sizes)) == 0


def test_split_vertices_are_welded_and_bad_triangles_ignored():
    mesh, atlas = split_cylinder()
    loose = replace(
        mesh,
        vertices=mesh.vertices[mesh.triangles].reshape(-1, 3),
        triangles=np.arange(mesh.triangles.size, dtype=np.int32).reshape(-1, 3),
    )
    assert len(find_seams(loose, atlas.layouts[0], atlas.sizes)) == 3 * 36
    # A third triangle at an edge: nobody knows which two go on.
    extra = mesh.triangles[:1].copy()
    doubled = replace(
        mesh,
        triangles=np.concatenate([mesh.triangles, extra, [[0, 0, 1]]]).astype(np.int32),
        corner_normals=np.concatenate(
            [mesh.corner_normals, mesh.corner_normals[:1], mesh.corner_normals[:1]]
        ),
    )
    old = atlas.layouts[0]
    layout = replace(
        old,
        uv=np.concatenate([old.uv, old.uv[:1], old.uv[:1]]),
        page=np.concatenate([old.page, [0, 0]]).astype(np.int32),
        chart=np.concatenate([old.chart, [1, -1]]).astype(np.int32),
    )
    assert 3 * 36 - 12 <= len(find_seams(doubled, layout, atlas.sizes)) <= 3 * 36
    assert len(find_seams(mesh, replace(old, page=np.full_like(old.page, -1)), atlas.sizes)) == 0


def test_matching_takes_steps_under_the_noise_and_moves_nothing_beyond_it():
    mesh, atlas = split_cylinder()
    noise = 1.5
    values, errors, computed, owners = shade(mesh, atlas, steady, noise)
    pairs = seams_of(mesh, atlas, owners)
    changes, steps = match_seams(values, errors, computed, pairs)
    assert steps.pairs == len(pairs)
    assert steps.before > 0.8 * steps.noise
    assert steps.after < 0.3 * steps.noise
    matched = corrected(values, changes)
    after, _ = measure_steps(pairs, matched, errors)
    assert np.sqrt(np.mean(after**2)) == pytest.approx(steps.after, rel=1e-9)
    touched = 0
    for old, new, known in zip(values, matched, computed, strict=True):
        assert np.abs(new - old)[known].max() <= 2.0 * noise * (1 + 1e-9)
        touched += ((new != old) & known).sum()
    # Border lumels only: at most four on either side of each place.
    assert 0 < touched < 8 * len(pairs)
    # Measured values are better for it or as good: the true light is known.
    truth = shade(mesh, atlas, steady)[0]
    for old, new, known, true in zip(values, matched, computed, truth, strict=True):
        changed = known & (new != old)
        before, now = (np.sqrt(np.mean((v - true)[changed] ** 2)) for v in (old, new))
        assert now < 1.05 * before


def test_without_noise_only_filled_pixels_move():
    mesh, atlas = split_cylinder()
    values, errors, computed, owners = shade(mesh, atlas, steady)
    pairs = seams_of(mesh, atlas, owners)
    changes, steps = match_seams(values, errors, computed, pairs)
    matched = corrected(values, changes)
    for old, new, known in zip(values, matched, computed, strict=True):
        assert np.array_equal(new[known], old[known])
    assert steps.noise == 0.0
    # What is left is that lumels at the rim hold the mean of their covered part, which does not lie at their centre.
    assert steps.after < 0.7 * steps.before


def test_a_step_that_the_surface_has_stays():
    # Light on half of the cylinder only, its border along a seam: 100 lx against noise of 0.5 lx.
    mesh, atlas = split_cylinder()

    def sharp(positions):
        turn = np.arctan2(positions[:, 1], positions[:, 0]) % (2 * np.pi)
        return np.where(turn < 2 * np.pi / 3, 100.0, 0.0)

    values, errors, computed, owners = shade(mesh, atlas, sharp, 0.5)
    pairs = seams_of(mesh, atlas, owners)
    changes, _ = match_seams(values, errors, computed, pairs)
    matched = corrected(values, changes)
    for old, new, known in zip(values, matched, computed, strict=True):
        assert np.abs(new - old)[known].max() <= 1.0 + 1e-9


def test_places_whose_pixels_belong_to_others_are_left_out():
    mesh, atlas = split_cylinder()
    _, _, _, owners = shade(mesh, atlas, steady)
    pairs = find_seams(mesh, atlas.layouts[0], atlas.sizes)
    strange = [np.where(owner == 1, 7, owner) for owner in owners]
    kept = usable_pairs(pairs, strange)
    assert len(kept) == 36
    assert not (kept.chart == 1).any()


def test_seams_of_nothing_are_nothing():
    mesh, atlas = split_cylinder(charts=1)
    none = join_pairs([find_seams(mesh, atlas.layouts[0], atlas.sizes)] * 2)
    assert len(none) == 0
    values = [np.zeros((100, 100)) for _ in range(2)]
    changes, steps = match_seams(values, values, [v > 0 for v in values], none)
    assert [len(index) for index, _ in changes] == [0, 0]
    assert (steps.pairs, steps.before, steps.after, steps.noise) == (0, 0.0, 0.0, 0.0)


def test_the_same_seams_give_the_same_changes():
    mesh, atlas = split_cylinder()
    made = [shade(mesh, atlas, steady, 1.0, seed=3) for _ in range(2)]
    results = []
    for values, errors, computed, owners in made:
        pairs = join_pairs([seams_of(mesh, atlas, owners)])
        results.append(match_seams(values, errors, computed, pairs)[0])
    for one, other in zip(*results, strict=True):
        assert np.array_equal(one[0], other[0])
        assert np.array_equal(one[1], other[1])


def test_matching_makes_no_light_less_than_none():
    mesh, atlas = split_cylinder()
    values, errors, computed, owners = shade(
        mesh, atlas, lambda p: np.maximum(3.0 - 20.0 * np.abs(p[:, 1]), 0.0), 0.4, seed=9
    )
    values = [np.maximum(value, 0.0) for value in values]
    changes, _ = match_seams(values, errors, computed, seams_of(mesh, atlas, owners))
    assert min(page.min() for page in corrected(values, changes)) >= 0.0
