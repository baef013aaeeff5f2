"""Measures whether what befalls workers changes bits of results, and how well two work together; writes the document."""

import hashlib
import time
from pathlib import Path

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.cluster.dask_crew import DaskCrew
from ...engine.cluster.hosts import LocalCluster
from ...engine.cluster.session import ClusterSession
from ...engine.reading.whole_file import write_whole
from ...engine.scene.light import AreaLight, Output, Quantity
from ...engine.scene.material import Diffuse, Material
from ...engine.scene.scene import SceneDelta
from ...engine.scene.spectrum import Constant
from ..common.bars import Bar
from ..common.document import make_table, tell_demands
from ..common.machine import describe_machine
from ..common.output import write_numbers
from ..common.pieces import box, make_mesh, rigid_frame
from ..common.statistics import median
from .harm import KINDS, SLOW_SECONDS, Harm

RUNS, PAIRS = 50, 3
"""Runs with harm, and pairs of runs without, by one worker and by two."""

SAMPLES = 1 << 20
"""Of each sensor."""

SIDE, HEIGHT = 8, 0.8
"""Sensors along a side of the room, and their height. [m]"""

SIZE = (6.0, 4.0, 3.0)
"""Of the room. [m]"""

LEAST_EFFICIENCY = 0.9

SEED = 1

TEXT = """# Clusters

*Made by `lumenray benchmark cluster`; do not edit by hand.*

Illuminance at {sensors} sensors of a room by {samples} samples each, by full paths, on a scheduler and two workers of
one machine ({cpu}, {cores} cores; a thread for each worker). In every run workers are killed (another one then joins),
stopped until its end, or made to stand for half of the time for {slow:g} s, one to three times, at random. *Equal*: mean
and standard error of every sensor have the bits of a run without harm. *Efficiency*: time of one worker over twice that
of two, median of {pairs} pairs.

"""


def build_room() -> tuple:
    """Items of a room with a block in it and a lamp below its ceiling."""
    room = make_mesh("room", [box((0.0, 0.0, 0.0), SIZE, inwards=True)], "paint")
    block = make_mesh("block", [box((2.0, 1.5, 0.01), (3.0, 2.5, 0.7))], "wood")
    frame = rigid_frame((3.0, 2.0, 2.9), (0, 0, -1))
    flux = Output(Quantity.LUMINOUS_FLUX, 4000.0)
    lamp = AreaLight("lamp", "lamp", flux, frame, 1.2, 0.6)
    paints = [
        Material(name, name, Diffuse(Constant(value)))
        for name, value in (("paint", 0.6), ("wood", 0.3))
    ]
    return (*paints, room, block, lamp)


def place_sensors() -> tuple[np.ndarray, np.ndarray]:
    """Positions and normals. (n, 3), (n, 3) [m]"""
    along = (np.arange(SIDE) + 0.5) / SIDE
    x, y = np.meshgrid(SIZE[0] * along, SIZE[1] * along)
    positions = np.stack([x.ravel(), y.ravel(), np.full(x.size, HEIGHT)], axis=1)
    return positions, np.tile([0.0, 0.0, 1.0], (x.size, 1))


def run(runs: int = RUNS, pairs: int = PAIRS, samples: int = SAMPLES, say=None) -> dict:
    """Measure.

    Parameters
    ----------
    runs, pairs : int    With harm, and without it.
    samples : int    Of each sensor.
    say : callable or None    Told of progress in words.

    Returns
    -------
    dict    Plain data for JSON.
    """
    say = say or (lambda line: None)
    made = {"machine": describe_machine(), "samples": samples, "pairs": pairs, "rows": []}
    with LocalCluster(1, threads=1) as cluster:
        # The first run of a process makes kernels.
        reference, _ = measure(cluster, samples)
        alone = [measure(cluster, samples) for _ in range(pairs)]
        cluster.add_worker()
        measure(cluster, samples)
        together = [measure(cluster, samples) for _ in range(pairs)]
        made["plain_equal"] = all(each[0] == reference for each in (*alone, *together))
        made["one_seconds"] = [seconds for _, seconds in alone]
        made["two_seconds"] = [seconds for _, seconds in together]
        efficiency = [
            one / (2.0 * two)
            for one, two in zip(made["one_seconds"], made["two_seconds"], strict=True)
        ]
        made["efficiency_2"] = median(efficiency) if efficiency else None
        say(
            f"without harm {'equal' if made['plain_equal'] else 'NOT equal'}, efficiency {made['efficiency_2']}"
        )
        span = min(made["two_seconds"], default=10.0)
        for number in range(runs):
            with Harm(cluster, SEED + number, span) as harm:
                bits, seconds = measure(cluster, samples)
            row = {"harm": harm.done, "seconds": seconds, "is_equal": bits == reference}
            made["rows"].append(row)
            say(
                f"run {number + 1}: {', '.join(harm.done) or 'nothing'}; {seconds:.1f} s; equal: {row['is_equal']}"
            )
    made["runs"] = len(made["rows"])
    made["equal"] = sum(row["is_equal"] for row in made["rows"])
    return made


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


def check_bars(result: dict) -> list[Bar]:
    """Demands, and whether they are met."""
    runs, equal, efficiency = result["runs"], result["equal"], result["efficiency_2"]
    is_equal = equal == runs and result["plain_equal"]
    return [
        Bar("results with the same bits", f"all of {runs}", f"{equal}", is_equal if runs else None),
        Bar(
            "efficiency of two workers",
            f"at least {LEAST_EFFICIENCY:g}",
            "-" if efficiency is None else f"{efficiency:.2f}",
            None if efficiency is None else efficiency >= LEAST_EFFICIENCY,
        ),
    ]


def describe(result: dict, bars: list[Bar]) -> str:
    """Text of the document."""
    machine = result["machine"]
    text = TEXT.format(
        sensors=SIDE**2,
        samples=result["samples"],
        cpu=machine["cpu"],
        cores=machine["cores"],
        slow=SLOW_SECONDS,
        pairs=result["pairs"],
    )
    rows = []
    for kind in KINDS:
        own = [row for row in result["rows"] if kind in row["harm"]]
        equal = sum(row["is_equal"] for row in own)
        rows.append(f"| {kind} | {len(own)} | {equal} |")
    table = make_table("| a worker was | runs | equal |", rows)
    return f"{text}{tell_demands(bars)}\n{table}"


def write_results(result: dict, folder: Path, numbers: Path | None) -> None:
    """Write the document, and all numbers as JSON."""
    text = describe(result, check_bars(result))
    folder.mkdir(parents=True, exist_ok=True)
    with write_whole(folder / "cluster.md") as file:
        file.write(text.encode())
    write_numbers(result, numbers)
