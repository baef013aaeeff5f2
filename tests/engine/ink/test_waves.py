"""Waves in layers against closed forms: films, stacks, spheres, gratings, and what no layer may break."""

from functools import partial

import numpy as np
import pytest
from small_inks import BINDER, WAVELENGTH, random_grid

from lumenray.engine.errors import SceneError
from lumenray.engine.ink import waves as waves_module
from lumenray.engine.ink.films import film_shares
from lumenray.engine.ink.krylov import solve_linear, solve_short
from lumenray.engine.ink.packing import Packing
from lumenray.engine.ink.particles import Population
from lumenray.engine.ink.relief import carve
from lumenray.engine.ink.resolvent import Resolvent
from lumenray.engine.ink.scalar_sphere import forward_amplitude, scalar_efficiencies
from lumenray.engine.ink.voxels import fill_shares
from lumenray.engine.ink.waves import Cell, Waves


@pytest.mark.parametrize(
    ("index", "angle", "reflected", "transmitted"),
    [
        (1.558, 30, 0.20613145686722623, 0.7938685431327742),
        (1.4, 60, 0.0, 1.0),
        (1.4 + 0.1j, 30, 0.043802185038582644, 0.08008679925912107),
    ],
)
def test_homogeneous_layers_do_what_films_do(index, angle, reflected, transmitted):
    """Values of the program tmm 0.2.0."""
    sine = np.sin(np.radians(angle))
    grid = np.full((6, 2, 2), complex(index) ** 2)
    waves = Waves(Cell(grid, 1.0, 1.0), WAVELENGTH, (2.0 * np.pi / WAVELENGTH * sine, 0.0))
    out = waves.scatter(tolerance=1e-11)
    assert out.reflected[0, 0] == pytest.approx(reflected, abs=1e-10)
    assert out.transmitted[0, 0] == pytest.approx(transmitted, abs=1e-10)
    film = film_shares(index**2, 1.0, sine, WAVELENGTH)
    assert film[0][0] == pytest.approx(reflected, abs=1e-10)


def test_stacks_converge_with_the_square_of_the_step():
    """0.4, 0.3, 0.3 um of binder, absorber, binder; exact values of the program tmm."""
    errors = []
    for layers in (20, 40, 80):
        place = (np.arange(layers) + 0.5) / layers
        absorbs = ((place > 0.4) & (place < 0.7))[:, None, None]
        grid = np.where(absorbs, (1.4 + 0.1j) ** 2, BINDER**2 + 0j) * np.ones((1, 2, 2))
        out = Waves(Cell(grid, 1.0, 1.0), WAVELENGTH, background=BINDER**2).scatter(tolerance=1e-10)
        errors.append(out.transmitted.sum() - 0.4279910025688672)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 1e-3
    np.testing.assert_allclose(orders, 2.0, atol=0.05)


def test_energy_is_kept_to_1e_8_with_and_without_absorption():
    for index in (1.4, 1.4 + 0.1j):
        waves = Waves(Cell(random_grid(index=index), 2.0, 1.0), WAVELENGTH, background=BINDER**2)
        out = waves.scatter(tolerance=1e-10)
        total = out.reflected.sum() + out.transmitted.sum() + out.absorbed
        assert total == pytest.approx(1.0, abs=1e-8)
        assert (out.absorbed > 0.1) == (index != 1.4)


def test_damped_iterations_solve_the_same_equations(monkeypatch):
    """What is damped is the search, not the waves: light and energy are those of the plain iteration."""
    waves = Waves(
        Cell(random_grid(layers=8, columns=12), 1.0, 0.5), WAVELENGTH, (1.0, 2.0), BINDER**2
    )
    plain = waves.scatter(tolerance=1e-10)
    monkeypatch.setattr(waves_module, "PLAIN_ITERATIONS", 2)
    damped = waves.scatter(tolerance=1e-10)
    assert damped.iterations != plain.iterations
    np.testing.assert_allclose(damped.up, plain.up, atol=1e-8)
    assert damped.reflected.sum() + damped.transmitted.sum() == pytest.approx(1.0, abs=1e-8)


def strong_grid():
    """Grains at random whose index is 3, without absorption."""
    return Cell(random_grid(layers=8, columns=12, index=3.0), 1.0, 0.5)


def middle_of(cell):
    return 0.5 * (cell.permittivity.real.min() + cell.permittivity.real.max())


def test_strong_scatterers_are_solved_by_the_same_equations(monkeypatch):
    """Where particles resonate the search is another: light and energy are those of the plain iteration."""
    cell = strong_grid()
    waves = Waves(cell, WAVELENGTH, (1.0, 2.0), middle_of(cell))
    monkeypatch.setattr(waves_module, "STRONG", 1.0)
    monkeypatch.setattr(waves_module, "PLAIN_ITERATIONS", 600)
    plain = waves.scatter(tolerance=1e-10)
    monkeypatch.setattr(waves_module, "PLAIN_ITERATIONS", 2)
    strong = waves.scatter(tolerance=1e-10)
    assert strong.iterations != plain.iterations
    np.testing.assert_allclose(strong.up, plain.up, atol=1e-8)
    np.testing.assert_allclose(strong.down, plain.down, atol=1e-8)
    assert strong.reflected.sum() + strong.transmitted.sum() == pytest.approx(1.0, abs=1e-8)


def test_strong_scatterers_that_do_not_settle_are_told(monkeypatch):
    monkeypatch.setattr(waves_module, "STRONG", 1.0)
    monkeypatch.setattr(waves_module, "PLAIN_ITERATIONS", 2)
    monkeypatch.setattr(waves_module, "MOST_SHORT", 20)
    with pytest.raises(SceneError, match=r"do not settle .* energy off by .* after 22 iterations"):
        Waves(strong_grid(), WAVELENGTH).scatter()


def test_a_layer_that_absorbs_has_the_resolvent_of_the_one_that_does_not():
    """(1 - c G) x is the source again, whatever the faces send back, and whether modes carry power or not."""
    cell = Cell(random_grid(layers=8, columns=12), 1.0, 0.5, 1.0, 1.5)
    waves = Waves(cell, WAVELENGTH, (1.0, 2.0))
    strength = 3.0j * waves.k0**2
    made = Resolvent(
        waves._chain, waves._stride, waves._other, waves._own - waves._other, 8, strength
    )
    rng = np.random.default_rng(4)
    source = rng.standard_normal((8, 12, 12)) + 1j * rng.standard_normal((8, 12, 12))
    field = made.apply(source)
    np.testing.assert_allclose(field - strength * waves.spread(field), source, atol=1e-11)
    np.testing.assert_allclose(made.spread(source), waves.spread(field), atol=1e-11)


@pytest.mark.parametrize("solve", [solve_short, partial(solve_linear, restart=30)])
def test_linear_equations_are_solved(solve):
    rng = np.random.default_rng(5)
    matrix = np.eye(60) + 0.08 * (
        rng.standard_normal((60, 60)) + 1j * rng.standard_normal((60, 60))
    )
    right = rng.standard_normal(60) + 0j
    found = solve(matrix.__matmul__, right, tolerance=1e-9, most=400)
    assert found.residual <= 1e-9
    np.testing.assert_allclose(found.answer, np.linalg.solve(matrix, right), atol=1e-6)
    few = solve(matrix.__matmul__, right, tolerance=1e-9, most=3)
    assert few.iterations == 3 and few.residual > 1e-9


def test_both_ways_scatter_alike_to_1e_10():
    waves = Waves(Cell(random_grid(), 2.0, 1.0), WAVELENGTH)
    there = waves.scatter((0, 0), 1e-12).up[0, 2] * waves.above[0, 2]
    back = waves.scatter((0, -2), 1e-12).up[0, 0] * waves.above[0, 0]
    assert abs(there - back) < 1e-10 * abs(there)


def test_light_from_the_other_side_passes_alike():
    """Through a random layer with glass below: T of mode 0 to mode 0 does not know the direction."""
    cell = Cell(random_grid(), 2.0, 1.0, 1.0, 1.5)
    down = Waves(cell, WAVELENGTH).scatter(tolerance=1e-10).transmitted[0, 0]
    up = Waves(cell.turned_over(), WAVELENGTH).scatter(tolerance=1e-10).transmitted[0, 0]
    assert down == pytest.approx(up, rel=1e-8)


@pytest.mark.parametrize("index", [1.4, 1.4 + 0.1j])
def test_a_sphere_scatters_forwards_as_partial_waves_say(index):
    """In a cell of 2.4 um, where its images hardly matter."""
    width, diameter, height = 2.4, 0.3, 0.6
    population = Population(np.pi / 6.0 * diameter**3 / (width**2 * height), diameter)
    one = Packing(
        np.array([[1.2, 1.2, 0.3]]), np.array([[0.0, 0.0, 1.0]]), np.array([diameter]), np.zeros(1, int),
        (population,), width, height, 0,
    )  # fmt: skip
    share = fill_shares(one, (16, 64))[0]
    cell = Cell(BINDER**2 + share * (index**2 - BINDER**2), width, height, BINDER, BINDER)
    out = Waves(cell, WAVELENGTH, background=BINDER**2).scatter(tolerance=1e-6)
    k = 2.0 * np.pi / WAVELENGTH * BINDER
    through = np.exp(1j * k * height)
    found = (out.down[0, 0] - through) / through * k * width**2 / (2j * np.pi)
    assert found == pytest.approx(forward_amplitude(0.15, index / BINDER, k), rel=0.03)


def test_scalar_spheres_have_the_efficiencies_of_the_series():
    """Sums of another program; small ones scatter 3/2 of what electromagnetic ones do."""
    size = np.pi * 0.3 * BINDER / WAVELENGTH
    assert scalar_efficiencies(size, (1.4 + 0.2j) / BINDER) == pytest.approx(
        (0.6857391239663332, 0.1866676129561406), rel=1e-9
    )


def test_shallow_gratings_diffract_by_the_first_order_of_their_height():
    """A film with a sinusoidal face of the height h: |a_1|^2 = |h k0^2 (eps - 1) u(0) g_1|^2 / 4, by Born's series."""
    width, height, thickness = 1.5, 2e-3, 0.4
    columns, layers, margin = 16, 80, 0.02
    heights = height * np.cos(2.0 * np.pi * np.arange(columns) / columns) * np.ones((columns, 1))
    whole = thickness + margin
    solid = np.full((layers, columns, columns), BINDER**2 + 0j)

    def solve(face):
        grid = carve(solid, face, whole, margin, 1.0)
        return Waves(Cell(grid, width, whole), WAVELENGTH, background=BINDER**2).scatter(
            tolerance=1e-11
        )

    bumpy = solve(heights)
    k0 = 2.0 * np.pi / WAVELENGTH
    q = 2.0 * np.pi / width
    outer, inner = np.sqrt(k0**2 - q**2), np.sqrt(BINDER**2 * k0**2 - q**2)

    def amplitude(first, second):
        share = (first - second) / (first + second)
        turn = np.exp(2j * second * thickness)
        return (share - share * turn) / (1.0 - share**2 * turn)

    on_face = 1.0 + amplitude(k0, BINDER * k0)
    sent = 0.5j / outer * (1.0 + amplitude(outer, inner))
    expected = abs(k0**2 * (BINDER**2 - 1.0) * 0.5 * height * on_face * sent) ** 2 * outer / k0
    assert bumpy.reflected[0, 1] == pytest.approx(expected, rel=0.03)
    assert bumpy.reflected.sum() + bumpy.transmitted.sum() == pytest.approx(1.0, abs=1e-8)
