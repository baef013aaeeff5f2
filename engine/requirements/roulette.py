"""From when on paths of sensors end by roulette: from their third vertex on, or once they count less than pays.

The mean is the same. In bright rooms roulette that begins early is nearly all of the noise; where little is reflected it
saves vertices that bring nothing. What pays follows from how much surfaces reflect on the mean, and from how samples scatter
(theory 3.4).
"""

import numpy as np

from ..photometry.spectra import GRID, evaluate_reflectance, luminous_efficiency
from ..scene.memo import recall_latest
from ..scene.mesh import Geometry, Mesh, Placement
from ..scene.modelling import Switch
from ..scene.scene import Scene
from ..scene.texture import ImageTexture
from .decision import Asked, Decision, Outcome
from .facts import Facts
from .fading import find_saving

NAME = "roulette"

EARLY, LATE = "from the third vertex on", "once a path counts little"
"""Choices."""

USUAL, MOST = 0.5, 0.99
"""Reflectance of what has no colour that tells; and the largest that is reckoned with. [-]"""


def decide(facts: Facts, _asked: Asked, _allowance: float, switch: Switch) -> Outcome:
    """End paths of sensors where going on no longer pays; exact."""
    if switch is Switch.OFF:
        return Outcome(Decision(NAME, EARLY, "as the user wants it", switch=switch))
    reflectance = min(mean_reflectance(facts.scene), MOST)
    if reflectance <= 0.0:
        return Outcome(Decision(NAME, EARLY, "nothing reflects light", switch=switch))
    reason = (
        f"surfaces reflect {100.0 * reflectance:.2g} % on the mean, so paths of sensors end by chance only once they count "
        "so little that this makes less noise than it saves time"
    )
    made = Decision(NAME, LATE, reason, saving=find_saving(reflectance), switch=switch)
    return Outcome(made, reflectance=reflectance)


def mean_reflectance(scene: Scene) -> float:
    """What surfaces reflect or let through of daylight, on the mean by area; 0 without any. [-]"""
    whole, reflected = 0.0, 0.0
    known: dict[str, float] = {}
    for item in scene.meshes.values():
        if not item.meets_light:
            continue
        areas = _areas_by_slot(scene, item)
        for key, area in zip(item.materials, areas, strict=True):
            if key not in known:
                known[key] = _reflectance_of(scene.materials.get(key))
            whole, reflected = whole + area, reflected + area * known[key]
    return reflected / whole if whole > 0.0 else 0.0


def _areas_by_slot(scene: Scene, item: Mesh | Placement) -> np.ndarray:
    """Area of what an object has of each of its materials. (slots,) [m2]"""
    if isinstance(item, Mesh):
        return _slot_areas(item, len(item.materials))
    shape = scene.geometries.get(item.geometry)
    if shape is None:
        return np.zeros(len(item.materials))
    # Of shapes that are stretched, about.
    scale = abs(float(np.linalg.det(np.asarray(item.frame)[:3, :3]))) ** (2.0 / 3.0)
    return scale * _slot_areas(shape, len(item.materials))


def _slot_areas(shape: Mesh | Geometry, slots: int) -> np.ndarray:
    def add_up():
        if not _is_sound(shape):
            # It is refused in words where it is compiled.
            return (np.zeros(slots),)
        corners = shape.vertices[shape.triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        slot = np.minimum(shape.material_index, slots - 1)
        return (0.5 * np.bincount(slot, np.linalg.norm(normal, axis=1), slots),)

    others = shape.triangles, shape.material_index
    return recall_latest(shape.vertices, "areas by slot", others, slots, add_up)[0]


def _is_sound(shape: Mesh | Geometry) -> bool:
    """Whether triangles have corners that are there, and materials."""
    corners, slots = shape.triangles, shape.material_index
    return bool(
        corners.size
        and corners.min() >= 0
        and corners.max() < len(shape.vertices)
        and len(slots) == len(corners)
        and slots.min() >= 0
        and np.isfinite(shape.vertices).all()
    )


def _reflectance_of(material) -> float:
    """About what a material reflects or lets through. [-]"""
    colours = () if material is None else material.surface.colours
    if not colours:
        return USUAL
    return float(np.clip(sum(map(_mean_of, colours)), 0.0, 1.0))


def _mean_of(colour) -> float:
    if isinstance(colour, ImageTexture):
        return float(colour.mean().mean())
    weights = luminous_efficiency()
    return float(weights @ evaluate_reflectance(colour, GRID) / weights.sum())
