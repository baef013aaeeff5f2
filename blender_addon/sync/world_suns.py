"""Suns and bright sources of a world as lights of their own; suns of Sky Textures are what nodes make of each disk."""

from dataclasses import dataclass

import numpy as np

from ...engine.scene.checks import LARGEST_AMOUNT
from ...engine.scene.light import Output, Quantity, SunLight
from ...engine.scene.light_groups import WORLD
from ...engine.sky.atmosphere.scattered_sky import LIMB
from ..foundation.report import ConversionReport
from .nodes.directions import DirectionContext
from .nodes.fields import luminance, rgb
from .nodes.sky_texture import sun_of
from .spectra import light_spectrum
from .world_shaders import world_radiance

RINGS, PARTS = 32, 128
"""Directions within a disk: distances from its middle, and places round it."""

UNLIKE = 0.05
"""Root of the mean square by which a disk may differ from the one that is lit, before it is told. [-]"""

DARK = 0.01
"""Part of the largest component that may be less than nothing: a red sun has less blue than the sky behind it. [-]"""


@dataclass(frozen=True, eq=False)
class Disk:
    """What the disk of a sun adds.

    Parameters
    ----------
    irradiance : (3,) array    Linear Rec. 709 components of a plane that faces it, where 1 of radiance is 1 in the nodes.
    towards : (3,) array    Unit vector to the middle of its light.
    angle : float    Angular diameter. [rad]
    unlikeness : float    Root of the mean square by which it differs from a disk that is darkened at its limb alone. [-]
    limb_darkening : float    As of `SunLight`. [-]
    is_sun : bool    Whether it is one, and no lamp.
    """

    irradiance: np.ndarray
    towards: np.ndarray
    angle: float
    unlikeness: float
    limb_darkening: float = LIMB
    is_sun: bool = True


def find_disks(surface, skies, name: str, report: ConversionReport, images, is_camera: bool):
    """Find what the suns of a world's skies add to its light.

    Parameters
    ----------
    surface : bpy.types.NodeSocket    Of the world's output.
    skies : iterable of ScatteredSky    That show a sun.
    name : str    Of the world, for the report.
    report : ConversionReport
    images : ImageCache
    is_camera : bool    Whether rays of the camera look.

    Returns
    -------
    tuple of Disk    Those that give light, in a fixed order.
    """
    suns = {sun_of(sky): sky for sky in skies}
    found = []
    for key, sky in sorted(suns.items()):
        directions, weights, profile = _spread(sky.towards_sun, sky.sun_angle)
        grid = directions.astype(np.float32)
        bare, whole = (
            _radiance(surface, grid, shown, name, images, is_camera) for shown in (None, key)
        )
        added = whole - bare
        if added.min() < -DARK * np.abs(added).max():
            report.warn(
                name,
                "the nodes make less light of the sun's disk than of the sky behind it",
                "the part that is less than nothing does not count",
            )
        disk = _add_up(added, directions, weights, profile, sky.sun_angle)
        if disk is not None:
            found.append(disk)
    return tuple(found)


def make_suns(disks, factor: float, world_id: str, name: str, report) -> tuple[SunLight, ...]:
    """Return the lights of disks.

    Parameters
    ----------
    disks : tuple of Disk
    factor : float    Luminance that 1 in the nodes stands for. [cd/m2]
    world_id, name : str    Of the world.
    report : ConversionReport
    """
    made = []
    for number, disk in enumerate(disks):
        amount = illuminance_of(disk) * factor
        if not 0.0 < amount <= LARGEST_AMOUNT:
            report.error(name, f"its sun gives {amount:.3g} lx", "the sun is left out")
            continue
        # The end is how light groups know whose it is.
        key = f"{world_id}/sun {number}/{WORLD}"
        output = Output(Quantity.ILLUMINANCE, amount, light_spectrum(disk.irradiance))
        called = f"{'sun' if disk.is_sun else 'bright source'} of {name}"
        made.append(SunLight(key, called, output, -disk.towards, disk.angle, disk.limb_darkening))
        if disk.unlikeness > UNLIKE:
            report.info(
                name,
                "the disk of its sun is not as bright everywhere as the true sun's",
                "it shines as that does, with the same light on surfaces",
            )
    return tuple(made)


def illuminance_of(disk: Disk) -> float:
    """Illuminance of a plane that faces a disk, where 1 in the nodes stands for 1 cd/m2. [lx]"""
    return float(luminance(disk.irradiance)[0])


def _spread(towards, angle: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return directions in a disk, and the solid angles [sr] and the relative radiance of rings.

    (RINGS, PARTS, 3), (RINGS, 1), (RINGS, 1)
    """
    node, weight = np.polynomial.legendre.leggauss(RINGS)
    # Even in the cosine of what is darkened towards the limb, which has a root at the edge.
    cosine, weight = 0.5 + 0.5 * node, 0.5 * weight
    half = 0.5 * angle
    polar = half * np.sqrt(1.0 - cosine**2)
    solid = np.sin(polar) / polar * half**2 * cosine * weight * (2.0 * np.pi / PARTS)
    azimuth = 2.0 * np.pi * (np.arange(PARTS) + 0.5) / PARTS
    up = np.eye(3)[int(np.argmin(np.abs(towards)))]
    across = np.cross(up, towards)
    across /= np.linalg.norm(across)
    beside = np.cross(towards, across)
    round_it = np.cos(azimuth)[:, None] * across + np.sin(azimuth)[:, None] * beside
    made = np.cos(polar)[:, None, None] * towards + np.sin(polar)[:, None, None] * round_it[None, :]
    return made, solid[:, None], (1.0 - LIMB * (1.0 - cosine))[:, None]


def _radiance(surface, grid, shown, name, images, is_camera) -> np.ndarray:
    """Return a world's radiance in directions, float64, black where nothing shines. ``shown``: the sun that has its disk."""
    context = DirectionContext(name, ConversionReport(), images, grid, is_camera, shown)
    radiance = world_radiance(surface, context)
    values = np.zeros(1) if radiance is None else rgb(radiance.settled().values)
    return np.broadcast_to(np.asarray(values, dtype=np.float64), grid.shape)


def _add_up(added, directions, weights, profile, angle: float) -> Disk | None:
    """Return the disk of a light by direction, None if it gives none; the others as of `_spread`."""
    added = np.maximum(added, 0.0)
    light = added * weights[..., None]
    vectors = np.einsum("rpc,rpd->cd", light, directions)
    towards = luminance(vectors.T)[:, 0]
    length = float(np.linalg.norm(towards))
    if length <= 0.0:
        return None
    towards = towards / length
    bright = luminance(added)[..., 0]
    level = (bright * weights).sum() / (profile * weights).sum() / PARTS
    apart = ((bright - level * profile) ** 2 * weights).mean(axis=1).sum()
    unlikeness = np.sqrt(apart / ((level * profile) ** 2 * weights).sum())
    return Disk(np.maximum(vectors @ towards, 0.0), towards, angle, float(unlikeness))
