"""The mean spectrum of a scene's lights."""

import numpy as np

from ...photometry.spectra import GRID, illuminant
from ...scene.light import FormulaSky, ImageWorld, UniformWorld
from . import emission


def find_mean_light(
    world, world_luminance: float, sources, suns, radius: float, seen=()
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Flux-weighted mean spectrum of the scene's lights on the 1 nm grid, sum 1 (471,); and all that differ.

    Only the proportions of lamps matter here (they steer sampling and photometric reflectances), so emitters whose
    flux depends on the scene around them (world, sun) are weighed by the flux through the scene's bounds.

    Parameters
    ----------
    world : World or None
    world_luminance : float    Mean over all directions, without its suns. [cd/m2]
    sources : list of Source
    suns : list of SunLight
    radius : float    Of the scene. [m]
    seen : list of Source    What glows for the camera alone; it counts, as its surroundings do, where there is no light.
    """
    disk = np.pi * max(radius, 1.0) ** 2
    total = np.zeros(len(GRID))
    shining = [(source.density, source.flux) for source in sources]
    shining += [(m.density, m.amount * disk) for m in map(emission.sun_illuminance, suns)]
    is_pictured = isinstance(world, ImageWorld) and world.luminance_per_unit > 0.0
    is_pictured |= world is not None and world.photo is not None
    if world_luminance > 0.0 and not is_pictured:
        made = emission.luminous(world_luminance, world.spectrum)
        shining.append((made.density, made.amount * np.pi * 4.0 * disk))
    different = {density.tobytes(): density for density, flux in shining if flux > 0.0}
    for density, flux in shining:
        total += density / max(density.sum(), 1e-300) * flux
    if is_pictured:
        white = illuminant(GRID, "D65")
        total += white / white.sum() * max(total.sum(), 1.0)
    if total.sum() <= 0.0:
        total = _spectrum_seen(None if world is None else world.seen, seen)
    return total / total.sum(), list(different.values())


def _spectrum_seen(world, seen) -> np.ndarray:
    """Spectrum of what the camera alone sees, equal energy where that is nothing. (471,)"""
    total = np.zeros(len(GRID))
    for source in seen:
        total += source.density / max(source.density.sum(), 1e-300) * source.flux
    if world is not None and world.photo is not None:
        total += illuminant(GRID, "D65")
    elif isinstance(world, UniformWorld | FormulaSky):
        total += emission.luminous(1.0, world.spectrum).density
    elif isinstance(world, ImageWorld):
        total += illuminant(GRID, "D65")
    return total if total.sum() > 0.0 else np.ones(len(GRID))
