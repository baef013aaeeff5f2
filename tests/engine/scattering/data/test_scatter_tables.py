"""Tables of scattering: the interpolation is the stated one, integrals are exact, resampling keeps its stated error."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scattering_models import directions, ggx, lambert, random_table, schlick, towards

from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.materials.facets import COSINES, directional_reflectance
from lumenray.engine.scattering.data import store
from lumenray.engine.scattering.data.evaluation import albedo, evaluate, measure_reciprocity, total
from lumenray.engine.scattering.data.record import ScatteringFile
from lumenray.engine.scattering.data.resampling import resample
from lumenray.engine.scattering.data.surface import usable
from lumenray.engine.scattering.data.table import (
    check_table,
    coordinates_of,
    direct_share,
    direction_of,
    has_many_cells,
    quadrature,
    rotations_around,
)
from lumenray.engine.scene.material import Measured


def test_coordinates_and_directions_undo_each_other():
    wi, wo = directions(2000, 1), directions(2000, 2)
    rotation, incidence, radial, azimuth = coordinates_of(wi, wo)
    made = direction_of(incidence, radial, azimuth)
    c, s = np.cos(rotation), np.sin(rotation)
    back = np.stack(
        [c * made[:, 0] - s * made[:, 1], s * made[:, 0] + c * made[:, 1], made[:, 2]], 1
    )
    assert np.abs(back - wo).max() < 1e-12
    # The mirror direction is the centre; the side of the horizon has the azimuth 0, that of the normal 180 degrees.
    mirror = wi * [-1, -1, 1]
    assert coordinates_of(wi, mirror)[2].max() < 1e-7
    lower, upper = towards(50, 180), towards(30, 180)
    assert coordinates_of(towards(40), lower)[3] == pytest.approx(0.0, abs=1e-9)
    assert coordinates_of(towards(40), upper)[3] == pytest.approx(np.pi)
    assert coordinates_of(towards(40), upper)[2] == pytest.approx(np.radians(10))


def test_grid_points_hold_their_values_and_between_them_they_are_linear():
    table = random_table()
    rng = np.random.default_rng(4)
    names = ("rotations", "incidences", "radials", "azimuths")
    checked = 0
    while checked < 40:
        p, s, t, a = (rng.integers(0, len(getattr(table, n)) - 1) for n in names)
        shares = rng.random(4) * rng.integers(0, 2, 4)
        spots = [
            (1 - u) * getattr(table, n)[i] + u * getattr(table, n)[i + 1]
            for u, n, i in zip(shares, names, (p, s, t, a), strict=True)
        ]
        wo = direction_of(*spots[1:])
        # At the centre itself there is no azimuth.
        if wo[2] < 0.01 or spots[2] == 0.0:
            continue
        c, r = np.cos(spots[0]), np.sin(spots[0])
        turn = np.array([[c, -r, 0], [r, c, 0], [0, 0, 1]])
        wi = turn @ np.array([np.sin(spots[1]), 0, np.cos(spots[1])])
        expected = 0.0
        for corner in range(16):
            at = [i + (corner >> k & 1) for k, i in enumerate((p, s, t, a))]
            weight = np.prod([u if corner >> k & 1 else 1 - u for k, u in enumerate(shares)])
            expected = expected + weight * table.values[tuple(at)]
        assert evaluate(table, wi[None], (turn @ wo)[None])[0] == pytest.approx(expected, rel=1e-6)
        checked += 1


def test_the_axis_of_rotations_closes_on_itself():
    table = random_table()
    first, last = table.rotations[0], table.rotations[-1]
    gap = first + 2.0 * np.pi - last
    middle = last + 0.5 * gap
    wo = direction_of(0.7, 0.3, 1.0)

    def at(rotation):
        c, r = np.cos(rotation), np.sin(rotation)
        turn = np.array([[c, -r, 0], [r, c, 0], [0, 0, 1]])
        return evaluate(table, (turn @ [np.sin(0.7), 0, np.cos(0.7)])[None], (turn @ wo)[None])[0]

    assert at(middle) == pytest.approx(0.5 * (at(first) + at(last)), rel=1e-6)


@pytest.mark.parametrize("is_symmetric", [True, False])
def test_an_orthotropic_table_is_the_same_in_its_mirrors(is_symmetric):
    table = random_table(3, 4, is_symmetric, is_orthotropic=True)
    direct = np.random.default_rng(2).random((4, 4, 3)).astype(np.float32)
    table = replace(table, direct=direct)
    check_table(table)
    quarter = replace(table, is_orthotropic=False)
    wi, wo = directions(3000, 1), directions(3000, 2)
    wi[:, :2] = np.abs(wi[:, :2])
    expected, shares = evaluate(quarter, wi, wo), direct_share(quarter, wi)
    for mirror in ([1, 1, 1], [-1, 1, 1], [1, -1, 1], [-1, -1, 1]):
        assert np.allclose(evaluate(table, wi * mirror, wo * mirror), expected, atol=1e-9)
        assert np.allclose(direct_share(table, wi * mirror), shares, atol=1e-9)
    # All quarters are told of, each rotation once.
    around = rotations_around(table)
    assert len(around) == 12
    assert (np.diff(around) > 0.0).all()
    assert around[-1] < 2.0 * np.pi


def test_ends_hold_and_nothing_leaves_below_the_horizon():
    table = random_table(rotations=1)
    steep, last = towards(85), towards(np.degrees(table.incidences[-1]))
    assert evaluate(table, steep[None], (steep * [-1, -1, 1])[None]) == pytest.approx(
        evaluate(table, last[None], (last * [-1, -1, 1])[None])
    )
    below = towards(100)[None]
    assert not evaluate(table, towards(30)[None], below).any()


@pytest.mark.parametrize("is_symmetric", [True, False])
@pytest.mark.parametrize("incidence", [0, 30, 60, 80, 89.9])
def test_a_matt_table_reflects_its_reflectance(incidence, is_symmetric):
    table = random_table(rotations=1, is_symmetric=is_symmetric, bands=1)
    table = replace(table, values=np.full_like(table.values, 0.6 / np.pi))
    assert albedo(table, np.radians(incidence)) == pytest.approx(0.6, rel=2e-5)


@pytest.mark.parametrize("incidence", [5, 40, 75])
def test_the_albedo_is_the_integral_over_the_hemisphere(incidence):
    table = random_table(seed=7)
    rotation = 2.0
    wi = towards(incidence, np.degrees(rotation))
    rng = np.random.default_rng(5)
    z = np.sqrt(rng.random(400_000))
    turn = 2.0 * np.pi * rng.random(len(z))
    sine = np.sqrt(1.0 - z**2)
    wo = np.stack([sine * np.cos(turn), sine * np.sin(turn), z], axis=1)
    f = np.pi * evaluate(table, np.broadcast_to(wi, wo.shape), wo)
    error = f.std(axis=0) / np.sqrt(len(f))
    made = albedo(table, np.radians(incidence), rotation)
    assert (np.abs(made - f.mean(axis=0)) < 4.0 * error).all()


@pytest.mark.parametrize("tolerance", [0.05, 0.02])
def test_resampling_keeps_the_wanted_error(tolerance):
    exact = ggx(0.15, schlick)

    def paint(wi, wo):
        return exact(wi, wo) + 0.1 / np.pi

    table = resample(paint, [550.0], tolerance=tolerance)
    assert table.error <= tolerance
    wi, wo = directions(20_000, 8, 0.09), directions(20_000, 9, 0.02)
    floor = 0.05 * max(albedo(table, s)[0] for s in table.incidences) / np.pi
    true = paint(wi, wo)
    relative = (evaluate(table, wi, wo) - true) / (true + floor)
    assert np.sqrt((relative**2).mean()) < 1.1 * tolerance
    assert table.values.nbytes < 2_000_000


@pytest.mark.parametrize("is_orthotropic", [True, False])
def test_rotations_are_chosen_for_the_wanted_error_between_them(is_orthotropic):
    exact = ggx(0.45, schlick, along=0.25)

    def brushed(wi, wo):
        return exact(wi, wo) + 0.1 / np.pi

    table = resample(
        brushed,
        [550.0],
        rotations=None,
        is_symmetric=False,
        is_orthotropic=is_orthotropic,
        tolerance=0.1,
    )
    check_table(table)
    assert table.is_orthotropic == is_orthotropic
    assert table.error <= 0.1
    wi, wo = directions(20_000, 8, 0.09), directions(20_000, 9, 0.02)
    floor = 0.05 * max(albedo(table, s)[0] for s in table.incidences) / np.pi
    true = brushed(wi, wo)
    relative = (evaluate(table, wi, wo) - true) / (true + floor)
    assert np.sqrt((relative**2).mean()) < 1.1 * table.error


def test_what_is_too_bright_at_grazing_does_not_hide_errors():
    """Data that make light near 90 degrees, as instruments do there: elsewhere errors still count by what is there."""
    lobe = ggx(0.15, schlick)

    def glare(wi, wo):
        excess = 1.0 + 5e4 * np.exp(-((wi[:, 2:] / 0.02) ** 2))
        return (lobe(wi, wo) + 0.1 / np.pi) * excess

    table = resample(glare, [550.0], tolerance=0.05)
    wi, wo = directions(20_000, 8, np.cos(np.radians(80))), directions(20_000, 9, 0.05)
    true = glare(wi, wo)
    relative = (evaluate(table, wi, wo) - true) / (true + 0.05 / np.pi)
    assert np.sqrt((relative**2).mean()) < 0.05


def test_a_resampled_lobe_reflects_as_much_as_the_lobe():
    # The directional reflectance of a GGX coat by another route: quadrature over its visible normals.
    from lumenray.engine.materials.facets import fresnel

    table = resample(ggx(0.2, lambda cosine: fresnel(cosine, 1.5)), [550.0], tolerance=0.03)
    expected = directional_reflectance(0.2, 1.5)
    for angle in (0.0, 30.0, 60.0, 75.0):
        place = np.sqrt(np.cos(np.radians(angle))) * (COSINES - 1)
        wanted = np.interp(place, np.arange(COSINES), expected)
        nearest = table.incidences[np.argmin(np.abs(table.incidences - np.radians(angle)))]
        assert np.degrees(nearest) == pytest.approx(angle)
        assert albedo(table, nearest)[0] == pytest.approx(wanted, rel=0.01)


def test_a_table_of_many_cells_reflects_as_much_as_what_it_was_made_from():
    """There few points of each cell are asked; twenty times as many tell what the totals should be."""
    exact = ggx(0.05, schlick)
    table = resample(exact, [550.0], tolerance=0.01)
    assert has_many_cells(table)
    for number in range(0, len(table.incidences), 6):
        incidence = table.incidences[number]
        radial, azimuth, weight = quadrature(table, incidence, 5)
        wo = direction_of(incidence, radial, azimuth)
        wi = np.broadcast_to(towards(np.degrees(incidence)), wo.shape)
        wanted = weight @ exact(wi, wo)
        rel = 3e-4 if incidence < np.radians(80) else 5e-3
        assert albedo(table, incidence) == pytest.approx(wanted, rel=rel)


def test_bands_on_a_line_are_left_out_and_others_stay():
    nm = np.arange(400.0, 701.0, 10.0)
    spectrum = np.where(nm < 550.0, 0.2, 0.2 + (nm - 550.0) * 0.004)

    def evaluate_it(wi, wo):
        return lambert(1.0)(wi, wo) * spectrum

    table = resample(evaluate_it, nm, tolerance=0.01)
    assert len(table.wavelengths) == 3
    assert 550.0 in table.wavelengths
    grey = resample(lambda wi, wo: np.repeat(lambert(0.5)(wi, wo), 31, axis=1), nm)
    assert len(grey.wavelengths) == 1


def test_reciprocity_is_measured():
    fair = resample(ggx(0.3, schlick), [550.0], tolerance=0.02)
    assert measure_reciprocity(fair).residual < 0.04
    # f = cos(theta_i) / pi, whose mirror image is cos(theta_o) / pi.
    unfair = resample(lambda wi, wo: wi[:, 2:] / np.pi, [550.0])
    assert measure_reciprocity(unfair).residual > 0.2
    # And the exact residual of it, over directions whose sines squared are even up to that of 80 degrees.
    assert measure_reciprocity(resample(lambert(), [550.0])).residual < 1e-6


def test_a_surface_that_makes_light_is_scaled_down_where_it_does():
    table = resample(lambert(0.9), [550.0], incidences=np.radians([0, 30, 60]))
    values = table.values.copy()
    values[:, 1] *= 1.3
    bright = replace(table, values=values)
    used = usable(Measured(bright, bright))
    assert used.front_reflection is used.back_reflection
    totals = [total(used.front_reflection, s)[0] for s in table.incidences]
    assert totals[1] == pytest.approx(1.0, rel=1e-4)
    assert max(totals) < 1.001
    fine = Measured(table, table)
    assert usable(fine) is fine
    # Together with what passes it must not be more than all either.
    sheet = usable(Measured(table, None, table, None))
    both = [
        total(sheet.front_reflection, s) + total(sheet.front_transmission, s)
        for s in table.incidences
    ]
    assert np.max(both) < 1.001


def test_reflection_and_transmission_are_added_at_the_same_angle():
    """A pane that reflects what it does not let through, tabulated at different angles, makes no light."""

    def pane(reflected, angles):
        shares = np.interp(angles, [0, 60, 89], [0.1, 0.2, 0.9])
        shares = shares if reflected else 0.95 - shares
        table = resample(lambert(0.5), [550.0], incidences=np.radians(angles))
        return replace(table, values=table.values * (2 * shares[None, :, None, None, None]))

    clear = Measured(pane(True, [0, 30, 60, 89]), None, pane(False, [0, 20, 40, 60, 89]), None)
    assert usable(clear) is clear
    # Bands too: what one reflects, the other lets through.
    red = resample(lambda wi, wo: lambert(1.0)(wi, wo) * [0.1, 0.9], [400.0, 600.0])
    blue = resample(lambda wi, wo: lambert(1.0)(wi, wo) * [0.85, 0.05], [400.0, 600.0])
    both = Measured(red, None, blue, None)
    assert usable(both) is both


def test_a_shared_table_is_limited_for_the_side_that_needs_it():
    shared, dark, bright = (resample(lambert(r), [550.0]) for r in (0.7, 0.2, 0.6))
    made = usable(Measured(shared, shared, dark, bright))
    assert made.front_reflection is made.back_reflection
    for side in ("front", "back"):
        parts = [getattr(made, f"{side}_{kind}") for kind in ("reflection", "transmission")]
        assert sum(total(part, 0.5)[0] for part in parts) < 1.001


def test_light_from_nothing_outside_the_tabulated_angles_is_found():
    table = resample(lambert(0.9), [550.0], incidences=np.radians([60.0]))
    lobe = np.where(table.radials[:, None, None] < 0.5, 1.0, 0.02) * table.values[0, 0]
    lobe *= 0.9 / total(replace(table, values=lobe[None, None]), np.radians(60.0))[0]
    steep = replace(table, values=lobe[None, None].astype(np.float32))
    made = usable(Measured(steep, None)).front_reflection
    assert total(made, 0.0)[0] < 1.001


def test_a_grid_that_is_too_large_at_once_ends():
    table = resample(lambert(0.5), [550.0], most=200)
    assert table.values.size > 200


def test_a_direct_part_counts():
    table = resample(lambert(0.5), [550.0], incidences=np.radians([0.0, 80.0]))
    table = replace(table, direct=np.array([[[0.1], [0.3]]], dtype=np.float32))
    assert total(table, np.radians(40.0)) == pytest.approx(0.7, rel=1e-4)


def test_orthotropic_rotations_fill_a_quarter():
    table = random_table(rotations=3, is_orthotropic=True)
    for rotations in ([0.0, 0.5, 1.5], [0.1, 0.5, 0.5 * np.pi]):
        with pytest.raises(SceneError, match="from 0 to 90 degrees"):
            check_table(replace(table, rotations=np.array(rotations)))


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("incidences", np.array([0.5, 0.4, 0.3, 0.2]), "ascend"),
        ("values", np.zeros((1, 2, 3, 4, 5), np.float32), "shape"),
        ("azimuths", np.linspace(0, 3, 6), "pi"),
        ("wavelengths", np.array([np.nan, 500.0, 600.0]), "wavelength"),
    ],
)
def test_a_table_that_breaks_its_rules_is_refused(name, value, words):
    with pytest.raises(SceneError, match=words):
        check_table(replace(random_table(), **{name: value}))


def store_file(**sides):
    return ScatteringFile(Path("x.lumbsdf"), "made", sides, "name", "description", "source")


def test_files_of_ours_give_back_what_was_written():
    table = replace(random_table(), direct=np.full((3, 4, 3), 0.25, dtype=np.float32), error=0.0123)
    data = store.pack(store_file(front_reflection=table, back_reflection=table))
    assert store.is_store(data)
    assert data == store.pack(store_file(front_reflection=table, back_reflection=table))
    read = store.read_store(data, "x.lumbsdf")
    made = read.sides["front_reflection"]
    assert made is read.sides["back_reflection"]
    assert (read.name, read.description, read.source) == ("name", "description", "source")
    assert np.allclose(made.values, table.values, rtol=6e-4, atol=1e-6)
    assert np.array_equal(made.direct, table.direct)
    assert np.array_equal(made.azimuths, table.azimuths)
    assert made.error == table.error


def test_files_keep_that_a_table_is_orthotropic():
    table = random_table(2, is_orthotropic=True)
    data = store.pack(store_file(front_reflection=table))
    made = store.read_store(data, "x.lumbsdf").sides["front_reflection"]
    assert made.is_orthotropic
    assert np.array_equal(made.rotations, table.rotations)


def test_files_of_another_version_are_refused(monkeypatch):
    monkeypatch.setattr(store, "VERSION", 1)
    data = store.pack(store_file(front_reflection=random_table()))
    monkeypatch.undo()
    with pytest.raises(FileFormatError, match="another version of Lumenray"):
        store.read_store(data, "x.lumbsdf")


def test_damaged_files_of_ours_are_refused_with_a_sentence():
    data = store.pack(store_file(front_reflection=random_table()))
    rng = np.random.default_rng(6)
    refused = 0
    for _ in range(400):
        broken = bytearray(data)
        for _ in range(rng.integers(1, 4)):
            broken[rng.integers(0, len(broken))] = rng.integers(0, 256)
        if rng.random() < 0.2:
            broken = broken[: rng.integers(1, len(broken))]
        try:
            store.read_store(bytes(broken), "x.lumbsdf")
        except FileFormatError as error:
            assert "x.lumbsdf" in str(error)
            refused += 1
    assert refused > 200


def test_light_along_the_normal_is_extrapolated_alike_in_all_azimuths():
    # ln f = a + b sin^2 of the half angle between wi and wo, even in the incidence: exact for the parabola to 1 %.
    from lumenray.engine.scattering.data.normal_incidence import add_normal_incidence

    def hazy(wi, wo):
        return np.exp(-3.0 * (1.0 - wo[:, 2:]) - 1.5 * (1.0 - wi[:, 2:]))

    table = resample(hazy, [550.0], incidences=np.radians([10.0, 20.0, 40.0]), tolerance=0.005)
    made = add_normal_incidence(table)
    assert made.incidences[0] == 0.0
    wi = np.tile([0.0, 0.0, 1.0], (200, 1))
    # Towards the horizon fewer azimuths tell of it.
    wo = directions(200, 3, 0.45)
    assert np.allclose(evaluate(made, wi, wo), hazy(wi, wo), rtol=0.03)
    # Without it the lowest incidence would hold, and the sample look lopsided.
    around = np.array([towards(30, a) for a in range(0, 360, 20)])
    before, after = (evaluate(t, np.tile([0.0, 0.0, 1.0], (18, 1)), around) for t in (table, made))
    assert np.ptp(after) < 1e-6
    assert np.ptp(before) > 0.05 * before.mean()
    assert add_normal_incidence(made) is None
    assert np.array_equal(made.values[:, 1:], table.values)


def test_long_texts_are_cut_so_that_files_can_be_read_again():
    file = replace(store_file(front_reflection=random_table()), description="é" * 100_000)
    assert store.read_store(store.pack(file), "x.lumbsdf").description.startswith("éé")
