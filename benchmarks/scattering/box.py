"""A light box as behind displays: a measured reflector below and around, a diffuser above, a small lamp between them."""

import numpy as np

from ...engine.scene.light import Output, PointLight, Quantity
from ...engine.scene.material import Material, Surface
from ...engine.scene.mesh import Mesh
from ...engine.scene.scene import SceneDelta
from ...engine.session import Session

SIZE = np.array([0.3, 0.2, 0.04])
"""Length, width, depth. [m]"""

LAMPS = ((0.08, 0.1, 0.015), (0.22, 0.1, 0.015))
"""Places. [m]"""

FLUX = 150.0
"""Of each lamp. [lm]"""

ABOVE = 1e-4
"""Height of sensors over the diffuser. [m]"""

_CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
_TRAY = np.array(
    [
        [0, 1, 3], [0, 3, 2], [0, 4, 5], [0, 5, 1], [1, 5, 7], [1, 7, 3], [3, 7, 6], [3, 6, 2], [2, 6, 4], [2, 4, 0],
    ]
)  # fmt: skip
_SHEET = np.array([[4, 5, 7], [4, 7, 6]])


def light_box(reflector: Surface, diffuser: Surface) -> tuple[Session, Material]:
    """Return a session with the box, and the material of the reflector."""
    walls = Material("reflector", "Reflector", reflector)
    sheet = Material("diffuser", "Diffuser", diffuser)
    lamps = [
        PointLight(
            f"lamp{k}", f"Lamp {k}", Output(Quantity.LUMINOUS_FLUX, FLUX), np.array(p), 0.003
        )
        for k, p in enumerate(LAMPS)
    ]
    parts = [
        Mesh(name, name, _CORNERS * SIZE, faces, (material.id,), np.zeros(len(faces), np.int32))
        for name, faces, material in (("tray", _TRAY, walls), ("sheet", _SHEET, sheet))
    ]
    session = Session(witness=False)
    session.apply(SceneDelta((walls, sheet, *lamps, *parts)))
    return session, walls


def sensors_above() -> tuple[np.ndarray, np.ndarray]:
    """Places just above the diffuser and normals towards it: their illuminance is its exitance. (n, 3) each [m]"""
    x, y = np.meshgrid(np.linspace(0.03, 0.27, 9), np.linspace(0.03, 0.17, 5))
    places = np.stack([x.ravel(), y.ravel(), np.full(x.size, SIZE[2] + ABOVE)], axis=1)
    return places, np.tile([0.0, 0.0, -1.0], (len(places), 1))
