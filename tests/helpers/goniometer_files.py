"""Texts of goniometers, made from a function of two directions."""

import numpy as np
from scattering_models import towards

from lumenray.engine.scattering.data.table import direction_of

COLOURS = np.array([1.0, 0.8, 0.5])
"""Of the bands."""

NAMES = "450 550nm 650"

POLARS = np.arange(0.0, 86.0, 5.0)

AZIMUTHS = np.arange(0.0, 181.0, 15.0)

SIGNED = np.arange(-85.0, 86.0, 2.5)

RADIALS = np.array([0, 2, 4, 6, 8, 10, 13, 16, 20, 25, 30, 40, 50, 65, 80, 100, 130.0])


def lobe(wi, wo, matt=0.1, width=15.0):
    """A matt surface with a lobe about the mirror direction. (n,) [1/sr]"""
    away = np.arccos(np.clip((wi * [-1.0, -1.0, 1.0] * wo).sum(axis=-1), -1.0, 1.0))
    return matt + 0.5 * np.exp(-0.5 * (away / np.radians(width)) ** 2)


def grid(*axes):
    """All combinations, flat."""
    return [axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")]


def write(head, names, columns, order=None, mark=" ") -> bytes:
    """A text of lines of a head, names of columns, and rows of numbers."""
    rows = np.column_stack(columns)
    rows = rows if order is None else rows[order]
    body = [mark.join(f"{value:.9g}" for value in row) for row in rows]
    return "\n".join([*head, mark.join(names.split()), *body, ""]).encode()


def about_normal(
    f, incidences=(0, 20, 40, 60), rotations=(0,), polars=POLARS, azimuths=AZIMUTHS,
    quantity="brdf", factor=1.0, order=None, more=(),
) -> bytes:  # fmt: skip
    """Our layout about the normal; ``factor`` on the values; ``azimuths`` count from the light's."""
    theta_i, phi_i, theta_o, turn = grid(incidences, rotations, polars, azimuths)
    wi, wo = towards(theta_i, phi_i), towards(theta_o, phi_i + turn)
    values = (f(wi, wo) * factor)[:, None] * COLOURS
    head = ["# lumenray goniometer 1", *([f"# quantity: {quantity}"] if quantity else []), *more]
    names = f"theta_i phi_i theta_o phi_o {NAMES}"
    return write(head, names, [theta_i, phi_i, theta_o, (phi_i + turn) % 360.0, values], order)


def about_mirror(
    f, incidences=(0, 20, 40, 60), rotations=(0,), radials=RADIALS, azimuths=AZIMUTHS,
    share=1.0, more=(),
) -> bytes:  # fmt: skip
    """Our layout about the mirror direction, in random order, of a share of the directions above the horizon."""
    sigma, psi, theta, phi = grid(incidences, rotations, radials, azimuths)
    level = direction_of(*np.radians([sigma, theta, phi]))
    cos_p, sin_p = np.cos(np.radians(psi)), np.sin(np.radians(psi))
    x, y, z = level.T
    wo = np.stack([cos_p * x - sin_p * y, sin_p * x + cos_p * y, z], axis=1)
    values = f(towards(sigma, psi), wo)[:, None] * COLOURS
    rng = np.random.default_rng(4)
    kept = rng.permutation(np.flatnonzero((z > 0.05) & (rng.random(len(z)) < share)))
    head = ["# lumenray goniometer 1", "# quantity: brdf", "# angles: specular", *more]
    return write(head, f"sigma psi theta phi {NAMES}", [sigma, psi, theta, phi, values], kept)


def in_plane(f, incidences=(10, 30, 50, 70), angles=SIGNED, mark=",", head=(), sign=1.0):
    """A table of one plane: names and rows alone."""
    theta, signed = grid(incidences, angles)
    values = f(towards(theta, 0.0), towards(signed, 180.0))[:, None] * COLOURS
    return write(
        head,
        "Incident_angle Measure_angle 450nm 550nm 650nm",
        [theta, sign * signed, values],
        mark=mark,
    )


def e1392(f, in_degrees=False, stated=None) -> bytes:
    """A text like those of ASTM E1392, unordered."""
    theta_i, theta_o, phi_o = grid(
        (10.0, 50.0), np.arange(0.0, 81.0, 10.0), np.arange(0.0, 360.0, 30.0)
    )
    values = f(towards(theta_i, 0.0), towards(theta_o, phi_o))[:, None] * COLOURS
    scale = 1.0 if in_degrees else np.pi / 180.0
    angles = [scale * angle for angle in (theta_i, 0.0 * theta_i, theta_o, phi_o)]
    order = np.random.default_rng(6).permutation(len(theta_i))
    rows = np.column_stack([*angles, values])[order]
    head = f"MATERIAL test\nNUM_POINTS {stated or len(rows)}\nVARS theta_i,phi_i,theta_s,phi_s,450nm,550nm,650nm\n"
    return (head + "".join(",".join(f"{v:.9g}" for v in row) + "\n" for row in rows)).encode()
