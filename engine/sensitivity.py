"""How much a result depends on what surfaces reflect and let through: what it changes per 1 % of each material.

A few per cent off in a reflectance becomes tens of per cent after many reflections, so a result needs to say which input it
hangs on. The scene is computed with the surface's reflectance and transmittance a little larger and a little smaller, with
the same random numbers, so that most noise cancels in the difference:

    S = (E(1 + h) - E(1 - h)) / (2 h E(1))

S = 3 means that 1 % more of the surface's reflectance is 3 % more light. It is repeated with other numbers, and its
standard error is that of the mean over the repetitions.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from .accuracy.stopping import StopRule
from .errors import SceneError
from .scattering.surface import excess_of
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

STEP = 0.02
"""By which reflectances are changed. [-]"""

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
    scene = session.scene
    chosen = _choose(scene, materials)
    steps = 2 * REPETITIONS * len(chosen)
    done = 0
    made = []
    for material in chosen:
        low, high = _steps(material.surface)
        estimates = {low: [], high: []}
        try:
            for factor, found in estimates.items():
                changed = replace(material, surface=scale_surface(material.surface, factor))
                session.apply(SceneDelta((changed,)))
                for repetition in range(REPETITIONS):
                    reading = session.measure(
                        positions,
                        normals,
                        rule,
                        seed + repetition,
                        transport,
                        kind=kind,
                    )
                    found.append(reading.illuminance)
                    done += 1
                    if progress is not None:
                        progress(done / steps)
        finally:
            session.apply(SceneDelta((material,)))
        made.append(_compare(material, low, high, *(np.stack(e) for e in estimates.values())))
    return sorted(made, key=lambda each: -abs(each.mean))


def _compare(material: Material, low: float, high: float, less, more) -> Sensitivity:
    """Sensitivity from readings (repetitions, n) with less and more of a material."""
    share = (1.0 - low) / (high - low)
    middle = less + share * (more - less)
    change = (more - less) / (high - low)
    with np.errstate(divide="ignore", invalid="ignore"):
        each = np.where(middle.mean(axis=0) > 0.0, change / middle.mean(axis=0), np.nan)
    whole = change.mean(axis=1) / max(float(middle.mean()), 1e-300)
    count = np.sqrt(len(less))
    return Sensitivity(
        material.id,
        material.name,
        float(whole.mean()),
        float(whole.std(ddof=1) / count),
        each.mean(axis=0),
        each.std(axis=0, ddof=1) / count,
    )


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


def _steps(surface) -> tuple[float, float]:
    """Factors with which a surface is computed; where more of it would be more than all light, only less is."""
    if isinstance(surface, Measured):
        sides = [
            excess_of(getattr(surface, f"{s}_reflection"), getattr(surface, f"{s}_transmission"))
            for s in ("front", "back")
        ]
        largest = max(sides) * surface.factor
    else:
        largest = _largest(surface)
    if largest * (1.0 + STEP) <= 1.0:
        return 1.0 - STEP, 1.0 + STEP
    return 1.0 - 2.0 * STEP, 1.0


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
