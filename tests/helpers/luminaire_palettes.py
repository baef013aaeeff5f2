"""Palettes of luminaires in kernels, and what is seen of their openings."""

import numpy as np
from luminaires import opening_axes, opening_pieces

from lumenray.engine.photometry.spectra import photometric_density
from lumenray.engine.scene.distribution import SHAPES

CENTRE = np.array([0.3, -0.2, 0.4])


def palette_of(lights):
    """Palette that holds luminaires, row by row as they are given."""
    from lumenray.engine.luminaires.emitters.palette import LuminairePalette, Row
    from lumenray.engine.luminaires.emitters.tables import distribution_digest

    made = LuminairePalette()
    rows = []
    for light in lights:
        rotation = light.frame[:3, :3]
        axes, half = opening_axes(light.opening)
        rows.append(
            Row(
                light.distribution,
                distribution_digest(light.distribution),
                rotation @ light.distribution.frame,
                SHAPES.index(light.opening.shape),
                rotation @ axes,
                half,
                light.frame[:3, 3],
                light.output.value,
                photometric_density(light.output.spectrum),
            )
        )
    made.commit(rows)
    return made


def interaction(position):
    """Interaction at one place, as data. (3,)"""
    import drjit as dr
    import mitsuba as mi

    made = dr.zeros(mi.Interaction3f)
    made.p = mi.Point3f(*(dr.opaque(mi.Float, float(x)) for x in position))
    return made


def visible(light, place, count=320):
    """Directions from a place to points all over the side of an opening that it sees, and the solid angle of each."""
    rotation = light.frame[:3, :3]
    directions, angles = [], []
    if light.opening.shape == "box":
        count //= 2
    for points, elements in opening_pieces(light.opening, count, is_scattered=True):
        towards = points @ rotation.T + CENTRE - place
        distance = np.linalg.norm(towards, axis=1)
        towards /= distance[:, None]
        seen = -((elements @ rotation.T) * towards).sum(axis=1)
        use = seen > 0.0
        directions.append(towards[use])
        angles.append((seen / distance**2)[use] / len(points))
    return np.concatenate(directions), np.concatenate(angles)
