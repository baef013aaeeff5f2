"""The passes of a bake: a job for every layer, from the first one that finds even charts to the last that meets the rule."""

import time
from dataclasses import dataclass, field, replace

import numpy as np

from ..accuracy.stopping import Progress, StopRule
from ..atlas.detail import halve_even_charts
from ..errors import Cancelled
from ..scene.scene import Scene
from ..transport.light_tracing.light_paths import LightTracer
from ..transport.lux_maps.bands import TOLERANCE as BAND_TOLERANCE
from ..transport.lux_maps.bands import interpolation_error
from ..transport.lux_maps.job import LuxJob, Options
from .estimates import estimate_lumels
from .host import Host
from .layer import Layer
from .layer_state import Ending, LayerState
from .light_layers import split_lights
from .notes import Notes
from .order import BakeOrder
from .pages import lay_out_page
from .planning import SHORT
from .saver import Saver
from .surfaces import Ground

LAYER_SEEDS = 1_000_003
"""Distance between the seeds of layers."""

FIRST_PASS_SAMPLES = 16
"""Samples per lumel of the pass that finds out which charts are even."""

MOST_ADAPTIVE = 20_000_000
"""Lumels beyond which all get samples alike: what is kept of every one would not fit the memory."""


@dataclass
class Passes:
    """What makes and runs the jobs of a bake.

    Parameters
    ----------
    host : Host
    order : BakeOrder
    options : Options or None    How the jobs work; None: as the order and the scene want it.
    notes : Notes
    saver : Saver
    stopped : list of str    Layers that were ended before their rule was met.
    """

    host: Host
    order: BakeOrder
    options: Options | None
    notes: Notes
    saver: Saver
    stopped: list[str] = field(default_factory=list)

    def find_factors(self, compiled, ground: Ground):
        """Find the charts that turn out even in a first pass; returns what `arrange_charts` takes."""
        ending = Ending(self.host.cancelled)
        job = self._job(compiled, ground, ending, self.order.seed)
        # Whatever the rule: a bake that goes on with another one has to find the same layout.
        rule = StopRule(samples=FIRST_PASS_SAMPLES)
        count = len(ground.surfaces)
        layer = Layer(job, rule, ground.owners, self.notes.report, lambda _: None, count, ending)
        try:
            state = layer.run()
        finally:
            job.close()
        atlas, table = ground.atlas, ground.table
        estimates = estimate_lumels([("", state)], self.order, table, len(atlas.layouts))
        area = np.where(job.valid, job.area, 0.0)
        mean = float((estimates.illuminance * area).sum() / max(area.sum(), 1e-300))
        pages = [
            lay_out_page(number, atlas, table, estimates, 0)[0]
            for number in range(len(atlas.sizes))
        ]
        return halve_even_charts(
            atlas,
            [page.illuminance for page in pages],
            [page.covered for page in pages],
            [page.chart for page in pages],
            self.order.detail * mean,
        )

    def run(self, compiled, ground: Ground) -> list[tuple[str, LayerState]]:
        """States of all layers by name; a single one without a name where no groups are asked for.

        Raises
        ------
        Cancelled    The host said so; what there is has been saved.
        """
        order, saver = self.order, self.saver
        scenes: list[tuple[str, Scene | None]] = []
        if order.groups:
            scenes = list(split_lights(self.host.scene, order.groups))
        scenes = scenes or [("", None)]
        rule = order.rule.beside(compiled.requirements.spent)
        if rule.seconds is not None:
            rule = replace(rule, seconds=rule.seconds / len(scenes))
        saver.read_states(rule, len(scenes), sum(ground.table.counts))
        for number, (name, scene) in enumerate(scenes):
            if saver.is_finished(number):
                continue
            is_late = self.host.stopped() and saver.state(number) is None
            if is_late:
                # The whole needs every layer; one for which there is no time left gets a few samples.
                rule = StopRule(samples=SHORT)
            ending = Ending(self.host.cancelled, _never if is_late else self.host.stopped)
            own = compiled if scene is None else self.host.compiled(scene, compiled)

            def report(state: Progress, number=number, name=name) -> None:
                self.notes.report(_part_of(state, number, len(scenes), name))

            # Errors of layers add up as those of independent estimates.
            seed = order.seed if order.pass_seed is None else order.pass_seed
            job = self._job(own, ground, ending, seed + LAYER_SEEDS * number)
            layer = Layer(
                job,
                rule,
                ground.owners,
                report,
                (lambda _: None) if is_late else saver.saving(number),
                len(ground.surfaces),
                ending,
                self.notes.start if number == 0 else time.perf_counter(),
            )
            try:
                state = layer.run(saver.state(number))
            except Cancelled:
                saver.write()
                raise
            finally:
                job.close()
            saver.finish(number, state, is_late)
            if is_late or not state.is_done:
                self.stopped.append(name)
        if self.stopped:
            saver.write()
        return [(name, saver.state(number)) for number, (name, _) in enumerate(scenes)]

    # ---- private ----

    def _job(self, compiled, ground: Ground, ending: Ending, seed: int) -> LuxJob:
        """Make the job of a layer."""
        self.notes.name_stage("learning where light comes from")
        missed = ground.find_missed(compiled)
        options = self.options or self._choose_options(compiled, sum(ground.table.counts))
        tracer = self._make_tracer(compiled, has_near=missed is None)
        try:
            job = LuxJob(
                compiled,
                ground.table,
                seed,
                options,
                ending,
                tracer,
                lambda: ground.finder(compiled),
                missed,
            )
        except BaseException:
            # What is traced of ray sets is missing from next-event until then.
            if tracer is not None:
                tracer.close()
            raise
        if job.straight is not None and job.straight.is_needed:
            self.notes.decisions.append(job.straight.reason)
        if missed is not None:
            self.notes.decisions.append(
                "some maps lie on what takes no part in light or only mirrors: nothing is traced to small bright spots"
            )
        for note in job.bent.notes if job.bent else ():
            self.notes.depart("caustics", note, "on maps that traced light does not reach")
        return job

    def _choose_options(self, compiled, count: int) -> Options:
        cells, reason = self._choose_method(compiled)
        self.notes.decisions.append(reason)
        return Options(
            cells=cells,
            exitance=self.order.exitance,
            adaptive=count <= MOST_ADAPTIVE,
            fineness=self.saver.fineness,
        )

    def _choose_method(self, compiled) -> tuple[bool, str]:
        """Whether to read the radiance beyond the first bounce from cells, and why."""
        method = compiled.requirements.method_of(self.order.method)
        if method == "paths":
            return False, "full paths are asked for"
        spectra = [] if compiled.requirements.spectral is False else compiled.light_spectra
        error = interpolation_error(compiled.mean_light, spectra)
        if method == "auto" and error > BAND_TOLERANCE:
            return False, (
                f"the lights' spectra are so unlike that cells would be wrong by up to {100.0 * error:.2g} %: full paths"
            )
        return True, "the radiance beyond the first bounce is read from cells; the bias is measured"

    def _make_tracer(self, compiled, has_near: bool) -> LightTracer | None:
        """Return what traces light over bends; None where that is switched off, which is told if light is lost."""
        if self.order.caustics == "off":
            tracer = LightTracer(compiled)
            tracer.close()
            if tracer.is_needed:
                self.notes.depart(
                    "caustics",
                    f"tracing from the lights is off, but {tracer.reason}",
                    "that light is missing",
                    is_error=True,
                )
            return None
        tracer = LightTracer(compiled, has_near=has_near)
        if tracer.is_needed or tracer.rays.is_kept_point:
            self.notes.decisions.append(tracer.reason)
        elif self.order.caustics == "on":
            self.notes.depart(
                "caustics",
                "no light can reach a surface over smooth glass or a curved mirror unseen",
                "nothing is traced over bends",
            )
        return tracer


def _never() -> bool:
    return False


def _part_of(state: Progress, number: int, count: int, name: str) -> Progress:
    """Progress of a bake of ``count`` layers from that of one of them."""
    if count == 1:
        return state
    done = (number + state.done) / count
    left = state.seconds * (1.0 - done) / done if done > 0.0 else None
    return replace(state, done=done, seconds_left=left, stage=f"{name}: {state.stage}")
