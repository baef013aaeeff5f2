"""Where a result comes from."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Provenance:
    """Where a result comes from; enough to get it again.

    ``simplified``: relative error that the light may have by what was not modelled; it is in the errors of results. [-]
    """

    engine_version: str
    variant: str
    scene_hash: str
    seed: int
    samples: int
    seconds: float
    decisions: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    simplified: float = 0.0

    def with_words(self, decision: str, notes: tuple[str, ...]) -> "Provenance":
        """The same with one more decision, if it says anything, and more notes."""
        decisions = (*self.decisions, *([decision] if decision else []))
        return replace(self, decisions=decisions, notes=(*self.notes, *notes))
