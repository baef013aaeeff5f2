"""What the library of ray sets has, without what makes it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Entry:
    """A ray set.

    Parameters
    ----------
    name : str    Of its file, without the end.
    title, description : str    For people.
    spectrum : str    Name of the spectrum in `libraries.spectra`, or colour temperature such as ``2900 K``.
    luminous_flux : float    [lm]
    """

    name: str
    title: str
    description: str
    spectrum: str
    luminous_flux: float


ENTRIES = (
    Entry(
        "led_dome",
        "LED with dome",
        "Square chip of 1 mm under a hemisphere of silicone 2.5 mm wide",
        "LED-B3",
        120.0,
    ),
    Entry(
        "led_collimator",
        "LED with collimator",
        "Square chip of 1 mm in a lens of acrylic 18 mm wide that reflects totally at its wall",
        "LED-B3",
        110.0,
    ),
    Entry(
        "filament",
        "Filament of a lamp",
        "Coil of ten turns, 4.8 mm long, along x; turns shade each other",
        "2900 K",
        800.0,
    ),
    Entry(
        "tube_t8_18w",
        "Fluorescent tube T8 18 W",
        "Tube of 26 mm by 590 mm along x, darker before its electrodes",
        "FL3.12",
        1350.0,
    ),
)
"""All."""
