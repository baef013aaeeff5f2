"""Our own bakes, through the engine's door, and what they are judged by."""

import time
from dataclasses import dataclass

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.baking.order import BakeOrder, BakeResult
from ...engine.scene.scene import SceneDelta
from ...engine.session import Session
from .lumels import LumelPlaces, draw_rows, find_places, hidden_share
from .references import Reference, find_reference
from .scenes import AtlasScene
from .stage import Stage

LARGEST = 2048
"""Side of a page. [lumel]"""

REFERENCE_ERROR = 0.002
"""Relative standard error of references: a fifth of the least that is tested. [-]"""

REFERENCE_SECONDS = 120.0
"""Longest that a reference may take. [s]"""

PLACES_SEED = 11
"""Chooses the lumels that are judged."""


@dataclass(frozen=True, eq=False)
class Made:
    """A bake: what it gave, and how long the whole call took. [s]"""

    result: BakeResult
    seconds: float


class Ours:
    """A scene in a session of its own."""

    def __init__(self, scene: AtlasScene):
        self.scene = scene
        self.session = Session(witness=False)
        self.session.apply(SceneDelta(changed=scene.items))

    def order(self, rule: StopRule, seed: int, **more) -> BakeOrder:
        """Order of the scene's bake."""
        return BakeOrder(
            self.scene.objects,
            rule,
            density=self.scene.density,
            largest=LARGEST,
            seed=seed,
            **more,
        )

    def bake(self, rule: StopRule, seed: int, options=None, **more) -> Made:
        """Bake; ``options``: of `engine.transport.lux_maps.job`, for what single parts of the method are worth."""
        order = self.order(rule, seed, **more)
        begin = time.perf_counter()
        extra = {} if options is None else {"options": options}
        result = self.session.bake_objects(order, **extra)
        return Made(result, time.perf_counter() - begin)


@dataclass(frozen=True, eq=False)
class Judge:
    """Lumels of a scene with their reference.

    Parameters
    ----------
    places : LumelPlaces    Of all lumels.
    rows : (n,) int array    Those that are judged.
    reference : Reference    Of these.
    cut : int    Lumels that are partly inside a solid and so left out.
    """

    places: LumelPlaces
    rows: np.ndarray
    reference: Reference
    cut: int

    @property
    def judged(self) -> LumelPlaces:
        """The lumels that are judged."""
        return self.places.take(self.rows)


def find_judge(scene: AtlasScene, result: BakeResult, say, inner_only: bool = False) -> Judge:
    """Choose lumels of a result and find their reference.

    Parameters
    ----------
    inner_only : bool    Only lumels that every program means the same by: away from the borders of charts.
    """
    stage = Stage(scene)
    meshes = {key: stage.scene.mesh(key) for key in scene.objects}
    places = find_places(result, meshes)
    allowed = places.is_inner if inner_only else np.ones(len(places), dtype=bool)
    rows = draw_rows(places, allowed, scene.judged, PLACES_SEED)
    hidden = hidden_share(places.take(rows), stage.are_inside)
    is_cut = (hidden > 0.0) & (hidden < 1.0)
    rows = rows[~is_cut]
    reference = find_reference(stage, places.take(rows), REFERENCE_ERROR, REFERENCE_SECONDS, say)
    return Judge(places, rows, reference, int(is_cut.sum()))
