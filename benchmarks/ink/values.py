"""What we find for the reference's values, by their names: (value, standard error or 0)."""

import json
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from ...engine.ink.ensemble import Ensemble
from ...engine.ink.film import analyse
from ...engine.ink.films import film_shares
from ...engine.ink.packing import Packing, pack
from ...engine.ink.particles import Population, union_volume
from ...engine.ink.plan import make_plan
from ...engine.ink.printed import Printed
from ...engine.ink.reader import parse_ink
from ...engine.ink.realisation import solve_unit
from ...engine.ink.scalar_sphere import forward_amplitude, scalar_efficiencies
from ...engine.ink.voxels import fill_shares
from ...engine.ink.waves import Cell, Waves

BINDER, WAVELENGTH = 1.558, 0.55
"""Index of the reference's binder, and its wavelength. [-], [um]"""

STACK = (20, 40, 80)
"""Cells along the depth by which convergence is told."""

REALISATIONS, DILUTE = 3, 6


@lru_cache
def entries() -> dict[str, dict]:
    """Return the reference's values: ``value``, ``tolerance`` and, of random layers, the standard ``error``."""
    return json.loads(Path(__file__).with_name("reference.json").read_text(encoding="utf-8"))


def find_values(say) -> dict:
    """Find all that takes no ensembles."""
    say("spheres, films, stacks")
    found = {}
    for name in entries():
        kind, *parts = name.split(".", 1)
        if name.startswith("C1."):
            diameter, index = parts[0].removeprefix("scalar_mie.d").split(".n", 1)
            size = np.pi * float(diameter) * BINDER / WAVELENGTH
            found[name] = scalar_efficiencies(size, complex(index) / BINDER), 0.0
        elif name.startswith("C2.slab"):
            index, angle = parts[0].removeprefix("slab.n").split(".th")
            found[name] = _slab(complex(index), float(angle)), 0.0
        elif kind == "C5":
            absorption, share = parts[0].removeprefix("molecular.k").split(".phi")
            ink = _ink(float(share), 0.0, float(absorption))
            shares = film_shares(ink.mean_permittivity(550.0), 1.0, 0.0, WAVELENGTH)
            found[name] = [float(each[0]) for each in shares], 0.0
        elif kind == "C11":
            back = film_shares(BINDER**2, 1.0, np.sin(np.radians(float(name[10:]))), WAVELENGTH)[0]
            found[name] = [float(back[0]), float(back.mean())], 0.0
    for layers in STACK:
        found[f"C2.ls.nz{layers}"] = _stack(layers), 0.0
    fine = [np.array(_stack(each)) for each in STACK[1:]]
    found["C2.multilayer"] = (4.0 * fine[1] - fine[0]) / 3.0, 0.0
    say("energy and reciprocity")
    found["C3.energy"] = energy_error(False) + 1.0, 0.0
    found["C3.reciprocity"] = reciprocity(), 0.0
    say("one sphere")
    for name in [each for each in entries() if each.startswith("C4.")]:
        index = complex(name.split(".n", 1)[1])
        made = (
            _amplitude_of_cell(index)
            if name.startswith("C4.ls")
            else forward_amplitude(0.15, index / BINDER, 2.0 * np.pi / WAVELENGTH * BINDER)
        )
        found[name] = [made.real, made.imag], 0.0
    say("films on paper")
    for name, ink, is_furnace in (
        ("C6.paper.clear", _ink(0.0, 0.0, 0.0), False),
        ("C6.paper.ink", _ink(0.3, 0.0, 0.2), False),
        ("C6.paper.white_furnace", _ink(0.0, 0.0, 0.0, 1.0), True),
    ):
        found[name] = _on_paper(ink, is_furnace), 0.0
    volume = union_volume(np.arange(5.0) - 2.0, np.ones(5))
    found["C7.cylinder"] = [np.cbrt(1.0 / 4.5), np.cbrt(1.0 / 4.0), volume], 0.0
    return found


def find_dense(say) -> dict:
    """Find the layers of explicit spheres."""
    found = {}
    for name in entries():
        if name.startswith("C9."):
            say(name)
            absorption, share, diameter = (
                float(part) for part in name.removeprefix("C9.layer.k").replace(".phi", " ").replace(".d", " ").split()
            )  # fmt: skip
            rows = [_layer(share, diameter, absorption, seed) for seed in range(REALISATIONS)]
            error = np.std(rows, axis=0, ddof=1) / np.sqrt(REALISATIONS)
            found[name] = np.mean(rows, axis=0), error
    say("C10.dilute")
    found["C10.dilute"] = _dilute(), 0.0
    return found


def convergence_order() -> float:
    """Order in the step along the depth, of the stack's transmittance against the film's closed form."""
    exact = entries()["C2.multilayer"]["value"][1]
    errors = np.array([_stack(each)[1] - exact for each in STACK])
    return float(np.log2(errors[:-1] / errors[1:]).mean())


def energy_error(is_absorbing: bool) -> float:
    """Light that a random layer has too much: 1 less what it reflects, transmits and absorbs."""
    out = _random(1.4 + 0.1j if is_absorbing else 1.4).scatter(tolerance=1e-11)
    return float(out.reflected.sum() + out.transmitted.sum() + out.absorbed - 1.0)


def reciprocity() -> float:
    """Relative difference of gamma a between both ways, of two orders of a random layer."""
    waves = _random(1.4)
    there = waves.scatter((0, 0), 1e-12).up[0, 3] * waves.above[0, 3]
    back = waves.scatter((0, -3), 1e-12).up[0, 0] * waves.above[0, 0]
    return float(abs(there - back) / abs(there))


def _random(index) -> Waves:
    chance = np.random.default_rng(0).random((20, 32, 32)) < 0.3
    grid = np.where(chance, complex(index) ** 2, BINDER**2 + 0j)
    return Waves(Cell(grid, 2.0, 1.0), WAVELENGTH, background=BINDER**2)


def _slab(index: complex, angle: float):
    tangential = 2.0 * np.pi / WAVELENGTH * np.sin(np.radians(angle))
    cell = Cell(np.full((8, 2, 2), index**2), 1.0, 1.0)
    out = Waves(cell, WAVELENGTH, (tangential, 0.0)).scatter(tolerance=1e-12)
    return [out.reflected[0, 0], out.transmitted[0, 0]]


@lru_cache
def _stack(layers: int):
    place = (np.arange(layers) + 0.5) / layers
    absorbs = ((place > 0.4) & (place < 0.7))[:, None, None]
    grid = np.where(absorbs, (1.4 + 0.1j) ** 2, BINDER**2 + 0j) * np.ones((1, 2, 2))
    out = Waves(Cell(grid, 1.0, 1.0), WAVELENGTH, background=BINDER**2).scatter(tolerance=1e-11)
    return [float(out.reflected.sum()), float(out.transmitted.sum())]


def _amplitude_of_cell(index: complex) -> complex:
    width, diameter, height = 2.4, 0.3, 0.6
    population = Population(np.pi / 6.0 * diameter**3 / (width**2 * height), diameter)
    one = Packing(
        np.array([[1.2, 1.2, 0.3]]), np.array([[0.0, 0.0, 1.0]]), np.array([diameter]), np.zeros(1, int),
        (population,), width, height, 0,
    )  # fmt: skip
    share = fill_shares(one, (24, 96))[0]
    cell = Cell(BINDER**2 + share * (index**2 - BINDER**2), width, height, BINDER, BINDER)
    out = Waves(cell, WAVELENGTH, background=BINDER**2).scatter(tolerance=1e-6)
    k = 2.0 * np.pi / WAVELENGTH * BINDER
    through = np.exp(1j * k * height)
    return complex((out.down[0, 0] - through) / through * k * width**2 / (2j * np.pi))


def _ink(share: float, median: float, absorption: float, reflectance: float = 0.9):
    pigment = {
        "index": {"wavelengths_nm": [400, 700], "n": [1.4, 1.4], "k": [absorption, absorption]},
        "volume_fraction": share,
        "median_um": median,
    }
    return parse_ink(
        {
            "lumenray_ink": 1,
            "name": "reference",
            "thickness_um": 1.0,
            "thickness_spread": 0.0,
            "binder": {"index": BINDER},
            "pigments": [pigment] if share else [],
            "substrate": {"reflectance": reflectance},
        }
    )


def _on_paper(ink, is_furnace: bool):
    plan = replace(make_plan(ink), wavelengths=(550.0,), realisations=2)
    units = {(k, 0): solve_unit(ink, plan, k, 0) for k in range(2)}
    film = analyse(ink, plan, Ensemble(units, {}, 2), range(2))
    printed = Printed(ink, plan.wavelengths, film, 2, count=200, is_scalar=True)
    total = float((printed.albedo([0.0]) + printed.mirror([0.0]))[0, 0])
    if is_furnace:
        return [total]
    up = np.array([[0.0, 0.0, 1.0]])
    back, passed = (float(each[0]) for each in printed.hemispherical)
    return [back, passed, float(printed.evaluate(up, up)[0, 0]), total]


def _layer(share: float, diameter: float, absorption: float, seed: int):
    """Reflected, transmitted, absorbed and diffusely transmitted share."""
    packing = pack([Population(share, diameter)], 4.0, 1.0, seed)
    filled = fill_shares(packing, (40, 128))[0]
    grid = BINDER**2 + filled * ((1.4 + 1j * absorption) ** 2 - BINDER**2)
    out = Waves(Cell(grid, 4.0, 1.0), WAVELENGTH).scatter(tolerance=1e-3)
    back, passed = out.reflected.sum(), out.transmitted.sum()
    return [back, passed, 1.0 - back - passed, passed - out.transmitted[0, 0]]


def _dilute():
    diameter, width, height = 0.3, 4.0, 2.0
    share = entries()["C10.dilute"]["share"]
    sent = []
    for seed in range(DILUTE):
        packing = pack([Population(share, diameter)], width, height, seed)
        filled = fill_shares(packing, (64, 128))[0]
        grid = BINDER**2 + filled * (1.4**2 - BINDER**2) + 0j
        cell = Cell(grid, width, height, BINDER, BINDER)
        sent.append(
            Waves(cell, WAVELENGTH, background=BINDER**2).scatter(tolerance=1e-4).down[0, 0]
        )
    size = np.pi * diameter * BINDER / WAVELENGTH
    alone = 1.5 * share / diameter * scalar_efficiencies(size, 1.4 / BINDER)[0] * height
    return [-np.log(abs(np.mean(sent)) ** 2), alone]
