"""Spectrum of a sky as its settings state it: a colour temperature, or that of a clear sky where there is one."""

import numpy as np

from ...engine.errors import SceneError
from ...engine.scene.spectrum import Daylight, Spectrum
from ...engine.sky import clear_sky

CLOUDLESS = range(11, 16)
"""Types of the CIE without clouds."""

CLEAR = 4.5
"""Clearness of the model of Perez from which on a sky counts as clear. [-]"""


def find_spectrum(settings, towards_sun: np.ndarray, clearness: float | None = None) -> Spectrum:
    """Return the spectrum of a sky by formula.

    Parameters
    ----------
    settings : LumenraySkySettings
    towards_sun : (3,) array    Unit vector, not below the horizon.
    clearness : float or None    Of a weather file's record.

    Raises
    ------
    SceneError    That of a clear sky is asked for, of a sky with clouds or a sun that is not above the horizon.
    """
    daylight = Daylight(settings.colour_temperature)
    if settings.spectrum != "CLEAR":
        return daylight
    _refuse_clouds(settings, clearness)
    if settings.kind == "CLOUDINESS" and settings.cloudiness >= 1.0:
        return daylight
    clear = clear_sky.find_spectrum(*_numbers(settings, towards_sun))
    if settings.kind == "CLOUDINESS" and settings.cloudiness > 0.0:
        name = f"{clear.name}, {100.0 * settings.cloudiness:.0f} % by clouds"
        return clear_sky.mix_spectra(clear, daylight, settings.cloudiness, name)
    return clear


def own_illuminance(settings, towards_sun: np.ndarray) -> float:
    """Return the horizontal illuminance that the spectral sky itself has. [lx]

    Raises
    ------
    SceneError    The spectrum is none of a clear sky, or the sky has clouds.
    """
    if settings.spectrum != "CLEAR":
        raise SceneError(
            "the sky is to be as bright as a clear sky itself, but its spectrum is not that of one"
        )
    if settings.kind == "CLOUDINESS" and settings.cloudiness > 0.0:
        raise SceneError("a sky with clouds has no level of a clear sky's own; state it")
    return clear_sky.find_illuminance(*_numbers(settings, towards_sun))


def refuse_picture(settings) -> None:
    """Refuse the spectrum of a clear sky for skies that are pictures, which have no one place of the sun.

    Raises
    ------
    SceneError    It is asked for.
    """
    if settings.spectrum == "CLEAR":
        raise SceneError(
            "the spectrum of a clear sky is not known for measured skies and means of several hours; take a colour "
            "temperature"
        )


def _refuse_clouds(settings, clearness: float | None) -> None:
    if settings.kind == "CIE" and int(settings.type) not in CLOUDLESS:
        raise SceneError(
            f"the spectrum of a clear sky is asked for, but type {settings.type} has clouds; types {CLOUDLESS[0]} to "
            f"{CLOUDLESS[-1]} have none"
        )
    if settings.kind == "WEATHER" and not (clearness is not None and clearness >= CLEAR):
        raise SceneError(
            f"the spectrum of a clear sky is asked for, but the weather's record has clouds: its clearness is "
            f"{clearness:.1f}, expected {CLEAR:g} at least"
        )


def _numbers(settings, towards_sun: np.ndarray) -> tuple[float, float, float]:
    elevation = float(np.degrees(np.arcsin(np.clip(towards_sun[2], -1.0, 1.0))))
    return elevation, settings.turbidity, settings.ground_reflectance
