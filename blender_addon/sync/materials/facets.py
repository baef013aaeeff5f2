"""What is lost where rough facets shade and mask each other, as light that bounces between them is not followed.

References
----------
E. Heitz: Sampling the GGX Distribution of Visible Normals, Journal of Computer Graphics Techniques 7, 2018.
"""

from functools import cache

import numpy as np

SAMPLES = 64
"""Of each of three numbers, evenly spread."""

LITTLE, MUCH = 0.01, 0.05
"""Losses below which nothing is said, and from which on it is a warning. [-]"""

NAMES = {"BECKMANN": "Beckmann", "ASHIKHMIN_SHIRLEY": "Ashikhmin-Shirley"}


@cache
def facet_loss(roughness: float) -> float:
    """Share of even light from all sides that facets of GGX lose if they reflect everything once. [-]

    ``roughness``: as Blender has it, whose square is the slopes' width.
    """
    alpha = max(roughness, 1e-4) ** 2
    even = (np.arange(SAMPLES) + 0.5) / SAMPLES
    cosine, u, v = np.meshgrid(np.sqrt(even), even, even, indexing="ij")
    sine = np.sqrt(1.0 - cosine**2)
    # Facets as they are seen from the direction (sine, 0, cosine).
    x, z = alpha * sine, cosine
    x, z = x / np.hypot(x, z), z / np.hypot(x, z)
    radius, angle = np.sqrt(u), 2.0 * np.pi * v
    a, b = radius * np.cos(angle), radius * np.sin(angle)
    s = 0.5 * (1.0 + z)
    # a lies across the plane of incidence, b within it.
    b = (1.0 - s) * np.sqrt(1.0 - a**2) + s * b
    c = np.sqrt(np.maximum(1.0 - a**2 - b**2, 0.0))
    normal = np.stack([-b * z + c * x, a, b * x + c * z])
    normal[:2] *= alpha
    normal[2] = np.maximum(normal[2], 1e-9)
    normal /= np.linalg.norm(normal, axis=0)
    facing = normal[0] * sine + normal[2] * cosine
    out = 2.0 * facing * normal[2] - cosine
    return 1.0 - float(np.mean(np.where(out > 0.0, _kept(cosine, out, alpha), 0.0)))


def _kept(cosine, out, alpha):
    """Share of what one facet sends out that no other one stops: masking with shadowing over masking alone."""
    a, b = (
        np.sqrt(1.0 + alpha**2 * (1.0 - c**2) / np.maximum(c, 1e-9) ** 2) for c in (cosine, out)
    )
    return (1.0 + a) / (a + b)


def report_facets(at, roughness) -> None:
    """Say where facets are others than Blender's, or lose light that its own keep. ``roughness``: a field."""
    if roughness.is_everywhere(0):
        return
    chosen = getattr(at.node, "distribution", "MULTI_GGX")
    if chosen in NAMES:
        at.note(f"Facets are distributed by {NAMES[chosen]}", "GGX is used")
    if chosen != "MULTI_GGX":
        return
    loss = facet_loss(round(float(np.clip(roughness.limits()[1], 0.0, 1.0)), 2))
    if loss < LITTLE:
        return
    say = at.note if loss > MUCH else at.remark
    say(
        "Light that rough facets pass on to each other is not computed",
        f"up to {100.0 * loss:.2g} % of what they reflect is lost",
    )
