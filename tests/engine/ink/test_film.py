"""Films of realisations: what they come to in the limits that are known, kept work, processes, and substrates."""

from dataclasses import replace

import numpy as np
import pytest
from small_inks import BINDER, make_ink

from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.ink.composition import Ink
from lumenray.engine.ink.computed import _lab_error, compute, lab_of
from lumenray.engine.ink.ensemble import Ensemble, film_content, key_of, solve_ensemble
from lumenray.engine.ink.film import _fit, analyse, series
from lumenray.engine.ink.films import film_shares
from lumenray.engine.ink.plan import make_plan, memory_of
from lumenray.engine.ink.printed import Printed
from lumenray.engine.ink.realisation import solve_unit
from lumenray.engine.scattering.data.table import check_table
from lumenray.engine.scene.scattering import ScatterTable


def _solve(ink, plan, **options) -> Printed:
    """Film on its substrate, solved in this process."""
    runs, bands = range(plan.realisations), range(len(plan.wavelengths))
    units = {(k, band): solve_unit(ink, plan, k, band) for k in runs for band in bands}
    film = analyse(ink, plan, Ensemble(units, {}, len(units)), runs)
    return Printed(ink, plan.wavelengths, film, plan.realisations, **options)


def _small(ink, **changes):
    return replace(make_plan(ink, draft=True), wavelengths=(550.0,), **changes)


@pytest.fixture(scope="module")
def scattering():
    """A lossless layer of large grains, on white paper."""
    ink = make_ink(0.3, 0.3, 1.7, reflectance=1.0, spread=0.1)
    plan = _small(ink, width=1.5, columns=20, layers=16, tolerance=1e-4)
    return _solve(ink, plan)


def _normal(printed):
    up = np.array([[0.0, 0.0, 1.0]])
    return float(printed.evaluate(up, up)[0, 0])


@pytest.mark.parametrize(
    ("ink", "back", "passed", "straight", "total"),
    [
        (make_ink(), 0.29175815811022854, 0.7082418418897715, 0.28967622771290613, 0.8829009576406249),
        (
            make_ink(0.3, absorption=0.2),
            0.15983629255033038,
            0.17898542465907924,
            0.021244977919823032,
            0.11411791275450117,
        ),
    ],
)  # fmt: skip
def test_films_without_particles_lie_on_paper_as_the_closed_form_says(
    ink, back, passed, straight, total
):
    """Reference values C6, of the wave across the plane of incidence alone."""
    printed = _solve(ink, _small(ink, columns=2), count=200, is_scalar=True)
    assert printed.hemispherical[0][0] == pytest.approx(back, abs=1e-5)
    assert printed.hemispherical[1][0] == pytest.approx(passed, abs=1e-5)
    assert _normal(printed) == pytest.approx(straight, abs=1e-5)
    whole = printed.albedo([0.0]) + printed.mirror([0.0])
    assert whole[0, 0] == pytest.approx(total, abs=1e-5)


def test_mirrors_have_both_polarisations():
    """Reference values C11: unpolarised reflectance of the clear film at 0, 30, 60 degrees."""
    ink = make_ink()
    printed = _solve(ink, _small(ink, columns=2))
    found = printed.mirror(np.sin(np.radians([0.0, 30.0, 60.0])))[:, 0]
    np.testing.assert_allclose(
        found, [0.13649098464343346, 0.15208556993533107, 0.2172184308700416], atol=1e-6
    )


def test_a_white_furnace_stays_white(scattering):
    sines = np.sin(np.radians([0.0, 30.0, 60.0, 80.0]))
    total = scattering.albedo(sines) + scattering.mirror(sines)
    np.testing.assert_allclose(total, 1.0, atol=2e-3)
    # Between the film's faces nothing is lost at all.
    reflected, passed = scattering.total("above", scattering.nodes.tangential)
    np.testing.assert_allclose(reflected + passed, 1.0, atol=1e-6)


def test_prints_are_reciprocal(scattering):
    rng = np.random.default_rng(1)
    both = rng.normal(size=(2, 200, 3))
    both[..., 2] = np.abs(both[..., 2])
    wi, wo = both / np.linalg.norm(both, axis=2, keepdims=True)
    np.testing.assert_allclose(
        scattering.evaluate(wi, wo), scattering.evaluate(wo, wi), rtol=1e-9, atol=1e-12
    )


def test_a_matt_table_is_a_matt_substrate(scattering):
    """The general way, by matrices, does what the closed form does."""
    axes = (
        np.radians([0.0, 30.0, 60.0, 89.0]),
        np.radians([0.0, 90.0, 180.0]),
        np.array([0.0, np.pi]),
    )
    values = np.full((1, 4, 3, 2, 1), 0.8 / np.pi, np.float32)
    table = ScatterTable(np.zeros(1), *axes, np.array([550.0]), values)
    on_table, on_paper = (
        Printed(_on(scattering.ink, substrate), [550.0], scattering.film, 2)
        for substrate in (table, make_ink(reflectance=0.8).substrate)
    )
    wi = np.array([[0.3, 0.1, 0.9], [0.8, 0.0, 0.6]])
    wi /= np.linalg.norm(wi, axis=1, keepdims=True)
    wo = wi[::-1] * [1.0, -1.0, 1.0]
    np.testing.assert_allclose(on_table.evaluate(wi, wo), on_paper.evaluate(wi, wo), rtol=5e-3)


def _on(ink, substrate) -> Ink:
    return replace(ink, substrate=substrate)


def test_wet_paper_sends_light_back_under_the_film():
    """A clear film in contact with paper of its own index and reflectance 1 still loses nothing."""
    ink = make_ink(substrate={"reflectance": 1.0, "contact_index": BINDER})
    printed = _solve(ink, _small(ink, columns=2))
    total = printed.albedo([0.0, 0.6]) + printed.mirror([0.0, 0.6])
    np.testing.assert_allclose(total, 1.0, atol=1e-3)
    # Half a wave in air: the first face alone reflects.
    face = ((BINDER - 1.0) / (BINDER + 1.0)) ** 2
    assert printed.mirror([0.0])[0, 0] == pytest.approx(face, abs=1e-6)


def test_small_particles_tend_to_the_mean_permittivity():
    ink = make_ink(0.15, 0.06, absorption=0.2)
    plan = _small(ink, width=0.6, columns=24, layers=40)
    found = _solve(ink, plan).film.coherent["above"][:, 0, 0]
    sine = plan.sines[0]
    slab = [each[0] for each in film_shares(ink.mean_permittivity(550.0), 1.0, sine, 0.55)]
    np.testing.assert_allclose(found, slab, atol=0.02)


def test_tables_of_prints_can_be_used(scattering):
    from lumenray.engine.ink.computed import Computed

    made = Computed(
        scattering, make_plan(scattering.ink, draft=True), np.ones(1), np.zeros(1), 0.0, np.zeros(3), 0.0, {}, 1.0, 0
    )  # fmt: skip
    table = made.table()
    check_table(table)
    assert table.error <= 0.03
    assert table.direct.max() > 0.0


def test_a_job_goes_on_where_it_was_ended_to_the_same_bits(tmp_path):
    ink = make_ink(0.2, 0.3, absorption=0.1)
    plan = replace(
        make_plan(ink, draft=True), wavelengths=(500.0, 600.0), width=1.0, columns=8, layers=8, sines=(0.1, 0.8)
    )  # fmt: skip

    def stop_after(progress):
        if progress.done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solve_ensemble(ink, plan, tmp_path / "ended", 1, stop_after)
    resumed = solve_ensemble(ink, plan, tmp_path / "ended", 2)
    at_once = solve_ensemble(ink, plan, tmp_path / "whole", 1)
    assert resumed.solved == at_once.solved - 2
    for unit, arrays in at_once.units.items():
        for name, array in arrays.items():
            assert np.array_equal(array, resumed.units[unit][name]), (unit, name)
    more = solve_ensemble(ink, replace(plan, realisations=4), tmp_path / "whole", 1)
    assert more.solved == 4
    assert solve_ensemble(ink, plan, tmp_path / "whole").solved == 0


def test_what_lies_below_and_names_do_not_change_the_film():
    ink, other = make_ink(0.2, 0.2), make_ink(0.2, 0.2, reflectance=0.3, name="Other")
    plan = make_plan(ink)
    assert film_content(ink) == film_content(other)
    assert key_of(ink, plan) != key_of(make_ink(0.25, 0.2), plan)


def test_memory_is_bounded_before_anything_is_solved():
    import tracemalloc

    ink = make_ink(0.3, 0.3, absorption=0.1)
    plan = _small(ink, width=1.5, columns=40, layers=32, sines=(0.5,))
    tracemalloc.start()
    solve_unit(ink, plan, 0, 0)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < memory_of(ink, plan)
    with pytest.raises(SceneError, match="8 GB at most"):
        make_plan(make_ink(0.3, 0.05, solution={"cell_um": 30}))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"thickness_um": -1}, "thickness_um is -1"),
        ({"substrate": {}}, "substrate"),
        ({"pigments": [{"index": 1.5, "volume_fraction": 0.7}]}, "volume_fraction is 0.7"),
        ({"pigments": [{"index": "gold", "volume_fraction": 0.1}]}, "names 'gold'"),
        ({"pigments": [{"index": 1.5, "volume_fraction": 0.1, "median_um": 2}]}, "median_um is 2"),
    ],
)
def test_what_a_description_has_wrong_is_said(change, words):
    with pytest.raises(FileFormatError, match=words):
        make_ink(**change)


def test_a_narrow_cell_that_has_few_orders_makes_no_wild_reflectances(tmp_path):
    """Of so few orders a series of 20 terms is anything between them; a black layer on white paper is dark at all bands."""
    solution = {"cell_um": 0.6, "band_step_nm": 80, "incidences": 2, "realisations": 2}
    ink = make_ink(0.3, 0.25, 1.8, 0.6, solution=solution | {"tolerance": 0.01})
    readings = compute(ink, make_plan(ink, draft=True), tmp_path).readings
    assert readings.max() < 0.1


def test_the_error_of_a_fitted_kernel_is_that_of_speckle():
    """Samples that are exponentially distributed about a kernel: 600 fits scatter as each of them says on the mean."""
    rng = np.random.default_rng(8)
    first, second, turn = rng.random(120), rng.random(120), rng.uniform(-1.0, 1.0, 120)
    terms = series(first, second, turn, True)[:, :7]
    mean = 0.2 + 0.5 * first * second
    place = series(np.array([0.7]), np.ones(1), np.ones(1), True)[0, :7]
    values, errors = [], []
    for _ in range(600):
        found, scatter = _fit(terms, mean * rng.exponential(size=120))
        values.append(place @ found)
        errors.append(place @ scatter @ place)
    # Of 600 the standard deviation is known to 3 %.
    assert np.std(values) == pytest.approx(np.sqrt(np.mean(errors)), rel=0.1)
    assert np.mean(values) == pytest.approx(
        0.2 + 0.5 * 0.7, abs=4.0 * np.std(values) / np.sqrt(600)
    )


def test_no_more_goes_on_as_one_wave_than_was_found(scattering):
    """Where waves cancel at the thickness of realisations in the homogeneous film, what they have beside it is chance."""
    plain = scattering.film.coherent["above"]
    found = dict.fromkeys(("above", "below"), 0.0 * plain + 0.2)
    # A film of half a wave, which reflects nothing along the normal at its middle thickness.
    index = np.sqrt(scattering._means[0]).real
    halved = replace(scattering.ink, thickness=1.5 * 0.55 / index)
    printed = Printed(halved, scattering.wavelengths, replace(scattering.film, coherent=found), 2)
    shares = printed.coherent("above", scattering.film.sines)
    # Of both polarisations; what was found is of one.
    assert shares[0].max() < 2.0 * 0.2
    assert _normal(printed) > 0.01


def test_the_error_of_a_colour_is_that_of_its_bands():
    """Bands that scatter by their errors: colours scatter as stated, also about a band that reflects nothing."""
    rng = np.random.default_rng(9)
    bands = np.linspace(390.0, 710.0, 5)
    for readings in (np.array([0.4, 0.5, 0.45, 0.4, 0.35]), np.array([0.4, 0.5, 0.0, 0.4, 0.35])):
        errors = np.full(5, 0.002)
        drawn = np.abs(readings + errors * rng.standard_normal((4000, 5)))
        apart = lab_of(drawn, bands) - lab_of(readings, bands)
        scatter = np.sqrt((apart**2).sum(axis=1).mean())
        assert _lab_error(readings, errors, bands) == pytest.approx(scatter, rel=0.1)
