"""Measured materials as kernels of the engine."""

import numpy as np


def start_backend(spectral: bool) -> None:
    """Start Mitsuba, and make our plug-in known to it."""
    from ...engine.scattering.kernels import plugin
    from ...engine.transport import backend

    backend.start(spectral=spectral)
    plugin.register()


def make_plugin(table):
    """Return the BSDF of a table, alike on both sides."""
    from ...engine.scene.material import Measured
    from ...engine.transport.compiled.surfaces import bsdf
    from ...engine.transport.compiled.textures import TextureMaker

    return bsdf(Measured(table, table), TextureMaker(np.ones(471)))


def weigh_by_eye(values, wavelengths):
    """Sum over the bands by the eye at equal energy, as photometric kernels take them here."""
    from ...engine.transport.compiled.textures import TextureMaker

    return TextureMaker(np.ones(471)).weigh(values, wavelengths)[..., 0]
