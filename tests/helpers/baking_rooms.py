"""Rooms that are baked in tests, and where the lumels of their maps lie."""

from dataclasses import replace

import numpy as np
from small_scenes import box

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.scene.light import Output, PointLight, Quantity
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.session import Session


def lamp(position, flux=1000.0, radius=0.1, name="lamp"):
    """Sphere that gives a luminous flux."""
    output = Output(Quantity.LUMINOUS_FLUX, flux)
    return PointLight(name, name, output, np.asarray(position, float), radius)


def moved(mesh, name, offset):
    """The mesh under another name and elsewhere."""
    vertices = mesh.vertices + np.asarray(offset, float)
    return replace(mesh, id=name, name=name, vertices=vertices)


def furnished_room(material="paint"):
    """Room of 2 m by 2 m by 2 m with a block on its floor."""
    room = moved(box(2.0, 2.0, 2.0, material), "room", (0, 0, 0))
    return room, moved(box(0.5, 0.5, 0.8, material, inwards=False), "block", (1.2, 1.1, 0.0))


def pierced_box(width, material="paint"):
    """Box of 1 m whose lid has a square hole in its middle; faces look inwards."""
    whole = box(1, 1, 1)
    kept = [t for t in whole.triangles if not (whole.vertices[t][:, 2] == 1).all()]
    low, high = 0.5 - 0.5 * width, 0.5 + 0.5 * width
    strips = [(0, 0, 1, low), (0, high, 1, 1), (0, low, low, high), (high, low, 1, high)]
    vertices, triangles = list(whole.vertices), [list(t) for t in kept]
    for a, b, c, d in strips:
        first = len(vertices)
        vertices += [(a, b, 1), (c, b, 1), (c, d, 1), (a, d, 1)]
        triangles += [[first, first + 2, first + 1], [first, first + 3, first + 2]]
    triangles = np.array(triangles, np.int32)
    return Mesh("room", "room", np.array(vertices, float), triangles, (material,),
                np.zeros(len(triangles), np.int32))  # fmt: skip


def bake(items, objects, samples=None, progress=None, density=6.0, **more):
    """Bake in a session of its own; ``more`` as of `StopRule` and `BakeOrder`."""
    session = Session(witness=False)
    session.apply(SceneDelta(changed=tuple(items)))
    return bake_in(session, objects, samples, progress, density, **more)


def bake_in(session, objects, samples=None, progress=None, density=6.0, **more):
    """Bake in a session."""
    names = ("error", "absolute", "seconds")
    rule = StopRule(samples=samples, **{name: more.pop(name) for name in names if name in more})
    return session.bake_objects(BakeOrder(objects, rule, density=density, **more), progress)


def lumel_places(result, made, mesh):
    """Centres and normals (n, 3) of an object's lumels in the order of `BakeResult.lumels`, NaN off the surface."""
    places, normals = [], []
    corners = mesh.vertices[mesh.triangles]
    for page in result.pages:
        row, column = np.nonzero(page.covered & (page.object == made.number))
        centre = np.stack([(column + 0.5) / page.width, (row + 0.5) / page.height], axis=1)
        place, normal = np.full((len(row), 3), np.nan), np.full((len(row), 3), np.nan)
        for triangle in np.flatnonzero(made.layout.page == page.number):
            a, b, c = made.layout.uv[triangle].astype(float)
            v, w = np.linalg.solve(np.stack([b - a, c - a], axis=1), (centre - a).T)
            inside = (v >= -1e-9) & (w >= -1e-9) & (v + w <= 1.0 + 1e-9)
            p, q, r = corners[triangle]
            place[inside] = p + v[inside, None] * (q - p) + w[inside, None] * (r - p)
            across = np.cross(q - p, r - p)
            normal[inside] = across / np.linalg.norm(across)
        places.append(place)
        normals.append(normal)
    return np.concatenate(places), np.concatenate(normals)


def error_ratio(made, reference):
    """True error of a map over its stated one by a reference, both root mean squares by area."""
    difference = (made.illuminance - reference.illuminance).astype(float) ** 2
    true = (made.area * (difference - reference.standard_error.astype(float) ** 2)).sum()
    return np.sqrt(max(true, 0.0) / (made.area * made.standard_error.astype(float) ** 2).sum())
