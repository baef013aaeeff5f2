"""How much a result depends on what surfaces reflect and let through: what it changes per 1 % of each material.

A few per cent off in a reflectance becomes tens of per cent after many reflections, so a result needs to say which input it
hangs on. The scene is computed with the surface's reflectance and transmittance a little larger and a little smaller, with
the same random numbers, so that most noise cancels in the difference:

    S = (E(1 + h) - E(1 - h)) / (2 h E(1))

S = 3 means that 1 % more of the surface's reflectance is 3 % more light. Where 1 + h would be more than all light, three
points from below give the slope at 1. It is repeated with other numbers, and its standard error is that of the ratio over
the repetitions.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .accuracy.stopping import StopRule
from .errors import SceneError
from .scattering.data.surface import excess_of, usable
from .scene.material import Material, Measured
from .scene.scene import Scene, SceneDelta
from .scene.sensor import SensorKind
from .session import Session

STEP, LEAST_STEP = 0.02, 0.0005
"""By which reflectances are changed, and the least. [-]"""

REPETITIONS = 4
"""Independent estimates of each figure."""


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """What a material does to the illuminance at sensors.

    Parameters
    ----------
    material, name : str    Id and name.
    mean, mean_error : float
        Relative change of the mean illuminance over the relative change of the material, with its standard error. [-]
    each, each_error : (n,) float64 array    The same of every sensor; nan where it is dark. [-]
    """

    material: str
    name: str
    mean: float
    mean_error: float
    each: np.ndarray
    each_error: np.ndarray


def measure_sensitivities(
    session: Session,
    positions,
    normals,
    rule: StopRule,
    seed: int = 0,
    transport: str = "auto",
    kind: SensorKind = SensorKind.PLANAR,
    materials: Sequence[str] | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Sensitivity]:
    """Find what materials do to illuminance at points, the strongest first.

    Parameters
    ----------
    session : Session    Its scene is as before when this returns or raises.
    positions, normals : (n, 3) array    World space. [m]
    rule : StopRule    Of every single estimate; give it samples, so that those to be compared are alike.
    materials : sequence of str or None    Ids; None: all that are used and can be changed.
    progress : callable or None    Told the share that is done.

    Raises
    ------
    SceneError    A material is unknown or has nothing that can be changed, or the scene cannot be computed.
    Cancelled
    """
    chosen = _choose(session.scene, materials)
    done, sensitivities = 0, []
    for material in chosen:
        surface = material.surface
        if isinstance(surface, Measured):
            # What is scaled down because it would be more than all light must not be scaled down again.
            surface = usable(surface)
        scheme = _choose_scheme(surface)
        readings: list[list[np.ndarray]] = []
        try:
            for factor in scheme.factors:
                changed = replace(material, surface=surface.scaled(factor))
                session.apply(SceneDelta((changed,)))
                readings.append([])
                for repetition in range(REPETITIONS):
                    # Of cells each scene would have its own, whose noise would not cancel.
                    measured = session.measure(
                        positions, normals, rule, seed + repetition, transport,
                        kind=kind, method="paths", witness=False,
                    )  # fmt: skip
                    readings[-1].append(measured.illuminance)
                    done += 1
                    if progress is not None:
                        progress(min(done / (2.5 * REPETITIONS * len(chosen)), 1.0))
        finally:
            session.apply(SceneDelta((material,)))
        sensitivities.append(_compare(material, scheme, np.array(readings, dtype=np.float64)))
    return sorted(sensitivities, key=lambda each: -abs(each.mean))


@dataclass(frozen=True)
class _Scheme:
    """Factors with which a surface is computed, and weights that make the derivative at 1, and the value there."""

    factors: tuple[float, ...]
    slope: tuple[float, ...]
    value: tuple[float, ...]


def _choose_scheme(surface) -> _Scheme:
    """Central differences; where more of the surface would be more than all light, one-sided ones of second order."""
    if isinstance(surface, Measured):
        sides = [
            excess_of(getattr(surface, f"{s}_reflection"), getattr(surface, f"{s}_transmission"))
            for s in ("front", "back")
        ]
        largest = max(sides) * surface.factor
    else:
        largest = surface.largest
    if largest * (1.0 + STEP) <= 1.0:
        return _Scheme((1.0 - STEP, 1.0 + STEP), (-0.5 / STEP, 0.5 / STEP), (0.5, 0.5))
    # Light that is reflected often grows as 1 / (1 - rho): steps stay well below what is missing to 1.
    step = float(np.clip(0.1 * (1.0 - largest), LEAST_STEP, STEP))
    return _Scheme(
        (1.0 - 2.0 * step, 1.0 - step, 1.0),
        (0.5 / step, -2.0 / step, 1.5 / step),
        (0.0, 0.0, 1.0),
    )


def _compare(material: Material, scheme: _Scheme, readings: np.ndarray) -> Sensitivity:
    """Sensitivity from readings (factors, repetitions, n)."""
    change = np.tensordot(scheme.slope, readings, axes=1)
    value = np.tensordot(scheme.value, readings, axes=1)
    each, each_error = _ratio(change, value)
    mean, mean_error = _ratio(change.mean(axis=1), value.mean(axis=1))
    return Sensitivity(material.id, material.name, float(mean), float(mean_error), each, each_error)


def _ratio(change: np.ndarray, value: np.ndarray):
    """Ratio of means over repetitions (r, ...) and its standard error: both share most of their noise."""
    whole = value.mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(whole > 0.0, change.mean(axis=0) / whole, np.nan)
        scatter = (change - ratio * value).std(axis=0, ddof=1)
        return ratio, scatter / (np.sqrt(len(change)) * whole)


def _choose(scene: Scene, materials: Sequence[str] | None) -> list[Material]:
    from .requirements.facts import used_materials

    if materials is None:
        return [m for m in used_materials(scene) if m.surface.scaled(1.0) is not None]
    chosen = []
    for key in materials:
        if key not in scene.materials:
            raise SceneError(f"the scene holds no material with the id {key}")
        if scene.materials[key].surface.scaled(1.0) is None:
            name = scene.materials[key].name
            raise SceneError(f"material '{name}' has no reflectance that could be changed")
        chosen.append(scene.materials[key])
    return chosen
