"""Spectra of TM-33 documents, and what they make of radiant and photon intensities."""

import numpy as np

from ....errors import FileFormatError
from ....photometry.spectra import luminous_weight
from ....reading.remarks import Remark
from ....reading.safe_xml import XmlElement
from ....reading.text import parse_number
from ....scene.spectrum import Tabulated
from ...distribution import azimuth_weights, polar_weights
from ...spectrum_checks import tell_oddities
from .intensity import LONGEST_WAVELENGTH, read_table, to_grid
from .values import attribute, number_in, optional_number, text_of

MOLAR_PHOTON_ENERGY = 0.11962656582
"""Energy of a mole of photons times their wavelength, h c N_A. [J m / mol] (SI 2019)"""

Spectrum = tuple[np.ndarray, np.ndarray]


def read_spectrum(path, emitter: XmlElement, photometric_type: str, remarks) -> Spectrum | None:
    """Relative spectral power of an emitter.

    Returns
    -------
    (wavelengths (n,) [nm], values (n,)) or None    Ascending; None if the document states none.

    Raises
    ------
    FileFormatError    It cannot be a spectrum; with the line.
    """
    data = emitter.find("SpectralData")
    found = data.findall("EmitterSpectral") if data is not None else []
    if found:
        if len(found) > 1:
            text = f"{len(found)} spectra (EmitterSpectral), of which the first is used"
            remarks.append(Remark(text, found[0].line))
        return _of_emitter(path, found[0], remarks)
    angular = data.find("AngularSpectral") if data is not None else None
    if angular is not None:
        return _of_angles(path, angular, photometric_type, remarks)
    listed = emitter.find("SpectralDistribution")
    if listed is not None:
        return _of_lists(path, listed, remarks)
    return None


def _of_emitter(path, element: XmlElement, remarks) -> Spectrum | None:
    data = element.findall("PwrData")
    quantum = optional_number(element, "Quantum", remarks)
    if quantum:
        text = "the spectrum counts photons (Quantum), which is not read; give the light a spectrum"
        remarks.append(Remark(text, element.line))
        return None
    wavelengths = np.array([attribute(path, item, "w") for item in data])
    values = np.array([number_in(path, item, "a spectral power") for item in data])
    stated = element.find("NumberWavelength")
    if stated is not None and number_in(path, stated, "NumberWavelength") != len(data):
        raise FileFormatError(
            path,
            f"NumberWavelength says {text_of(element, 'NumberWavelength')}, but there are {len(data)} PwrData",
            stated.line,
        )
    lines = np.array([item.line for item in data])
    return _checked(path, wavelengths, values, element.line, remarks, lines)


def _of_angles(path, element: XmlElement, photometric_type: str, remarks) -> Spectrum:
    """The mean over all directions."""
    table = read_table(path, element, remarks, True)
    grid = to_grid(path, table, photometric_type, remarks)
    rows = np.tensordot(azimuth_weights(np.deg2rad(grid.azimuth)), grid.values, 1)
    values = polar_weights(np.deg2rad(grid.polar)) @ rows
    text = "the spectrum depends on the direction; its mean over all directions is used"
    remarks.append(Remark(text, element.line))
    return _checked(path, table.wavelengths, values, element.line, remarks)


def _of_lists(path, element: XmlElement, remarks) -> Spectrum:
    """Two lists of numbers, as some programs write."""
    lists = []
    for name in ("Wavelengths", "Values"):
        numbers = [parse_number(token) for token in text_of(element, name).split()]
        if None in numbers:
            raise FileFormatError(path, f"{name} holds something that is no number", element.line)
        lists.append(np.array(numbers, dtype=np.float64))
    if len(lists[0]) != len(lists[1]):
        raise FileFormatError(
            path,
            f"{len(lists[0])} Wavelengths and {len(lists[1])} Values, expected as many of both",
            element.line,
        )
    text = "SpectralDistribution, which the schema does not know, read as the spectrum"
    remarks.append(Remark(text, element.line))
    return _checked(path, *lists, element.line, remarks)


def _checked(path, wavelengths, values, line, remarks, lines=None) -> Spectrum:
    """Ascending wavelengths, each once, and powers of which none is negative; ``lines``: of each, None: all in one."""

    def fail(message):
        raise FileFormatError(path, message, line)

    if len(wavelengths) < 2:
        fail(f"a spectrum of {len(wavelengths)} values, expected at least two")
    found, beside = wavelengths, values
    order = np.argsort(wavelengths, kind="stable")
    wavelengths, values = wavelengths[order], values[order]
    if wavelengths[0] <= 0.0 or wavelengths[-1] > LONGEST_WAVELENGTH or wavelengths[-1] < 20.0:
        fail(
            f"wavelengths from {wavelengths[0]:g} to {wavelengths[-1]:g}, expected nanometres above 0"
        )
    doubled = np.flatnonzero(np.diff(wavelengths) <= 0.0)
    if len(doubled):
        fail(f"two spectral powers at {wavelengths[doubled[0]]:g} nm")
    if values.min() < 0.0:
        fail(f"a negative spectral power ({values.min():g}), expected 0 or more")
    if not 0.0 < values.max() < 1e30:
        fail(f"a largest spectral power of {values.max():g}, expected more than 0")
    lines = np.full(len(found), line) if lines is None else lines
    told = tell_oddities(path, lines, found, beside, "the spectrum")
    remarks += [Remark(text, line) for text in told]
    return wavelengths, values


def luminous_efficacy(path, spectrum: Spectrum, low, high, line, photons: bool = False) -> float:
    """Lumens for a watt, or for a micromole of photons per second, counted between two wavelengths.

    Parameters
    ----------
    spectrum : (wavelengths (n,) [nm], values (n,))
    low, high : float or None    Between which the watts or photons were counted, None: all. [nm]
    line : int    For messages.
    photons : bool

    Returns
    -------
    float    [lm/W] or [lm s/umol]

    Raises
    ------
    FileFormatError    The spectrum has no visible light, or nothing between the wavelengths.
    """
    wavelengths, values = spectrum
    values = values / values.max()
    low = wavelengths[0] if low is None else max(low, wavelengths[0])
    high = wavelengths[-1] if high is None else min(high, wavelengths[-1])
    visible = luminous_weight(Tabulated(wavelengths, values))
    if visible <= 0.0:
        raise FileFormatError(
            path, "the spectrum has no visible light, so the intensities give no candela", line
        )
    amount = 0.0
    if low < high:
        inside = (wavelengths > low) & (wavelengths < high)
        fine = np.arange(np.ceil(low), high) if high - low < 1e5 else np.empty(0)
        grid = np.unique(np.concatenate([[low], wavelengths[inside], fine[fine > low], [high]]))
        power = np.interp(grid, wavelengths, values)
        if photons:
            power = power * grid * 1e-9 / MOLAR_PHOTON_ENERGY * 1e6
        amount = float(np.sum(0.5 * (power[1:] + power[:-1]) * np.diff(grid)))
    if amount <= 0.0:
        raise FileFormatError(
            path, f"the spectrum has no power between {low:g} and {high:g} nm", line
        )
    return visible / amount
