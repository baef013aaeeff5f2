"""Bodies of glass and mirrors, lights for them, and the laws that light follows there."""

from dataclasses import replace

import numpy as np
from small_scenes import box, paint

from lumenray.engine.scene.light import Output, PointLight, Quantity, SunLight
from lumenray.engine.scene.material import Cauchy, Dielectric, Glossy, Material
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.spectrum import Constant

CANDELA = Output(Quantity.LUMINOUS_INTENSITY, 100.0)
LUX = Output(Quantity.ILLUMINANCE, 1000.0)
INDEX = 1.5
GLASS = Material("glass", "glass", Dielectric(Cauchy(INDEX)))
MIRROR = Material("mirror", "mirror", Glossy(Constant(0.9), 0.0))
BLACK = paint(0.0, "black")


def ball(name, radius, centre, material, rings=96):
    """Sphere of many triangles with the true sphere's normals."""
    theta = np.linspace(0.0, np.pi, rings + 1)
    phi = np.linspace(0.0, 2.0 * np.pi, 2 * rings, endpoint=False)
    unit = np.stack(
        [
            np.outer(np.sin(theta), np.cos(phi)),
            np.outer(np.sin(theta), np.sin(phi)),
            np.outer(np.cos(theta), np.ones_like(phi)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    row, column = (x.ravel() for x in np.mgrid[0:rings, 0 : 2 * rings])
    a, b = row * 2 * rings + column, row * 2 * rings + (column + 1) % (2 * rings)
    c, d = a + 2 * rings, b + 2 * rings
    upper = np.stack([a, c, d], axis=1)[row < rings - 1]
    triangles = np.concatenate([upper, np.stack([a, d, b], axis=1)[row > 0]]).astype(np.int32)
    return Mesh(
        name,
        name,
        radius * unit + np.asarray(centre, float),
        triangles,
        (material,),
        np.zeros(len(triangles), np.int32),
        corner_normals=unit[triangles].astype(np.float32),
    )


def slab(low, high, material="glass", name="slab"):
    low, high = np.asarray(low, float), np.asarray(high, float)
    made = box(*(high - low), material, inwards=False)
    return replace(made, id=name, name=name, vertices=made.vertices + low)


def point(position, **more):
    return PointLight("lamp", "lamp", CANDELA, np.asarray(position, float), **more)


def sun(direction, angle=0.0, output=LUX):
    direction = np.asarray(direction, float)
    return SunLight("sun", "sun", output, direction / np.linalg.norm(direction), angle)


def fresnel(angle, index):
    """Mean reflectance of both polarisations from outside and the angle inside. (n,) [rad]"""
    inside = np.arcsin(np.sin(angle) / index)
    a, b = np.cos(angle), np.cos(inside)
    s = (a - index * b) / (a + index * b)
    p = (index * a - b) / (index * a + b)
    return 0.5 * (s**2 + p**2), inside


def through_slab(angle, gap, thickness, orders=12):
    """Radii where light of a point lands under a slab, and share of it, by order of inner reflection. (orders, n) [m]"""
    reflected, inside = fresnel(angle, INDEX)
    passes = 2 * np.arange(orders)[:, None] + 1
    radius = gap * np.tan(angle) + passes * thickness * np.tan(inside)
    return radius, (1.0 - reflected) ** 2 * reflected ** (passes - 1)
