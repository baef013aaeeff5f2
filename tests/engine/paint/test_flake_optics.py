"""Flakes as stacks of sheets: reflectance against an independent program's, energy, thickness spread."""

import numpy as np
import pytest
from paints import interference, one_layer

from lumenray.benchmarks.paint import reference
from lumenray.engine.errors import SceneError
from lumenray.engine.paint.flake_optics import find_curves, find_shares, polynomials

ANGLES = np.cos(np.radians([0, 15, 30, 45, 60, 75]))

WAVELENGTHS = np.array([450.0, 550.0, 650.0])

BINDER = np.full(3, 1.45)

STACKS = {
    (448, 1.5, 12): "viola SiO2 448 / TiO2 12",
    (230, 1.77, 165): "xirallic Al2O3 230 / TiO2 165",
    (300, 1.77, 60): "xirallic silver Al2O3 300 / TiO2 60",
}
"""Core's thickness and index and the coating's thickness of the stacks that tmm 0.2.0 computed (A6), by their names."""


def stack_of(core, index, coating, **own):
    return one_layer([interference(core, index, coating, 0.05, **own)]).layers[0].flakes[0]


@pytest.mark.parametrize("core", STACKS)
def test_interference_stacks(core):
    across, within, _, passed = find_shares(stack_of(*core).optics, BINDER, WAVELENGTHS, ANGLES)
    mean = 0.5 * (across + within)
    want = [reference.value(f"A6.stack.{STACKS[core]}.{band:.0f}") for band in WAVELENGTHS]
    assert mean == pytest.approx(np.array(want), abs=1e-6)
    assert mean + passed == pytest.approx(np.ones_like(mean), abs=1e-12)


def test_polarised_stack():
    across, within, both, _ = find_shares(
        stack_of(448, 1.5, 12).optics, BINDER[:1], [550.0], [np.sqrt(0.5)]
    )
    assert (across[0, 0], within[0, 0]) == pytest.approx(
        (0.29839493897909763, 0.05031315538353199), abs=1e-6
    )
    # What becomes of 45 degrees is at most the root of both, whatever the phase.
    assert abs(both[0, 0]) <= np.sqrt(across[0, 0] * within[0, 0]) + 1e-12


def test_metal_sheets():
    """Aluminium of 100 nm (A6), whose n and k stand at these wavelengths."""
    table = {
        "wavelengths_nm": [450, 550, 650],
        "n": [0.6332, 1.0152, 1.5580],
        "k": [5.4543, 6.6273, 7.7124],
    }
    flake = {"mirror": {"index": table, "thickness_nm": 100}, "amount": {"volume_fraction": 0.1}}
    optics = one_layer([flake]).layers[0].flakes[0].optics
    across, within, _, passed = find_shares(optics, BINDER, WAVELENGTHS, ANGLES)
    want = reference.value("A6.stack.aluminium 100 nm.550")
    assert 0.5 * (across + within)[1] == pytest.approx(want, abs=1e-6)
    assert passed.max() < 1e-5


def test_curves_hold_fringes():
    wavelengths = np.arange(390.0, 711.0, 40.0)
    flake = stack_of(1500, 1.5, 60)
    binder = np.full(len(wavelengths), 1.45)
    curves = find_curves(flake, binder, wavelengths)
    cosines = np.linspace(0.73, 1.0, 200)
    across, within, both, _ = find_shares(flake.optics, binder, wavelengths, cosines)
    assert (
        np.abs(curves.read(cosines) - np.stack([each.T for each in (across, within, both)])).max()
        < 1e-3
    )
    with pytest.raises(SceneError, match="too many interference orders"):
        find_curves(stack_of(9000, 1.5, 60), binder, wavelengths)


def test_series_hold_means_of_fringes():
    """Towards grazing fringes are narrower than tilts; their mean over a tilt of 3 degrees is that of the series."""
    wavelengths = np.array([390.0, 550.0])
    flake = stack_of(448, 1.5, 12)
    curves = find_curves(flake, np.full(2, 1.45), wavelengths)
    angle = np.radians(np.arange(0.0, 90.0, 0.05))
    across, within, *_ = find_shares(flake.optics, np.full(2, 1.45), wavelengths, np.cos(angle))
    series = curves.reflected @ polynomials(np.cos(angle), curves.terms).T
    for middle in np.radians([10, 30, 50, 70]):
        weight = np.exp(-0.5 * ((angle - middle) / flake.slope) ** 2)
        means = [
            (each * weight).sum(axis=1) / weight.sum() for each in (0.5 * (across + within), series)
        ]
        assert means[0] == pytest.approx(means[1], abs=5e-4)


def test_thickness_spread_damps_fringes():
    wavelengths = np.arange(400.0, 701.0, 5.0)
    binder = np.full(len(wavelengths), 1.45)
    swings = []
    for spread in (0.0, 0.1):
        flake = interference(800, 1.5, 60, 0.1)
        flake["stack"]["core"]["thickness_spread"] = spread
        optics = one_layer([flake]).layers[0].flakes[0].optics
        across, *_ = find_shares(optics, binder, wavelengths, [1.0])
        swings.append(np.ptp(across))
    assert swings[1] < 0.7 * swings[0]
