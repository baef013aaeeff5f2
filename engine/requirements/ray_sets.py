"""How far out the light of a ray set is that of its rays, and from where on that of a point.

How wrong a point is was measured when the set was made ready: the root mean square over all directions, so that it is the
error of the light round the lamp as a whole and not of every place in it (theory 6.9).
"""

from dataclasses import replace

import numpy as np

from ..scene.light import Luminaire
from ..scene.modelling import Switch
from ..scene.nearness import box_distance
from ..scene.ray_emission import EVERYWHERE, RayEmission
from .decision import Asked, Decision, Outcome, accepts
from .facts import Facts

NAME = "ray sets"

SAVING = 0.99
"""Share of the time to an error that is saved with a lamp whose light lands far away: few rays meet a place there. [-]"""

RAYS, NEAR, POINT = "rays everywhere", "rays near, a point far", "a point everywhere"
"""Choices."""


def decide(facts: Facts, asked: Asked, allowance: float, switch: Switch) -> Outcome:
    """Take ray sets for points where these are right enough."""
    lights = [light for light in facts.scene.lights.values() if _has_rays(light)]
    if not lights:
        return Outcome(Decision(NAME, "none", "no light is from a ray set", switch=switch))
    if switch is Switch.OFF:
        changes = {each.id: _limited(each, EVERYWHERE, 0.0) for each in lights}
        return Outcome(Decision(NAME, RAYS, "as the user wants it", switch=switch), changes)
    if switch is Switch.FORCE:
        bound = max(_point_error(facts, asked, light) for light in lights)
        if accepts(bound, allowance, switch):
            reason = f"on what is nearest to them a point is right within {100.0 * bound:.2g} %"
            changes = {each.id: replace(each, rays=None) for each in lights}
            return Outcome(Decision(NAME, POINT, reason, bound, SAVING, switch), changes)
    # Where no error is asked for, what was put up with when the set was made ready.
    most = np.inf if asked.error is None or switch is Switch.FORCE else allowance
    changes, bound = {}, 0.0
    for light in lights:
        near = find_limit(light.rays, most)
        spared = min(light.rays.spared, most)
        if (near, spared) != (light.rays.near, light.rays.spared):
            changes[light.id] = _limited(light, near, spared)
        if near < EVERYWHERE:
            bound = max(bound, float(light.rays.point_errors(near)), spared if asked.objects else 0)
    if bound == 0.0:
        reason = "no distance is known from which on points would be right enough"
        return Outcome(Decision(NAME, RAYS, reason, switch=switch), changes)
    reason = (
        f"beyond {_tell_limits(lights, changes)} of them a point is right within {100.0 * bound:.2g} %, as root mean square "
        "all round"
    )
    return Outcome(Decision(NAME, NEAR, reason, bound, SAVING, switch), changes)


def find_limit(rays: RayEmission, most: float) -> float:
    """Distance from which on a point is right enough: that of the set, or farther out. [m]

    ``most``: largest error of a point there. [-]
    """
    if not len(rays.far_distances) or float(rays.point_errors(rays.near)) <= most:
        return rays.near
    if most <= 0.0:
        return EVERYWHERE
    distances = np.geomspace(rays.near, max(rays.far_distances[-1], rays.near), 200)
    enough = np.flatnonzero(rays.point_errors(distances) <= most)
    return float(distances[enough[0]]) if len(enough) else EVERYWHERE


def _has_rays(light) -> bool:
    # Rays that hardly fluctuate are never asked, see `transport.light_tracing.near_rays`.
    is_lit = isinstance(light, Luminaire) and light.output.value > 0.0
    return is_lit and light.rays is not None and not light.rays.is_narrow


def _limited(light: Luminaire, near: float, spared: float) -> Luminaire:
    return replace(light, rays=replace(light.rays, near=near, spared=spared))


def _point_error(facts: Facts, asked: Asked, light: Luminaire) -> float:
    """Error of a point at the nearest place that light is wanted at, or may fall on; infinite where it is not known. [-]"""
    rays, scene = light.rays, facts.scene
    if asked.places is None or not len(rays.far_distances):
        return np.inf
    meshes = [scene.mesh(key) for key in scene.meshes]
    nearest = [box_distance(light.place, mesh) for mesh in meshes if len(mesh.triangles)]
    for low, high in asked.places:
        beside = np.maximum(np.maximum(low - light.place, light.place - high), 0.0)
        nearest.append(float(np.linalg.norm(beside)))
    least = min(nearest, default=np.inf)
    return float(rays.point_errors(least)) if least >= rays.far_distances[0] else np.inf


def _tell_limits(lights, changes) -> str:
    limits = [changes.get(light.id, light).rays.near for light in lights]
    limits = [limit for limit in limits if limit < EVERYWHERE]
    low, high = min(limits), max(limits)
    return f"{low:.3g} m" if low == high else f"{low:.3g} to {high:.3g} m"
