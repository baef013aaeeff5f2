"""Small scenes made by chance, with something in each that may be simplified, and their errors against the full model."""

from dataclasses import dataclass, replace

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.requirements.decision import Asked, boxes_of
from ...engine.requirements.plan import DECISIONS, make_plan
from ...engine.scene.light import AreaLight, Output, PointLight, Quantity, SpotLight, UniformWorld
from ...engine.scene.material import (
    Black,
    Coated,
    Diffuse,
    Glossy,
    Material,
    Mix,
    Sheen,
    Surface,
    ThinGlass,
    Varnish,
)
from ...engine.scene.mesh import Mesh
from ...engine.scene.modelling import Modelling, Switch
from ...engine.scene.scene import SceneDelta
from ...engine.scene.spectrum import Blackbody, Constant, Daylight, Illuminant, Rgb
from ...engine.session import Session
from ..common.shapes import make_ball, make_box, make_rectangle

SPECTRA = (
    Illuminant("D65"),
    Illuminant("A"),
    Illuminant("FL2"),
    Illuminant("FL11"),
    Blackbody(4000.0),
    Daylight(6000.0),
)

SENSORS = 4


@dataclass(frozen=True)
class RandomScene:
    """A scene and where it is measured.

    Parameters
    ----------
    items : tuple    Of the scene.
    places, normals : (n, 3) array    Of sensors. [m]
    words : str    What is in it, for people.
    """

    items: tuple
    places: np.ndarray
    normals: np.ndarray
    words: str


@dataclass(frozen=True)
class Trial:
    """What a simplification changes of a scene.

    Parameters
    ----------
    name : str    Of the decision that alone was forced.
    bound : float    Relative; infinite where it declined, as it knows none. [-]
    error, noise : (n,) array    Relative difference to the full model at every sensor, and its standard error. [-]
    """

    name: str
    bound: float
    error: np.ndarray
    noise: np.ndarray


def make_scene(number: int) -> RandomScene:
    """One scene; the same number gives the same one."""
    draw = np.random.default_rng([number, 31])
    size = draw.uniform(1.5, 4.0, 3)
    words = [f"{size[0]:.1f} x {size[1]:.1f} x {size[2]:.1f} m"]
    hue = float(10.0 ** draw.uniform(-3.0, -0.7)) if draw.random() < 0.8 else 0.0
    items: list = [make_box(size), Material("paint", "paint", _paint(draw, hue, words))]
    for k in range(int(draw.integers(0, 4))):
        items += _thing(draw, size, k, hue, words)
    spectra = draw.choice(len(SPECTRA), 1 if draw.random() < 0.6 else 2, replace=False)
    for k in range(int(draw.integers(1, 4))):
        items.append(_lamp(draw, size, k, SPECTRA[spectra[k % len(spectra)]], words))
    if draw.random() < 0.6:
        items += _outdoors(draw, size, SPECTRA[spectra[0]], words)
    places = draw.uniform(0.1, 0.9, (SENSORS, 3)) * size
    normals = draw.normal(size=(SENSORS, 3))
    return RandomScene(tuple(items), places, normals, ", ".join(words))


def find_error(scene: RandomScene, name: str, samples: int, seed: int = 0) -> Trial:
    """Force one simplification alone, and compare it with the full model; both by independent samples."""
    off = tuple((other, Switch.OFF) for other in DECISIONS if other != name)
    asked = Asked(None, False, places=boxes_of(scene.places))
    forced = Modelling((*off, (name, Switch.FORCE)))
    session = _session(scene, forced)
    plan = make_plan(session.scene, asked)
    known = {decision.name: decision for decision in plan.decisions}[name]
    rule = StopRule(samples=samples)
    made = session.measure(scene.places, scene.normals, rule, 2 * seed + 1, method="paths")
    every = tuple((each, Switch.OFF) for each in DECISIONS)
    full = _session(scene, Modelling(every)).measure(
        scene.places, scene.normals, rule, 2 * seed + 2, "spectral", method="paths"
    )
    light = np.maximum(full.illuminance, 1e-12)
    # What the simplified one may be off by is no noise.
    own = made.standard_error**2 - (known.bound * made.illuminance) ** 2
    noise = np.sqrt(np.maximum(own, 0.0) + full.standard_error**2) / light
    did = plan.changes or not plan.spectral
    error = np.abs(made.illuminance / light - 1.0)
    return Trial(name, known.bound if did else np.inf, error, noise)


def _session(scene: RandomScene, modelling: Modelling) -> Session:
    session = Session(witness=False)
    session.apply(SceneDelta(changed=(*scene.items, modelling)))
    return session


def _colour(draw, hue: float):
    grey = float(draw.uniform(0.1, 0.85))
    if hue == 0.0:
        return Constant(grey)
    parts = np.clip(grey * (1.0 + hue * draw.normal(size=3)), 0.02, 0.9)
    return Rgb(*(float(x) for x in parts))


def _paint(draw, hue: float, words: list[str]) -> Surface:
    colour = _colour(draw, hue)
    words.append(f"walls by hue {hue:.2g}")
    if draw.random() < 0.3:
        words.append("coated")
        return Coated(colour, 1.5, float(draw.uniform(0.2, 1.0)))
    return Diffuse(colour)


def _surface(draw, hue: float) -> Surface:
    """A surface of any kind, many of which are simpler ones by what they say."""
    first, second = Diffuse(_colour(draw, hue)), Diffuse(_colour(draw, hue))
    metal = Glossy(Constant(float(draw.uniform(0.3, 0.9))), float(draw.uniform(0.1, 0.6)))
    kinds = (
        first,
        Coated(first.reflectance, 1.5, float(draw.uniform(0.2, 1.0))),
        metal,
        Mix(first, second, float(draw.uniform(0.0, 1.0))),
        Mix(first, metal, float(draw.choice([0.0, 0.3, 1.0]))),
        Mix(Black(), first, 0.5),
        Varnish(second, float(draw.choice([0.0, 0.5]))),
        Sheen(first, float(draw.choice([0.0, 0.5]))),
        ThinGlass(1.52, Constant(0.9)),
        Diffuse(Constant(0.3), Constant(0.3)),
    )
    return kinds[int(draw.integers(len(kinds)))]


def _thing(draw, size, k: int, hue: float, words: list[str]) -> list:
    """A box, a ball or a panel; in a box or ball may be another one and a lamp."""
    name, surface = f"thing {k}", _surface(draw, hue)
    words.append(f"{name} of {type(surface).__name__}")
    paint = f"{name}'s paint"
    material = Material(paint, paint, surface)
    place, side = draw.uniform(0.2, 0.8, 3) * size, float(draw.uniform(0.1, 0.4))
    kind = draw.choice(["box", "ball", "panel"])
    if kind == "panel":
        edges = draw.normal(size=(2, 3)) * side
        return [material, make_rectangle(name, place, *edges, paint)]
    inner = f"within {k}"
    made = [
        material,
        _solid(name, paint, place, side, kind),
        _solid(inner, paint, place, 0.3 * side, "ball"),
    ]
    if draw.random() < 0.5:
        output = Output(Quantity.LUMINOUS_FLUX, 300.0)
        made.append(PointLight(f"{inner} lamp", inner, output, place + 0.3 * side, 0.0))
    return made


def _solid(name: str, material: str, place, side: float, kind: str) -> Mesh:
    if kind == "ball":
        return make_ball(name, side, place, material, 6, smooth=False)
    box = make_box(np.full(3, 2.0 * side))
    turned = box.triangles[:, ::-1].copy()
    return replace(
        box,
        id=name,
        name=name,
        materials=(material,),
        vertices=box.vertices + place - side,
        triangles=turned,
    )


def _lamp(draw, size, k: int, spectrum, words: list[str]):
    name, place = f"lamp {k}", draw.uniform(0.2, 0.8, 3) * size
    flux = Output(Quantity.LUMINOUS_FLUX, float(draw.uniform(300.0, 2000.0)), spectrum)
    kind = draw.choice(["ball", "spot", "panel"])
    words.append(str(kind))
    if kind == "ball":
        return PointLight(name, name, flux, place, float(draw.uniform(0.01, 0.05)))
    if kind == "spot":
        aim = draw.normal(size=3)
        half = float(np.radians(draw.uniform(20.0, 60.0)))
        return SpotLight(name, name, flux, place, aim / np.linalg.norm(aim), half, 0.2)
    frame = np.eye(4)
    frame[:3, 3] = [*place[:2], 0.9 * size[2]]
    return AreaLight(name, name, flux, frame, *draw.uniform(0.1, 0.6, 2))


def _outdoors(draw, size, spectrum, words: list[str]) -> list:
    """A sky, small objects far away and a lit room next door."""
    words.append("with what is outside")
    door = make_box(size)
    shift = np.array([size[0] + 0.2, 0.0, 0.0])
    made: list = [
        UniformWorld(float(draw.uniform(100.0, 5000.0)), spectrum),
        replace(door, id="next door", name="next door", vertices=door.vertices + shift),
        PointLight(
            "next lamp",
            "next lamp",
            Output(Quantity.LUMINOUS_FLUX, 900.0),
            shift + 0.5 * size,
            0.02,
        ),
    ]
    for k in range(3):
        away = draw.normal(size=3)
        away *= draw.uniform(20.0, 60.0) / np.linalg.norm(away)
        made.append(_solid(f"far {k}", "paint", away, 0.1, "ball"))
    return made
