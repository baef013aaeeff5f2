"""Motion blur of Blender's scenes: when the shutter is open, and pictures of its moments."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...engine.moving_picture import Shutter, render_moments
from ..foundation.report import ConversionReport

OPENS = {"START": 0.0, "CENTER": -0.5, "END": -1.0}
"""When the shutter opens, after the frame's own moment, by the setting Position. [lengths of its time]"""

UNBLURRED = ("light", "material", "world")
"""Kinds of items that stand still for Cycles while the shutter is open."""

CURVE_VALUES = 256
"""Values by which the shutter's curve is read."""


def shutter_of(scene, view_layer) -> Shutter | None:
    """Return when the shutter of a scene's current frame is open; None without motion blur."""
    render = scene.render
    is_on = render.use_motion_blur and getattr(view_layer, "use_motion_blur", True)
    if not is_on or render.motion_blur_shutter <= 0.0:
        return None
    length = render.motion_blur_shutter
    # As frames are set: before Blender remaps the time.
    frame = scene.frame_current + scene.frame_subframe
    begin = frame + OPENS[render.motion_blur_position] * length
    return Shutter(frame, begin, length, _opening(render.motion_blur_shutter_curve))


def _opening(mapping) -> np.ndarray | None:
    """How much light the shutter lets through, evenly over its time; None: all, always."""
    mapping.initialize()
    times = (np.arange(CURVE_VALUES) + 0.5) / CURVE_VALUES
    values = np.array([mapping.evaluate(mapping.curves[0], time) for time in times])
    values = np.maximum(values, 0.0)
    return None if values[0] > 0.0 and (values == values[0]).all() else values


def split_time(time: float) -> tuple[int, float]:
    """Return frame and subframe of a time, as Blender wants them. [frame]"""
    frame = int(np.floor(time))
    return frame, float(time - frame)


def render_open_shutter(
    shutter: Shutter,
    settings,
    feed,
    go_to: Callable[[float], object],
    render: Callable,
    progress: Callable | None = None,
):
    """Render the mean over an open shutter.

    Parameters
    ----------
    shutter : Shutter
    settings : ViewSettings
    feed : SceneFeed    Its scene is that of the shutter's middle.
    go_to : callable    ``go_to(time)`` brings the scene to a time [frame] and returns its dependency graph.
    render : callable    ``render(camera, settings, progress)``, of the feed's session.
    progress : callable or None    As of `Session.render`.

    Returns
    -------
    Picture
    """
    moving = set()

    def moment(time, own, follow):
        depsgraph = go_to(time)
        edit = feed.update(depsgraph, is_moment=True)
        # A texture that lies in the world stays there in Cycles, too.
        sent = {} if edit is None else {**edit.stats.sent, "material": edit.stats.remade}
        moving.update(kind for kind in UNBLURRED if sent.get(kind))
        camera = feed.sync.camera(depsgraph, ConversionReport())
        return render(camera, own, follow)

    picture = render_moments(shutter, settings, moment, progress)
    if moving:
        kinds = " and ".join(f"{kind}s" for kind in UNBLURRED if kind in moving)
        note = f"{kinds} change while the shutter is open, and are blurred as well; Cycles keeps them as they are"
        picture = replace(picture, provenance=picture.provenance.with_words("", (note,)))
    if settings.spectral_file and picture.bands is not None:
        feed.session.write_spectral(settings.spectral_file, picture)
    return picture
