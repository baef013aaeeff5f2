"""What the panel of a ray file shows: its state, and its figures in words."""

from dataclasses import dataclass

from ...engine.errors import LumenrayError
from ...engine.raysets.emission import RayLight
from ..foundation.units import format_lengths
from . import files
from .convert import luminous_flux
from .settings import LIGHT_TYPES, rays_of
from .source import absolute_path, name_of

REMEDY = "Choose another file; until then the light is left out"


@dataclass(frozen=True)
class State:
    """State of a ray file.

    Parameters
    ----------
    name : str    Of the file; empty while none is chosen.
    light : RayLight or None    None while it is not ready.
    share : float or None    Of the preparation that is done, while it is under way.
    problem : str    Why it cannot be used.
    """

    name: str
    light: RayLight | None = None
    share: float | None = None
    problem: str = ""


def state_of(settings) -> State:
    """Find out the state of the file that settings choose; it is prepared in the background if it is not."""
    name = name_of(settings)
    if not name:
        return State(name)
    try:
        return State(name, files.obtain(settings, is_patient=False))
    except files.NotReadyError:
        return State(name, share=files.share_of(settings) or 0.0)
    except LumenrayError as error:
        text = str(error)
        return State(name, problem=text.removeprefix(f"{absolute_path(settings)}: "))


def describe(settings, light: RayLight) -> list[tuple[str, str]]:
    """Return figures of a light as (label, value) pairs."""
    emission = light.emission
    flux = luminous_flux(settings, light)
    held = len(emission.threshold)
    count = f"{light.rays:,}".replace(",", " ")
    return [
        ("Rays", count if held >= light.rays else f"{count}, {held:,} held".replace(",", " ")),
        ("Flux", "not stated" if flux is None else f"{flux:.4g} lm"),
        ("Size", format_lengths([emission.size])),
        ("Starts from", light.body.removeprefix("a body of ")),
        ("Symmetry", "even about an axis" if emission.axis is not None else "none"),
        ("Own error", f"{100.0 * emission.information_error:.2g} % for want of rays"),
        ("Rays in lux maps", f"within {format_lengths([emission.near])}"),
        ("Point beyond", _point_words(emission)),
    ]


def _point_words(emission) -> str:
    return f"wrong by {100.0 * float(emission.point_errors(emission.near)):.1g} % at most"


def settings_used(light):
    """Return the settings of a light that shines as a ray file says, None of other lights."""
    settings = light.lumenray.rayset
    return settings if light.type in LIGHT_TYPES and settings.use_file else None


def shown_rays(context) -> list:
    """Visible objects whose rays are to be drawn, each with its prepared light; those that are not ready are left out."""
    found = []
    for thing in context.visible_objects:
        settings = rays_of(thing)
        if settings is None or not (settings.use_file and settings.show_rays):
            continue
        state = state_of(settings)
        if state.light is not None:
            found.append((thing, state.light))
    return found
