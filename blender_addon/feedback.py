"""What Lumenray tells the user: engine status, running job, conversion report and results.

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

from ..engine.accuracy.stopping import Progress, format_seconds
from ..engine.baking.order import BakeResult
from .probe import Probe
from .report import ConversionReport

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
    cause: StringProperty(name="Cause", description="What was found")
    remedy: StringProperty(name="Remedy", description="What to do about it")


class LumenrayJob(PropertyGroup):
    """The bake or render that runs in the background."""

    running: BoolProperty(name="Running", description="Whether something is being computed")
    progress: FloatProperty(
        name="Progress",
        description="Part that is done",
        min=0.0,
        max=1.0,
        subtype="FACTOR",
    )
    text: StringProperty(name="State", description="What the job is at")
    stage: StringProperty(name="Stage", description="Part of the work that is being done")
    samples: IntProperty(name="Samples", description="Per point, so far", min=0)
    error: FloatProperty(name="Error", description="Relative standard error so far; 0 is unknown")
    left: StringProperty(name="Time left", description="As forecast; empty while that is unknown")


class LumenrayReportRow(PropertyGroup):
    """One departure of the conversion."""

    severity: EnumProperty(name="Severity", description="How much it matters", items=SEVERITIES)
    datablock: StringProperty(name="Where", description="Object, material, light or world")
    node: StringProperty(name="Node", description="Node inside it")
    message: StringProperty(name="What", description="What could not be taken over")
    remedy: StringProperty(name="Instead", description="What was done instead")
    count: IntProperty(name="Count", description="How often it occurred", default=1, min=1)


class LumenrayResultRow(PropertyGroup):
    """One lux map. ``relative_error`` is that of its lumels, ``mean_error`` that of ``mean``."""

    name: StringProperty(name="Name", description="Object that the map lies on")
    mean: FloatProperty(name="Mean", description="Area-weighted mean")
    minimum: FloatProperty(name="Minimum", description="Smallest value on the surface")
    maximum: FloatProperty(name="Maximum", description="Largest value on the surface")
    mean_error: FloatProperty(name="Error of the mean", description="Standard error of the mean")
    relative_error: FloatProperty(
        name="Relative error",
        description="Standard error of the single values divided by the mean",
    )
    bias: FloatProperty(
        name="Bias", description="What the method adds to the mean on the whole, as measured"
    )
    bias_error: FloatProperty(name="Error of the bias", description="Standard error of the bias")
    samples: IntProperty(name="Samples", description="Samples per lumel")
    lumels: IntProperty(name="Lumels", description="How many lie on the surface")
    density: FloatProperty(name="Density", description="Lumels per metre that were reached")
    invalid: IntProperty(
        name="Inside solids", description="Lumels that were filled from their neighbours"
    )
    is_smoothed: BoolProperty(
        name="Smoothed", description="Whether the map was smoothed after its error was known"
    )
    unit: StringProperty(name="Unit", description="Unit of the values", default="lx")


class LumenrayBakeSummary(PropertyGroup):
    """The last bake as a whole."""

    relative_error: FloatProperty(
        name="Relative error", description="Standard error of all lumels divided by the mean"
    )
    mean: FloatProperty(name="Mean", description="Of everything, in lx")
    seconds: FloatProperty(name="Time", description="Time that it took", subtype="TIME_ABSOLUTE")
    pages: IntProperty(name="Pages", description="Of the atlas")
    shrink: FloatProperty(
        name="Shrink", description="Factor on all densities that made the charts fit"
    )
    seam_pairs: IntProperty(name="Seam points", description="Places where charts meet")
    seam_before: FloatProperty(name="Steps", description="At seams before matching, in lx")
    seam_after: FloatProperty(name="Steps left", description="At seams after matching, in lx")
    seam_noise: FloatProperty(name="Noise of steps", description="Their standard error, in lx")


class LumenrayFeedback(PropertyGroup):
    """All of it; the indices are the active rows of the lists."""

    engine: PointerProperty(type=LumenrayEngineStatus)
    job: PointerProperty(type=LumenrayJob)
    reported: BoolProperty(name="Reported", description="Whether a scene has been converted")
    rows: CollectionProperty(type=LumenrayReportRow)
    row_index: IntProperty(name="Active row", description="Row whose details are shown", min=0)
    results: CollectionProperty(type=LumenrayResultRow)
    result_index: IntProperty(name="Active map", description="Map whose details are shown", min=0)
    summary: PointerProperty(type=LumenrayBakeSummary)
    render: StringProperty(
        name="Last render", description="Samples, error and time of the last picture"
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
    for window in window_manager.windows:
        for area in window.screen.areas:
            if area.type in {"IMAGE_EDITOR", "PROPERTIES"}:
                area.tag_redraw()


def begin_job(window_manager) -> None:
    """Tell that a job runs, of which nothing is known yet."""
    feedback = window_manager.lumenray
    feedback.property_unset("job")
    feedback.job.running = True


def show_progress(window_manager, progress: Progress) -> None:
    """Show how far the running job is."""
    job = window_manager.lumenray.job
    # Rounded down: a job that shows 100 % is done.
    job.progress = int(progress.done * 1000) / 1000
    job.text, job.stage, job.samples = progress.text(), progress.stage, progress.samples
    job.error = progress.relative_error if progress.relative_error < UNKNOWN else 0.0
    left = progress.seconds_left
    job.left = "" if left is None else format_seconds(left)


def show_results(window_manager, result: BakeResult) -> None:
    """Show a finished bake in place of the one before."""
    feedback = window_manager.lumenray
    feedback.results.clear()
    feedback.result_index = 0
    for made in result.maps:
        item = feedback.results.add()
        item.name = made.name
        item.mean, item.minimum, item.maximum = made.mean, made.minimum, made.maximum
        item.mean_error = made.mean_standard_error
        item.relative_error = made.relative_standard_error
        item.bias, item.bias_error = made.bias, made.bias_error
        item.samples, item.lumels = round(made.samples), made.lumels
        item.density, item.invalid = made.density, made.invalid
        item.is_smoothed = made.smoothed
        item.unit = "lx"
    summary, seams = feedback.summary, result.seams
    summary.relative_error, summary.mean = result.relative_standard_error, result.mean
    marks = result.history.marks
    summary.seconds = marks[-1].seconds if marks else 0.0
    summary.pages, summary.shrink = len(result.pages), result.shrink
    summary.seam_pairs, summary.seam_noise = seams.pairs, seams.noise
    summary.seam_before, summary.seam_after = seams.before, seams.after


def check_engine(window_manager) -> bool:
    """Find out whether the engine can run, note it and return it; takes some seconds."""
    return note_status(window_manager, Probe().wait())


def note_status(window_manager, status) -> bool:
    """Note a `BackendStatus` and return whether it is usable."""
    engine = window_manager.lumenray.engine
    engine.checked = True
    engine.usable, engine.cause, engine.remedy = status.usable, status.cause, status.remedy
    for window in window_manager.windows:
        for area in window.screen.areas:
            area.tag_redraw()
    return status.usable


def report_text(window_manager) -> str:
    """Conversion report as lines of text, for pasting into a mail or a bug report."""
    lines = []
    for row in window_manager.lumenray.rows:
        where = f"{row.datablock} / {row.node}" if row.node else row.datablock
        count = f" ({row.count} times)" if row.count > 1 else ""
        lines.append(f"{row.severity}: {where}: {row.message}; {row.remedy}{count}")
    return "\n".join(lines)


def _first_check():
    """Return a timer function that asks the engine once without holding up the window."""
    probe = None

    def look():
        nonlocal probe
        managers = [wm for wm in bpy.data.window_managers if hasattr(wm, "lumenray")]
        if not managers or managers[0].lumenray.engine.checked:
            if probe is not None:
                probe.close()
            return None
        if probe is None:
            probe = Probe()
        status = probe.poll()
        if status is None:
            return CHECK_INTERVAL
        note_status(managers[0], status)
        return None

    return look


def _start_check() -> None:
    if not bpy.app.background:
        bpy.app.timers.register(_first_check(), first_interval=FIRST_CHECK)


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
    LumenrayResultRow,
    LumenrayBakeSummary,
    LumenrayFeedback,
)


def attach():
    """Attach the group to Blender's window manager; the classes must be registered."""
    bpy.types.WindowManager.lumenray = PointerProperty(
        type=LumenrayFeedback, options={"HIDDEN", "SKIP_SAVE"}
    )
    if _forget not in bpy.app.handlers.load_post:
        bpy.app.handlers.load_post.append(_forget)
    _start_check()


def detach():
    """Take the group off again."""
    if _forget in bpy.app.handlers.load_post:
        bpy.app.handlers.load_post.remove(_forget)
    del bpy.types.WindowManager.lumenray
