"""Size and error of tables made of materials that are known exactly."""

import time
from pathlib import Path

import numpy as np

from ...engine.scattering.data.evaluation import albedo, evaluate, measure_reciprocity
from ...engine.scattering.data.record import ScatteringFile
from ...engine.scattering.data.store import pack
from ...engine.scattering.data.table import direction_of, place_on
from .models import MATERIALS, cosine_directions, table_of

TOLERANCES = (0.05, 0.02, 0.01)
"""Errors that tables are made with."""

ANGLES = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0)
"""Of incidence, of the table that sampling is measured on. [deg]"""


def measure_storage(told) -> list[dict]:
    """Size and error of tables made of materials that are known exactly."""
    rows = []
    for name, (exact, wavelengths, _) in MATERIALS.items():
        for tolerance in TOLERANCES:
            start = time.perf_counter()
            table = table_of(name, tolerance)
            seconds = time.perf_counter() - start
            content = pack(ScatteringFile(Path(name), "", {"front_reflection": table}))
            rows.append(
                {
                    "material": name,
                    "tolerance": tolerance,
                    "shape": list(table.values.shape),
                    "bytes": len(content),
                    "stated": table.error,
                    "measured": _error_of(table, exact, wavelengths),
                    "albedo": _albedo_error(table, exact, wavelengths),
                    "reciprocity": measure_reciprocity(table).residual,
                    "seconds": seconds,
                }
            )
            told(f"{name}, {100 * tolerance:g} %: {len(content)} bytes")
    return rows


def _error_of(table, exact, wavelengths) -> float:
    """Error of a table over other pairs of directions than those that its stated error is of."""
    rng = np.random.default_rng(99)
    wi, spread = (cosine_directions(rng.random((2, 20_000))) for _ in range(2))
    wi = wi[wi[:, 2] > np.cos(np.radians(80.0))]
    spread = spread[: len(wi)]
    near = wi * [-1.0, -1.0, 1.0] + 0.2 * rng.normal(size=wi.shape) * rng.random((len(wi), 1))
    near /= np.linalg.norm(near, axis=1, keepdims=True)
    wo = np.where(np.arange(len(wi))[:, None] % 2 == 0, near, spread)
    above = wo[:, 2] > 0.05
    wi, wo = wi[above], wo[above]
    true = exact(wi, wo)
    floor = 0.05 * max(albedo(table, s).max() for s in table.incidences) / np.pi
    made = evaluate(table, wi, wo)
    if made.shape[1] > 1:
        below, share = place_on(table.wavelengths, wavelengths)
        made = made[:, below] * (1.0 - share) + made[:, below + 1] * share
    relative = (made - true) / (true + floor)
    return float(np.sqrt((relative**2).mean()))


def _at_bands(values, wavelengths, bands):
    """Values at those of the wavelengths that a table kept."""
    if values.shape[1] == 1:
        return values
    return values[:, np.searchsorted(wavelengths, bands)]


def _albedo_error(table, exact, wavelengths) -> float:
    """Largest relative error of the reflectance at the angles of `ANGLES`, by quadrature over 600 x 400 directions."""
    radial = (np.arange(600) + 0.5) / 600
    worst = 0.0
    for angle in ANGLES:
        s = np.radians(angle)
        # Points crowd about the mirror direction, where lobes are.
        polar = 0.5 * np.pi * radial**2
        turn = (np.arange(400) + 0.5) / 400 * 2.0 * np.pi
        t, a = (m.ravel() for m in np.meshgrid(polar * 2.0, turn, indexing="ij"))
        weight = np.sin(t) * 2.0 * np.pi * radial.repeat(400) / 600 * (2.0 * np.pi / 400)
        wo = direction_of(np.full_like(t, s), t, a)
        above = wo[:, 2] > 0.0
        wi = np.broadcast_to([np.sin(s), 0.0, np.cos(s)], wo.shape)
        f = _at_bands(exact(wi[above], wo[above]), wavelengths, table.wavelengths)
        true = ((weight * wo[:, 2])[above]) @ f
        worst = max(worst, float(np.abs(albedo(table, s) / true - 1.0).max()))
    return worst
