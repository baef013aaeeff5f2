"""Round bodies of glass and lamps in them."""

import numpy as np
from lumenray.engine.scene.mesh import Mesh


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
