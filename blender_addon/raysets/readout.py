"""What the panel of a ray file shows: its figures in words."""

from ...engine.raysets.emission import RayLight
from ..foundation.units import format_lengths
from .convert import luminous_flux
from .files import ray_files
from .settings import rays_of

REMEDY = "Choose another file; until then the light is left out"


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


def shown_rays(context) -> list:
    """Visible objects whose rays are to be drawn, each with its prepared light; those that are not ready are left out."""
    found = []
    for thing in context.visible_objects:
        settings = rays_of(thing)
        if settings is None or not (settings.use_file and settings.show_rays):
            continue
        light = ray_files.state_of(settings).reading
        if light is not None:
            found.append((thing, light))
    return found
