"""The bake: from objects of a scene to finished pages.

Charts on pages, lumels, passes until the rule is met (layer by layer where light groups are asked for), then the pages:
filling, seams, smoothing, files.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ..accuracy.extremes import Extreme, Halves, find_largest, find_least, part_by_mean
from ..accuracy.history import History
from ..accuracy.stopping import Progress, StopRule, format_seconds
from ..accuracy.tails import tail_factor
from ..atlas.arrange import arrange, find_all_charts
from ..atlas.detail import halve_even_charts
from ..atlas.finder import LumelFinder
from ..atlas.layout import Atlas, Charts
from ..atlas.lumels import LumelTable
from ..atlas.smoothing import smooth_maps
from ..atlas.texture_density import texture_density
from ..errors import Cancelled, SceneError
from ..scene.mesh import Mesh
from ..scene.scene import Scene
from ..transport.compiled.surfaces import is_mirror, is_purely_specular
from ..transport.light_tracing.light_paths import LightTracer
from ..transport.lux_maps.bands import TOLERANCE as BAND_TOLERANCE
from ..transport.lux_maps.bands import interpolation_error
from ..transport.lux_maps.job import LuxJob, Options
from ..transport.lux_maps.tiles import tile_numbers
from .facets import find_facet_loss, tell_facet_loss
from .files import scale_top, write_page, write_report
from .layer import CHUNK, SHORT, Ending, Layer, LayerState
from .light_layers import split_lights
from .means import ObjectMean, find_means
from .order import AtlasPage, BakeOrder, BakeResult, Departure, Layout, LuxMap, Seams
from .pages import Estimates, lay_out_page, match_pages
from .saver import Saver
from .testimony import hear, widen

METHODS = ("auto", "cells", "paths")
SWITCH = ("auto", "on", "off")

LAYER_SEEDS = 1_000_003
"""Distance between the seeds of layers."""

FIRST_PASS_SAMPLES = 16
"""Samples per lumel of the pass that finds out which charts are even."""

MOST_ADAPTIVE = 20_000_000
"""Lumels beyond which all get samples alike: what is kept of every one would not fit the memory."""

MOST_MATCHED = 1 << 27
"""Pixels of all pages up to which seams are matched: all pages have to be at hand together."""

TILE_FREEDOM = 12.0
"""Degrees of freedom that the mean variance of a tile counts for in that of a lumel."""

OUTLYING = 1.645
"""Standard deviations beyond which a lumel's variance is its own: chance lifts one of twenty so far."""


@dataclass(frozen=True)
class Host:
    """What a bake needs of the session.

    Parameters
    ----------
    scene : Scene
    engine : callable    ``engine(transport)`` is a context that gives the compiled scene.
    compiled : callable    ``compiled(scene, like)`` compiles another scene for the same variant.
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


@dataclass
class _Item:
    """A layout and what belongs to it."""

    key: str
    mesh: Mesh
    density: float
    is_back: bool


@dataclass
class Bake:
    """One bake.

    Parameters
    ----------
    host : Host
    order : BakeOrder
    progress : callable or None    Gets a `Progress`.
    options : Options or None    How the job works, for measuring; None: as the order and the scene want it.
    """

    host: Host
    order: BakeOrder
    progress: Callable | None = None
    options: Options | None = None
    departures: list[Departure] = field(default_factory=list)
    _done: float = 0.0
    _decisions: list[str] = field(default_factory=list)
    _balance: dict | None = None
    _start: float = field(default_factory=time.perf_counter)
    _saver: Saver | None = None
    _stopped: list[str] = field(default_factory=list)

    def run(self) -> BakeResult:
        """Bake.

        Raises
        ------
        SceneError    Nothing of the order can be baked, or it makes no sense.
        Cancelled    The host said so; a checkpoint stays.
        FileFormatError    The order's checkpoint belongs to another bake; the text says what differs.
        """
        order = self.order
        _check(order)
        self._saver = Saver(order, self.host.scene)
        items = self._find_items()
        charts = self._find_charts(items)
        atlas = self._arrange(items, charts)
        with self.host.engine(order.transport) as compiled:
            table = self._make_table(items, atlas, compiled)
            if order.detail > 0.0:
                atlas = self._shrink_even(items, charts, atlas, table, compiled)
                table = self._make_table(items, atlas, compiled)
            layers = self._run_layers(compiled, table, items, atlas)
            states = [state for _, state in layers]
            estimates = _estimates(layers, order, table, len(atlas.layouts))
            means = find_means(len(items), table, estimates, states)
            floors = self._hear_witness(compiled, items, means)
            estimates = widen(estimates, means, floors)
            losses = self._find_facet_losses(items, means)
            samples = round(sum(s.sums.mean_samples for s in states))
            provenance = self.host.provenance(compiled, order.seed, samples, self._start)
            decisions = (*provenance.decisions, *dict.fromkeys(self._decisions))
            provenance = replace(provenance, decisions=decisions)
        self._report(Progress(1.0, samples, float("inf"), self._seconds, None, "finishing pages"))
        maps = self._summarise(items, atlas, means, floors, losses, estimates, states, provenance)
        pages, seams = self._make_pages(items, atlas, table, estimates, provenance)
        return self._finish(maps, pages, seams, table, estimates, states, atlas)

    # ---- before the passes ----

    @property
    def _seconds(self) -> float:
        return time.perf_counter() - self._start

    def _report(self, state: Progress) -> None:
        if self.progress is not None:
            # Forecasts go up and down; what people see goes up.
            self._done = max(self._done, state.done)
            self.progress(replace(state, done=self._done))

    def _find_items(self) -> list[_Item]:
        """Fronts of all objects, then backs of those that are baked on both sides."""
        order, scene = self.order, self.host.scene
        items = []
        for key in order.objects:
            if key not in scene.meshes:
                self.departures.append(
                    Departure(key, "the object has no surface that is rendered", "it is not baked", True)
                )  # fmt: skip
                continue
            mesh = scene.mesh(key)
            if len(mesh.triangles) == 0 or not mesh.areas().sum() > 0.0:
                self.departures.append(
                    Departure(mesh.name, "the object has no surface to bake", "it is not baked", True)
                )  # fmt: skip
                continue
            density = order.densities.get(key, order.density)
            if order.from_textures:
                density = max(density, texture_density(mesh, scene.materials))
            items.append(_Item(key, mesh, density, False))
        if not items:
            raise SceneError("nothing to bake: none of the objects has a surface that is rendered")
        wanted = set(order.two_sided)
        return items + [replace(each, is_back=True) for each in items if each.key in wanted]

    def _find_charts(self, items: list[_Item]) -> tuple[Charts, ...]:
        fronts = [item for item in items if not item.is_back]

        def report(done: int, count: int) -> None:
            stage = f"laying out {done} of {count}"
            self._report(Progress(0.0, 0, float("inf"), self._seconds, None, stage))

        return find_all_charts(
            [item.mesh for item in fronts],
            [item.density for item in fronts],
            cone=self.order.cone,
            progress=report,
            cancelled=self.host.cancelled,
        )

    def _arrange(self, items: list[_Item], charts: tuple[Charts, ...], factors=None) -> Atlas:
        order = self.order
        fronts = [item for item in items if not item.is_back]
        place = {item.key: number for number, item in enumerate(fronts)}
        atlas = arrange(
            [item.mesh for item in fronts],
            charts,
            [item.density for item in fronts],
            largest=order.largest,
            pages=order.pages,
            margin=order.margin,
            two_sided=tuple(place[item.key] for item in items if item.is_back),
            factors=factors,
        )
        if factors is None:
            self.departures += [
                Departure(name, message, "baked like that") for name, message in atlas.notes
            ]
        return atlas

    def _make_table(self, items, atlas: Atlas, compiled) -> LumelTable:
        self._report(Progress(0.0, 0, float("inf"), self._seconds, None, "finding lumels"))
        table = LumelTable([item.mesh for item in items], atlas)
        if sum(table.counts) == 0:
            raise SceneError(
                "no lumel lies on the surfaces of the objects; raise the lumels per metre"
            )

        def report(number: int, count: int) -> None:
            stage = f"finding lumels, {100 * number // count} %"
            self._report(Progress(0.0, 0, float("inf"), self._seconds, None, stage))

        table.validate(compiled, self.host.cancelled, report, self.order.seed)
        if not table.survey.valid.any():
            raise SceneError("all lumels lie inside solids: nothing of the objects can be seen")
        return table

    def _shrink_even(self, items, charts, atlas: Atlas, table, compiled) -> Atlas:
        """Lay out anew with fewer lumels on charts that turn out even in a first pass."""
        order = self.order
        ending = Ending(self.host.cancelled)
        job = self._job(compiled, table, items, atlas, ending)
        # Whatever the rule: a bake that goes on with another one has to find the same layout.
        rule = StopRule(samples=FIRST_PASS_SAMPLES)
        owners = _owners(table)
        try:
            state = Layer(job, rule, owners, self._report, lambda _: None, len(items), ending).run()
        finally:
            job.close()
        made = _estimates([("", state)], order, table, len(atlas.layouts))
        area = np.where(job.valid, job.area, 0.0)
        threshold = order.detail * float((made.illuminance * area).sum() / max(area.sum(), 1e-300))
        pages = [
            lay_out_page(number, atlas, table, made, 0)[0] for number in range(len(atlas.sizes))
        ]
        factors = halve_even_charts(
            atlas,
            [page.illuminance for page in pages],
            [page.covered for page in pages],
            [page.chart for page in pages],
            threshold,
        )
        return self._arrange(items, charts, factors)

    # ---- the passes ----

    def _choose_method(self, compiled) -> tuple[bool, str]:
        """Whether to read the radiance beyond the first bounce from cells, and why."""
        if self.order.method == "paths":
            return False, "the order asks for full paths"
        spectra = [] if compiled.requirements.spectral is False else compiled.light_spectra
        error = interpolation_error(compiled.mean_light, spectra)
        if self.order.method == "auto" and error > BAND_TOLERANCE:
            return False, (
                f"the lights' spectra are so unlike that cells would be wrong by up to {100.0 * error:.2g} %: full paths"
            )
        return True, "the radiance beyond the first bounce is read from cells; the bias is measured"

    def _job(self, compiled, table, items, atlas, ending: Ending, layer: int = 0) -> LuxJob:
        options = self.options
        if options is None:
            count = sum(table.counts)
            cells, reason = self._choose_method(compiled)
            self._decisions.append(reason)
            options = Options(
                cells=cells,
                exitance=self.order.exitance,
                adaptive=count <= MOST_ADAPTIVE,
                fineness=self._saver.fineness,
            )
        tracer = None
        missed = _find_missed(compiled, items, table)
        if self.order.caustics == "off":
            self._tell_missing(compiled)
        else:
            tracer = LightTracer(compiled, has_near=missed is None)
            if tracer.is_needed or tracer.rays.is_kept_point:
                self._decisions.append(tracer.reason)
            elif self.order.caustics == "on":
                self.departures.append(
                    Departure(
                        "caustics",
                        "no light can reach a surface over smooth glass or a curved mirror unseen",
                        "nothing is traced over bends",
                    )
                )

        def find_lumels() -> LumelFinder:
            keys, meshes = [item.key for item in items], [item.mesh for item in items]
            return LumelFinder(compiled, keys, meshes, atlas, table)

        # Errors of layers add up as those of independent estimates.
        seed = self.order.seed + LAYER_SEEDS * layer
        try:
            job = LuxJob(compiled, table, seed, options, ending, tracer, find_lumels, missed)
        except BaseException:
            # What is traced of ray sets is missing from next-event until then.
            if tracer is not None:
                tracer.close()
            raise
        if job.straight is not None and job.straight.is_needed:
            self._decisions.append(job.straight.reason)
        if missed is not None:
            self._decisions.append(
                "some maps lie on what takes no part in light or only mirrors: nothing is traced to small bright spots"
            )
        self.departures += [
            Departure("caustics", note, "on maps that traced light does not reach")
            for note in (job.bent.notes if job.bent else ())
        ]
        return job

    def _tell_missing(self, compiled) -> None:
        """Say what light a bake without paths from the lights lacks."""
        tracer = LightTracer(compiled)
        tracer.close()
        if tracer.is_needed:
            self.departures.append(
                Departure("caustics", f"tracing from the lights is off, but {tracer.reason}", "that light is missing", True)
            )  # fmt: skip

    def _run_layers(self, compiled, table, items, atlas) -> list[tuple[str, LayerState]]:
        """States of all layers by name; a single one without a name where no groups are asked for."""
        order = self.order
        scenes: list[tuple[str, Scene | None]] = [("", None)]
        if order.groups:
            scenes = list(split_lights(self.host.scene, order.groups))
        if not scenes:
            scenes = [("", None)]
        rule = order.rule
        if rule.seconds is not None:
            rule = replace(rule, seconds=rule.seconds / len(scenes))
        saver = self._saver
        saver.read_states(rule, len(scenes), sum(table.counts))
        owners = _owners(table)
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
                self._report(_part_of(state, number, len(scenes), name))

            layer = Layer(
                self._job(own, table, items, atlas, ending, number),
                rule,
                owners,
                report,
                (lambda _: None) if is_late else saver.saving(number),
                len(items),
                ending,
                self._start if number == 0 else time.perf_counter(),
            )
            try:
                state = layer.run(saver.state(number))
            except Cancelled:
                saver.write()
                raise
            finally:
                layer.job.close()
            saver.finish(number, state, is_late)
            if is_late or not state.is_done:
                self._stopped.append(name)
        if self._stopped:
            saver.write()
        return [(name, saver.state(number)) for number, (name, _) in enumerate(scenes)]

    # ---- after the passes ----

    def _hear_witness(self, compiled, items, means) -> np.ndarray:
        """What the error of each map must be at least by what light paths from the lights bring. (n,) [lx]"""
        if not self.order.witness:
            return np.zeros(len(items))
        self._report(
            Progress(1.0, 0, float("inf"), self._seconds, None, "light paths from the lights")
        )
        floors = np.zeros(len(items))
        met = {key for key, _, _ in compiled.parts()}
        known = [number for number, item in enumerate(items) if item.key in met]
        sides = [(items[n].key, items[n].is_back, items[n].mesh.name) for n in known]
        own = [means[n] for n in known]
        try:
            heard = hear(compiled, sides, own, self.order.seed, self.host.cancelled)
        except Cancelled:
            # The passes are done, and need not be made again.
            self._saver.write()
            raise
        self.departures += heard.departures
        self._balance = heard.balance
        floors[known] = heard.floors
        if known:
            self._decisions.append(heard.decision)
        # What takes no part in light, such as a measuring plane, no path meets. It may lack as much as the rest.
        others = [number for number in range(len(items)) if number not in known]
        if others:
            shares = [floors[n] / means[n].mean for n in known if means[n].mean > 0.0]
            share = max(shares, default=0.0)
            floors[others] = [share * means[n].mean for n in others]
            names = ", ".join(f"'{items[n].mesh.name}'" for n in others[:8])
            self._decisions.append(
                f"no light path meets {names}, so no second witness was heard; "
                + (
                    f"their errors hold the largest share that other maps may lack, {100.0 * share:.2g} %"
                    if known
                    else "bake what they lie before along with them to hear one"
                )
            )
        return floors

    def _find_facet_losses(self, items, means: list[ObjectMean]) -> np.ndarray:
        """What the mean of each map may be off by because facets are shaded smoothly. (n,) [lx]"""
        losses = {}
        for item in items:
            if item.key not in losses:
                losses[item.key] = find_facet_loss(item.mesh)
                self.departures += tell_facet_loss(item.mesh.name, losses[item.key])
        return np.array(
            [losses[item.key] * own.mean for item, own in zip(items, means, strict=True)]
        )

    def _summarise(
        self, items, atlas, means: list[ObjectMean], floors, losses, estimates, states, provenance
    ) -> list[LuxMap]:
        made = []
        each = zip(items, means, floors, losses, strict=True)
        for number, (item, own, floor, loss) in enumerate(each):
            layout, rows = atlas.layouts[number], own.rows
            error = estimates.standard_error[rows]
            parts = own.areas * error.astype(np.float64) ** 2
            heavy = float(tail_factor(parts.sum(), parts.max(initial=0.0), len(parts)))
            total = float(own.areas.sum())
            square = max(float(parts.sum()) - estimates.surplus[number], 0.0)
            whole = heavy * np.sqrt(square / total) if total > 0.0 else 0.0
            spread = float(np.hypot(own.error, floor))
            least, largest = _extremes(estimates, states, rows, own.mean, spread)
            made.append(
                LuxMap(
                    id=item.key,
                    name=item.mesh.name + (" (back)" if item.is_back else ""),
                    number=number,
                    lumels=own.count,
                    charts=len(np.unique(layout.chart[layout.chart >= 0])),
                    mean=own.mean,
                    least=least,
                    largest=largest,
                    relative_standard_error=whole / own.mean if own.mean > 0.0 else float("inf"),
                    # Lumels know nothing of what facets lose, see `facets`.
                    mean_standard_error=float(np.hypot(spread, loss)),
                    bias=own.bias,
                    bias_error=own.bias_error,
                    samples=_mean_samples(states, rows) if len(rows) else 0.0,
                    density=layout.density,
                    requested_density=layout.requested_density,
                    area=own.area,
                    invalid=own.count - len(rows),
                    smoothed=self.order.smooth,
                    provenance=provenance,
                    layout=_layout_of(item, layout, atlas.sizes),
                )
            )
        return made

    def _make_pages(self, items, atlas, table, estimates, provenance):
        order = self.order
        folder = None if order.folder is None else Path(order.folder)
        high = scale_top(estimates.illuminance)
        is_whole = int(np.prod(atlas.sizes, axis=1).sum()) <= MOST_MATCHED
        attributes = {
            "sceneHash": provenance.scene_hash,
            "seed": str(order.seed),
            "samples": str(provenance.samples),
            "replicates": str(estimates.replicates),
            "freedom": f"{estimates.freedom:g}",
        }
        pages, owners = [], []

        def finish(page: AtlasPage) -> AtlasPage:
            if order.smooth:
                page = _smoothed(page)
            if folder is not None:
                page = write_page(folder, page, attributes, high)
            return page if order.keep_pages else _emptied(page)

        for number in range(len(atlas.sizes)):
            if self.host.cancelled():
                raise Cancelled("cancelled")
            page, owner = lay_out_page(number, atlas, table, estimates, order.margin)
            pages.append(page if is_whole else finish(page))
            owners.append(owner)
        seams = Seams(0, 0.0, 0.0, 0.0)
        if is_whole:
            seams = match_pages(pages, owners, [item.mesh for item in items], atlas)
            pages = [finish(page) for page in pages]
        else:
            self.departures.append(
                Departure(
                    "atlas",
                    "the pages are too many to be at hand together",
                    "seams are not matched",
                )
            )
        return pages, seams

    def _finish(self, maps, pages, seams, table, estimates, states, atlas) -> BakeResult:
        order = self.order
        mean, rms, error = _whole(estimates, table)
        relative = error / mean if mean > 0.0 else float("inf")
        shortfall = order.rule.shortfall(relative, error)
        if shortfall:
            self.departures.append(
                Departure("all maps", shortfall, "they carry the error that was reached")
            )
        result = BakeResult(
            maps=tuple(maps),
            pages=tuple(pages),
            departures=tuple(self.departures),
            files=tuple(file for page in pages for file in page.files),
            history=_ended(
                _joined_history([state.forecaster.history for state in states]), relative
            ),
            relative_standard_error=relative,
            quadratic_relative_error=error / rms if rms > 0.0 else float("inf"),
            mean=mean,
            shrink=atlas.shrink,
            seams=seams,
            balance=self._balance,
            shortfall=_shortfall(order.rule, mean, error) if self._stopped else "",
        )
        if order.folder is not None:
            conversion = [*order.conversion, *(_report_row(each) for each in self.departures)]
            files = write_report(Path(order.folder), order, result, conversion)
            result = replace(result, files=(*result.files, *(str(file) for file in files)))
        if order.checkpoint is not None and not self._stopped:
            Path(order.checkpoint).unlink(missing_ok=True)
        return result


def _never() -> bool:
    return False


def _check(order: BakeOrder) -> None:
    for name, value, known in (
        ("method", order.method, METHODS),
        ("caustics", order.caustics, SWITCH),
    ):
        if value not in known:
            raise SceneError(f"{name} is '{value}', expected {', '.join(known)}")
    if not order.density > 0.0 or any(not value > 0.0 for value in order.densities.values()):
        raise SceneError("lumels per metre must be above 0")
    if order.largest < 16 or order.margin < 0 or order.pages < 0:
        raise SceneError(
            "pages need a side of 16 lumels at least, and margin and number of pages must not be negative"
        )


def _shortfall(rule: StopRule, mean: float, error: float) -> str:
    """Say what a bake that was stopped has, and what it should have. ``mean``, ``error`` [lx]"""
    wanted = []
    if rule.error is not None:
        wanted.append(f"{100.0 * rule.error:.2g} %")
    if rule.absolute is not None:
        wanted.append(f"{rule.absolute:.3g} lx")
    if rule.samples is not None:
        wanted.append(f"{rule.samples} samples")
    if rule.seconds is not None:
        wanted.append(format_seconds(rule.seconds))
    share = f"{100.0 * error / mean:.2g} % ({error:.3g} lx)" if mean > 0.0 else f"{error:.3g} lx"
    return f"stopped at an error of {share}; asked for: {' or '.join(wanted)}"


def _owners(table: LumelTable) -> np.ndarray:
    """Number of the layout of every lumel. (n,)"""
    return np.concatenate(
        [
            np.full(count, table.layout(number), dtype=np.int32)
            for number, count in enumerate(table.counts)
        ]
    )


def _find_missed(compiled, items, table: LumelTable) -> np.ndarray | None:
    """Lumels on which traced light never lands: no light meets them, or they only mirror. (n,) bool; None: none."""
    met = {
        key
        for key, _, material in compiled.parts()
        if not (is_purely_specular(material.surface) or is_mirror(material.surface))
    }
    missed = np.array([item.key not in met for item in items], dtype=bool)
    return missed[_owners(table)] if missed.any() else None


def _estimates(
    layers: list[tuple[str, LayerState]], order: BakeOrder, table: LumelTable, layouts: int
) -> Estimates:
    """Sum of all layers; their errors are independent. ``layouts``: how many there are."""
    count = sum(table.counts)
    light, error = np.zeros((2, count), dtype=np.float32)
    surplus = np.zeros(layouts)
    replicates = min(state.sums.passes for _, state in layers)
    first = 0
    for number, many in enumerate(table.counts):
        part = slice(first, first + many)
        first += many
        light[part] = sum(state.sums.mean(part) for _, state in layers)
        facts = table.facts(number)
        tiles = tile_numbers(facts, table.width(number))
        plain = np.zeros(many)
        for _, state in layers:
            own = state.sums.variance(part)
            plain += np.where(facts.valid & np.isfinite(own), own, 0.0)
        variance = sum(pool_variance(state.sums, part, tiles, facts.valid) for _, state in layers)
        error[part] = np.sqrt(variance)
        area = np.where(facts.valid, facts.area, 0.0).astype(np.float64)
        surplus[table.layout(number)] += float(area @ (variance - plain))
    named = {name: state.sums.mean().astype(np.float32) for name, state in layers if name}
    exitance = None
    if order.exitance:
        exitance = sum(state.sums.further_means() for _, state in layers)
    freedom = max(min(state.sums.degrees_of_freedom for _, state in layers), 1.0) + TILE_FREEDOM
    return Estimates(light, error, named, exitance, replicates, freedom, surplus)


def pool_variance(sums, part: slice, tiles: np.ndarray, valid: np.ndarray) -> np.ndarray:
    """Variance of some lumels' means, from their own passes and those of their tiles. (n,) [lx2]

    Where rare bright paths make the error, the passes of most lumels have seen none of them, and would state too little
    by themselves. So the mean over the tile counts as so many degrees of freedom. Where the own passes scatter more than
    those of such a tile do by chance, as at the edge of a shadow, they count alone. To the mean k such lumels of a tile
    are sqrt(k): a single one may be the rare path that the others wait for, many are more likely of another kind.
    """
    variance = sums.variance(part)
    is_known = valid & np.isfinite(variance)
    passes = sums.replicates(part)[is_known]
    freedom = max(float(passes.mean()) - 1.0, 1.0) if len(passes) else 1.0
    own = np.where(is_known, variance, 0.0)
    known = np.maximum(np.bincount(tiles, valid.astype(np.float64)), 1.0)
    # Wilson and Hilferty's quantile of chi-square over its degrees of freedom.
    spread = 2.0 / (9.0 * freedom)
    largest = (1.0 - spread + OUTLYING * np.sqrt(spread)) ** 3
    outlies = own > largest * (np.bincount(tiles, own) / known)[tiles]
    alike = np.bincount(tiles, own * ~outlies)
    alike += np.bincount(tiles, own * outlies) / np.sqrt(
        np.maximum(np.bincount(tiles, outlies), 1.0)
    )
    pooled = (freedom * own + TILE_FREEDOM * (alike / known)[tiles]) / (freedom + TILE_FREEDOM)
    return np.where(outlies, own, pooled)


def _mean_samples(states: list[LayerState], rows: np.ndarray) -> float:
    return float(np.mean([state.sums.samples(rows).mean() for state in states]))


def _extremes(
    estimates: Estimates, states: list[LayerState], rows: np.ndarray, mean: float, error: float
) -> tuple[Extreme, Extreme]:
    """Least and largest illuminance of an object of a mean illuminance with a standard error. [lx]"""
    if not len(rows):
        return Extreme(0.0, 0.0, 0.0), Extreme(0.0, 0.0, 0.0)
    sums = [state.sums for state in states]
    halves = Halves(
        estimates.illuminance[rows],
        estimates.standard_error[rows],
        sum(each.even(rows) for each in sums),
        sum(each.odd(rows) for each in sums),
        np.mean([each.even_share(rows) for each in sums], axis=0),
        estimates.freedom,
    )
    common = error / mean if mean > 0.0 else 0.0
    found = find_least(halves, common), find_largest(halves, common)
    return part_by_mean(*found, mean, error, estimates.freedom)


def _whole(estimates: Estimates, table: LumelTable) -> tuple[float, float, float]:
    """Mean, root mean square and standard error of everything, by area. [lx]"""
    known = table.survey
    sums, largest = np.zeros(4), 0.0
    for first in range(0, len(known.area), CHUNK):
        part = slice(first, first + CHUNK)
        area = np.where(known.valid[part], known.area[part], 0.0).astype(np.float64)
        light, error = estimates.illuminance[part], estimates.standard_error[part]
        parts = error**2 * area
        sums += [area.sum(), (light * area).sum(), (light**2 * area).sum(), parts.sum()]
        largest = max(largest, float(parts.max(initial=0.0)))
    mean, square, variance = sums[1:] / max(sums[0], 1e-300)
    variance = max(variance - float(estimates.surplus.sum()) / max(sums[0], 1e-300), 0.0)
    variance *= float(tail_factor(sums[3], largest, len(known.area))) ** 2
    return float(mean), float(np.sqrt(square)), float(np.sqrt(variance))


def _layout_of(item: _Item, layout, sizes: np.ndarray) -> Layout:
    page = np.maximum(layout.page, 0)
    uv = layout.uv / sizes[page][:, None, :]
    return Layout(
        uv.astype(np.float32),
        layout.page.astype(np.int32),
        item.mesh.triangles,
        item.mesh.polygon,
        len(item.mesh.vertices),
    )


def _smoothed(page: AtlasPage) -> AtlasPage:
    maps = [page.illuminance, *page.layers.values()]
    maps += [] if page.exitance is None else list(np.moveaxis(page.exitance, -1, 0))
    made = smooth_maps(np.stack(maps), page.standard_error, page.covered, page.chart)
    names = list(page.layers)
    exitance = None if page.exitance is None else np.moveaxis(made[-3:], 0, -1)
    layers = {name: made[1 + k] for k, name in enumerate(names)}
    return replace(page, illuminance=made[0], layers=layers, exitance=exitance)


def _emptied(page: AtlasPage) -> AtlasPage:
    names = ("illuminance", "standard_error", "covered", "area", "object", "chart", "exitance")
    return replace(page, layers={}, **dict.fromkeys(names))


def _part_of(state: Progress, number: int, count: int, name: str) -> Progress:
    """Progress of a bake of ``count`` layers from that of one of them."""
    if count == 1:
        return state
    done = (number + state.done) / count
    left = state.seconds * (1.0 - done) / done if done > 0.0 else None
    return replace(state, done=done, seconds_left=left, stage=f"{name}: {state.stage}")


def _joined_history(histories: list[History]) -> History:
    """Histories one after the other; that of a single layer as it is."""
    if len(histories) == 1:
        return histories[0]
    marks, offset = [], 0.0
    for history in histories:
        marks += [
            replace(mark, seconds=mark.seconds + offset, forecast=None) for mark in history.marks
        ]
        offset = marks[-1].seconds if marks else offset
    return History(tuple(marks), histories[0].target, histories[0].setup_seconds)


def _ended(history: History, error: float) -> History:
    """With what is stated in the end, where that is more than passes knew of. ``error``: relative. [-]"""
    last = history.marks[-1] if history.marks else None
    if last is None or not last.error * (1.0 + 1e-3) < error < float("inf"):
        return history
    return replace(history, marks=(*history.marks, replace(last, error=error, forecast=None)))


def _report_row(departure: Departure) -> dict:
    return {
        "severity": "error" if departure.is_error else "warning",
        "object": departure.name,
        "node": "",
        "message": departure.message,
        "instead": departure.remedy,
        "count": 1,
    }
