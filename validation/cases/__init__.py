"""The cases, one module for each kind of scene; each is registered under its number when its module is imported."""

from .registry import CASES, Case, case

__all__ = ["Case", "all_cases", "case"]


def all_cases() -> dict[str, Case]:
    """Return all cases by id, in order."""
    from . import (  # noqa: F401 - registers the cases
        bulb,
        closed_rooms,
        direct,
        direct_flux,
        direct_points,
        enclosures,
        facade,
        faceted,
        glare,
        glass,
        interreflection,
        keyhole,
        panes,
        photometry,
        pictures,
        roof,
        skies,
        spectral,
        specular,
        stability,
        sun,
        weather_skies,
    )

    return dict(sorted(CASES.items()))
