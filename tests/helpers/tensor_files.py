"""Tensor files like those of real measurements: with a density of visible facets, one to many azimuths, and noise."""

import numpy as np

from lumenray.engine.scattering.readers.tensor_file import pack_fields


def visible_facets(half, wi, roughness):
    """Density of the facets of a rough surface (Trowbridge and Reitz) that are seen from a direction. [1/sr]"""
    across, aside = roughness
    slope = (half[:, 0] / across) ** 2 + (half[:, 1] / aside) ** 2 + half[:, 2] ** 2
    facets = 1.0 / (np.pi * across * aside * slope**2)
    tilt = ((wi[0] * across) ** 2 + (wi[1] * aside) ** 2) / wi[2] ** 2
    shown = 2.0 / (1.0 + np.sqrt(1.0 + tilt))
    return shown * np.maximum(half @ wi, 0.0) * facets / wi[2]


def measured_like(
    azimuths=(0.0,),
    incidences=(0.05, 0.4, 0.8, 1.2, 1.5),
    wavelengths=(400.0, 500.0, 550.0, 700.0),
    roughness=(0.3, 0.3),
    side=16,
    is_rgb=False,
    without=(),
    **instead,
) -> bytes:
    """A file whose arrays all vary; fields may be left out, or given instead.

    Both sides of the plane of incidence of isotropic ones are alike: Mitsuba 3.9.1 leaves it to chance whether it turns
    those over, as it never sets into how many parts their turn falls.
    """
    rng = np.random.default_rng(7)
    rows, columns = 24, 20
    u, v = np.meshgrid(np.linspace(0.0, 1.0, columns), np.linspace(0.0, 1.0, rows))
    polar, turn = 0.5 * np.pi * u.ravel() ** 2, (2.0 * v.ravel() - 1.0) * np.pi
    half = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], 1)
    density = np.zeros((len(azimuths), len(incidences), rows, columns))
    for i, phi in enumerate(azimuths):
        for k, theta in enumerate(incidences):
            turned = 0.0 if len(azimuths) <= 2 else phi
            wi = np.array(
                [np.sin(theta) * np.cos(turned), np.sin(theta) * np.sin(turned), np.cos(theta)]
            )
            seen = visible_facets(half, wi, roughness) * u.ravel() * np.sin(polar)
            density[i, k] = (seen + 1e-3 * seen.max()).reshape(rows, columns)
    shape = (len(azimuths), len(incidences), 3 if is_rgb else len(wavelengths), side, side)
    fields = {
        "description": np.frombuffer(b"made for tests", np.uint8),
        "jacobian": np.ones(1, np.uint8),
        "phi_i": np.asarray(azimuths),
        "theta_i": np.asarray(incidences),
        "ndf": rng.uniform(0.5, 2.0, (9, 12)),
        "sigma": rng.uniform(0.5, 1.0, (8, 10)),
        "vndf": density,
        "luminance": rng.uniform(0.5, 2.0, (*shape[:2], side, side)),
        "rgb" if is_rgb else "spectra": rng.uniform(0.1, 1.0, shape),
    }
    if not is_rgb:
        fields["wavelengths"] = np.asarray(wavelengths)
    if len(azimuths) <= 2:
        for name in ("rgb" if is_rgb else "spectra", "ndf"):
            axis = fields[name].ndim - 2
            fields[name] = 0.5 * (fields[name] + np.flip(fields[name], axis))
        fields["sigma"] = np.broadcast_to(fields["sigma"][:1], (8, 10))
    fields |= {name: np.asarray(values) for name, values in instead.items()}
    return pack_fields({name: values for name, values in fields.items() if name not in without})
