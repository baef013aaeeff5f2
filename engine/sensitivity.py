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
from dataclasses import dataclass, fields, replace

import numpy as np

from .accuracy.stopping import StopRule
from .errors import SceneError
from .scattering.data.surface import excess_of, usable
from .scene.material import (
    Coated,
    Dielectric,
    Diffuse,
    Glossy,
    Material,
    Measured,
    Mix,
    TabulatedPane,
    ThinGlass,
    Transparent,
)
from .scene.scene import Scene, SceneDelta
from .scene.sensor import SensorKind
from .scene.spectrum import Constant, Rgb, Tabulated
from .scene.texture import ImageTexture
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
    done, made = 0, []
    for material in chosen:
        surface = material.surface
        if isinstance(surface, Measured):
            # What is scaled down because it would be more than all light must not be scaled down again.
            surface = usable(surface)
        scheme = _choose_scheme(surface)
        readings: list[list[np.ndarray]] = []
        try:
            for factor in scheme.factors:
                changed = replace(material, surface=scale_surface(surface, factor))
                session.apply(SceneDelta((changed,)))
                readings.append([])
                for repetition in range(REPETITIONS):
                    found = session.measure(
                        positions, normals, rule, seed + repetition, transport,
                        kind=kind, witness=False,
                    )  # fmt: skip
                    readings[-1].append(found.illuminance)
                    done += 1
                    if progress is not None:
                        progress(min(done / (2.5 * REPETITIONS * len(chosen)), 1.0))
        finally:
            session.apply(SceneDelta((material,)))
        made.append(_compare(material, scheme, np.array(readings, dtype=np.float64)))
    return sorted(made, key=lambda each: -abs(each.mean))


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
        largest = _largest(surface)
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
    from .transport.requirements import used_materials

    if materials is None:
        return [m for m in used_materials(scene) if scale_surface(m.surface, 1.0) is not None]
    made = []
    for key in materials:
        if key not in scene.materials:
            raise SceneError(f"the scene holds no material with the id {key}")
        if scale_surface(scene.materials[key].surface, 1.0) is None:
            name = scene.materials[key].name
            raise SceneError(f"material '{name}' has no reflectance that could be changed")
        made.append(scene.materials[key])
    return made


def scale_surface(surface, factor: float):
    """Return a surface that reflects and lets through ``factor`` times as much of what it lacks no law for; None: nothing.

    What follows from a refractive index is not changed: the mirror reflection of coats, panes and metals.
    """
    match surface:
        case Measured():
            return replace(surface, factor=surface.factor * factor)
        case TabulatedPane():
            return replace(
                surface,
                transmittance=np.asarray(surface.transmittance) * factor,
                reflectance=np.asarray(surface.reflectance) * factor,
            )
        case Mix():
            parts = [scale_surface(part, factor) for part in (surface.first, surface.second)]
            if parts == [None, None]:
                return None
            first, second = (
                old if new is None else new
                for old, new in zip((surface.first, surface.second), parts, strict=True)
            )
            return replace(surface, first=first, second=second)
        case Diffuse() | Coated() | Glossy() | ThinGlass() | Transparent() | Dielectric():
            changed = {
                name: _scale_colour(value, factor) for name, value in _colours(surface).items()
            }
            return replace(surface, **changed)
    return None


def _colours(surface) -> dict:
    """Spectra of a surface that say how much it reflects or lets through, by their names."""
    names = {"reflectance", "transmittance", "tint"}
    found = {field.name: getattr(surface, field.name) for field in fields(surface)}
    return {k: v for k, v in found.items() if k in names and v is not None}


def _scale_colour(value, factor: float):
    match value:
        case Constant():
            return Constant(value.value * factor)
        case Rgb():
            return Rgb(value.red * factor, value.green * factor, value.blue * factor)
        case Tabulated():
            return replace(value, values=value.values * factor)
        case ImageTexture():
            return replace(value, pixels=value.pixels * np.float32(factor))
    return value


def _largest(surface) -> float:
    """Largest sum of what a surface's spectra say. [-]"""
    match surface:
        case Mix():
            return max(_largest(surface.first), _largest(surface.second))
        case TabulatedPane():
            return float((np.asarray(surface.transmittance) + surface.reflectance).max())
    largest = 0.0
    for value in _colours(surface).values() if surface is not None else ():
        match value:
            case Constant():
                largest += value.value
            case Rgb():
                largest += max(value.red, value.green, value.blue)
            case Tabulated():
                largest += float(value.values.max())
            case ImageTexture():
                largest += float(value.pixels.max())
    return largest
