"""What rays that leave the scene see: the world and the suns, as one emitter."""

from dataclasses import dataclass

import mitsuba as mi
import numpy as np

from ...errors import SceneError
from ...luminaires.emitters.portals import MAXIMUM_PORTALS, Portal, PortalSet, portal_order
from ...photometry import units
from ...photometry.spectra import GRID
from ...scene.light import FormulaSky, ImageWorld, SunLight, UniformWorld
from ...scene.spectrum import Illuminant
from ...sky.picture import WHITE, clean, find_luminances
from ...sky.picture_plugin import make_picture
from ...sky.plugin import make_sky
from ...sky.projection_plugin import make_projection
from ...sky.skies import check_sky, mean_luminance
from . import emission
from .lights import Source

SUN_POINT_ANGLE = 1e-5
"""Suns narrower than this are computed as disks of this angular diameter; no shadow shows the difference. [rad]"""

LEAST_SHARE = 0.2
"""Least share of the samples for the world and for all suns: neither is forgotten where the other is hidden. [-]"""

PORTAL_SHARE = 0.75
"""Share of the world's samples that aim at panes, where there are any."""


@dataclass(frozen=True)
class World:
    """Mitsuba's emitter of a world and its luminance, averaged over all directions. [cd/m2]

    ``plain``: the same without ground and photo where it has any of these; None: it is that itself, or black.
    """

    emitter: object
    mean_luminance: float
    plain: "World | None" = None


def make_world(world, old=None, made: World | None = None, origin=(0.0, 0.0, 0.0)) -> World | None:
    """Return the emitter of a world, None when it is black.

    Parameters
    ----------
    world : UniformWorld, ImageWorld, FormulaSky or None
    old, made : World's description and emitter
        Of before; the emitter is changed in place if it shows the same picture, or another sky of the same spectrum.
    origin : (3,) array    Of the scene's frame, in the world. [m]
    """
    plain = made if old is None or not _is_projected(old) or made is None else made.plain
    plain = _make_plain(world, old, plain)
    if world is None or not _is_projected(world):
        return plain
    if plain is None and (world.photo is None or world.photo.luminance_per_unit <= 0.0):
        return None
    white = emission.luminous(1.0, Illuminant(WHITE)).texture()
    emitter = None if plain is None else plain.emitter
    emitter = make_projection(emitter, world.ground, world.photo, np.asarray(origin), white)
    mean = 0.0 if plain is None else plain.mean_luminance
    return World(emitter, max(mean, _mean_of_photo(world.photo)), plain)


def _is_projected(world) -> bool:
    return world.ground is not None or world.photo is not None


def _mean_of_photo(photo) -> float:
    """Mean luminance that a photo adds to all directions, roughly: it steers sampling alone. [cd/m2]"""
    if photo is None:
        return 0.0
    share = photo.extent_x * photo.extent_y / (photo.extent_x * photo.extent_y + 4.0 * np.pi)
    return (
        share * photo.luminance_per_unit * float(find_luminances(clean(photo.image.pixels)).mean())
    )


def _make_plain(world, old, made: World | None) -> World | None:
    """As `make_world`, without ground and photo."""
    if isinstance(world, UniformWorld) and world.luminance > 0.0:
        made = emission.luminous(world.luminance, world.spectrum)
        return World(
            mi.load_dict({"type": "constant", "radiance": made.texture()}), world.luminance
        )
    if isinstance(world, FormulaSky):
        check_sky(world)
        if world.illuminance > 0.0:
            return _formula_sky(world, old, made)
    if isinstance(world, ImageWorld) and world.luminance_per_unit > 0.0:
        if made is not None and isinstance(old, ImageWorld) and world.image.is_same(old.image):
            return _changed(world, old, made)
        return _image_world(world)
    return None


def _formula_sky(world: FormulaSky, old, made: World | None) -> World:
    mean = mean_luminance(world)
    if made is not None and isinstance(old, FormulaSky) and world.spectrum == old.spectrum:
        made.emitter.set_sky(world)
        return World(made.emitter, mean)
    return World(make_sky(world, emission.luminous(1.0, world.spectrum).texture()), mean)


def _changed(world: ImageWorld, old: ImageWorld, made: World) -> World:
    """Lay the same picture in another way; a new emitter would read all of it again."""
    made.emitter.lay(world.luminance_per_unit, _rotation(world))
    ratio = world.luminance_per_unit / old.luminance_per_unit
    return World(made.emitter, made.mean_luminance * ratio)


def _image_world(world: ImageWorld) -> World | None:
    white = emission.luminous(1.0, Illuminant(WHITE)).texture()
    picture = make_picture(world.image, white)
    if picture is None:
        return None
    emitter, mean = picture
    emitter.lay(world.luminance_per_unit, _rotation(world))
    return World(emitter, mean * world.luminance_per_unit)


def _rotation(world: ImageWorld) -> np.ndarray:
    rotation = np.asarray(world.rotation, dtype=np.float64)
    if rotation.shape != (3, 3) or not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-4):
        raise SceneError(
            "the world's picture is laid by a matrix that is no rotation: "
            + np.array2string(rotation, separator=", ", precision=6).replace("\n", "")
        )
    return rotation


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
    amounts = [emission.sun_illuminance(sun) for sun in suns]
    total = sum(illuminance.amount for illuminance in amounts)
    world_share = share_of_world(None if world is None else world.mean_luminance, total)
    plugin["world_share"] = world_share
    reach = max(radius, 1.0)
    flux = 0.0
    if world is not None:
        plugin["world"] = world.emitter
        flux = world.mean_luminance * 4.0 * np.pi**2 * reach**2
    for i, (sun, illuminance) in enumerate(zip(suns, amounts, strict=True)):
        half = 0.5 * max(sun.angle, SUN_POINT_ANGLE)
        plugin[f"sun_{i}"] = illuminance.scaled(
            units.luminance_from_illuminance_disk(1.0, half)
        ).texture()
        plugin[f"towards_{i}"] = [-float(x) for x in sun.direction]
        plugin[f"cap_{i}"] = float(2.0 * np.sin(0.5 * half) ** 2)
        plugin[f"limb_{i}"] = float(sun.limb_darkening)
        plugin[f"share_{i}"] = float((1.0 - world_share) * illuminance.amount / total)
        flux += illuminance.amount * np.pi * reach**2
    emitter = mi.load_dict(plugin)
    emitter.set_bounds(mi.Point3f(0.0), mi.Float(radius))
    if world is not None:
        emitter.set_portals(portals, PORTAL_SHARE)
    return emitter, flux


def share_of_world(mean_luminance: float | None, sunlight: float) -> float:
    """Return the share of the samples that goes to the world, the rest to the suns: by the light through a sphere.

    So a sun that is taken out of a picture is sampled about as often as it was in there.

    Parameters
    ----------
    mean_luminance : float or None    Of the world, over all directions; None: there is none. [cd/m2]
    sunlight : float    Sum of the illuminances of planes that face the suns; 0 without any. [lx]
    """
    if mean_luminance is None:
        return 0.0
    if sunlight <= 0.0:
        return 1.0
    share = 4.0 * np.pi * mean_luminance
    return float(np.clip(share / (share + sunlight), LEAST_SHARE, 1.0 - LEAST_SHARE))


class Outside:
    """What is around a scene, from edit to edit: its world, its suns, and the panes by which their light enters.

    ``emitter`` is what rays that leave the scene see, None if that is nothing, and ``portals`` where its samples are aimed.
    ``backdrop`` is what rays of the camera see, the same or, with ``has_backdrop``, one of its own.
    """

    def __init__(self):
        self.emitter = self.backdrop = None
        self.has_backdrop = False
        self.portals: PortalSet | None = None
        self._item, self._world, self._seen = None, None, None
        self._panes: list[Portal] = []
        self._key: object = None
        self._parts = None, [], None, None
        self._whole: tuple | None = None
        self._source: Source | None = None

    @property
    def suns(self) -> tuple[SunLight, ...]:
        """Suns of the emitter, in their order there."""
        return () if self.emitter is None else tuple(self._parts[1])

    @property
    def world_luminance(self) -> float:
        """Mean over all directions of the world without its suns. [cd/m2]"""
        return 0.0 if self._world is None else self._world.mean_luminance

    def take_world(self, world, origin: np.ndarray) -> bool:
        """Take a world's description in; true when it is another. ``origin`` (3,): of the scene's frame. [m]"""
        if world is self._item:
            return False
        old = self._item
        self._world = make_world(world, old, self._world, origin)
        seen, before = (None if each is None else each.seen for each in (world, old))
        self.has_backdrop = seen is not None
        self._seen = make_world(seen, before, self._seen, origin)
        self._item = world
        return True

    def take_panes(self, panes: list[Portal], origin: np.ndarray) -> None:
        """Take in by which panes light enters. ``panes``: in the world; ``origin`` (3,): of the scene's frame. [m]"""
        panes = sorted(panes, key=portal_order)[:MAXIMUM_PORTALS]
        if [id(p) for p in panes] != [id(p) for p in self._panes]:
            self._panes = panes
            local = [Portal(p.centre - origin, p.half_u, p.half_v) for p in panes]
            self.portals = PortalSet(local) if local else None

    def commit(self, suns: list[SunLight], radius: float, with_world: bool = True) -> Source | None:
        """Return the emitter of world and suns as next-event chooses it; ``radius`` as of `make_surroundings`.

        ``with_world``: whether the world shines.
        """
        world = self._world if with_world else None
        seen = self._seen if with_world else None
        key = (id(world), id(seen), tuple(map(id, suns)), radius, id(self.portals))
        key += (self.has_backdrop,)
        if key != self._key:
            joined = make_surroundings(world, suns, radius, self.portals)
            self._source = self.emitter = None
            if joined is not None:
                self.emitter, flux = joined
                self._source = Source(self.emitter, flux, np.zeros(len(GRID)), None)
            self.backdrop = self.emitter
            if self.has_backdrop:
                behind = make_surroundings(seen, suns, radius, None)
                self.backdrop = None if behind is None else behind[0]
            # Kept so that the ids above stay taken.
            self._key, self._parts = key, (world, suns, self.portals, seen)
        return self._source

    def whole(self, suns: list[SunLight], radius: float):
        """What rays see that leave the scene while all shines, those of light and of the camera; None: nothing."""
        parts = self._world, suns, self._seen
        if self._whole is None or not _are_same(self._whole[0], parts):
            if _are_same((self._parts[0], self._parts[1], self._parts[3]), parts):
                return self.emitter, self.backdrop
            emitter = behind = _emitter_of(self._world, suns, radius)
            if self.has_backdrop:
                behind = _emitter_of(self._seen, suns, radius)
            self._whole = parts, emitter, behind
        return self._whole[1:]


def _emitter_of(world: World | None, suns: list[SunLight], radius: float):
    joined = make_surroundings(world, suns, radius, None)
    return None if joined is None else joined[0]


def _are_same(a: tuple, b: tuple) -> bool:
    """Whether worlds, suns and worlds that are seen are the same objects."""
    return a[0] is b[0] and a[2] is b[2] and [*map(id, a[1])] == [*map(id, b[1])]
