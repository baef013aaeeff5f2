"""Where a result comes from."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Provenance:
    """Where a result comes from; enough to get it again."""

    engine_version: str
    variant: str
    scene_hash: str
    seed: int
    samples: int
    seconds: float
    decisions: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
