"""What no light that is wanted can meet.

A closed surface that lets no light pass parts a scene in two. Where everything that is measured or looked at lies on one of
its sides, light, lamps and surfaces of the other change nothing there (theory 15.2).
"""

import numpy as np

from ..scene.light import PlacedLight
from ..scene.material import Holdout, Material
from ..scene.mesh import Mesh
from ..scene.modelling import Switch
from ..scene.scene import Scene
from .decision import Asked, Decision, Outcome
from .facts import Facts
from .hulls import INSIDE, OUTSIDE, UNKNOWN, closed_parts, sides

NAME = "unseen"

SAVING = 0.58
"""Share of the time to an error that is saved where one of nine closed and lit rooms is measured. [-]"""

MARGIN = 1e-3
"""By which what lies beside a surface is kept away from it: sensors just below one count as lying on it. [m]"""

FULL = "everything is modelled"


def decide(facts: Facts, asked: Asked, _allowance: float, switch: Switch) -> Outcome:
    """Leave out what closed surfaces hide from all that is wanted; exact."""
    if switch is Switch.OFF:
        return Outcome(Decision(NAME, FULL, "as the user wants it", switch=switch))
    if asked.places is None:
        reason = "light may be wanted anywhere"
        return Outcome(Decision(NAME, FULL, reason, switch=switch))
    hidden = find_hidden(facts.scene, asked)
    if not hidden:
        reason = "no closed surface hides anything from all that is wanted"
        return Outcome(Decision(NAME, FULL, reason, switch=switch))
    scene = facts.scene
    objects, lights = (
        sum(key in table for key in hidden) for table in (scene.meshes, scene.lights)
    )
    told = [
        f"{count} {word}" for count, word in ((objects, "objects"), (lights, "lights")) if count
    ]
    if len(hidden) > objects + lights:
        told.append("the world")
    reason = f"closed surfaces hide {' and '.join(told)} from all that is wanted"
    made = Decision(NAME, "left out", reason, saving=SAVING, switch=switch)
    return Outcome(made, dict.fromkeys(hidden))


def find_hidden(scene: Scene, asked: Asked) -> list[str]:
    """Ids of objects, lights and the world whose light cannot reach what is wanted, nor theirs it."""
    boxes = _Boxes(scene, asked)
    hidden: dict[str, None] = {}
    for key, item in scene.meshes.items():
        if key in asked.objects or not boxes.may_part(key) or not _is_closing(scene, item, asked):
            continue
        mesh = scene.mesh(key)
        for corners in closed_parts(mesh):
            hidden |= dict.fromkeys(boxes.hidden_by(key, corners))
    # Shadow catchers show what is behind everything.
    is_shown = any(item.is_catcher for item in scene.meshes.values())
    if scene.world is not None and boxes.is_world_hidden and not is_shown:
        hidden[scene.world.id] = None
    return list(hidden)


class _Boxes:
    """Boxes round everything that is wanted, and round everything else."""

    def __init__(self, scene: Scene, asked: Asked):
        self.is_world_hidden = False
        wanted, others = list(asked.places), {}
        for key, item in scene.meshes.items():
            box = _box_of(scene, item)
            if box is None:
                continue
            if key in asked.objects:
                wanted.append(box)
            else:
                others[key] = box
        self._clear = {
            key for key in others if not _is_opaque(scene, scene.meshes[key], has_camera=True)
        }
        for key, light in scene.lights.items():
            if not isinstance(light, PlacedLight):
                others[key] = None
            elif getattr(light, "rays", None) is None:
                others[key] = (light.place - light.reach, light.place + light.reach)
        placed = [key for key, box in others.items() if box is not None]
        self._keys, self._endless = placed, [key for key, box in others.items() if box is None]
        self._places = {key: place for place, key in enumerate(placed)}
        self._wanted = _grown(wanted)
        self._others = _grown([others[key] for key in placed])

    def may_part(self, owner: str) -> bool:
        """Whether something else lies within the box round an object; what surrounds nothing need not be looked at."""
        if owner not in self._places:
            return False
        low, high = (each[self._places[owner]] for each in self._others)
        # It lies within its own.
        return self._holds(low, high, 1)

    def _holds(self, low: np.ndarray, high: np.ndarray, own: int) -> bool:
        """Whether a box holds more than ``own`` things as a whole, or all that is wanted."""
        others, wanted = (
            ((lows >= low) & (highs <= high)).all(axis=1)
            for lows, highs in (self._others, self._wanted)
        )
        return others.sum() > own or (len(wanted) > 0 and bool(wanted.all()))

    def hidden_by(self, owner: str, corners: np.ndarray) -> list[str]:
        """Ids of what a closed part of an object hides from all that is wanted."""
        # Grown boxes of things that lie in the part may stand out by so much.
        low, high = corners.min(axis=(0, 1)) - MARGIN, corners.max(axis=(0, 1)) + MARGIN
        if not self._holds(low, high, 0):
            return []
        wanted = sides(corners, *self._wanted)
        if not len(wanted) or wanted[0] == UNKNOWN or (wanted != wanted[0]).any():
            return []
        found = sides(corners, *self._others)
        touching = {
            key
            for key, side in zip(self._keys, found, strict=True)
            if side == UNKNOWN and key != owner
        }
        if touching & self._clear:
            # Light that passes what lies on the surface might pass both.
            return []
        other = OUTSIDE if wanted[0] == INSIDE else INSIDE
        hidden = [
            key
            for key, side in zip(self._keys, found, strict=True)
            if side == other and key != owner
        ]
        if other == OUTSIDE:
            self.is_world_hidden = True
            hidden += self._endless
        return hidden


def _grown(boxes) -> tuple[np.ndarray, np.ndarray]:
    lows, highs = (np.array([box[k] for box in boxes], float).reshape(-1, 3) for k in (0, 1))
    return lows - MARGIN, highs + MARGIN


def _box_of(scene: Scene, item):
    """Lowest and highest corner of an object, by the box of its geometry; None: it has no place. (3,), (3,) [m]"""
    if isinstance(item, Mesh):
        points = item.vertices
    else:
        geometry = scene.geometries.get(item.geometry)
        if geometry is None:
            return None
        points = geometry.vertices
    if not len(points):
        return None
    low, high = points.min(axis=0), points.max(axis=0)
    if not isinstance(item, Mesh):
        grid = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
        frame = np.asarray(item.frame, dtype=np.float64)
        points = grid @ frame[:3, :3].T + frame[:3, 3]
        low, high = points.min(axis=0), points.max(axis=0)
    return low, high


def _is_closing(scene: Scene, item, asked: Asked) -> bool:
    """Whether nothing passes an object's surface: no light, and no ray of the camera where there may be one."""
    if not item.meets_light:
        return False
    has_camera = asked.has_colour
    if has_camera and (not item.visible_to_camera or item.is_holdout or item.is_catcher):
        return False
    return _is_opaque(scene, item, has_camera)


def _is_opaque(scene: Scene, item, has_camera: bool) -> bool:
    return all(
        key in scene.materials and _stops(scene.materials[key], has_camera)
        for key in item.materials
    )


def _stops(material: Material, has_camera: bool) -> bool:
    seen = material.seen if has_camera else None
    return _blocks(material.surface) and (seen is None or _blocks(seen.surface))


def _blocks(surface) -> bool:
    return surface.is_opaque and not surface.passes_straight and not isinstance(surface, Holdout)
