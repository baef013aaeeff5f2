"""Illuminance at sensors: what a session asks for, by full paths or by cells, with all that their errors have to hold."""

from dataclasses import dataclass

import numpy as np

from ...accuracy.estimate import Estimate
from ...accuracy.lost_samples import tell_lost
from ...accuracy.stopping import Clock, StopRule
from ...photometry.alpha_opic import RECEPTORS
from ...photometry.units import LUMINOUS_EFFICACY
from ...scene.sensor import SensorColour, SensorKind
from ..light_tracing.bent_lights import bent_lights
from ..light_tracing.blur import find_blur
from ..light_tracing.bright_spots import bright_spots
from ..light_tracing.known_directions import KnownDirections
from ..light_tracing.near_rays import near_rays
from ..paths import gather
from ..paths.illuminance import FALL, STAGE, Receivers, compute, finish
from ..paths.light_learning import learn
from ..paths.spectral_meter import band_edges
from ..paths.visible_surfaces import Sight
from ..pictures.view_cells import Division, ViewCells
from ..witness.sensors import STAGE as WITNESS_STAGE
from ..witness.sensors import SensorTestimony, expect_work, hear_sensors
from .cell_job import CellJob
from .file_errors import find_file_errors, has_open_files
from .lateness import ENDLESS, late_bounds
from .method import BUDGET, FEWEST_PATHS, Choice

GROUPS = 16
"""Independent groups of samples: enough for an error of each sensor, within 18 % of itself."""

CELLS, MOST_CELLS = 12_000, 48_000
"""How many cells there are, about, whatever the number of sensors, as each of them looks at all of a room: of jobs for which
cells just pay, and of long ones, which read them so often that more of them, which are off by less, cost next to nothing."""

LOOKS = 1 << 16
"""Rays that find which surfaces matter."""

PILOT, MOST_PILOT = 1 << 16, 1 << 10
"""Samples of all sensors together that tell how much of the asked error samples cannot lower, and most of one of them."""


@dataclass(frozen=True)
class Reading:
    """What sensors tell.

    Parameters
    ----------
    estimate : Estimate    As of `illuminance.compute`. [lx]
    decisions, notes : tuple of str    For people.
    balance : dict or None    Of the second witness, see `WitnessReport.balance`. [lm]
    has_common_errors : bool    Whether errors of sensors have much in common, such as cells that all read.
    """

    estimate: Estimate
    decisions: tuple[str, ...]
    notes: tuple[str, ...]
    balance: dict | None
    has_common_errors: bool = False


def measure(
    scene,
    positions,
    normals,
    rule: StopRule,
    seed: int = 0,
    kind: SensorKind = SensorKind.PLANAR,
    reflections: int | None = None,
    colour: SensorColour | bool = False,
    method: str = "auto",
    witness: bool = True,
    progress=None,
    cancelled=lambda: False,
) -> Reading:
    """Measure at points of a compiled scene; parameters as of `Session.measure`.

    Raises
    ------
    SceneError    A position, a normal or the method is not usable.
    Cancelled    When ``cancelled`` answered true.
    """
    receivers = Receivers.at_points(positions, normals, kind)
    seen = receivers.outlooks(scene)
    heard, spent = None, scene.requirements.spent
    with (
        near_rays(scene, seen[0]) as kept,
        bent_lights(scene) as notes,
        bright_spots(scene, *seen),
    ):
        made = _Measuring(scene, receivers, rule, seed, colour, progress, cancelled)
        # Lamps at one place and nothing else: no path from them meets anything.
        witness = witness and len(receivers.start) > 0 and scene.radius > 0.0
        if witness:
            made.clock.after = lambda samples: expect_work(samples, len(receivers.start))
        made.leave_room(kind, reflections)
        estimate, decision, more = made.run(method, reflections)
        blur = find_blur(
            scene, receivers, estimate.samples, seed, reflections, cancelled, made.known
        )
        if blur.any():
            estimate = estimate.widened(blur)
        if spent:
            bright = estimate.channel(1) if colour else estimate
            wider, late = late_bounds(scene, receivers, bright, seed, cancelled)
            estimate = estimate.widened((spent + wider) * bright.mean)
            more = (*more, *late)
        if witness:
            made.tell(WITNESS_STAGE, estimate)
            bright = estimate.channel(1) if colour else estimate
            asked = positions, normals, kind, bright, seed, reflections, cancelled
            heard = hear_sensors(scene, *asked)
            estimate = estimate.widened(heard.floors)
        bright = estimate.channel(1) if colour else estimate
        open_errors = _find_open(scene, receivers, kind, bright)
        more = (*more, *_tell_open(open_errors, bright))
        estimate = estimate.widened(open_errors) if open_errors.any() else estimate
    whole = estimate.samples * len(estimate.mean)
    notes = (*notes, *kept, *more, *tell_lost({"samples": (estimate.lost, whole)}))
    # What is left out of a scene, or not known of a lamp, is wrong at all sensors alike.
    has_common = made.reads_cells or spent > 0.0 or bool(open_errors.any())
    if heard is None:
        return Reading(estimate, (decision,), notes, None, has_common)
    decisions = (decision, heard.decision) if heard.decision else (decision,)
    return Reading(estimate, decisions, (*notes, *heard.notes), heard.balance, has_common)


def confirm(
    scene,
    positions,
    normals,
    kind: SensorKind,
    found: Estimate,
    seed: int,
    reflections: int | None = None,
    cancelled=lambda: False,
) -> SensorTestimony | None:
    """Have the second witness look at a measurement that was made elsewhere; parameters as of `hear_sensors`.

    Returns
    -------
    SensorTestimony or None    None where there is nothing to look at: no sensors, or no surfaces.
    """
    if not len(found.mean) or not scene.radius > 0.0:
        return None
    seen = Receivers.at_points(positions, normals, kind).outlooks(scene)
    with near_rays(scene, seen[0]), bent_lights(scene), bright_spots(scene, *seen):
        return hear_sensors(scene, positions, normals, kind, found, seed, reflections, cancelled)


def spectral_fields(estimate: Estimate) -> dict:
    """Fields of `SensorSpectra` of an estimate with the channels of `spectral_meter` behind X, Y and Z."""
    mean, error, receptors = estimate.mean, estimate.standard_error, slice(3, 3 + len(RECEPTORS))
    bands, bands_error = (each[:, receptors.stop :] / LUMINOUS_EFFICACY for each in (mean, error))
    return {
        "edges": band_edges(),
        "bands": bands,
        "bands_error": bands_error,
        "equivalent_daylight": mean[:, receptors],
        "equivalent_daylight_error": error[:, receptors],
    }


def _find_open(scene, receivers: Receivers, kind: SensorKind, bright: Estimate) -> np.ndarray:
    """What ray files leave open of illuminances. (n,) [lx]"""
    places = receivers.positions, receivers.normals
    return find_file_errors(scene, *places, kind, bright.mean, scene.bent is not None)


def _tell_open(errors: np.ndarray, rest: Estimate) -> tuple[str, ...]:
    """Say if most of what is stated are gaps between the rays of files. ``errors``: by these [lx]; ``rest``: without."""
    if not (errors**2).sum() > (rest.standard_error**2).sum():
        return ()
    share = 100.0 * np.sqrt((errors**2).mean()) / rest.mean.mean()
    return (
        f"most of the stated errors, {share:.2g} % of the mean, is what ray files leave open between their rays: more "
        "samples do not lower it, files of more rays do",
    )


class _Measuring:
    """A measurement by the method that suits it."""

    def __init__(self, scene, receivers: Receivers, rule, seed, colour, progress, cancelled):
        self.scene, self.receivers, self.rule, self.seed = scene, receivers, rule, seed
        self.colour, self.progress, self.cancelled = colour, progress, cancelled
        self.clock = Clock(rule, STAGE, fall=FALL)
        known = KnownDirections(scene, receivers, seed, rule.samples, cancelled)
        self.known = known if known.is_useful else None
        self.reads_cells = False

    def leave_room(self, kind: SensorKind, reflections: int | None) -> None:
        """Have samples make up for the errors that they do not lower, as a few of them tell how large these are."""
        asked, spent = self.rule, self.scene.requirements.spent
        count = len(self.receivers.start)
        is_open = has_open_files(self.scene)
        if not count or asked.relative_goal is None or not (spent or is_open):
            return
        few = int(np.clip(PILOT // count, GROUPS, MOST_PILOT))
        made = self._by_paths(reflections, rule=StopRule(samples=few))
        bright = made.channel(1) if self.colour else made
        shares = np.full(count, spent)
        if is_open:
            found = _find_open(self.scene, self.receivers, kind, bright)
            shares = np.hypot(shares, found / np.maximum(bright.mean, 1e-300))
        self.rule = self.clock.rule = asked.beside_shares(shares, bright)
        self.clock.restart()

    def tell(self, stage: str, made: Estimate) -> None:
        """Tell of what is done after the samples."""
        if self.progress is not None:
            bright = made.channel(1) if self.colour else made
            error = bright.relative_error(self.receivers.weights)
            self.progress(self.clock.progress(made.samples, error, stage))

    def run(self, method: str, reflections: int | None) -> tuple[Estimate, str, tuple[str, ...]]:
        """The estimate, how it was made, and notes on it."""
        count = len(self.receivers.start)
        if reflections is None:
            method = self.scene.requirements.method_of(method)
        choice = Choice(self.scene, self.rule, count, method, reflections)
        made, notes = None, ()
        if count and choice.uses_cells is None:
            made = self._by_paths(None, choice)
        if made is None and count and choice.uses_cells:
            made, notes = self._by_cells(choice, is_forced=method == "cells")
            self.reads_cells = made is not None
        if made is None:
            self.clock.restart()
            made = self._by_paths(reflections)
        if made.fewest_most is not None:
            fewest, most = made.fewest_most
            told = f"sensors have as many samples as they need: {fewest} to {most}, {made.samples} on the mean"
            notes = (*notes, told)
        return made, choice.reason, notes

    def _by_paths(
        self, reflections, choice: Choice | None = None, rule: StopRule | None = None
    ) -> Estimate | None:
        if reflections is None and self.scene.requirements.late:
            # With the kernel that `late_bounds` uses.
            reflections = ENDLESS
        leaves = {} if choice is None else {"leaves": choice.leaves}
        return compute(
            self.scene,
            self.receivers,
            self.rule if rule is None else rule,
            self.seed,
            GROUPS,
            self.progress if rule is None else None,
            self.cancelled,
            reflections,
            self.colour,
            self.known,
            self.clock if rule is None else None,
            by_need=not self.scene.requirements.samples_evenly,
            **leaves,
        )

    def _by_cells(self, choice: Choice, is_forced: bool) -> tuple[Estimate | None, tuple[str, ...]]:
        """The estimate and notes on it; None where cells are off by too much."""
        scene = self.scene
        places, normals = self.receivers.outlooks(scene)
        spots, scene.spots = scene.spots, None
        try:
            learn(scene, places, normals.astype(np.float32), gather.typical_wavelengths())
            rows = np.random.default_rng([self.seed & 0xFFFFFFFF, 6]).integers(
                0, len(places), LOOKS
            )
            wanted = int(np.clip(CELLS * choice.paths / FEWEST_PATHS, CELLS, MOST_CELLS))
            sight = Sight(scene, places[rows], normals[rows], self.seed)
            division = Division(scene, sight, wanted, reads_all=True)
            cells = ViewCells(scene, division, self.seed, self.cancelled, groups=GROUPS)
            if not cells:
                choice.uses_cells, choice.reason = False, "no surface is matt: full paths"
                return None, ()
            if self.progress is not None:
                self.progress(self.clock.progress(0, float("inf"), "light of the cells"))
            cells.prepare()
            job = CellJob(
                scene,
                self.receivers,
                self.rule,
                self.seed,
                GROUPS,
                self.colour,
                cells,
                self.known,
                self.clock,
                self.progress,
                self.cancelled,
            )
            self.clock.restart()
            most = (np.inf, np.inf) if is_forced else (BUDGET, choice.most_held)
            made, bias = job.run(choice.paths, *most)
        finally:
            scene.spots = spots
        if made is None:
            choice.refuse(bias)
            return None, ()
        return finish(made, self.colour), (bias.note(),)
