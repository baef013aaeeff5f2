"""What a scene asks of its light: the error at which its pictures, lux maps or sensors are done, whatever they are for."""

from dataclasses import dataclass

from ...engine.errors import SceneError
from ...imports import loaded_when_used
from ..rendering.render_engine import stop_rule

with loaded_when_used():
    from ...engine.requirements import decision
    from ..bake import job as bake
    from ..sensors import asked as sensors


@dataclass(frozen=True)
class Question:
    """What decisions are made for.

    Parameters
    ----------
    error : float or None    That is asked for; None: no error is. [-]
    has_colour : bool    Whether colours are wanted.
    names : tuple of str or None    Full names of the objects whose own light is wanted; None: of all.
    transport : str    As of `Session.measure`.
    words : str    Which rule of the scene it is that asks.
    """

    error: float | None
    has_colour: bool
    names: tuple[str, ...] | None
    transport: str
    words: str

    def asked(self, objects: dict[str, str]) -> "decision.Asked":
        """The same for the engine. ``objects``: ids by full name."""
        names = objects if self.names is None else self.names
        keys = frozenset(objects[name] for name in names if name in objects)
        return decision.Asked(self.error, self.has_colour, keys)


def find_question(scene, selected=()) -> Question:
    """Return what a scene is computed for by its settings. ``selected``: objects that a bake would be of."""
    settings, names, has_colour = scene.lumenray, (), False
    if settings.modelling.purpose == "LUX_MAPS":
        what, has_colour = "lux maps are done at", settings.bake.exitance
        names = tuple(each.name_full for each in bake.bakeable(selected)) or None
        try:
            rule = bake.rule_of(settings.bake)
        except SceneError:
            # The panel of lux maps says that none of its ends is on.
            rule = None
    elif settings.modelling.purpose == "SENSORS":
        what, rule = "illuminance sensors are done at", sensors.rule_of(settings.sensors)
    else:
        what, has_colour = "pictures are done at", True
        own = settings.render
        rule = stop_rule(own.stop, own.samples, own.error, own.time)
    error = None if rule is None else rule.relative_goal
    ends = f"an error of {100.0 * error:.3g} %" if error else "no stated error"
    return Question(error, has_colour, names, settings.transport.lower(), f"{what} {ends}")
