"""Random compositions: the solution against photons, the table against the solution, energy and reciprocity."""

import copy

import numpy as np

from ...engine.paint.explicit_flakes import walk_among_discs
from ...engine.paint.photon_walk import RINGS, walk
from ...engine.paint.reader import parse_paint
from ...engine.paint.solution import Resolution, solve
from ...engine.paint.tabulation import FLOOR, compute, random_directions
from ...engine.scattering.data.table import evaluate_table
from .makers import make_paint, mirrors

COMPOSITIONS = 30

PHOTONS, DISC_PHOTONS = 60_000, 8_000

SIGMAS = 4.0
"""Standard errors beyond which a difference is one: of nearly 500 shares about one in thirty runs has such."""

PLACES = 24
"""Places of Gauss and Legendre by which a solution is integrated over each ring of exit, and over the azimuth."""

WAVELENGTH = 550.0

TABLES, PAIRS = 4, 10_000
"""Compositions of which tables are judged, and pairs of directions for that."""


def random_paint(rng, is_thin: bool = False):
    """A paint of one or two layers; a thin one has few flakes, with diameters, so that hardly any shadows another."""

    def layer(index):
        flakes = []
        for _ in range(1 if is_thin else rng.integers(1, 3)):
            tilt = float(rng.uniform(4.0, 15.0))
            if is_thin or rng.random() < 0.5:
                share = float(rng.uniform(0.3, 0.95))
                flakes.append(mirrors(share, tilt, 0.0, float(rng.uniform(0.0, 1.0 - share))))
            else:
                stack = {
                    "core": {
                        "index": float(rng.uniform(1.45, 1.8)),
                        "thickness_nm": float(rng.uniform(150, 500)),
                    },
                    "coatings": [{"index": 2.5, "thickness_nm": float(rng.uniform(20, 120))}],
                }
                flakes.append({"stack": stack, "tilt_deg": tilt})
            area = rng.uniform(0.002, 0.006) if is_thin else rng.uniform(0.01, 0.08)
            flakes[-1]["amount"] = {"area_per_volume_per_um": float(area)}
            if is_thin:
                flakes[-1]["diameter"] = {"median_um": float(rng.uniform(2.0, 10.0))}
        grains = []
        if rng.random() < 0.5:
            medium = {
                "extinction_per_um": float(rng.uniform(0.005, 0.1)),
                "albedo": float(rng.uniform(0.3, 1.0)),
                "asymmetry": float(rng.uniform(-0.2, 0.8)),
            }
            grains = [{"medium": medium}]
        return float(rng.uniform(10, 30)), flakes, grains, index

    first = float(rng.uniform(1.4, 1.6))
    layers = [layer(first)]
    if not is_thin and rng.random() < 0.5:
        layers.append(layer(first if rng.random() < 0.5 else float(rng.uniform(1.4, 1.6))))
    return make_paint(layers, float(rng.uniform(0.0, 0.8)))


def ring_shares(solution, incidence: float) -> np.ndarray:
    """Shares of light by ring of exit, forward, then backward, as of `photon_walk.RINGS`. (8,)"""
    x, weight = np.polynomial.legendre.leggauss(PLACES)
    x, weight = 0.5 * (x + 1.0), 0.5 * weight
    shares = []
    for is_back in (False, True):
        for low, high in zip(RINGS[:-1], RINGS[1:], strict=True):
            # By the cosine: towards grazing the sine crowds.
            first, last = np.sqrt(1.0 - high**2), np.sqrt(1.0 - low**2)
            cosine, turn = np.meshgrid(
                first + (last - first) * x, np.pi * (0.5 * x + 0.5 * is_back)
            )
            sine = np.sqrt(1.0 - cosine**2)
            wo = np.stack([-sine * np.cos(turn), sine * np.sin(turn), cosine], axis=-1).reshape(
                -1, 3
            )
            wi = np.tile([np.sin(incidence), 0.0, np.cos(incidence)], (len(wo), 1))
            area = np.outer(weight * np.pi, weight * (last - first)).ravel()
            shares.append((solution.evaluate(wi, wo)[:, 0] * wo[:, 2] * area).sum())
    # Photons are counted towards +x, which is forward; azimuths of one half stand for both.
    return np.array(shares)


def measure(say) -> dict:
    """Differences by both kinds of Monte Carlo, and what tables lose."""
    found = {}
    for name, is_thin in (("continuum", False), ("discs", True)):
        rng = np.random.default_rng(32)
        rows = []
        for number in range(COMPOSITIONS):
            paint = random_paint(rng, is_thin)
            incidence = float(rng.uniform(0.0, np.radians(60.0)))
            solution = solve(paint, [WAVELENGTH], is_polarised=False, resolution=Resolution(32, 32))
            if is_thin:
                made = walk_among_discs(paint, WAVELENGTH, incidence, DISC_PHOTONS, number)
            else:
                made = walk(paint, WAVELENGTH, incidence, PHOTONS, number)
            shares = ring_shares(solution, incidence)
            albedo = float(solution.albedo([np.sin(incidence)])[0, 0])
            counted = made.shares * made.photons > 30.0
            away = np.abs(shares - made.shares)[counted] / np.maximum(made.errors, 1e-9)[counted]
            rows.append(
                {
                    "albedo": albedo,
                    "walked": made.albedo,
                    "error": made.error,
                    "sigmas": abs(albedo - made.albedo) / made.error,
                    "ring_sigmas": float(away.max(initial=0.0)),
                    "rings": int(counted.sum()),
                    "ring_square": float((away**2).sum()),
                    "kept": made.albedo + made.absorbed + made.mirrored,
                }
            )
        say(f"{name}: {sum(row['sigmas'] > SIGMAS for row in rows)} of {COMPOSITIONS} apart")
        found[name] = rows
    return found


def measure_tables(say) -> list[dict]:
    """Tables of the random compositions' first: T1 to T5."""
    rng = np.random.default_rng(32)
    rows = []
    for _ in range(TABLES):
        paint = random_paint(rng)
        made = compute(paint, [450.0, 550.0, 650.0])
        pairs = random_directions(rng, PAIRS), random_directions(rng, PAIRS)
        direct = made.solution.evaluate(*pairs)
        away = (evaluate_table(made.table, *pairs) - direct) / (direct + FLOOR)
        rows.append(
            {
                "table_error": float(np.sqrt((away**2).mean())),
                "reciprocity": made.reciprocity,
                "inner_reciprocity": made.inner_reciprocity,
                "clamped": made.clamped,
                "energy": made.energy,
                "furnace": _furnace_loss(paint),
                "convergence": made.convergence,
            }
        )
    say("tables")
    return rows


def _furnace_loss(paint) -> float:
    """Largest share of light that a paint loses once nothing in it absorbs."""
    content = copy.deepcopy(paint.content)
    content["substrate"] = {"reflectance": 1.0}
    for layer in content["layers"]:
        for each in layer["flakes"]:
            if "mirror" in each:
                each["mirror"]["transmittance"] = 1.0 - each["mirror"]["reflectance"]
        for each in layer["pigments"]:
            each["medium"]["albedo"] = 1.0
    solution = solve(parse_paint(content), [450.0, 550.0, 650.0])
    sines = np.sin(np.radians(np.arange(0.0, 81.0, 5.0)))
    return float(np.abs(solution.albedo(sines) + solution.mirror(sines) - 1.0).max())
