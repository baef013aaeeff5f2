"""Where the cases are run: scenes go to an instrument, readings come back with their errors.

The engine is one instrument, other programs are others, so that a case is stated once and answered by each.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.sensor import SensorKind
from lumenray.engine.session import Session
from lumenray.engine.views import Picture, ViewSettings

from .reference import Group, groups_of

MARGIN = 3.0
"""Standard errors are at most this part of the tolerance, so that noise does not decide."""


MOST_SAMPLES = 1 << 30
"""Samples per point at which a measurement ends, whatever its error; no case comes near it."""


class CannotStateError(Exception):
    """The instrument has no means for what a case needs; the text says what is missing."""


@dataclass(frozen=True)
class Readings:
    """Illuminances (n,) [lx] with standard errors; ``tristimulus`` (n, 3) and its errors where colour was asked for."""

    values: np.ndarray
    errors: np.ndarray
    tristimulus: np.ndarray | None = None
    tristimulus_errors: np.ndarray | None = None


@dataclass(frozen=True)
class Query:
    """What is asked at points of a scene.

    Parameters
    ----------
    positions, normals : (n, 3) array    [m]
    allowed : (n,) array    Largest difference that passes, in lx: the instrument goes on until its standard errors are
        a third of it.
    kind : SensorKind
    reflections : int or None    Most reflections that light may have had; None: all of it.
    colour : bool    Whether X and Z are wanted too.
    """

    positions: np.ndarray
    normals: np.ndarray
    allowed: np.ndarray
    kind: SensorKind = SensorKind.PLANAR
    reflections: int | None = None
    colour: bool = False


class Instrument(Protocol):
    """Something that answers queries about scenes."""

    name: str

    def measure(self, items: Sequence, query: Query, seed: int) -> Readings:
        """Return readings. Raises `CannotStateError`."""


class Engine:
    """Our engine, through its public door. Items that are the same objects as before are not sent again."""

    name = "Lumenray"

    def __init__(self):
        self.session = Session(witness=False)
        self._sent: dict[str, object] = {}
        self.samples = 0

    def stage(self, items: Sequence) -> Session:
        """Return the session with exactly these items in its scene."""
        wanted = {item.id: item for item in items}
        if len(wanted) != len(items):
            raise ValueError("two items of a case have the same id")
        changed = [item for key, item in wanted.items() if self._sent.get(key) is not item]
        removed = [key for key in self._sent if key not in wanted]
        if changed or removed:
            self.session.apply(SceneDelta(changed=tuple(changed), removed=tuple(removed)))
        self._sent = wanted
        return self.session

    def measure(self, items: Sequence, query: Query, seed: int) -> Readings:
        """Measure until every standard error is below a third of what is allowed."""
        session = self.stage(items)
        limits = tuple(np.asarray(query.allowed, dtype=np.float64) / MARGIN)
        made = session.measure(
            query.positions,
            query.normals,
            StopRule(samples=MOST_SAMPLES, limits=limits),
            seed=seed,
            kind=query.kind,
            reflections=query.reflections,
            colour=query.colour,
        )
        self.samples += made.provenance.samples
        return Readings(
            made.illuminance, made.standard_error, made.tristimulus, made.tristimulus_error
        )

    def render(self, items: Sequence, camera, rule: StopRule, seed: int) -> Picture:
        """Render a picture by the case's rule; pixels share nothing, since cases sum up their errors as independent ones."""
        return self.stage(items).render(camera, ViewSettings(rule, seed=seed, shares=False))


@dataclass
class Finding:
    """What an instrument found for a group: values (n,) with standard errors (n,), 0 where nothing is random."""

    group: Group
    values: np.ndarray
    errors: np.ndarray
    seconds: float = 0.0


@dataclass
class Setup:
    """Scene and sensors of a case as they are drawn in the report."""

    items: tuple
    positions: np.ndarray
    normals: np.ndarray
    labels: tuple[str, ...]


@dataclass
class Bench:
    """What a case works with.

    Parameters
    ----------
    instrument : Instrument
    wanted : set of str or None    Ids of the groups that shall be run; None: all.
    seed : int
    error : float or None    Relative standard error to reach where the tolerances need less. [-]
    """

    instrument: Instrument
    wanted: frozenset[str] | None = None
    seed: int = 1
    setups: dict[str, Setup] = field(default_factory=dict)
    error: float | None = None

    def groups(self, case: str) -> dict[str, Group]:
        """Groups of a case that shall be run, by id. Cases skip what is not there.

        Their ``allowed`` is what to measure by: narrower than the tolerance where a smaller error is asked for.
        """
        return {
            key: self._narrowed(group)
            for key, group in groups_of(case).items()
            if self.wanted is None or key in self.wanted
        }

    def _narrowed(self, group: Group) -> Group:
        if self.error is None:
            return group
        size = np.abs(group.values)
        # What cannot be told from 0 has no relative error.
        wanted = np.where(size <= group.allowed, np.inf, MARGIN * self.error * size)
        return replace(group, allowed=np.minimum(group.allowed, wanted))

    @property
    def engine(self) -> Engine:
        """Our engine, for what only it can be asked (pictures, bakes). Raises `CannotStateError` for peers."""
        if not isinstance(self.instrument, Engine):
            raise CannotStateError("the case asks for more than illuminances at points")
        return self.instrument

    def measure(self, items: Sequence, positions, normals, allowed, **more) -> Readings:
        """Ask for illuminances at points; ``more`` as in `Query`."""
        positions = np.asarray(positions, dtype=np.float64).reshape(-1, 3)
        normals = np.asarray(normals, dtype=np.float64).reshape(-1, 3)
        allowed = np.broadcast_to(np.asarray(allowed, dtype=np.float64), len(positions))
        return self.instrument.measure(items, Query(positions, normals, allowed, **more), self.seed)

    def measure_group(self, items: Sequence, group: Group, factor: float = 1.0, **more) -> Finding:
        """Measure a group whose values are illuminances times ``factor``, at its own points."""
        made = self.measure(
            items, group.positions, group.normals, group.allowed / abs(factor), **more
        )
        self.show(group, items)
        return Finding(group, made.values * factor, made.errors * abs(factor))

    def show(self, group: Group, items: Sequence, positions=None, normals=None) -> None:
        """Keep the first set-up of a case for the report's drawing."""
        self.setups.setdefault(
            group.case,
            Setup(
                tuple(items),
                group.positions if positions is None else np.asarray(positions),
                group.normals if normals is None else np.asarray(normals),
                group.labels,
            ),
        )


Findings = Iterator[Finding]
"""What a case yields; one `Finding` per group."""
