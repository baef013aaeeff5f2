"""Processor time of graphs of nodes beside pictures on surfaces: sending the scene, samples of a picture, edits."""

import time
from pathlib import Path
from statistics import median

from ...engine.accuracy.stopping import StopRule
from ...engine.reading.whole_file import write_whole
from ..common.bars import Bar
from ..common.document import make_table, tell_demands
from ..common.machine import describe_machine
from ..common.output import write_numbers

KINDS = ("pictures", "graphs")

SIZE, SAMPLES = (160, 100), 32
"""Width and height of the picture [pixel], and its samples."""

LITTLE = 1
"""Samples of the picture after an edit."""

ROUNDS, EDITS = 3, 6
"""Pictures that are timed, and edits, each of another material."""

MOST_PICTURE, MOST_EDIT = 1.15, 1.15
"""Most that a picture and an edit with graphs may take, relative to the same with pictures. [-]"""

STEPS = {
    "sync": "sending the whole scene",
    "picture": "a picture",
    "edit": "an edit of a node's value",
    "shown": "the first sample after an edit",
}

TEXT = """# Graphs of nodes

*Made by `lumenray benchmark nodes`; do not edit by hand.*

The bundled office with {count} of its materials painted anew: with pictures of {side} x {side} pixels by UV maps, and with
graphs of two procedural textures in coordinates of the object, each through a colour ramp, mixed. Both end in a node
*Hue/Saturation/Value*, whose value is edited. Seconds of the processor, all of its cores added up, in one run side by side;
the median of {rounds} pictures and {edits} edits, after the kernels were compiled. A picture has {width} x {height} pixels
and {samples} samples by full paths. *An edit*, made
as beside a rendered view: finding and converting what changed, and handing it over. {cpu}, {cores}
cores.

"""


def run(say=None) -> dict:
    """Measure.

    Returns
    -------
    dict    Plain data, for JSON: ``seconds`` by kind and step, lists.
    """
    import bpy

    from ...blender_addon.foundation.report import ConversionReport
    from ...blender_addon.rendering.feed import SceneFeed
    from ...engine.session import Session
    from ...engine.views import ViewSettings
    from .dressing import COUNT, PICTURE, dress, turn

    say = say or (lambda _line: None)
    seconds = {kind: {step: [] for step in STEPS} for kind in KINDS}
    for kind in KINDS:
        materials = dress(kind)
        graph = bpy.context.evaluated_depsgraph_get()
        render = graph.scene.original.render
        render.resolution_x, render.resolution_y = SIZE
        render.resolution_percentage = 100
        bpy.context.view_layer.update()
        feed = SceneFeed(Session(witness=False), final=True)
        taken = seconds[kind]
        _time(taken["sync"], lambda feed=feed, graph=graph: feed.update(graph))
        camera = feed.sync.camera(graph, ConversionReport())

        def take(samples, seed, feed=feed, camera=camera):
            settings = ViewSettings(StopRule(samples=samples), seed, method="paths")
            return feed.session.render(camera, settings)

        for samples in (LITTLE, SAMPLES):
            take(samples, 0)
        for number in range(ROUNDS):
            _time(taken["picture"], lambda number=number: take(SAMPLES, number + 1))
        say(f"{kind}: sync {taken['sync'][0]:.2f} s, picture {median(taken['picture']):.2f} s")
        # What is edited is seen in a view, for which graphs are drawn with fewer texels.
        feed = SceneFeed(Session(witness=False))
        feed.update(graph)
        # The first edit compiles what edits need.
        turn(materials[-1], 0)
        feed.update(graph)
        take(LITTLE, 0, feed)
        for number in range(EDITS):
            turn(materials[number * (len(materials) // EDITS)], number + 1)
            _time(taken["edit"], lambda feed=feed, graph=graph: feed.update(graph))
            _time(taken["shown"], lambda feed=feed: take(LITTLE, 1, feed))
        say(f"{kind}: edit {median(taken['edit']):.3f} s, shown {median(taken['shown']):.3f} s")
    return {
        "machine": describe_machine(),
        "count": COUNT,
        "side": PICTURE,
        "seconds": seconds,
    }


def _time(into: list, do) -> None:
    start = time.process_time()
    do()
    into.append(time.process_time() - start)


def ratio(result: dict, step: str) -> float:
    """What a step takes with graphs, relative to the same with pictures. [-]"""
    pictures, graphs = (median(result["seconds"][kind][step]) for kind in KINDS)
    return graphs / pictures


def check_bars(result: dict) -> list[Bar]:
    """Judge by the demands."""
    return [
        _bar(f"{STEPS[step]}, of that with pictures", ratio(result, step), most)
        for step, most in (
            ("picture", MOST_PICTURE),
            ("edit", MOST_EDIT),
            ("shown", MOST_EDIT),
        )
    ]


def _bar(demand: str, value: float, most: float) -> Bar:
    return Bar(demand, f"{most:.0%}", f"{value:.0%}", value <= most)


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document to a folder, and all numbers to a JSON file if one is named."""
    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    machine = result["machine"]
    text = TEXT.format(
        count=result["count"],
        side=result["side"],
        rounds=ROUNDS,
        edits=EDITS,
        width=SIZE[0],
        height=SIZE[1],
        samples=SAMPLES,
        cpu=machine["cpu"],
        cores=machine["cores"],
    )
    rows = []
    for step, words in STEPS.items():
        pictures, graphs = (median(result["seconds"][kind][step]) for kind in KINDS)
        share = ratio(result, step)
        rows.append(f"| {words} | {pictures:.3f} s | {graphs:.3f} s | {share:.0%} |")
    text += make_table("| | pictures | graphs | graphs of pictures |", rows, 1) + "\n"
    text += tell_demands(check_bars(result))
    with write_whole(folder / "nodes.md", "utf-8") as file:
        file.write(text)
