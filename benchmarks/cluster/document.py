"""The document of the benchmark of clusters."""

from ..common.bars import Bar
from ..common.document import BEARABLE_LOAD, make_table, tell_demands
from ..common.statistics import median
from .harm import KINDS, SLOW_SECONDS
from .kinds import DENSITY, PIXELS, SUNS
from .room import SIDE
from .scaling import COUNTS, GOOD, HALF, HOURS, LINE, TAIL, reaches

HEAD = """# Clusters

*Made by `lumenray benchmark cluster`; do not edit by hand.*

Jobs by the workers of a cluster, [theory](../theory.md#19-beyond-one-machine). Every worker is a process with one thread;
{cpu}, {cores} cores.

"""

HARM = """## Whatever becomes of workers

Illuminance at {sensors} sensors of a room by {samples} samples each, by full paths, by two workers. In every run workers are
killed (another one then joins), stopped until its end (of the last one that runs another one takes the place), or made to
stand for half of the time for {slow:g} s, one to three times, at random. *Equal*: mean and standard error of every sensor
have the bits of a run without harm.

"""

EFFICIENCY = """## Efficiency

The same job by several numbers of workers on one machine, median of {repeats} runs. *Efficiency*: time of one worker over
that of all and their number. The work is fixed, so the last and longest chunks tell where there are many workers.

"""

SCALING = """## Up to a thousand workers

Simulated: the engine's own dispatcher sends workers about in virtual time. What it is fed with was measured on this machine
by one worker of one thread, on a scheduler of its own: sizes of parcels, times of chunks, how much equal chunks differ,
merging here, and what carrying an errand costs this process and the scheduler's. The dispatcher's own processor time is that
of the simulation. Assumed: a line of {rate:g} Gbit/s and {delay:g} ms between the scheduler's machine and the workers,
either way for itself; workers alike; an answer costs the scheduler what an errand of its size does; kernels are there; no
second witness; answers that wait here fit into memory.

The jobs are {sensors} sensors, lux maps of the room at {density:g} lumels per metre, a picture of {width} x {height} pixels,
and {sensors} sensors under {suns} suns and the sky. An errand without work takes {trip:.1f} ms there and back, of which this
process is busy for {here:.2f} ms and the scheduler for {scheduler:.2f} ms; a megabyte more takes them {here_byte:.2f} ms and
{scheduler_byte:.2f} ms.

"""

CHECKS = """
### Against reality

The measured job, simulated with the line of one machine. That of two workers is foretold from one.

"""

CURVES = """
### Efficiency over the number of workers

*Efficiency*: time of one worker that only computes, over that of all and their number.

![Efficiency over the number of workers](cluster.png)

"""

LEVERS = """
### What moves that

One thing changed at a time: efficiency with {some}. *Late*: {share:.0%} of all chunks take longer by
a factor of at least {least:g} by Pareto's distribution with the exponent {exponent:g}, beside the measured spread. Workers
that are faster do the same job, which is then shorter. *Held*: answers that wait to be merged, at most, and their size.

"""


def describe(result: dict, bars: list[Bar]) -> str:
    """Text of the document."""
    machine, parts = result["machine"], result["parts"]
    text = HEAD.format(cpu=machine["cpu"], cores=machine["cores"]) + tell_demands(bars)
    if "harm" in parts:
        text += "\n" + _tell_harm(parts["harm"])
    measured = [each for each in (parts.get("efficiency"), result["elsewhere"]) if each]
    if measured:
        text += "\n" + EFFICIENCY.format(repeats=len(measured[0]["rows"][0]["seconds"]))
        text += "\n".join(map(_tell_efficiency, measured))
    if "scaling" in parts:
        text += "\n" + _tell_scaling(parts["scaling"])
    return text


def _tell_harm(part: dict) -> str:
    rows = []
    for kind in KINDS:
        own = [row for row in part["rows"] if kind in row["harm"]]
        rows.append(f"| {kind} | {len(own)} | {sum(row['is_equal'] for row in own)} |")
    told = HARM.format(sensors=SIDE**2, samples=part["samples"], slow=SLOW_SECONDS)
    return told + make_table("| a worker was | runs | equal |", rows)


def _tell_efficiency(part: dict) -> str:
    machine, load = part["machine"], part["others"]
    told = f"{machine['cpu']}, {machine['cores']} cores, {part['samples']} samples of a sensor"
    if load is not None and load > BEARABLE_LOAD:
        told += f"; others had {load:.0%} of the processors meanwhile, so these are no bounds"
    rows = [
        f"| {row['workers']} | {median(row['seconds']):.2f} | {row['efficiency']:.2f} |"
        for row in part["rows"]
    ]
    return f"{told}:\n\n" + make_table("| workers | time [s] | efficiency |", rows, 0)


def _tell_scaling(part: dict) -> str:
    post, costs = part["post"], part["costs"]
    text = SCALING.format(
        rate=LINE.rate / 1e9,
        delay=1e3 * LINE.delay,
        sensors=SIDE**2,
        density=DENSITY,
        width=PIXELS[0],
        height=PIXELS[1],
        suns=SUNS,
        trip=1e3 * post["round_trip"],
        here=1e3 * post["here"],
        scheduler=1e3 * post["scheduler"],
        here_byte=1e9 * post["here_byte"],
        scheduler_byte=1e9 * post["scheduler_byte"],
    )
    rows = []
    for name, own in costs.items():
        grain = own["grain"]
        first, last = (own["fixed"] + own["pace"] * grain[size] for size in ("least", "most"))
        rows.append(
            f"| {name} | {_bytes(own['scene_bytes'])} | {_bytes(own['task_bytes'])} | {_bytes(own['answer_bytes'])} "
            f"| {own['begin']:.2f} | {own['cold']:.1f} | {first:.2f} | {last:.1f} | {_spread(own['spread']):.1%} "
            f"| {1e3 * own['take']:.1f} | {own['end']:.2f} |"
        )
    text += make_table(
        "| job | scene | errand | answer | to begin [s] | kernels [s] | first chunks [s] | longest [s] | spread "
        "| merging [ms] | end [s] |",
        rows,
    )
    text += CHECKS
    rows = [
        f"| {row['kind']} | {row['workers']} | {row['seconds']:.2f} | {row['simulated']:.2f} "
        f"| {row['simulated'] / row['seconds'] - 1.0:+.1%} |"
        for row in part["checks"]
    ]
    text += make_table("| job | workers | measured [s] | simulated [s] | off by |", rows)
    return text + CURVES + _tell_curves(part["curves"], costs) + _tell_levers(part, costs)


def _tell_curves(curves: list[dict], costs: dict) -> str:
    rows = []
    for name in costs:
        for hours in HOURS:
            own = [row for row in curves if (row["kind"], row["hours"]) == (name, hours)]
            values = " | ".join(f"{row['efficiency']:.2f}" for row in own)
            ends = " | ".join(_most(reaches(own, share)) for share in (GOOD, HALF))
            rows.append(f"| {name} | {hours} | {own[0]['chunks']} | {values} | {ends} |")
    counts = " | ".join(map(str, COUNTS))
    head = f"| job | hours | chunks | {counts} | at least {GOOD:.0%} up to | at least {HALF:.0%} up to |"
    return make_table(head, rows)


def _tell_levers(part: dict, costs: dict) -> str:
    levers = part["levers"]
    cases = sorted({(row["workers"], row["hours"]) for row in levers})
    some = " and ".join(
        f"{workers} workers at a job of {hours} h of one" for workers, hours in cases
    )
    text = LEVERS.format(some=some, share=TAIL.share, least=TAIL.least, exponent=TAIL.exponent)
    table = {
        (row["lever"], row["kind"], row["workers"], row["hours"]): row["efficiency"]
        for row in levers
    }
    names = list(dict.fromkeys(row["lever"] for row in levers))
    rows = [
        f"| {name} | "
        + " | ".join(f"{table[name, kind, *case]:.2f}" for case in cases for kind in costs)
        + " |"
        for name in names
    ]
    heads = " | ".join(f"{kind}, {workers}" for workers, _ in cases for kind in costs)
    text += make_table(f"| | {heads} |", rows)
    held = [row for row in levers if row["lever"] == names[0] and row["workers"] == cases[-1][0]]
    words = "; ".join(
        f"{row['kind']} {row['held']} ({_bytes(row['held'] * costs[row['kind']]['answer_bytes'])})"
        for row in held
    )
    return f"{text}\nHeld with {cases[-1][0]} workers: {words}.\n"


def _most(workers: int | None) -> str:
    if workers is None:
        return f"fewer than {COUNTS[0]}"
    return f"{workers}" if workers < COUNTS[-1] else f"{workers} and more"


def _spread(values) -> float:
    """Standard deviation over the mean."""
    mean = sum(values) / len(values)
    square = sum((value - mean) ** 2 for value in values) / max(len(values) - 1, 1)
    return square**0.5 / mean


def _bytes(count: int) -> str:
    for unit, size in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= size:
            return f"{count / size:.1f} {unit}"
    return f"{count} B"
