"""All decisions about what of a scene is modelled, in their order, and the budget that they share."""

from dataclasses import dataclass, field, replace

from ..errors import SceneError
from ..scene.modelling import Switch
from ..scene.scene import Scene, content_digest
from . import (
    colours,
    equal_materials,
    estimator,
    ray_sets,
    roulette,
    samples,
    surfaces,
    unseen,
    wavelengths,
)
from .budget import left_to_samples
from .decision import Asked, Decision, Late, Outcome
from .facts import Facts

DECISIONS = {
    unseen.NAME: unseen.decide,
    surfaces.NAME: surfaces.decide,
    equal_materials.NAME: equal_materials.decide,
    ray_sets.NAME: ray_sets.decide,
    colours.NAME: colours.decide,
    wavelengths.NAME: wavelengths.decide,
    estimator.NAME: estimator.decide,
    samples.NAME: samples.decide,
    roulette.NAME: roulette.decide,
}
"""What decides, by the decision's name. What saves most comes first: it takes what it needs of the budget."""

TRANSPORTS = ("auto", "mono", "spectral")
"""Kinds of transport that can be asked for."""


@dataclass(frozen=True)
class Plan:
    """What is computed of a scene.

    Parameters
    ----------
    asked : Asked
    decisions : tuple of Decision
    allowed : float    Relative error that simplifications might take. [-]
    spectral, dispersive : bool    Whether light has wavelengths, and glass refracts by them.
    changes : dict    Items in place of the scene's, by id; None: left out.
    late : tuple of Late    What more light may be wrong by where it comes late.
    draws_evenly : bool    Whether wavelengths are drawn evenly from all that there are.
    samples_evenly : bool    Whether all sensors get as many samples.
    reflectance : float    Of surfaces on the mean, by which roulette waits for paths of sensors; 0: it begins at once. [-]
    method : str    How reflected light is found where a job leaves that open, as of `Session.measure`, see `method_of`.
    """

    asked: Asked
    decisions: tuple[Decision, ...]
    allowed: float
    spectral: bool
    dispersive: bool
    changes: dict[str, object] = field(default_factory=dict, repr=False)
    late: tuple[Late, ...] = ()
    draws_evenly: bool = False
    samples_evenly: bool = False
    reflectance: float = 0.0
    method: str = "auto"

    @property
    def spent(self) -> float:
        """Sum of the bounds of what is left out: relative error that results may have beside that of samples. [-]"""
        return sum(decision.bound for decision in self.decisions)

    @property
    def reasons(self) -> tuple[str, ...]:
        """The decisions as sentences: of colours, then of what else is simplified."""
        first = [each.reason for each in self.decisions if each.name == colours.NAME]
        rest = [each for each in self.decisions if each.name != colours.NAME]
        told = first + [each.reason for each in rest if each.bound > 0.0 or each.saving > 0.0]
        if self.spent > 0.0:
            told.append(f"simplifications: at most {100.0 * self.spent:.2g} % of the light")
        return tuple(told)

    @property
    def sampling_error(self) -> float | None:
        """Relative error that is left to samples, None where none is asked for. [-]"""
        if self.asked.error is None:
            return None
        return left_to_samples(self.asked.error, self.spent)

    def method_of(self, asked: str) -> str:
        """How a job finds reflected light. ``asked``: what it is told itself, which counts where that is not ``auto``."""
        return self.method if asked == "auto" else asked

    @property
    def budget_text(self) -> str:
        """How the asked error is shared, for people."""
        told = "simplifications exact"
        if self.spent > 0.0:
            told = f"simplifications at most {100.0 * self.spent:.2g} %"
        if self.sampling_error is None:
            return told
        return f"sampling {100.0 * self.sampling_error:.3g} %, {told} ({100.0 * self.allowed:.2g} % allowed)"

    def simplify(self, scene: Scene) -> Scene:
        """The scene as it is computed; itself where nothing of it changes."""
        return scene.with_items(self.changes) if self.changes else scene


def make_plan(scene: Scene, asked: Asked | None = None, transport: str = "auto") -> Plan:
    """Decide how a scene has to be computed.

    Parameters
    ----------
    scene : Scene
    asked : Asked or None    None: as `Asked` is by itself.
    transport : str    ``auto``, ``mono`` or ``spectral``; the last two overrule the decision about colours.

    Raises
    ------
    SceneError    ``transport`` is none of the three, or a switch is that of no decision.
    """
    check_transport(transport)
    asked, wishes = asked or Asked(), scene.modelling
    for name, _ in wishes.switches:
        if name not in DECISIONS:
            raise SceneError(
                f"there is no decision '{name}' about what is modelled, expected {', '.join(DECISIONS)}"
            )
    allowed = 0.0 if asked.error is None else wishes.share * asked.error
    left, facts, made = allowed, Facts(scene), []
    for name, decide in DECISIONS.items():
        outcome = decide(facts, asked, max(left, 0.0), wishes.of(name))
        left -= outcome.decision.bound
        if outcome.is_spectral is not None:
            outcome = _overrule(outcome, transport)
            facts.is_spectral = outcome.is_spectral
        if outcome.changes:
            # What others decide is about what is left.
            facts = Facts(facts.scene.with_items(outcome.changes), facts.is_spectral)
        made.append(outcome)
    return _put_together(asked, allowed, made)


def check_transport(transport: str) -> None:
    """Raise `SceneError` where a kind of transport is none of the three."""
    if transport not in TRANSPORTS:
        raise SceneError(f"transport is '{transport}', expected auto, mono or spectral")


def _put_together(asked: Asked, allowed: float, made: list[Outcome]) -> Plan:
    """The plan that outcomes make."""
    changes: dict[str, object] = {}
    for outcome in made:
        changes |= outcome.changes
    return Plan(
        asked,
        tuple(outcome.decision for outcome in made),
        allowed,
        any(outcome.is_spectral for outcome in made),
        any(outcome.is_dispersive for outcome in made),
        changes,
        sum((outcome.late for outcome in made if not outcome.is_spectral), ()),
        any(outcome.draws_evenly for outcome in made),
        any(outcome.samples_evenly for outcome in made),
        max((outcome.reflectance for outcome in made), default=0.0),
        next((outcome.method for outcome in made if outcome.method != "auto"), "auto"),
    )


def _overrule(outcome: Outcome, transport: str) -> Outcome:
    """The outcome about colours where the user wants the other kind of transport. What that costs is told, not bounded."""
    is_spectral = transport == "spectral"
    if transport == "auto" or outcome.is_spectral == is_spectral:
        return outcome
    decision = outcome.decision
    verdict = "exact all the same" if is_spectral else "an approximation here"
    decision = replace(
        decision,
        choice="spectral" if is_spectral else "photometric",
        reason=f"{decision.reason}; the user asked for {transport} transport, which is {verdict}",
        bound=0.0,
        saving=0.0 if is_spectral else colours.SAVING,
        switch=Switch.OFF if is_spectral else Switch.FORCE,
    )
    return replace(outcome, decision=decision, is_spectral=is_spectral)


def changed_keys(before: dict[str, object], after: dict[str, object]) -> list[str]:
    """Ids of items that stand for others now and did not before, or the other way round, or are not what they were."""
    return [
        key for key in before | after if not _are_alike(before.get(key, key), after.get(key, key))
    ]


def _are_alike(first, second) -> bool:
    if first is second:
        return True
    if any(isinstance(each, str) or each is None for each in (first, second)):
        return False
    return content_digest(first) == content_digest(second)
