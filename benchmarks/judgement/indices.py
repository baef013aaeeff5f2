"""Ra, Rf, Rg, colour temperature and Duv beside colour-science."""

import warnings
from importlib import util

from ...engine.photometry.colour_fidelity import fidelity_and_gamut
from ...engine.photometry.colour_rendering import general_index
from ...engine.photometry.colour_temperature import colour_temperature
from ...engine.photometry.spectra import GRID, illuminant, observer

LAMPS = (
    "A", "D50", "D65", "FL1", "FL2", "FL3", "FL4", "FL7", "FL8", "FL9", "FL10", "FL11", "FL12", "LED-B1", "LED-B2", "LED-B3",
    "LED-B4", "LED-B5", "LED-BH1", "LED-RGB1", "LED-V1", "LED-V2",
)  # fmt: skip


def is_possible() -> bool:
    """Whether colour-science is there, a development dependency."""
    return util.find_spec("colour") is not None


def measure(say) -> list[dict]:
    """Compare; a row of each lamp with the figures of both."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour

        rows = []
        for lamp in LAMPS:
            power = illuminant(GRID, lamp)
            theirs = colour.SpectralDistribution(dict(zip(GRID, power, strict=True)))
            quality = colour.quality.colour_fidelity_index_ANSIIESTM3018(theirs, True)
            fidelity, gamut = fidelity_and_gamut(power)
            temperature, duv = colour_temperature(power @ observer())
            rows.append(
                {
                    "lamp": lamp,
                    "ra": [general_index(power), float(colour.colour_rendering_index(theirs))],
                    "rf": [fidelity, float(quality.R_f)],
                    "rg": [gamut, float(quality.R_g)],
                    "cct": [temperature, float(quality.CCT)],
                    "duv": [duv, float(quality.D_uv)],
                }
            )
    say(f"judgement: colour indices of {len(rows)} lamps")
    return rows
