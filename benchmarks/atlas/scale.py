"""Large bakes: millions of triangles, thousands of charts, dozens of pages. Each in a process of its own, for its memory.

That process is ``python -m lumenray.benchmarks.atlas.scale SPECIFICATION OUT``. Without arguments all of them are baked.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from ...engine.errors import LumenrayError
from ..common.machine import OtherLoad, describe_machine

CACHE = Path("out/atlas/scale.json")
"""Results of the last time, for the document."""

PATIENCE = 7200.0
"""Longest that a bake may take. [s]"""

SIDE = 2048
"""Of a page. [lumel]"""

FILLED = 0.85
"""Share of a page that charts cover, for the density that fills so many of them."""

SAMPLES = 4
"""Per lumel: enough to see what everything else takes."""

CHARTS = 10_000

MEMORY = 16.0
"""Most that a bake may take. [GiB]"""


@dataclass(frozen=True)
class Specification:
    """A bake: so many triangles, charts, and pages."""

    triangles: int
    charts: int
    pages: int


RUNS = (
    Specification(1_000_000, CHARTS, 3),
    Specification(2_000_000, CHARTS, 3),
    Specification(4_000_000, CHARTS, 3),
    Specification(4_000_000, CHARTS, 12),
    Specification(4_000_000, CHARTS, 50),
)
"""Triangles grow first, then lumels."""


def measure_scale(say, runs: tuple[Specification, ...] = RUNS, cache: Path = CACHE) -> dict:
    """Measure all runs and keep them. What was ended before its last run is gone on with.

    Returns
    -------
    dict    ``machine``, ``samples``, ``other_load``, ``is_whole`` and ``runs``: see `bake_building`.
    """
    earlier = read_scale(cache)
    load, rows = OtherLoad(), []
    if earlier is not None and not earlier.get("is_whole", True):
        rows = earlier["runs"]
    for run in runs[len(rows) :]:
        row = _in_child(run)
        rows.append(row)
        say(
            f"{row['triangles']} triangles, {row['charts']} charts, {row['lumels']} lumels on {row['pages']} pages: "
            f"{row['seconds']:.0f} s, {row['memory']:.1f} GiB"
        )
        made = {"machine": describe_machine(), "samples": SAMPLES, "runs": rows}
        made |= {"other_load": load.share(), "is_whole": len(rows) == len(runs)}
        cache.parent.mkdir(parents=True, exist_ok=True)
        cache.write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")
    return made


def read_scale(cache: Path = CACHE) -> dict | None:
    """Return the results of the last time, None where there are none."""
    try:
        return json.loads(cache.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None


def _in_child(run: Specification) -> dict:
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "row.json"
        try:
            made = subprocess.run(
                [sys.executable, "-m", __spec__.name, json.dumps(asdict(run)), str(path)],
                capture_output=True,
                timeout=PATIENCE,
                check=False,
            )
        except subprocess.TimeoutExpired as error:
            raise LumenrayError(f"the bake of {run} took longer than {PATIENCE:g} s") from error
        if made.returncode:
            said = made.stderr.decode(errors="replace").strip().splitlines() or ["no message"]
            raise LumenrayError(f"the bake of {run} ended with {made.returncode}: {said[-1]}")
        return json.loads(path.read_text(encoding="utf-8"))


def bake_building(run: Specification) -> dict:
    """Bake a building in this process.

    Returns
    -------
    dict    ``triangles``, ``charts``, ``lumels``, ``pages``, ``setup``, ``tracing`` and ``finishing``: times before the
        first samples, of the samples, and after the last ones [s], ``seconds``: all, ``memory``: peak [GiB],
        ``memory_before``: peak before the bake [GiB], ``not_finite``: maps whose mean is no number, ``density``, ``shrink``,
        ``samples``.
    """
    from ...engine.accuracy.stopping import StopRule
    from ...engine.baking.order import BakeOrder
    from ...engine.scene.scene import SceneDelta
    from ...engine.session import Session
    from .building import CHARTS as CHARTS_OF_ROOM
    from .building import SURFACE, build_building, count_triangles

    rooms = run.charts / CHARTS_OF_ROOM
    density = float(np.sqrt(FILLED * run.pages * SIDE**2 / (rooms * SURFACE)))
    scene = build_building(run.triangles, run.charts, density)
    session = Session(witness=False)
    session.apply(SceneDelta(changed=scene.items))
    before, begin = _peak(), time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        order = BakeOrder(
            scene.objects,
            StopRule(samples=SAMPLES),
            density=density,
            largest=SIDE,
            pages=run.pages,
            seed=1,
            folder=folder,
            keep_pages=False,
        )
        result = session.bake_objects(order)
        seconds = time.perf_counter() - begin
    marks = result.history.marks
    setup = result.history.setup_seconds
    traced = marks[-1].seconds if marks else setup
    return {
        "triangles": count_triangles(scene),
        "charts": sum(made.charts for made in result.maps),
        "lumels": sum(made.lumels for made in result.maps),
        "pages": len(result.pages),
        "setup": setup,
        "tracing": traced - setup,
        "finishing": seconds - traced,
        "seconds": seconds,
        "memory": _peak(),
        "memory_before": before,
        "not_finite": sum(not np.isfinite(made.mean) for made in result.maps),
        "density": float(np.mean([made.density for made in result.maps])),
        "shrink": result.shrink,
        "samples": float(np.mean([made.samples for made in result.maps])),
    }


def _peak() -> float:
    """Most memory that this process ever held. [GiB]"""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 2**30


def growth(rows: list[dict]) -> float | None:
    """Exponent of the time in the lumels, over the runs with the most triangles; 1 is linear, None if there is but one."""
    most = max(row["triangles"] for row in rows)
    mine = [row for row in rows if row["triangles"] == most]
    if len(mine) < 2:
        return None
    x, y = (np.log([row[name] for row in mine]) for name in ("lumels", "seconds"))
    return float(np.polyfit(x, y, 1)[0])


if __name__ == "__main__" and len(sys.argv) == 1:
    measure_scale(print)
elif __name__ == "__main__":
    row = bake_building(Specification(**json.loads(sys.argv[1])))
    Path(sys.argv[2]).write_text(json.dumps(row), encoding="utf-8")
