"""Whole jobs whose answers are known by closed forms: sensors, a lux map and a picture, on the device of this process."""

import math
import time
from dataclasses import dataclass

import numpy as np

from .accuracy.stopping import StopRule
from .baking.order import BakeOrder
from .scene.camera import Camera, Projection
from .scene.light import Output, PointLight, Quantity
from .scene.material import Diffuse, Emission, Material
from .scene.mesh import Mesh
from .scene.scene import SceneDelta
from .scene.spectrum import Constant
from .session import Session
from .views import ViewSettings

SIZE = 2.0
"""Side of the cube in which everything happens. [m]"""

FLUX, REFLECTANCE, LUMINANCE = 1000.0, 0.5, 100.0
"""Of the lamp [lm], of the walls, and of the walls of the furnace by themselves [cd/m2]."""

LIMIT = 4.0
"""Most standard errors by which an answer may be off: a right one is beyond it in 1 of 16 000 trials."""

LARGEST_ERROR = 0.05
"""Most that an answer's standard error may be of it: these jobs are small, but none is that small."""


@dataclass(frozen=True)
class Answer:
    """One answer beside the closed form, and how long it took, kernels included. ``value`` .. ``error`` in ``unit``."""

    job: str
    value: float
    expected: float
    error: float
    unit: str
    seconds: float

    @property
    def is_right(self) -> bool:
        """Whether the answer is within its error of the closed form, and the error one of a device that does its work."""
        if not self.error <= LARGEST_ERROR * self.expected:
            return False
        # Single precision adds some parts in a hundred thousand that no sample tells of.
        return abs(self.value - self.expected) <= LIMIT * self.error + 1e-4 * self.expected


def try_jobs(transport: str):
    """Yield an `Answer` for each job in a kind of transport, "mono" or "spectral"."""
    for job in (_measure, _bake, _render):
        start = time.perf_counter()
        value, expected, error, unit = job(transport)
        name = job.__name__.removeprefix("_")
        yield Answer(name, value, expected, error, unit, time.perf_counter() - start)


def _measure(transport):
    """Illuminance of a lamp alone is its intensity over the square of the distance."""
    session = _session(_lamp(), _paint(REFLECTANCE))
    place, up = [[1.0, 1.0, 0.2]], [[0.0, 0.0, 1.0]]
    made = session.measure(place, up, StopRule(samples=1 << 14), 1, transport, reflections=0)
    expected = FLUX / (4.0 * math.pi) / 0.8**2
    return float(made.illuminance[0]), expected, float(made.standard_error[0]), "lx"


def _bake(transport):
    """A closed room takes up what its lamp gives: mean illuminance is flux over (1 - reflectance) times area."""
    session = _session(_lamp(), _paint(REFLECTANCE))
    rule = StopRule(samples=256)
    made = session.bake_objects(BakeOrder(("room",), rule, transport=transport, density=8.0)).maps[
        0
    ]
    expected = FLUX / ((1.0 - REFLECTANCE) * 6.0 * SIZE**2)
    # What stands for the light beyond the first bounce has an error of its own.
    error = math.hypot(made.mean_standard_error, made.bias_error)
    return float(made.mean), expected, error, "lx"


def _render(transport):
    """In a furnace everything has the walls' own luminance over (1 - reflectance)."""
    session = _session(_paint(REFLECTANCE, Emission(Constant(1.0), LUMINANCE)))
    frame = np.eye(4)
    frame[:3, 3] = 1.0, 1.0, 1.9
    camera = Camera(frame, Projection.PERSPECTIVE, 32, 32)
    # Errors of pixels that share nothing are independent.
    settings = ViewSettings(StopRule(samples=64), 1, transport=transport, shares=False)
    made = session.render(camera, settings)
    seen = made.tristimulus[..., 1]
    error = float(seen.std() / math.sqrt(seen.size))
    return float(seen.mean()), LUMINANCE / (1.0 - REFLECTANCE), error, "cd/m2"


def _session(*items) -> Session:
    session = Session()
    session.apply(SceneDelta(changed=(_room(), *items)))
    return session


def _room() -> Mesh:
    """Cube whose faces look inwards."""
    places = [(x, y, z) for x in (0, SIZE) for y in (0, SIZE) for z in (0, SIZE)]
    quads = [(0, 2, 6, 4), (1, 5, 7, 3), (0, 4, 5, 1), (2, 3, 7, 6), (0, 1, 3, 2), (4, 6, 7, 5)]
    faces = [face for a, b, c, d in quads for face in ((c, b, a), (d, c, a))]
    return Mesh(
        "room", "room", np.array(places, float), np.array(faces, np.int32), ("paint",), np.zeros(12, np.int32)
    )  # fmt: skip


def _paint(reflectance, emission=None) -> Material:
    return Material("paint", "paint", Diffuse(Constant(reflectance)), emission)


def _lamp() -> PointLight:
    output = Output(Quantity.LUMINOUS_FLUX, FLUX)
    return PointLight("lamp", "lamp", output, np.array([1.0, 1.0, 1.0]), 0.02)
