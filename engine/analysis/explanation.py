"""How a scene will be computed, and what that costs in exactness: what ``lumenray explain`` tells."""

from dataclasses import dataclass

import numpy as np

from ..requirements.plan import Plan
from ..scene.light import Luminaire
from ..scene.nearness import box_distance, mesh_distance
from ..scene.scene import Scene

RAYS, POINT = "rays", "point"
"""How the light of a ray set reaches an object in a lux map."""


@dataclass(frozen=True)
class RayChoice:
    """How the light of a ray set reaches an object.

    Parameters
    ----------
    light, receiver : str    Names of the light and the object.
    nearest : float    Distance of the object's nearest place from the light's centre, or of the box around it where that is
        beyond ``limit``. [m]
    sizes : float    The same over the source's size. [-]
    limit : float    Distance below which the light of rays counts in lux maps, above which that of a point does. [m]
    method : str    `RAYS` where some of the object lies within the limit, else `POINT`.
    error : float    Relative error of the illuminance by the choice, at the nearest place: of rays the set's own error, of a
        point that of being none. [-]
    point_error : float    Of a point there. [-]
    seen_error : float    Of pictures and sensors there: that of the rays where a point is wrong by more than a hundredth,
        but of sets whose rays hardly fluctuate that of a point. [-]
    """

    light: str
    receiver: str
    nearest: float
    sizes: float
    limit: float
    method: str
    error: float
    point_error: float
    seen_error: float


@dataclass(frozen=True)
class Explanation:
    """How a scene will be computed.

    Parameters
    ----------
    plan : Plan    What is decided of the scene, and what that may cost.
    traced : str    What is traced from the lights in lux maps, and why; empty where no trial was made.
    notes : tuple of str    What is approximated.
    choices : tuple of RayChoice
    """

    plan: Plan
    traced: str
    notes: tuple[str, ...]
    choices: tuple[RayChoice, ...]


def explain_rays(scene: Scene, limits: dict[str, float] | None = None) -> tuple[RayChoice, ...]:
    """Say for every light of a ray set and every object which way the light takes, nearest objects first.

    Parameters
    ----------
    scene : Scene
    limits : dict of str to float or None    Distance below which rays are traced, by the light's id; None: wherever a point
        would be wrong. [m]
    """
    lights = [
        light
        for light in scene.lights.values()
        if isinstance(light, Luminaire) and light.rays is not None and light.output.value > 0.0
    ]
    meshes = [scene.mesh(key) for key in scene.meshes] if lights else []
    made = []
    for light in lights:
        rays = light.rays
        is_narrow = rays.is_narrow
        limit = rays.near if limits is None else limits.get(light.id, 0.0)
        centre = np.asarray(light.frame, dtype=np.float64)[:3, 3]
        for mesh in meshes:
            if not len(mesh.triangles):
                continue
            nearest = box_distance(centre, mesh)
            if nearest < limit:
                nearest = mesh_distance(centre, mesh)
            is_near = nearest < limit
            apart = float(rays.point_errors(nearest))
            made.append(
                RayChoice(
                    light.name,
                    mesh.name,
                    nearest,
                    nearest / rays.size,
                    limit,
                    RAYS if is_near else POINT,
                    rays.information_error if is_near else apart,
                    apart,
                    rays.information_error if nearest < rays.near and not is_narrow else apart,
                )
            )
    return tuple(sorted(made, key=lambda choice: (choice.light, choice.nearest, choice.receiver)))
