"""What a bake needs of the session that it runs in."""

from collections.abc import Callable
from dataclasses import dataclass

from ..scene.scene import Scene


@dataclass(frozen=True)
class Host:
    """What a bake needs of the session.

    Parameters
    ----------
    scene : Scene
    engine : callable    ``engine(transport, asked)`` is a context that gives the compiled scene.
    compiled : callable    ``compiled(scene, like)`` compiles another scene for the same variant, simplified alike.
    cancelled : callable    Whether to end; lets others work for a moment.
    provenance : callable    ``provenance(compiled, seed, samples, start)``.
    stopped : callable    Whether to end with what there is.
    """

    scene: Scene
    engine: Callable
    compiled: Callable
    cancelled: Callable
    provenance: Callable
    stopped: Callable = lambda: False
