"""A goniometer: reflectance and transmittance of a surface for light from given directions, by sampling its model.

Surface models state how radiance is scattered on the way from the eye to the light. By reciprocity the same samples give
what becomes of light that arrives from there: as a share of energy they are taken times the square of the relative index
that they pass to, by which radiance is denser in a denser body.

References
----------
E. Veach: Robust Monte Carlo Methods for Light Transport Simulation, 1997, 5.2 (non-symmetric scattering by refraction).
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ..accuracy.estimate import Accumulator, Estimate
from ..arrays import average
from ..errors import Cancelled, SceneError
from ..materials import plugins
from ..photometry.spectra import GRID
from ..photometry.units import MAXIMUM_WAVELENGTH, MINIMUM_WAVELENGTH
from ..requirements.facts import pictures
from ..scattering.kernels import plugin as scattering_plugin
from ..scene.material import Material
from .compiled.surfaces import bsdf
from .compiled.textures import TextureMaker, is_spectral
from .paths.sampler import hash_words, sobol_pair

GROUPS = 64
"""Independent groups of samples. Which of two ways light goes is counted in whole samples; where all groups count the same,
what they hide is less than one sample of all."""

LANES = 1 << 19
"""Samples per launch."""

SEED_STEP = 0x9E3779B1
"""Between the seeds of neighbouring angles, whose errors are then independent."""

PAIR_LOBE, PAIR_DIRECTION = range(2)
"""Which pair of the low-discrepancy sequence serves what."""


def check(surface, angles, samples: int, wavelength: float) -> None:
    """Refuse what a goniometer cannot answer.

    Raises
    ------
    SceneError    The surface differs from place to place, or a number is not usable.
    """
    if any(True for _ in pictures(Material("probe", "probe", surface))):
        raise SceneError("a surface with pictures differs from place to place and cannot be probed")
    if angles is not None:
        bad = ~((angles >= 0.0) & (angles <= 180.0) & (angles != 90.0))
        if bad.any():
            raise SceneError(
                f"light cannot arrive at {angles[bad][0]:g} degrees: expected 0 to 180, and not along the surface"
            )
    if not samples > 0:
        raise SceneError(f"a probe of {samples} samples says nothing, expected a number above 0")
    if not MINIMUM_WAVELENGTH <= wavelength <= MAXIMUM_WAVELENGTH:
        raise SceneError(
            f"surfaces are known from {MINIMUM_WAVELENGTH:g} to {MAXIMUM_WAVELENGTH:g} nm, not at {wavelength:g} nm"
        )


def measure(
    surface, angles, samples: int, seed: int, wavelength: float, cancelled=lambda: False
) -> tuple[Estimate, Estimate]:
    """Shares of light that a surface reflects and transmits, in the active variant.

    Parameters
    ----------
    surface : Surface    Without pictures.
    angles : (n,) float64 array or None
        Between the normal and the direction that light comes from; above 90 it comes from behind, which for a solid
        body is inside. None: even light from the front hemisphere, one value. [deg]
    samples : int    Per angle, at least.
    wavelength : float    [nm]

    Returns
    -------
    (Estimate, Estimate)    Of reflectance and transmittance, (n,) each. [-]

    Raises
    ------
    Cancelled    When ``cancelled`` answered true.
    """
    plugins.register()
    scattering_plugin.register()
    made = bsdf(surface, TextureMaker(np.ones(len(GRID))))
    model = mi.load_dict(made) if isinstance(made, dict) else made
    count = 1 if angles is None else len(angles)
    # Powers of two keep the sequence's strata whole.
    wanted = 1 << int(np.ceil(np.log2(max(samples / GROUPS, 1.0))))
    batch = min(wanted, LANES // GROUPS)
    reflected, transmitted = Accumulator(GROUPS, count), Accumulator(GROUPS, count)
    while reflected.samples < wanted:
        sums = np.zeros((2, GROUPS, count))
        for place in range(count):
            if cancelled():
                raise Cancelled("cancelled")
            angle = None if angles is None else float(np.radians(angles[place]))
            own_seed = (seed + place * SEED_STEP) & 0xFFFFFFFF
            sums[:, :, place] = _launch(
                model, angle, batch, reflected.samples, own_seed, wavelength
            )
        reflected.add(sums[0], batch)
        transmitted.add(sums[1], batch)
    return reflected.estimate(), transmitted.estimate()


def _launch(model, angle, batch: int, start: int, seed: int, wavelength: float) -> np.ndarray:
    """Sums of both shares over new samples, (2, groups)."""
    lane = dr.arange(mi.UInt32, GROUPS * batch)
    index = dr.opaque(mi.UInt32, start) + lane % batch
    own = hash_words(lane // batch, dr.opaque(mi.UInt32, seed))
    si = dr.zeros(mi.SurfaceInteraction3f, GROUPS * batch)
    si.n, si.sh_frame = mi.Normal3f(0, 0, 1), mi.Frame3f(mi.Normal3f(0, 0, 1))
    if is_spectral():
        si.wavelengths = mi.Spectrum(dr.opaque(mi.Float, float(wavelength)))
    lobe = sobol_pair(index, own, PAIR_LOBE)
    if angle is None:
        # No surface knows its azimuth, so one number draws the cosine-distributed direction.
        sine, cosine = dr.sqrt(lobe.y), dr.sqrt(1.0 - lobe.y)
    else:
        width = GROUPS * batch
        sine, cosine = (dr.opaque(mi.Float, float(f(angle)), width) for f in (np.sin, np.cos))
    si.wi = mi.Vector3f(sine, 0.0, cosine)
    direction = sobol_pair(index, own, PAIR_DIRECTION)
    sample, weight = model.sample(mi.BSDFContext(), si, lobe.x, direction, mi.Bool(True))
    energy = average(weight) * dr.square(sample.eta)
    goes_back = sample.wo.z * si.wi.z > 0.0
    shares = (dr.select(goes_back, energy, 0.0), dr.select(goes_back, 0.0, energy))
    return np.array(
        [np.array(dr.block_reduce(dr.ReduceOp.Add, share, batch)) for share in shares],
        dtype=np.float64,
    )
