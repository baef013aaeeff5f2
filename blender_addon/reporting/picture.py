"""The picture of a report: one render of the camera, which lighting scenes mix, as it is looked at and in false colours."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from ...engine.errors import Cancelled, SceneError
from ...imports import loaded_when_used
from ..foundation.exposure import white_luminance
from ..foundation.report import ConversionReport
from ..rendering.render_engine import shown_light, view_settings

with loaded_when_used():
    import numpy as np
    from PIL import Image

    from ...engine import light_mix, views
    from ...engine.accuracy import stopping
    from ...engine.analysis import denoiser, false_colour, looking, value_plan
    from ...engine.photometry import colour
    from ...engine.reporting import results
    from ...engine.scene import camera as scene_camera
    from ...engine.scene import scene
    from ..sync import scene as sync_scene

NAME = "report"
"""Of the job."""

NOISIEST = 0.1
"""Relative error of a picture up to which lines of equal luminance are more than noise. [-]"""

LINE_SMOOTHING = 2
"""How often neighbouring pixels are averaged before lines are drawn, so that noise does not fray them."""


@dataclass(eq=False)
class PictureJob:
    """A picture to be rendered; it is there after `run`."""

    delta: "scene.SceneDelta"
    camera: "scene_camera.Camera"
    view: "views.ViewSettings"
    picture: "views.Picture | None" = None
    shortfall: str = ""
    _session: object = field(default=None, repr=False)
    _is_cancelled: bool = False

    def run(self, session, progress: "Callable[[stopping.Progress], None] | None" = None) -> None:
        """Render.

        Parameters
        ----------
        session : Session or RemoteSession    An empty one.

        Raises
        ------
        Cancelled    After `cancel`.
        LumenrayError    The scene or the machine does not allow it.
        """
        self._session = session
        if self._is_cancelled:
            raise Cancelled("cancelled")
        session.apply(self.delta)
        self.picture = session.render(self.camera, self.view, progress)
        self.shortfall = self.view.rule.shortfall(self.picture.relative_error)

    def cancel(self) -> None:
        """End it; may be called from any thread."""
        self._is_cancelled = True
        if self._session is not None:
            self._session.cancel()


def prepare(
    depsgraph, rule: "stopping.StopRule | None" = None
) -> tuple[PictureJob, ConversionReport]:
    """Return the job of the picture of a scene's camera, and what could not be taken over.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph    Evaluated.
    rule : StopRule or None    None: that of the scene's renders.

    Raises
    ------
    SceneError    The scene has no camera.
    """
    converted = sync_scene.convert_scene(depsgraph)
    if converted.camera is None:
        raise SceneError("the scene has no camera for the picture of the report")
    view = view_settings(depsgraph.scene, None, converted.luminous)
    guides = denoiser.find_denoiser() is not None
    view = replace(view, bands=0, rule=rule or view.rule, guides=guides)
    return PictureJob(converted.delta, converted.camera, view), converted.report


def show(
    picture: "views.Picture", levels: "light_mix.LightMix", settings
) -> "tuple[results.Shown, ...]":
    """Return a picture at levels of its groups as it is looked at, and in false colours of luminance.

    ``settings``: a `LumenraySceneSettings`.
    """
    mixed = picture.mixed(levels)
    luminance = mixed.tristimulus[..., 1]
    white = white_luminance(settings) or colour.automatic_white(luminance)
    linear = colour.scene_linear(shown_light(mixed), white)
    words = "as computed"
    if mixed.denoising_normal is not None:
        made = looking.filter_noise(linear, mixed)
        linear, words = made.colour, made.words or words
    pixels = false_colour.encode_display(np.asarray(linear))
    told = f"{mixed.provenance.samples} samples a pixel, error of the picture {100.0 * mixed.relative_error:.2g} %"
    seen = results.Shown(
        f"What the camera sees; {white:.4g} cd/m² is white; {words}; {told}",
        Image.fromarray(pixels),
    )
    caption = f"mean {float(luminance.mean()):.4g} cd/m², {told}"
    # Lamps are a thousand times as bright as what they light.
    scale = value_plan.even_scale(luminance, "cd/m²", is_log=True)
    is_even = mixed.relative_error <= NOISIEST
    sheet = value_plan.draw_map(
        "Luminance",
        luminance,
        None,
        caption,
        scale,
        levels=None if is_even else (),
        unit="cd/m²",
        smoothing=LINE_SMOOTHING if is_even else 0,
    )
    lines = "with" if is_even else "too noisy for"
    return seen, results.Shown(
        f"Luminance in false colours, {lines} lines of equal luminance", sheet
    )
