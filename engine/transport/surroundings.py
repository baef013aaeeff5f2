"""What rays that leave the scene see: the world and the suns, as one emitter."""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ..photometry import units
from ..photometry.colour import REC709_LUMINANCE
from ..photometry.spectra import luminous_efficiency
from ..scene.light import CieSky, ImageWorld, SunLight, UniformWorld
from ..sky.cie import check_sky, mean_luminance
from ..sky.plugin import make_sky
from . import emission
from .textures import is_spectral

SUN_POINT_ANGLE = 1e-5
"""Suns narrower than this are computed as disks of this angular diameter; no shadow shows the difference. [rad]"""

PORTAL_SHARE = 0.75
"""Share of the world's samples that aim at panes, where there are any."""


@dataclass(frozen=True)
class World:
    """Mitsuba's emitter of a world and its luminance, averaged over all directions. [cd/m2]"""

    emitter: object
    mean_luminance: float


def make_world(world, old=None, made: World | None = None) -> World | None:
    """Return the emitter of a world, None when it is black.

    Parameters
    ----------
    world : UniformWorld, ImageWorld, CieSky or None
    old, made : World's description and emitter
        Of before; the emitter is changed in place if it shows the same picture, or another sky of the same spectrum.
    """
    if isinstance(world, UniformWorld) and world.luminance > 0.0:
        made = emission.luminous(world.luminance, world.spectrum)
        return World(
            mi.load_dict({"type": "constant", "radiance": made.texture()}), world.luminance
        )
    if isinstance(world, CieSky):
        check_sky(world)
        if world.illuminance > 0.0:
            return _cie_sky(world, old, made)
    if isinstance(world, ImageWorld) and world.luminance_per_unit > 0.0:
        if made is not None and isinstance(old, ImageWorld) and world.image.is_same(old.image):
            return _changed(world, old, made)
        return _image_world(world)
    return None


def _cie_sky(world: CieSky, old, made: World | None) -> World:
    mean = mean_luminance(world)
    if made is not None and isinstance(old, CieSky) and world.spectrum == old.spectrum:
        made.emitter.set_sky(world)
        return World(made.emitter, mean)
    return World(make_sky(world, emission.luminous(1.0, world.spectrum).texture()), mean)


def _changed(world: ImageWorld, old: ImageWorld, made: World) -> World:
    """Lay the same picture in another way; a new emitter would read all of it again."""
    _lay(made.emitter, world)
    ratio = world.luminance_per_unit / old.luminance_per_unit
    return World(made.emitter, made.mean_luminance * ratio)


def _lay(emitter, world: ImageWorld) -> None:
    """Set scale and rotation; plain numbers would be a part of kernels, which every edit would then have to compile."""
    values = mi.traverse(emitter)
    scale = mi.Float(_scale(world))
    place = type(values["to_world"])(mi.ScalarTransform4f(_frame(world)))
    dr.make_opaque(scale, place)
    values["scale"], values["to_world"] = scale, place
    values.update()


def _frame(world: ImageWorld) -> list:
    # Mitsuba looks up (x, y, z) at u = atan2(x, -z) / (2 pi) with +y up; ours at u = 0.5 - atan2(y, x) / (2 pi) with
    # +z up: they agree when Mitsuba's (x, y, z) is our (y, z, x).
    to_map = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]) @ world.rotation
    to_world = np.eye(4)
    to_world[:3, :3] = to_map.T
    return [list(row) for row in to_world]


def _scale(world: ImageWorld) -> float:
    scale = world.luminance_per_unit
    if is_spectral():
        scale /= units.LUMINOUS_EFFICACY * luminous_efficiency().sum()
    return float(scale)


def _image_world(world: ImageWorld) -> World:
    pixels = np.nan_to_num(np.asarray(world.image.pixels, dtype=np.float32), posinf=0.0)
    pixels = np.maximum(pixels, 0.0)
    luma = (pixels @ REC709_LUMINANCE.astype(np.float32))[..., None]
    if not is_spectral():
        pixels = np.repeat(luma, 3, axis=2)
    plugin = {
        "type": "envmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(pixels[::-1])),
    }
    emitter = mi.load_dict(plugin)
    _lay(emitter, world)
    rows = np.cos((np.arange(len(luma)) + 0.5) / len(luma) * np.pi - 0.5 * np.pi)
    mean = float((luma[..., 0].mean(axis=1) * rows).sum() / rows.sum())
    return World(emitter, mean * world.luminance_per_unit)


def make_surroundings(world: World | None, suns: list[SunLight], radius: float, portals):
    """Join world and suns.

    Parameters
    ----------
    world : World or None
    suns : list of SunLight    Those that shine, in a fixed order.
    radius : float    Of the sphere around the scene's origin that everything lies in. [m]
    portals : PortalSet or None    Panes that the world's samples aim at.

    Returns
    -------
    (mi.Emitter, float) or None    With its flux through the sphere. [lm]
    """
    if world is None and not suns:
        return None
    plugin = {"type": "lumenray_surroundings", "suns": len(suns)}
    # Half of the samples go to the world and half to the suns: both matter and neither is known beforehand.
    world_share = 0.0 if world is None else (0.5 if suns else 1.0)
    plugin["world_share"] = world_share
    reach = max(radius, 1.0)
    flux = 0.0
    if world is not None:
        plugin["world"] = world.emitter
        flux = world.mean_luminance * 4.0 * np.pi**2 * reach**2
    amounts = [emission.sun_illuminance(sun) for sun in suns]
    total = sum(made.amount for made in amounts)
    for i, (sun, made) in enumerate(zip(suns, amounts, strict=True)):
        half = 0.5 * max(sun.angle, SUN_POINT_ANGLE)
        plugin[f"sun_{i}"] = made.scaled(units.luminance_from_illuminance_disk(1.0, half)).texture()
        plugin[f"towards_{i}"] = [-float(x) for x in sun.direction]
        plugin[f"cap_{i}"] = float(2.0 * np.sin(0.5 * half) ** 2)
        plugin[f"share_{i}"] = float((1.0 - world_share) * made.amount / total)
        flux += made.amount * np.pi * reach**2
    emitter = mi.load_dict(plugin)
    emitter.set_bounds(mi.Point3f(0.0), mi.Float(radius))
    if world is not None:
        emitter.set_portals(portals, PORTAL_SHARE)
    return emitter, flux
