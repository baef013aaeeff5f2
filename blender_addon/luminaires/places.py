"""Which luminaires a 3D view shows, where they stand, and how finely each is worth drawing."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from mathutils import Matrix

from ...engine.errors import LumenrayError
from ...engine.scene.distribution import IntensityDistribution, Opening
from ..foundation.pose import Pose, pose_of
from .convert import find_opening, orient, reflected
from .files import Reading, photometric_files
from .settings import is_luminaire, settings_of

LEVELS = ((150.0, 96, 72), (45.0, 48, 36), (10.0, 24, 20))
"""Radius on the screen [pixel] from which a solid is drawn, and its number of columns and rows."""

MOST_SOLIDS = 150
"""Solids that are drawn at most, the largest on the screen; all others have their curves alone."""

DEEPEST = 8
"""Levels of collections that are instanced within one another; more is a mistake in the file."""


@dataclass(frozen=True, eq=False)
class Place:
    """A luminaire in the world.

    Parameters
    ----------
    digest : str    What tells contents of files apart.
    distribution : IntensityDistribution    As the file has it.
    turn : (3, 3) array    From the file's axes to the world's; a determinant of -1 mirrors.
    opening : Opening
    frame : (3, 3) array    From the opening's axes to the world's.
    centre : (3,) array    In Blender units.
    """

    digest: str
    distribution: IntensityDistribution
    turn: np.ndarray
    opening: Opening
    frame: np.ndarray
    centre: np.ndarray


def collect(view_layer, space, scale: float) -> list[Place]:
    """Find the luminaires whose solids a 3D view shows: the selected ones, and all that are told to.

    Of instances only those of collections are looked through: others may be millions.

    Parameters
    ----------
    view_layer : bpy.types.ViewLayer
    space : bpy.types.SpaceView3D or None    None: the view layer's own visibility.
    scale : float    Metres per Blender unit.
    """
    found = []
    readings = {}
    for source in view_layer.objects:
        if source.type not in {"LIGHT", "EMPTY"}:
            continue
        if not source.visible_get(view_layer=view_layer, viewport=space):
            continue
        is_chosen = source.select_get(view_layer=view_layer)
        for lamp, matrix in _lamps(source, source.matrix_world):
            if is_chosen or settings_of(lamp).show_solid:
                place = _place(lamp, matrix, scale, readings)
                if place is not None:
                    found.append(place)
    return found


def _lamps(source, matrix, depth=0):
    """Give the luminaires that an object is or, as an instance of a collection, brings, each with its world matrix."""
    if is_luminaire(source):
        yield source, matrix
    collection = source.instance_collection
    if source.type != "EMPTY" or source.instance_type != "COLLECTION" or collection is None:
        return
    if depth == DEEPEST:
        return
    moved = matrix @ Matrix.Translation(-collection.instance_offset)
    for member in collection.all_objects:
        if not member.hide_viewport:
            yield from _lamps(member, moved @ member.matrix_world, depth + 1)


def _place(source, matrix, scale, readings) -> Place | None:
    """Place a luminaire; None if its file or its scale cannot be used, which its panel or the report tells."""
    settings = settings_of(source)
    # Embedded content is told apart by its bytes, too many to look at for every one of hundreds.
    key = settings.text or photometric_files.absolute_path(settings)
    if key not in readings:
        readings[key] = _read(settings)
    reading, pose = readings[key], _pose(matrix.copy().freeze(), scale)
    if reading is None or pose is None:
        return None
    own = reflected(orient(settings, reading.file), pose)
    frame = pose.frame[:3, :3]
    return Place(
        digest=reading.digest,
        distribution=reading.distribution,
        turn=frame @ own.frame @ reading.distribution.frame.T,
        opening=find_opening(source, settings, reading.file, pose),
        frame=frame,
        centre=pose.frame[:3, 3] / scale,
    )


def _read(settings) -> Reading | None:
    try:
        return photometric_files.obtain(settings)
    except LumenrayError:
        return None


@lru_cache(maxsize=8192)
def _pose(matrix: Matrix, scale: float) -> Pose | None:
    """Take a world matrix apart; most of them stay the same from one look to the next."""
    try:
        # Of a frozen matrix, which alone can be looked up, NumPy makes no array in every version.
        return pose_of(matrix.copy(), scale)
    except LumenrayError:
        return None


def choose_levels(centres, radius: float, perspective, height: float) -> np.ndarray:
    """Say how finely solids are to be drawn. (n,): place in `LEVELS`, -1 where not at all.

    Parameters
    ----------
    centres : (n, 3) array    In Blender units.
    radius : float    Of a sphere around a solid. [Blender units]
    perspective : (4, 4) array    From the world to the view's clip space.
    height : float    Of the region. [pixel]
    """
    perspective = np.asarray(perspective, dtype=np.float64)
    centres = np.reshape(np.asarray(centres, dtype=np.float64), (-1, 3))
    points = np.pad(centres, ((0, 0), (0, 1)), constant_values=1.0)
    sides = perspective[3] + np.concatenate([perspective[:3], -perspective[:2]])
    sides /= np.linalg.norm(sides[:, :3], axis=1, keepdims=True)
    inside = (points @ sides.T > -radius).all(axis=1)
    pixels = screen_radius(centres, radius, perspective, height)
    level = np.full(len(points), -1)
    for place in reversed(range(len(LEVELS))):
        level[pixels >= LEVELS[place][0]] = place
    level[~inside] = -1
    drawn = np.flatnonzero(level >= 0)
    too_many = drawn[np.argsort(-pixels[drawn], kind="stable")][MOST_SOLIDS:]
    level[too_many] = -1
    return level


def screen_radius(centres, radius: float, perspective, height: float) -> np.ndarray:
    """Radius on the screen of spheres; infinite where the eye is inside. (n,), [pixel]"""
    perspective = np.asarray(perspective, dtype=np.float64)
    depth = np.asarray(centres) @ perspective[3, :3] + perspective[3, 3]
    nearest = radius * np.linalg.norm(perspective[3, :3])
    size = radius * np.linalg.norm(perspective[1, :3]) * 0.5 * height
    return np.where(depth > nearest, size / np.maximum(depth, 1e-30), np.inf)
