"""What Lumenray tells the user: engine status, running job and conversion report.

Kept in ``window_manager.lumenray``, on Blender's main thread. It belongs to the session, not to the file.
"""

import bpy
from bpy.app.handlers import persistent
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ..imports import loaded_when_used
from .foundation import engine_process
from .foundation.handlers import leave, listen
from .foundation.preferences import device
from .foundation.probe import Probe
from .foundation.redraw import redraw
from .foundation.report import ConversionReport

with loaded_when_used():
    from ..engine.accuracy import stopping

SEVERITIES = [
    ("ERROR", "Error", "Something was left out", "CANCEL", 0),
    ("WARNING", "Warning", "The result differs from what Blender shows", "ERROR", 1),
    ("INFO", "Note", "Changes little", "INFO", 2),
]

FIRST_CHECK = 1.0
"""Delay of the engine's check after Blender's start, so that the window is there first. [s]"""

CHECK_INTERVAL = 0.25
"""How often the check looks for its answer. [s]"""


UNKNOWN = 1e6
"""Relative errors from here on stand for one that is not known yet."""


class LumenrayEngineStatus(PropertyGroup):
    """Whether the engine can run here."""

    checked: BoolProperty(name="Checked", description="Whether the engine was looked for")
    usable: BoolProperty(name="Usable", description="Whether the engine can run")
    cause: StringProperty(name="Cause", description="What was found wrong")
    remedy: StringProperty(name="Remedy", description="What to do about it")
    found: StringProperty(
        name="Devices",
        description="What was looked at to compute on, a line each, with what it showed",
    )


class LumenrayJob(PropertyGroup):
    """The bake or render that runs in the background."""

    running: BoolProperty(name="Running", description="Whether something is being computed")
    is_stopping: BoolProperty(name="Stopping", description="Whether it is to end with what it has")
    progress: FloatProperty(
        name="Progress",
        description="Share of the work that is done, 0 to 1",
        min=0.0,
        max=1.0,
        subtype="FACTOR",
    )
    text: StringProperty(name="State", description="What the job is at")
    stage: StringProperty(name="Stage", description="Part of the work that is being done")
    samples: IntProperty(name="Samples", description="Number of samples per point, so far", min=0)
    error: FloatProperty(
        name="Error", description="Relative standard error so far, as a share; 0 is unknown"
    )
    left: StringProperty(
        name="Time Left", description="Time left as forecast; empty while that is unknown"
    )


class LumenrayReportRow(PropertyGroup):
    """One departure of the conversion."""

    severity: EnumProperty(name="Severity", description="How much it matters", items=SEVERITIES)
    datablock: StringProperty(name="Where", description="Object, material, light or world")
    node: StringProperty(name="Node", description="Node inside the data-block")
    message: StringProperty(name="What", description="What could not be taken over")
    remedy: StringProperty(name="Instead", description="What was done instead")
    count: IntProperty(
        name="Count", description="Number of times that it occurred", default=1, min=1
    )


class LumenrayClusterWorker(PropertyGroup):
    """A worker of the cluster; its name is its address."""

    silence: FloatProperty(
        name="Silence", description="Time since it was last heard, in seconds", min=0.0
    )


class LumenrayCluster(PropertyGroup):
    """The cluster as it was last seen."""

    is_known: BoolProperty(name="Known", description="Whether it was looked for")
    address: StringProperty(name="Address", description="Where it was looked for")
    workers: CollectionProperty(type=LumenrayClusterWorker)


class LumenrayFeedback(PropertyGroup):
    """All of it; the indices are the active rows of the lists."""

    engine: PointerProperty(type=LumenrayEngineStatus)
    cluster: PointerProperty(type=LumenrayCluster)
    job: PointerProperty(type=LumenrayJob)
    reported: BoolProperty(name="Reported", description="Whether a scene has been converted")
    rows: CollectionProperty(type=LumenrayReportRow)
    row_index: IntProperty(name="Active Row", description="Row whose details are shown", min=0)
    render: StringProperty(
        name="Last Render", description="Samples, error and time of the last picture"
    )


def show_report(window_manager, report: ConversionReport) -> None:
    """Show a conversion report in place of the one before, the worst rows first."""
    feedback = window_manager.lumenray
    feedback.reported = True
    feedback.rows.clear()
    feedback.row_index = 0
    for row, count in report.by_weight:
        item = feedback.rows.add()
        item.severity = row.severity.name
        item.datablock, item.node = row.datablock, row.node
        item.message, item.remedy = row.message, row.remedy
        item.count = count


def show_render(window_manager, text: str) -> None:
    """Show how well the last picture is known, where it is looked at."""
    window_manager.lumenray.render = text
    redraw("IMAGE_EDITOR", "PROPERTIES")


def show_workers(window_manager, address: str, workers) -> None:
    """Show who computes at a cluster. ``workers``: addresses, and for how long each has not been heard. [s]"""
    cluster = window_manager.lumenray.cluster
    cluster.is_known, cluster.address = True, address
    cluster.workers.clear()
    for name, silence in workers:
        row = cluster.workers.add()
        row.name, row.silence = name, silence
    redraw("PROPERTIES")


def begin_job(window_manager) -> None:
    """Tell that a job runs, of which nothing is known yet."""
    feedback = window_manager.lumenray
    feedback.property_unset("job")
    feedback.job.running = True


def show_progress(window_manager, progress: "stopping.Progress") -> None:
    """Show how far the running job is."""
    job = window_manager.lumenray.job
    # Rounded down: a job that shows 100 % is done.
    job.progress = int(progress.done * 1000) / 1000
    job.text, job.stage, job.samples = progress.text(), progress.stage, progress.samples
    job.error = progress.relative_error if progress.relative_error < UNKNOWN else 0.0
    left = progress.seconds_left
    job.left = "" if left is None else stopping.format_seconds(left)


def check_engine(window_manager) -> bool:
    """Find out whether the engine can run, note it and return it; takes some seconds."""
    return note_status(window_manager, Probe(device()).wait())


def check_again() -> None:
    """Forget what was found and look again in the background, as after Blender's start."""
    for window_manager in bpy.data.window_managers:
        window_manager.lumenray.engine.checked = False
    _start_check()


def note_status(window_manager, status) -> bool:
    """Note a `BackendStatus` and return whether it is usable."""
    engine = window_manager.lumenray.engine
    engine.checked = True
    engine.usable, engine.cause, engine.remedy = status.usable, status.cause, status.remedy
    engine.found = "\n".join(status.found)
    engine_process.note_device(status.device)
    redraw()
    return status.usable


def report_text(window_manager) -> str:
    """Conversion report as lines of text, for pasting into a mail or a bug report."""
    lines = []
    for row in window_manager.lumenray.rows:
        where = f"{row.datablock} / {row.node}" if row.node else row.datablock
        count = f" ({row.count} times)" if row.count > 1 else ""
        lines.append(f"{row.severity}: {where}: {row.message}; {row.remedy}{count}")
    return "\n".join(lines)


_open_questions: list[Probe] = []
"""The probe that runs, if any."""


def _look():
    """Ask the engine once without holding up the window; for a timer."""
    managers = [wm for wm in bpy.data.window_managers if hasattr(wm, "lumenray")]
    if not managers or managers[0].lumenray.engine.checked:
        _drop_question()
        return None
    if not _open_questions:
        _open_questions.append(Probe(device()))
    status = _open_questions[0].poll()
    if status is None:
        return CHECK_INTERVAL
    _open_questions.clear()
    note_status(managers[0], status)
    return None


def _start_check() -> None:
    """Look anew; what was asked before may have been of another device."""
    _end_check()
    if not bpy.app.background:
        bpy.app.timers.register(_look, first_interval=FIRST_CHECK)


def _end_check() -> None:
    if bpy.app.timers.is_registered(_look):
        bpy.app.timers.unregister(_look)
    _drop_question()


def _drop_question() -> None:
    for probe in _open_questions:
        probe.close()
    _open_questions.clear()


@persistent
def _forget(*_):
    """Blender saves window managers in files, but what they tell belongs to another session."""
    for window_manager in bpy.data.window_managers:
        window_manager.property_unset("lumenray")
    _start_check()


CLASSES = (
    LumenrayEngineStatus,
    LumenrayJob,
    LumenrayReportRow,
    LumenrayClusterWorker,
    LumenrayCluster,
    LumenrayFeedback,
)


_HANDLERS = {"load_post": _forget}


def attach():
    """Attach the group to Blender's window manager; the classes must be registered."""
    bpy.types.WindowManager.lumenray = PointerProperty(
        type=LumenrayFeedback, options={"HIDDEN", "SKIP_SAVE"}
    )
    listen(_HANDLERS)
    _start_check()


def detach():
    """Take the group off again."""
    leave(_HANDLERS)
    _end_check()
    del bpy.types.WindowManager.lumenray
