"""The job that measures the sensors of a scene: one by one kind of illuminance, and light group by light group."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ...engine.accuracy.estimate import Estimate
from ...engine.accuracy.stopping import Progress, StopRule
from ...engine.baking.light_layers import split_lights
from ...engine.camera_luminance import measure_regions
from ...engine.errors import Cancelled
from ...engine.light_mix import NEUTRAL, LightMix
from ...engine.luminance_meter import measure_luminance
from ...engine.measurements import SensorSpectra
from ...engine.observers import DARK, SAMPLES, find_unseen, rate_mixes
from ...engine.scene.light_groups import LightGroup
from ...engine.scene.scene import Scene, SceneDelta
from ...engine.scene.sensor import SensorKind
from .goniometers import SAMPLES as SPHERE_SAMPLES
from .goniometers import measure_sphere
from .places import GLARE, INTENSITY, PlacedSensors
from .readings import Readings, make_readings

GROUP_SEEDS = 1_000_003
"""Distance between the seeds of light groups."""

FIRST_SAMPLES = 256
"""Samples of a sensor that tell how exact light groups have to be."""

MOST_NAMES = 4
"""Lights that a note names."""

LEAST_PART = 1e-3
"""Share of the mean below which readings count as large as it. [-]"""


@dataclass(frozen=True, eq=False)
class Found:
    """What sensors of one kind have told: values and errors (n,), in lx or cd/m2, and where they come from.

    ``simplified``: as of a `Provenance`, in the errors. [-]
    """

    values: np.ndarray
    errors: np.ndarray
    samples: int
    seed: int
    method: str
    notes: tuple[str, ...]
    seconds: float
    has_common: bool = True
    lacks: str = ""
    simplified: float = 0.0
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rated: tuple[np.ndarray, np.ndarray] | None = None
    spectra: SensorSpectra | None = None


@dataclass(eq=False)
class SensorJob:
    """Sensors to be measured.

    Parameters
    ----------
    scene : Scene    It is not changed.
    places : list of PlacedSensors
    signatures : list of str    Of the empties as they are.
    rule : StopRule    Of each measurement; its time is that of all of them together.
    groups : tuple of LightGroup    Light groups that are kept apart; none: all light together.
    mixes : tuple of LightMix    Levels of the groups for which glare is rated, besides that of all light as it is.
    wants_direct : bool    Whether to keep what was not reflected besides, which some requirements ask for.

    Attributes
    ----------
    answer : dict of str to Readings    By the identity of the empty; filled by `run`.
    notes, decisions : tuple of str    For people.
    shortfall : str    What of the rule was not met.
    """

    scene: Scene
    places: list[PlacedSensors]
    signatures: list[str]
    rule: StopRule
    seed: int = 0
    transport: str = "auto"
    method: str = "auto"
    witness: bool = True
    reflections: int | None = None
    groups: tuple[LightGroup, ...] = ()
    mixes: tuple[LightMix, ...] = ()
    wants_direct: bool = False
    answer: dict[str, Readings] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    decisions: tuple[str, ...] = ()
    shortfall: str = ""
    _session: object = field(default=None, repr=False)
    _held: Scene = field(default_factory=Scene, repr=False)
    _step: int = 0
    _steps: int = 1
    _is_cancelled: bool = False

    def run(self, session, progress: Callable[[Progress], None] | None = None) -> None:
        """Measure all; the answer is kept.

        Parameters
        ----------
        session : Session or RemoteSession    An empty one.
        progress : callable or None    Gets a `Progress`.

        Raises
        ------
        Cancelled    After `cancel`.
        LumenrayError    The scene or the machine does not allow it.
        """
        self._session, self._held = session, Scene()
        kinds = list(dict.fromkeys(placed.kind for placed in self.places))
        whole_kinds = [kind for kind in kinds if _is_of_all_light(kind)]
        kinds = [kind for kind in kinds if not _is_of_all_light(kind)]
        rules = dict.fromkeys(kinds, self.rule)
        parts = split_lights(self.scene, self.groups) if self.groups else []
        if len(parts) > 1 and self.rule.each is not None:
            # The sum is to meet the rule: a group that is faint somewhere need not be known there as well as others.
            self._steps, self._step = (len(parts) + 1) * len(kinds) + len(whole_kinds), 0
            for kind in kinds:
                short = replace(self.rule, samples=FIRST_SAMPLES)
                whole = self._measure(session, self.scene, "", kind, short, 0, progress)
                rules[kind] = _share(self.rule, whole.values, len(parts))
        else:
            if len(parts) < 2:
                parts = [(name, self.scene) for name, _ in parts] or [("", self.scene)]
            self._steps, self._step = len(parts) * len(kinds) + len(whole_kinds), 0
        made, direct, notes, short = {}, {}, {}, {}
        asks = [kind for kind in kinds if self._asks_for_direct(kind)]
        self._steps += len(parts) * len(asks)
        for number, (name, scene) in enumerate(parts):
            for kind in kinds:
                rule = rules[kind]
                if rule.seconds is not None:
                    rule = replace(
                        rule, seconds=rule.seconds / len(parts) / (len(kinds) + len(asks))
                    )
                found = self._measure(session, scene, name, kind, rule, number + 1, progress)
                made[name, kind] = found
                notes |= dict.fromkeys(found.notes)
                if kind in asks:
                    direct[name, kind] = self._measure(
                        session, scene, name, kind, rule, number + 1, progress, reflections=0
                    )
        names = [name for name, _ in parts]
        for kind in kinds:
            found = [made[name, kind] for name in names]
            self._keep(kind, names, found, [direct[name, kind] for name in names if kind in asks])
            short |= dict.fromkeys(filter(None, [_shortfall(self.rule, found)]))
        for kind in whole_kinds:
            found = self._measure(session, self.scene, "", kind, self.rule, 1, progress)
            self._keep(kind, [""], [found])
            notes |= dict.fromkeys(found.notes)
        self.notes, self.shortfall = tuple(notes), "; ".join(short)

    def cancel(self) -> None:
        """End it; may be called from any thread."""
        self._is_cancelled = True
        if self._session is not None:
            self._session.cancel()

    def _asks_for_direct(self, kind) -> bool:
        return self.wants_direct and self.reflections is None and isinstance(kind, SensorKind)

    def _measure(
        self, session, scene: Scene, name: str, kind, rule, number: int, progress, reflections=None
    ):
        """Measure the sensors of a kind in a scene; ``number``: of the seed, 0 for what tells how long to measure.

        ``reflections``: at most, in place of those of the job.
        """
        if self._is_cancelled:
            raise Cancelled("cancelled")
        # A goniometer takes its part of the scene itself.
        scene_there = Scene() if _is_sphere(kind) else scene
        session.apply(_difference(self._held, scene_there))
        self._held = scene_there
        rows = [row for row, placed in enumerate(self.places) if placed.kind == kind]
        positions, normals = (
            np.concatenate([getattr(self.places[row], name) for row in rows])
            for name in ("positions", "normals")
        )
        own = (self.seed + GROUP_SEEDS * max(number - 1, 0)) % 2**31
        follow = _follow(progress, self._step, self._steps, name)
        if isinstance(kind, SensorKind):
            wants_spectrum = number > 0 and reflections is None
            wants_spectrum &= any(self.places[row].wants_spectrum for row in rows)
            made = session.measure(
                positions,
                normals,
                rule,
                own,
                self.transport,
                follow,
                kind=kind,
                reflections=self.reflections if reflections is None else reflections,
                method=self.method,
                witness=self.witness and number > 0,
                spectrum=wants_spectrum,
            )
            origin = made.provenance
            self.decisions = tuple(dict.fromkeys((*self.decisions, *origin.decisions)))
            found = Found(
                made.illuminance,
                made.standard_error,
                origin.samples,
                own,
                made.method,
                origin.notes,
                origin.seconds,
                made.has_common_errors,
                simplified=origin.simplified,
                spectra=made.spectra if wants_spectrum else None,
            )
        elif kind == GLARE:
            found = self._rate(session, positions, normals, own, follow)
        elif _is_sphere(kind):
            start = time.perf_counter()
            sphere = self.places[rows[0]].sphere
            made = measure_sphere(session, scene, sphere, own, self.transport, follow)
            found = Found(
                made.values,
                made.errors,
                SPHERE_SAMPLES,
                own,
                "goniometer",
                made.notes,
                time.perf_counter() - start,
                size=made.size,
            )
        else:
            start = time.perf_counter()
            how = (rule, own, self.transport, self.method, follow)
            if isinstance(kind, tuple):
                placed = self.places[rows[0]]
                meters = measure_regions(session, placed.camera, placed.shape, *how)
            else:
                meters = measure_luminance(session, positions, normals, kind, *how)
            found = Found(
                meters.luminance,
                meters.standard_error,
                meters.samples,
                own,
                "pictures",
                meters.notes,
                time.perf_counter() - start,
                simplified=meters.simplified,
            )
        self._step += 1
        return found

    def _rate(self, session, positions, normals, seed: int, follow) -> Found:
        """Rate the glare of observers; their pictures have a size of their own, whatever the rule."""
        start = time.perf_counter()
        tables, notes = rate_mixes(
            session,
            positions,
            normals,
            self.groups if self._told_mixes else (),
            (NEUTRAL, *self._told_mixes),
            seed=seed,
            transport=self.transport,
            progress=follow,
            is_cancelled=lambda: self._is_cancelled,
        )
        values, errors = np.stack([table["ugr"] for table in tables]).transpose(2, 0, 1)
        # Where nothing dazzles there is no rating, and nothing to be wrong about.
        errors = np.where(np.isfinite(values), errors, np.nan)
        rated = (values[1:], errors[1:]) if len(tables) > 1 else None
        seconds = time.perf_counter() - start
        unseen, lacks = find_unseen(self.scene), [note for note in notes if note == DARK]
        if unseen:
            more = ", …" if len(unseen) > MOST_NAMES else ""
            names = ", ".join(unseen[:MOST_NAMES]) + more
            lacks.append(
                f"lights without a size are not seen, so their glare is not rated: {names}"
            )
            notes = (*notes, lacks[-1])
        told = "; ".join(lacks)
        where = (SAMPLES, seed, "pictures", notes, seconds)
        return Found(values[0], errors[0], *where, False, told, rated=rated)

    @property
    def _told_mixes(self) -> tuple[LightMix, ...]:
        """Those that differ from all light as it is, once each."""
        made = {levels.key(): levels for levels in self.mixes if not levels.is_neutral}
        return tuple(made.values()) if self.groups else ()

    def _keep(self, kind, names, found, direct=()) -> None:
        """Share what was measured of a kind out among the empties."""
        start = 0
        for placed, signature in zip(self.places, self.signatures, strict=True):
            if placed.kind != kind:
                continue
            end = start + len(placed.positions)
            self.answer[placed.uid] = make_readings(
                placed,
                names,
                [each.values[start:end] for each in found],
                [each.errors[start:end] for each in found],
                samples=min(each.samples for each in found),
                seed=found[0].seed,
                scene_hash=self.scene.hash(),
                method=found[0].method,
                signature=signature,
                has_common=any(each.has_common for each in found),
                seconds=sum(each.seconds for each in found),
                reflections=self.reflections if isinstance(kind, SensorKind) else None,
                direct=[each.values[start:end] for each in direct] or None,
                direct_errors=[each.errors[start:end] for each in direct] or None,
                lacks=found[0].lacks,
                keeps_sources=kind == GLARE,
                simplified=max(each.simplified for each in found),
                size=found[0].size,
                mixes=[levels.key() for levels in self._told_mixes] if found[0].rated else (),
                rated=found[0].rated and found[0].rated[0][:, start:end],
                rated_errors=found[0].rated and found[0].rated[1][:, start:end],
                **_spectra_of(placed, found, start, end),
            )
            start = end


def _spectra_of(placed: PlacedSensors, found, start: int, end: int) -> dict[str, np.ndarray]:
    """Spectra of some of the sensors of a kind by light group, as arrays of `Readings`; none where none is wanted."""
    if not placed.wants_spectrum or found[0].spectra is None:
        return {}
    spectra = [each.spectra for each in found]
    return {
        "edges": spectra[0].edges,
        "bands": np.stack([each.bands[start:end] for each in spectra]),
        "band_errors": np.stack(
            [np.sqrt((each.bands_error[start:end] ** 2).mean(axis=0)) for each in spectra]
        ),
        "doses": np.stack([each.equivalent_daylight[start:end] for each in spectra]),
        "dose_errors": np.stack([each.equivalent_daylight_error[start:end] for each in spectra]),
    }


def _is_sphere(kind) -> bool:
    return isinstance(kind, tuple) and kind[0] == INTENSITY


def _is_of_all_light(kind) -> bool:
    """Whether sensors tell of all light together: ratings do not add up, and a luminaire is measured as it is."""
    return kind == GLARE or _is_sphere(kind)


def _difference(before: Scene, after: Scene) -> SceneDelta:
    """What makes one scene of another."""
    changed, removed = [], []
    for name in ("pixels", "geometries", "materials", "meshes", "lights"):
        old, new = getattr(before, name), getattr(after, name)
        changed += [item for key, item in new.items() if old.get(key) is not item]
        removed += sorted(old.keys() - new.keys())
    if after.world is not before.world:
        changed += [after.world] if after.world is not None else []
        if before.world is not None and (after.world is None or after.world.id != before.world.id):
            removed.append(before.world.id)
    if after.modelling != before.modelling:
        changed.append(after.modelling)
    return SceneDelta(changed=tuple(changed), removed=tuple(removed))


def _share(rule: StopRule, whole: np.ndarray, parts: int) -> StopRule:
    """Rule of each of several parts whose sum is to meet a rule; ``whole``: the sum, as far as it is known. [lx]"""
    if rule.each is None:
        return rule
    scale = np.maximum(whole, max(rule.floor, LEAST_PART * float(whole.mean())))
    limits = rule.each * scale / np.sqrt(parts)
    return replace(rule, each=None, limits=tuple(map(float, limits)))


def _shortfall(rule: StopRule, found) -> str:
    """What of a rule the sum of light groups has not met."""
    mean = sum(each.values for each in found)
    error = np.sqrt(sum(each.errors**2 for each in found))
    estimate = Estimate(mean, error, found[0].samples)
    return rule.shortfall(estimate.relative_error(), each=estimate.largest_error(rule.floor))


def _follow(progress, step: int, steps: int, name: str):
    """Progress of all steps from that of one of them."""
    if progress is None:
        return None

    def follow(state: Progress) -> None:
        stage = f"light group {name}" if name else state.stage
        progress(replace(state, done=(step + state.done) / steps, stage=stage))

    return follow
