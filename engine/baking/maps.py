"""Maps of single objects: what is stated of them."""

import numpy as np

from ..accuracy.extremes import Extreme, Halves, find_largest, find_least, part_by_mean
from ..accuracy.tails import tail_factor
from ..scene.provenance import Provenance
from .estimates import Estimates
from .layer_state import LayerState
from .means import ObjectMean
from .order import Layout, LuxMap
from .surfaces import BakedSurface, Ground


def make_maps(
    ground: Ground,
    means: list[ObjectMean],
    floors: np.ndarray,
    losses: np.ndarray,
    estimates: Estimates,
    states: list[LayerState],
    provenance: Provenance,
) -> list[LuxMap]:
    """State what is known of the map of each surface.

    Parameters
    ----------
    ground : Ground
    means : list of ObjectMean
    floors : (n,) array    What the error of each mean must be at least by a second witness. [lx]
    losses : (n,) array    What each mean may be off by because of facets. [lx]
    estimates : Estimates
    states : list of LayerState
    provenance : Provenance
    """
    maps = []
    each = zip(ground.surfaces, ground.atlas.layouts, means, floors, losses, strict=True)
    for number, (surface, layout, own, floor, loss) in enumerate(each):
        rows = own.rows
        whole = _whole_error(estimates, own)
        spread = float(np.hypot(own.error, floor))
        least, largest = _extremes(estimates, states, rows, own.mean, spread)
        maps.append(
            LuxMap(
                id=surface.key,
                name=surface.mesh.name + (" (back)" if surface.is_back else ""),
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
                provenance=provenance,
                layout=layout_of(surface, layout, ground.atlas.sizes),
            )
        )
    return maps


def layout_of(surface: BakedSurface, layout, sizes: np.ndarray) -> Layout:
    """Return where a surface's triangles lie, from its layout on pages of such sizes (p, 2). [lumel]"""
    page = np.maximum(layout.page, 0)
    uv = layout.uv / sizes[page][:, None, :]
    return Layout(
        uv.astype(np.float32),
        layout.page.astype(np.int32),
        surface.mesh.triangles,
        surface.mesh.polygon,
        len(surface.mesh.vertices),
    )


def _whole_error(estimates: Estimates, own: ObjectMean) -> float:
    """Root mean square by area of the errors of a map's lumels. [lx]"""
    errors = np.where(own.areas > 0.0, estimates.standard_error[own.rows], 0.0)
    parts = own.areas * errors.astype(np.float64) ** 2
    heavy = float(tail_factor(parts.sum(), parts.max(initial=0.0), len(parts)))
    total = float(own.areas.sum())
    square = max(float(parts.sum()) - estimates.surplus[own.number], 0.0)
    return heavy * np.sqrt(square / total) if total > 0.0 else 0.0


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
    ends = find_least(halves, common), find_largest(halves, common)
    return part_by_mean(*ends, mean, error, estimates.freedom)
