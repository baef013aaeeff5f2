"""The picture of a report: one render of the camera, which lighting scenes mix, as it is looked at and in false colours."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from PIL import Image

from ...engine.accuracy.stopping import Progress, StopRule
from ...engine.analysis.denoiser import find_denoiser
from ...engine.analysis.false_colour import encode_display
from ...engine.analysis.looking import filter_noise
from ...engine.analysis.value_plan import draw_map, even_scale
from ...engine.errors import Cancelled, SceneError
from ...engine.light_mix import LightMix
from ...engine.photometry.colour import automatic_white, scene_linear
from ...engine.reporting.results import Shown
from ...engine.scene.camera import Camera
from ...engine.scene.scene import SceneDelta
from ...engine.views import Picture, ViewSettings
from ..foundation.exposure import white_luminance
from ..foundation.report import ConversionReport
from ..rendering.render_engine import shown_light, view_settings
from ..sync.scene import convert_scene

NAME = "report"
"""Of the job."""

NOISIEST = 0.1
"""Relative error of a picture up to which lines of equal luminance are more than noise. [-]"""

LINE_SMOOTHING = 2
"""How often neighbouring pixels are averaged before lines are drawn, so that noise does not fray them."""


@dataclass(eq=False)
class PictureJob:
    """A picture to be rendered; it is there after `run`."""

    delta: SceneDelta
    camera: Camera
    view: ViewSettings
    picture: Picture | None = None
    shortfall: str = ""
    _session: object = field(default=None, repr=False)
    _is_cancelled: bool = False

    def run(self, session, progress: Callable[[Progress], None] | None = None) -> None:
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


def prepare(depsgraph, rule: StopRule | None = None) -> tuple[PictureJob, ConversionReport]:
    """Return the job of the picture of a scene's camera, and what could not be taken over.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph    Evaluated.
    rule : StopRule or None    None: that of the scene's renders.

    Raises
    ------
    SceneError    The scene has no camera.
    """
    converted = convert_scene(depsgraph)
    if converted.camera is None:
        raise SceneError("the scene has no camera for the picture of the report")
    view = view_settings(depsgraph.scene, None, converted.luminous)
    guides = find_denoiser() is not None
    view = replace(view, bands=0, rule=rule or view.rule, guides=guides)
    return PictureJob(converted.delta, converted.camera, view), converted.report


def show(picture: Picture, levels: LightMix, settings) -> tuple[Shown, ...]:
    """Return a picture at levels of its groups as it is looked at, and in false colours of luminance.

    ``settings``: a `LumenraySceneSettings`.
    """
    mixed = picture.mixed(levels)
    luminance = mixed.tristimulus[..., 1]
    white = white_luminance(settings) or automatic_white(luminance)
    linear = scene_linear(shown_light(mixed), white)
    words = "as computed"
    if mixed.denoising_normal is not None:
        made = filter_noise(linear, mixed)
        linear, words = made.colour, made.words or words
    pixels = encode_display(np.asarray(linear))
    told = f"{mixed.provenance.samples} samples a pixel, error of the picture {100.0 * mixed.relative_error:.2g} %"
    seen = Shown(
        f"What the camera sees; {white:.4g} cd/m² is white; {words}; {told}",
        Image.fromarray(pixels),
    )
    caption = f"mean {float(luminance.mean()):.4g} cd/m², {told}"
    # Lamps are a thousand times as bright as what they light.
    scale = even_scale(luminance, "cd/m²", is_log=True)
    is_even = mixed.relative_error <= NOISIEST
    sheet = draw_map(
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
    return seen, Shown(f"Luminance in false colours, {lines} lines of equal luminance", sheet)
