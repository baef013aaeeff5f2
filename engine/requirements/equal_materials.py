"""Materials that say the same: they get one surface, so that kernels tell fewer apart.

Only surfaces with a model of their own gain by it: diffuse ones, coated or not, are rows of one model already, and pictures
of equal arrays one array. Materials keep their ids, so that light groups and the index pass tell them apart. Exact.
"""

from dataclasses import replace

from ..scene.material import Black, Surface
from ..scene.modelling import Switch
from ..scene.scene import content_digest
from .decision import Asked, Decision, Outcome
from .facts import Facts, used_materials

NAME = "equal materials"

SAVING = 0.64
"""Share of the time that is saved where a hundred objects of gloss have one surface in place of a hundred equal ones. [-]"""

FULL = "each for itself"


def decide(facts: Facts, _asked: Asked, _allowance: float, switch: Switch) -> Outcome:
    """Let equal materials share a surface."""
    if switch is Switch.OFF:
        return Outcome(Decision(NAME, FULL, "as the user wants it", switch=switch))
    first: dict[bytes, Surface] = {}
    changes = {}
    for material in used_materials(facts.scene):
        if not _has_own_model(material.surface):
            continue
        own = first.setdefault(content_digest(material.surface), material.surface)
        if own is not material.surface:
            changes[material.id] = replace(material, surface=own)
    if not changes:
        return Outcome(
            Decision(NAME, FULL, "no two have equal surfaces of their own kind", switch=switch)
        )
    reason = f"{len(changes)} materials have the surface of another one"
    made = Decision(NAME, "one surface for equal ones", reason, saving=SAVING, switch=switch)
    return Outcome(made, changes)


def _has_own_model(surface: Surface) -> bool:
    plain = surface.as_coated
    if plain is None:
        return not isinstance(surface, Black)
    return plain.grain is not None or plain.film is not None
