"""Alpha-opic quantities: figures of the CIE's toolbox, and sensors in coloured rooms against quadrature."""

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.photometry.alpha_opic import (
    MELANOPIC,
    RECEPTORS,
    alpha_opic,
    daylight_ratios,
    equivalent_daylight,
)
from ...engine.photometry.spectra import GRID, evaluate_reflectance, photometric_density
from ...engine.scene.material import Diffuse, Emission, Material
from ...engine.scene.scene import SceneDelta
from ...engine.scene.spectrum import Illuminant, Tabulated
from ...engine.session import Session
from ..common.pieces import make_mesh, side_of_box

TOOLBOX = {
    "s_cone": 0.8173,
    "m_cone": 1.4558,
    "l_cone": 1.6289,
    "rhodopic": 1.4497,
    "melanopic": 1.3262,
}
"""Alpha-opic efficacies of luminous radiation of D65, as CIE S 026 and its toolbox print them. [mW/lm]"""

IRRADIANCE, DAYLIGHT = 52.3937e-3, 39.51
"""Melanopic irradiance [W/m2] and its equivalent daylight illuminance [lx] by the toolbox."""

LAMPS = ("A", "D65", "FL2", "FL11", "HP1", "LED-B1", "LED-B3", "LED-B5", "LED-BH1", "LED-RGB1")
"""Spectra of the rooms."""

PAINTS = {
    "red": Tabulated(np.array([360.0, 480.0, 620.0, 830.0]), np.array([0.1, 0.15, 0.7, 0.8])),
    "blue": Tabulated(np.array([360.0, 450.0, 560.0, 830.0]), np.array([0.6, 0.6, 0.2, 0.15])),
}

LUMINANCE, ERROR = 20.0, 0.001
"""That the walls give off themselves [cd/m2], and relative standard error that is asked for. [-]"""


def measure(say) -> dict:
    """Compare.

    Returns
    -------
    dict    ``toolbox_percent``: largest difference; ``rooms``: rows of lamp, paint, melanopic equivalent daylight
        illuminances [lx] of sensor and quadrature, and the stated error.
    """
    ratios = dict(zip(RECEPTORS, 1000.0 * daylight_ratios(), strict=True))
    apart = [abs(ratios[name] / value - 1.0) for name, value in TOOLBOX.items()]
    receptors = np.zeros(len(RECEPTORS))
    receptors[MELANOPIC] = IRRADIANCE
    apart.append(abs(equivalent_daylight(receptors)[MELANOPIC] / DAYLIGHT - 1.0))
    rows = []
    for lamp in LAMPS:
        for name, paint in PAINTS.items():
            rows.append({"lamp": lamp, "paint": name, **_room(Illuminant(lamp), paint)})
        say(f"judgement: melanopic light of {lamp}")
    return {"toolbox_percent": 100.0 * max(apart), "rooms": rows}


def largest_difference(result: dict) -> float:
    """Largest difference from the toolbox or from quadrature. [%]"""
    rooms = [100.0 * abs(row["sensor"] / row["quadrature"] - 1.0) for row in result["rooms"]]
    return max(result["toolbox_percent"], *rooms)


def _room(lamp, paint) -> dict:
    """A closed room whose walls shine and reflect: irradiance is pi L / (1 - rho) at every wavelength."""
    room = ((0.0, 0.0, 0.0), (2.0, 2.0, 2.0))
    names = ("bottom", "top", "-y", "+y", "-x", "+x")
    walls = make_mesh("walls", [side_of_box(*room, name) for name in names], "paint")
    session = Session(witness=False)
    material = Material("paint", "paint", Diffuse(paint), Emission(lamp, LUMINANCE))
    session.apply(SceneDelta(changed=(material, walls)))
    rule = StopRule(error=ERROR, samples=1 << 20)
    made = session.measure([[1.0, 1.0, 1.0]], [[0.0, 0.0, 1.0]], rule, 1, "spectral", spectrum=True)
    emitted = np.pi * LUMINANCE * photometric_density(lamp)
    expected = equivalent_daylight(alpha_opic(emitted / (1.0 - evaluate_reflectance(paint, GRID))))
    spectra = made.spectra
    return {
        "sensor": float(spectra.equivalent_daylight[0, MELANOPIC]),
        "error": float(spectra.equivalent_daylight_error[0, MELANOPIC]),
        "quadrature": float(expected[MELANOPIC]),
    }
