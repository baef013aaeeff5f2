"""What becomes white in a picture."""

from ...engine.photometry import units


def white_luminance(settings) -> float | None:
    """Return the luminance that becomes 1.0 in the picture, None when it is to be found from the picture. [cd/m2]"""
    if settings.exposure == "AUTO":
        return None
    if settings.exposure == "EV100":
        return float(units.luminance_from_ev100(settings.ev100))
    return settings.white_luminance
