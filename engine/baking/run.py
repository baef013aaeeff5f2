"""The bake: from objects of a scene to finished pages.

Charts on pages, lumels, passes until the rule is met (layer by layer where light groups are asked for), then the pages:
filling, seams, smoothing, files.
"""

from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..accuracy.history import ended, join_histories
from ..accuracy.lost_samples import tell_lost
from ..accuracy.stopping import StopRule, format_seconds
from ..errors import Cancelled
from ..requirements.decision import Asked
from ..scene.provenance import Provenance
from ..transport.lux_maps.job import Options
from .estimates import Estimates, estimate_lumels, find_whole
from .facets import find_facet_losses
from .files import write_report
from .host import Host
from .layer_state import LayerState
from .lost_light import hold_lost_light
from .maps import make_maps
from .means import ObjectMean, find_means
from .notes import Notes
from .order import BakeOrder, BakeResult, Departure, check_order
from .pages import make_pages
from .passes import Passes
from .saver import Saver
from .simplified import hold_file_errors, hold_simplifications
from .surfaces import Ground, arrange_charts, find_charts, find_lumels, find_surfaces
from .testimony import HIDDEN, hear, widen


def bake(
    host: Host,
    order: BakeOrder,
    progress: Callable | None = None,
    options: Options | None = None,
    states: tuple[LayerState, ...] = (),
) -> BakeResult:
    """Bake.

    Parameters
    ----------
    host : Host
    order : BakeOrder
    progress : callable or None    Gets a `Progress`.
    options : Options or None    How the job works, for measuring; None: as the order and the scene want it.
    states : tuple of LayerState    Of all layers, where their passes were made elsewhere, see `sum_passes`; empty: they are
        made here.

    Raises
    ------
    SceneError    Nothing of the order can be baked, or it makes no sense.
    Cancelled    The host said so; a checkpoint stays.
    FileFormatError    The order's checkpoint belongs to another bake; the text says what differs.
    """
    check_order(order)
    notes = Notes(progress)
    passes = Passes(host, order, options, notes, Saver(order, host.scene))
    for number, state in enumerate(states):
        passes.saver.finish(number, state, is_late=False)
    # What was made elsewhere was made of the whole scene.
    light = _find_light(passes, None if states else order.rule.relative_goal)
    notes.name_stage("finishing pages", 1.0, light.provenance.samples)
    maps = make_maps(
        light.ground,
        light.means,
        light.floors,
        find_facet_losses(light.ground.surfaces, light.means, notes),
        light.estimates,
        light.states,
        light.provenance,
    )
    pages, seams = make_pages(
        light.ground, light.estimates, order, light.provenance, host.cancelled, notes
    )
    mean, rms, error = find_whole(light.estimates, light.ground.table)
    relative = error / mean if mean > 0.0 else float("inf")
    shortfall = order.rule.shortfall(relative, error)
    if shortfall:
        notes.depart("all maps", shortfall, "they carry the error that was reached")
    history = join_histories([state.forecaster.history for state in light.states])
    result = BakeResult(
        maps=tuple(maps),
        pages=tuple(pages),
        departures=tuple(notes.departures),
        files=tuple(file for page in pages for file in page.files),
        history=ended(history, relative),
        relative_standard_error=relative,
        quadratic_relative_error=error / rms if rms > 0.0 else float("inf"),
        mean=mean,
        shrink=light.ground.atlas.shrink,
        seams=seams,
        balance=light.balance,
        shortfall=_shortfall(order.rule, mean, error) if passes.stopped else "",
    )
    if order.folder is not None:
        conversion = [*order.conversion, *(_report_row(each) for each in notes.departures)]
        files = write_report(Path(order.folder), order, result, conversion)
        result = replace(result, files=(*result.files, *(str(file) for file in files)))
    if order.checkpoint is not None and not passes.stopped:
        Path(order.checkpoint).unlink(missing_ok=True)
    return result


@dataclass(frozen=True)
class _Light:
    """What a bake has computed: values of all lumels, means of all surfaces, and what the errors of these must hold."""

    ground: Ground
    states: list[LayerState]
    estimates: Estimates
    means: list[ObjectMean]
    floors: np.ndarray
    provenance: Provenance
    balance: dict | None


@contextmanager
def _lay_out(passes: Passes, goal: float | None):
    """Give the compiled scene for an error and the lumels on it."""
    host, order, notes = passes.host, passes.order, passes.notes
    surfaces = find_surfaces(order, host.scene, notes)
    charts = find_charts(surfaces, order, host.cancelled, notes)
    atlas = arrange_charts(surfaces, charts, order)
    for name, message in atlas.notes:
        notes.depart(name, message, "baked like that")
    asked = Asked(goal, order.exitance, frozenset(order.objects), places=())
    with host.engine(order.transport, asked) as compiled:
        ground = find_lumels(surfaces, atlas, compiled, order.seed, host.cancelled, notes)
        if order.detail > 0.0:
            factors = passes.find_factors(compiled, ground)
            atlas = arrange_charts(surfaces, charts, order, factors)
            ground = find_lumels(surfaces, atlas, compiled, order.seed, host.cancelled, notes)
        yield compiled, ground


def sum_passes(
    host: Host, order: BakeOrder, progress: Callable | None = None
) -> tuple[dict[str, np.ndarray], ...]:
    """Make passes of a bake, and nothing of what follows them.

    Parameters
    ----------
    host, order, progress    As of `bake`. Of several parts of one bake ``pass_seed`` differs and ``seed`` does not.

    Returns
    -------
    tuple of dict of str to array    State of every layer, as of `LayerState.arrays`, without what only more passes need,
        and ``area``: surface in each lumel, 0 where it has no light of its own. (n,) [m2]

    Raises
    ------
    SceneError, Cancelled    As of `bake`.
    """
    order = replace(order, checkpoint=None)
    check_order(order)
    notes = Notes(progress)
    passes = Passes(host, order, None, notes, Saver(order, host.scene))
    with _lay_out(passes, None) as (compiled, ground):
        layers = passes.run(compiled, ground)
        known = ground.table.survey
        area = np.where(known.valid, known.area, 0.0).astype(np.float32)
    return tuple(state.arrays(goes_on=False) | {"area": area} for _, state in layers)


def _find_light(passes: Passes, goal: float | None) -> _Light:
    host, order, notes = passes.host, passes.order, passes.notes
    with _lay_out(passes, goal) as (compiled, ground):
        layers = passes.run(compiled, ground)
        surfaces = ground.surfaces
        states = [state for _, state in layers]
        estimates = estimate_lumels(layers, order, ground.table, len(surfaces))
        means = find_means(len(surfaces), ground.table, estimates, states)
        floors, balance = np.zeros(len(surfaces)), None
        if order.witness:
            notes.name_stage("light paths from the lights", 1.0)
            try:
                testimony = hear(compiled, surfaces, means, order.seed, host.cancelled)
            except Cancelled:
                # The passes are done, and need not be made again.
                passes.saver.write()
                raise
            notes.departures += testimony.departures
            notes.decisions += testimony.decisions
            floors, balance = testimony.floors, testimony.balance
            estimates = widen(estimates, means, floors)
        estimates, floors = hold_lost_light(states, estimates, means, floors)
        spent = compiled.requirements.spent
        estimates, floors = hold_simplifications(estimates, means, floors, spent)
        estimates, floors = hold_file_errors(estimates, means, floors, ground.table, compiled)
        for name, state in layers:
            for told in tell_lost(state.losses.parts()):
                notes.depart(name or "all maps", told, HIDDEN)
        samples = round(sum(state.sums.mean_samples for state in states))
        provenance = host.provenance(compiled, order.seed, samples, notes.start)
    decisions = (*provenance.decisions, *dict.fromkeys(notes.decisions))
    provenance = replace(provenance, decisions=decisions)
    return _Light(ground, states, estimates, means, floors, provenance, balance)


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


def _report_row(departure: Departure) -> dict:
    return {
        "severity": "error" if departure.is_error else "warning",
        "object": departure.name,
        "node": "",
        "message": departure.message,
        "instead": departure.remedy,
        "count": 1,
    }
