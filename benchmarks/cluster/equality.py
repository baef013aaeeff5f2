"""Whether results have the same bits whatever becomes of workers, and how much faster more of them are."""

import hashlib
import os
import time

from ...engine.accuracy.stopping import StopRule
from ...engine.cluster.dask_crew import DaskCrew
from ...engine.cluster.hosts import LocalCluster
from ...engine.cluster.session import ClusterSession
from ...engine.errors import LumenrayError
from ...engine.scene.scene import SceneDelta
from ..common.machine import OtherLoad, describe_machine
from ..common.statistics import median
from .harm import Harm
from .kinds import SEED
from .room import build_room, place_sensors


def measure(cluster: LocalCluster, samples: int) -> tuple[str, float]:
    """Fingerprint of a measurement by the workers of a cluster, and what it took. [s]"""
    crew = DaskCrew(cluster.address, None)
    try:
        session = ClusterSession(crew)
        session.apply(SceneDelta(changed=build_room()))
        begin = time.perf_counter()
        made = session.measure(
            *place_sensors(), StopRule(samples=samples), SEED, method="paths", witness=False
        )
        seconds = time.perf_counter() - begin
    finally:
        crew.close()
    bits = made.illuminance.tobytes() + made.standard_error.tobytes()
    return hashlib.sha256(bits).hexdigest(), seconds


def measure_harm(runs: int, samples: int, say) -> dict:
    """Do the same job without harm and so often with it.

    Returns
    -------
    dict    ``samples``, ``rows`` with ``harm``, ``seconds`` and ``is_equal``; plain data.
    """
    rows = []
    with LocalCluster(2, threads=1) as cluster:
        # The first run of a process makes kernels.
        measure(cluster, samples)
        reference, span = measure(cluster, samples)
        for number in range(runs):
            with Harm(cluster, SEED + number, span) as harm:
                bits, seconds = measure(cluster, samples)
            row = {"harm": harm.done, "seconds": seconds, "is_equal": bits == reference}
            rows.append(row)
            say(
                f"run {number + 1}: {', '.join(harm.done) or 'nothing'}; {seconds:.1f} s; equal: {row['is_equal']}"
            )
    return {"samples": samples, "rows": rows}


def measure_efficiency(counts: tuple[int, ...], repeats: int, samples: int, say) -> dict:
    """Do the same job by several numbers of workers of one thread each.

    Returns
    -------
    dict    ``machine``, ``others`` (share of its processors that others had), ``samples``, ``is_equal`` (whether all results
        have the same bits), ``rows`` with ``workers``, ``seconds`` and ``efficiency``; plain data.

    Raises
    ------
    LumenrayError    The machine has fewer processors than workers.
    """
    counts = sorted({1, *counts})
    if counts[-1] > (os.cpu_count() or 1):
        raise LumenrayError(
            f"{counts[-1]} workers need as many processors, of which this machine has {os.cpu_count()}; give fewer by "
            "--workers"
        )
    rows, prints, load = [], set(), OtherLoad()
    with LocalCluster(0, threads=1) as cluster:
        for count in counts:
            while len(cluster.workers) < count:
                cluster.add_worker()
            # The first run of a process makes kernels.
            runs = [measure(cluster, samples) for _ in range(repeats + 1)]
            prints |= {bits for bits, _ in runs}
            times = [seconds for _, seconds in runs[1:]]
            alone = median(rows[0]["seconds"]) if rows else median(times)
            efficiency = alone / (count * median(times))
            rows.append({"workers": count, "seconds": times, "efficiency": efficiency})
            say(f"{count} workers: {median(times):.2f} s, efficiency {efficiency:.2f}")
    # Processes that were waited for count as ours.
    others = load.share()
    return {
        "machine": describe_machine(),
        "others": others,
        "samples": samples,
        "is_equal": len(prints) == 1,
        "rows": rows,
    }
