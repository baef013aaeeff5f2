"""Daylight coefficients of sensors that see a part of everything alike, whose illuminances are known."""

import numpy as np

from lumenray.engine.daylight.coefficients import DaylightCoefficients, gather_suns
from lumenray.engine.scene.provenance import Provenance
from lumenray.engine.sky.nodes import SkyNodes, find_projection

GROUPS = 10

PROVENANCE = Provenance("0", "llvm_ad_rgb", "", 0, 0, 0.0)


def open_coefficients(year, factors=(1.0,), noise=0.0, seed=0, suns=None):
    """Horizontal sensors that see a part of everything alike, with noise by group."""
    projection = find_projection(year.steps)
    rng = np.random.default_rng(seed)
    suns = year.suns if suns is None else suns
    facing = projection.directions[:, 2] * projection.areas
    nodes = facing @ SkyNodes(year.steps).spread(projection.directions)
    count = len(factors)
    share = np.array(factors) * (1.0 + noise * rng.standard_normal((GROUPS, count)))
    sky = np.append(nodes, 0.0) * share[..., None]
    middles, neighbours, shares = gather_suns(suns, 3.0)
    many = len(middles)
    return DaylightCoefficients(
        year.steps,
        sky.astype(np.float32),
        np.zeros((GROUPS, count, many), np.float32),
        np.zeros((2, count, many), np.float32),
        np.zeros(count, np.float32),
        (np.maximum(suns[:, 2], 0.0) * np.array(factors)[:, None]).astype(np.float32),
        np.zeros((count, len(suns)), np.float32),
        neighbours,
        shares,
        GROUPS,
        0,
        PROVENANCE,
    )
