"""Small scenes made by chance, with something in each that may be simplified, and their errors against the full model."""

from dataclasses import dataclass, replace

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.requirements import estimator, roulette, wavelengths
from ...engine.requirements.decision import Asked, Decision, boxes_of
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

FAMILIES = 12
"""Scenes with the same kinds of things come again after so many, of other sizes, places, colours and amounts: the same
kernels serve them."""

SEED_STEP = 1_000_003
"""By which the seeds of trials of a scene are apart."""


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
    bound : float    Relative. [-]
    error, noise : (n,) array    Relative difference to the full model at every sensor, and its standard error. [-]
    """

    name: str
    bound: float
    error: np.ndarray
    noise: np.ndarray


class _Draw:
    """Numbers of a scene; and ``kinds``, by which is drawn what there is in it, alike for scenes of one family."""

    def __init__(self, number: int):
        self._numbers = np.random.default_rng([number, 31])
        self.kinds = np.random.default_rng([number % FAMILIES, 32])
        self.uniform, self.normal = self._numbers.uniform, self._numbers.normal


def make_scene(number: int) -> RandomScene:
    """One scene; the same number gives the same one."""
    draw = _Draw(number)
    size = draw.uniform(1.5, 4.0, 3)
    words = [f"{size[0]:.1f} x {size[1]:.1f} x {size[2]:.1f} m"]
    hue = float(10.0 ** draw.uniform(-3.0, -0.7)) if draw.kinds.random() < 0.8 else 0.0
    items: list = [make_box(size), Material("paint", "paint", _paint(draw, hue, words))]
    for k in range(int(draw.kinds.integers(0, 4))):
        items += _thing(draw, size, k, hue, words)
    many = 1 if draw.kinds.random() < 0.6 else 2
    spectra = draw.kinds.choice(len(SPECTRA), many, replace=False)
    for k in range(int(draw.kinds.integers(1, 4))):
        items.append(_lamp(draw, size, k, SPECTRA[spectra[k % len(spectra)]], words))
    if draw.kinds.random() < 0.6:
        items += _outdoors(draw, size, SPECTRA[spectra[0]], words)
    places = draw.uniform(0.1, 0.9, (SENSORS, 3)) * size
    normals = draw.normal(size=(SENSORS, 3))
    return RandomScene(tuple(items), places, normals, ", ".join(words))


TRIED = tuple(name for name in DECISIONS if name != estimator.NAME)
"""Decisions that are tried: what cells change is no bound of a plan, but measured by every job."""

SELDOM = {wavelengths.NAME: 4, roulette.NAME: 4}
"""In one of how many scenes a decision is tried that would be in nearly all of them."""


def find_errors(
    scene: RandomScene, samples: int, seed: int = 0, names: tuple[str, ...] = TRIED
) -> list[Trial]:
    """Force each of some simplifications alone that the scene allows, and compare with the full model.

    Both by samples of their own.
    """
    asked = Asked(None, False, places=boxes_of(scene.places))
    rule, whole = StopRule(samples=samples), dict.fromkeys(DECISIONS, Switch.OFF)

    def begin(switches) -> tuple[Session, dict[str, Decision]]:
        session = Session(witness=False)
        wishes = Modelling(tuple(switches.items()))
        session.apply(SceneDelta(changed=(*scene.items, wishes)))
        plan = make_plan(session.scene, asked)
        return session, {decision.name: decision for decision in plan.decisions}

    full_session, full_plan = begin(whole)
    tried = [name for name in names if seed % SELDOM.get(name, 1) == 0]
    forced = [(name, *begin(whole | {name: Switch.FORCE})) for name in tried]
    forced = [each for each in forced if each[2][each[0]].choice != full_plan[each[0]].choice]
    if not forced:
        return []
    full = full_session.measure(scene.places, scene.normals, rule, seed)
    light, trials = np.maximum(full.illuminance, 1e-12), []
    for number, (name, session, plan) in enumerate(forced, 1):
        own_seed = seed + number * SEED_STEP
        made = session.measure(scene.places, scene.normals, rule, own_seed)
        bound = plan[name].bound
        # What the simplified one may be off by is no noise.
        own = made.standard_error**2 - (bound * made.illuminance) ** 2
        noise = np.sqrt(np.maximum(own, 0.0) + full.standard_error**2) / light
        error = np.abs(made.illuminance - full.illuminance) / light
        trials.append(Trial(name, bound, error, noise))
    return trials


def _colour(draw, hue: float):
    grey = float(draw.uniform(0.1, 0.85))
    if hue == 0.0:
        return Constant(grey)
    parts = np.clip(grey * (1.0 + hue * draw.normal(size=3)), 0.02, 0.9)
    return Rgb(*(float(x) for x in parts))


def _paint(draw, hue: float, words: list[str]) -> Surface:
    colour = _colour(draw, hue)
    words.append(f"walls by hue {hue:.2g}")
    if draw.kinds.random() < 0.3:
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
        Mix(first, metal, float(draw.kinds.choice([0.0, 0.3, 1.0]))),
        Mix(Black(), first, 0.5),
        Varnish(second, float(draw.kinds.choice([0.0, 0.5]))),
        Sheen(first, float(draw.kinds.choice([0.0, 0.5]))),
        ThinGlass(1.52, Constant(0.9)),
        Diffuse(Constant(0.3), Constant(0.3)),
    )
    return kinds[int(draw.kinds.integers(len(kinds)))]


def _thing(draw, size, k: int, hue: float, words: list[str]) -> list:
    """A box, a ball or a panel; in a box or ball may be another one and a lamp."""
    name, surface = f"thing {k}", _surface(draw, hue)
    words.append(f"{name} of {type(surface).__name__}")
    paint = f"{name}'s paint"
    material = Material(paint, paint, surface)
    place, side = draw.uniform(0.2, 0.8, 3) * size, float(draw.uniform(0.1, 0.4))
    kind = draw.kinds.choice(["box", "ball", "panel"])
    if kind == "panel":
        edges = draw.normal(size=(2, 3)) * side
        return [material, make_rectangle(name, place, *edges, paint)]
    inner = f"within {k}"
    made = [
        material,
        _solid(name, paint, place, side, kind),
        _solid(inner, paint, place, 0.3 * side, "ball"),
    ]
    if draw.kinds.random() < 0.5:
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
    kind = draw.kinds.choice(["ball", "spot", "panel"])
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
