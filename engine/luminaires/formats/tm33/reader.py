"""ANSI/IES TM-33, UNI 11733 and ATLA S001: luminaires as XML, the successor of LM-63.

Read are the intensities (luminous, or radiant and photon ones by way of the spectrum), the spectrum and what describes the
luminaire. Illuminances on planes, colours by angle and custom data are left out.

References
----------
ANSI/IES TM-33-18 and TM-33-23, Standard Format for the Electronic Transfer of Luminaire Optical Data.
"""

from dataclasses import dataclass, field

import numpy as np

from ....errors import FileFormatError
from ....photometry.spectra import luminous_weight
from ....reading.remarks import Remark
from ....reading.safe_xml import XmlElement, parse_xml
from ....scene.distribution import IntensityDistribution
from ....scene.spectrum import Tabulated
from ...coordinates import FRAMES
from ...distribution import azimuth_weights, flux, polar_weights
from ..record import LampSet, LuminaireFile, TiltTable
from .body import read_body
from .intensity import Grid, Table, read_table, to_grid
from .spectrum import Spectrum, luminous_efficacy, read_spectrum
from .values import attribute, key_of, number_in, optional_number, text_of

MINIMUM_INTENSITY, MAXIMUM_INTENSITY = 1e-12, 1e12
"""The peak lies between; more than a searchlight and less than anything that can be measured are mistakes. [cd]"""

MAXIMUM_EMITTERS = 1000

MAXIMUM_QUANTITY = 100_000

TOLERANCE = 0.05
"""How far the computed flux may be off a stated one before it is remarked on."""

LEAST_OUTPUT_RATIO = 0.2
"""Luminaires with less of their lamps' flux are remarked on."""

_QUANTITIES = (
    ("LuminousData", "LuminousIntensity", "luminous"),
    ("RadiantData", "RadiantIntensity", "radiant"),
    ("PhotonData", "PhotonIntensity", "photon"),
)
"""Where intensities stand, in the order in which they are taken."""

_METADATA = (
    ("MANUFAC", "Manufacturer"),
    ("LUMCAT", "CatalogNumber"),
    ("LUMINAIRE", "Description"),
    ("TESTLAB", "Laboratory"),
    ("TEST", "ReportNumber"),
    ("ISSUEDATE", "ReportDate"),
    ("_GTIN", "GTIN"),
    ("_DOCUMENT_CREATOR", "DocumentCreator"),
    ("_DOCUMENT_DATE", "DocumentCreationDate"),
    ("_UNIQUE_IDENTIFIER", "UniqueIdentifier"),
    ("_URI", "MoreInfoURI"),
)
"""Keys of the metadata, those of LM-63 where they mean the same, and the elements of the header."""


@dataclass(eq=False)
class _Emitter:
    """One emitter; ``grid`` holds candela."""

    lamp: LampSet
    grid: Grid | None
    spectrum: Spectrum | None
    line: int
    is_absolute: bool = True
    rated_flux: float | None = None
    measured_flux: float | None = None
    tilt: TiltTable | None = None
    table: Table | None = field(default=None, repr=False)


def parse_tm33(data: bytes, path) -> LuminaireFile:
    """Read the content of a file.

    Parameters
    ----------
    data : bytes
    path : str or Path    For messages only.

    Returns
    -------
    LuminaireFile    Length lies along y: TM-33 calls length and height the sides of the face towards C0.

    Raises
    ------
    FileFormatError    It cannot be read safely: with the line, what was found and what was expected.
    """
    root = parse_xml(data, path)
    name = _format(path, root)
    remarks: list[Remark] = []
    found = root.findall("Emitter")
    if not 0 < len(found) <= MAXIMUM_EMITTERS:
        raise FileFormatError(
            path, f"{len(found)} emitters, expected 1 to {MAXIMUM_EMITTERS}", root.line
        )
    photometric_type = _photometric_type(path, root, found[0], remarks)
    emitters = [_read_emitter(path, item, photometric_type, remarks) for item in found]
    lit = [emitter for emitter in emitters if emitter.grid is not None]
    if not lit:
        raise FileFormatError(
            path,
            "holds no luminous, radiant or photon intensities (LuminousData, RadiantData, PhotonData)",
            found[0].line,
        )
    grid = _sum(path, lit, remarks)
    distribution = IntensityDistribution(
        np.deg2rad(grid.azimuth),
        np.deg2rad(grid.polar),
        grid.values[:, :, 0],
        FRAMES[photometric_type],
    )
    if not MINIMUM_INTENSITY <= grid.values.max() <= MAXIMUM_INTENSITY:
        raise FileFormatError(
            path,
            f"a largest intensity of {grid.values.max():g} cd, expected {MINIMUM_INTENSITY:g} to"
            f" {MAXIMUM_INTENSITY:g} cd",
            lit[0].line,
        )
    is_absolute = all(emitter.is_absolute for emitter in lit)
    stated = _stated_flux(lit, is_absolute)
    if stated is not None:
        _compare_flux(flux(distribution), stated, is_absolute, lit[0].line, remarks)
    opening, housing = read_body(root, found, remarks)
    watts = [emitter.lamp.watts for emitter in emitters if emitter.lamp.watts is not None]
    swapped = photometric_type == "B"
    table = lit[0].table
    return LuminaireFile(
        format=name,
        photometric_type=photometric_type,
        symmetry=grid.symmetry,
        distribution=distribution,
        opening=opening,
        stored_azimuths=table.vertical if swapped else table.horizontal,
        stored_polars=table.horizontal if swapped else table.vertical,
        is_absolute=is_absolute,
        stated_flux=stated,
        watts=sum(watts) if watts else None,
        lamps=tuple(emitter.lamp for emitter in lit + [e for e in emitters if e.grid is None]),
        housing=housing,
        tilt=lit[0].tilt,
        spectrum=_mixed_spectrum(lit, remarks),
        metadata=_metadata(root.find("Header")),
        remarks=tuple(sorted(remarks, key=lambda remark: remark.line)),
    )


def _format(path, root: XmlElement) -> str:
    key = key_of(root.tag)
    if key == "iestm33":
        return "TM-33-18"
    if key.startswith("iestm33-"):
        return "TM-33-23"
    if key.startswith(("atlas001", "luminaireopticaldata")):
        return "ATLA S001"
    if key.startswith("uni"):
        return "UNI 11733"
    raise FileFormatError(
        path,
        f"is XML with the root element {root.tag[:40]}, expected IESTM33 or IESTM33-22 (a TM-33 luminaire)",
        root.line,
    )


def _photometric_type(path, root: XmlElement, emitter: XmlElement, remarks) -> str:
    """Type A, B or C of the goniometer."""
    places = (
        root.find("Equipment/Gonioradiometer/Type"),
        root.find("Equipment/Goniometer/Type"),
        root.find("Equipment/Goniometer/GoniometerType"),
        emitter.find("IntensityDistribution/PhotometryType"),
        emitter.find("LuminousData/PhotometryType"),
    )
    for element in places:
        key = key_of(element.text or "") if element is not None else ""
        if not key:
            continue
        if key in {"iesa", "iesb", "iesc"}:
            return key[-1].upper()
        if key in {"ciec", "typec", "c"}:
            return "C"
        raise FileFormatError(
            path,
            f"'{' '.join(element.text.split())[:40]}' as type of the goniometer, expected IES_A, IES_B, IES_C or"
            " CIE_C: the axes of other types are not settled, so convert the file",
            element.line,
        )
    remarks.append(Remark("the type of the goniometer is not stated, taken as type C", root.line))
    return "C"


def _read_emitter(path, element: XmlElement, photometric_type: str, remarks) -> _Emitter:
    rated = optional_number(element, "RatedLumens", remarks) or None
    watts = optional_number(element, "InputWattage", remarks) or None
    if watts is None:
        watts = optional_number(element, "InputWatts", remarks) or None
    colour = text_of(element, "ColorTemperature/FixedCCT", "FixedCCT", "CCT")
    lamp = LampSet(
        count=_quantity(element, remarks),
        luminous_flux=rated,
        watts=watts,
        colour_temperature=_colour_temperature(element, remarks),
        name=text_of(element, "Description", "CatalogNumber"),
        colour=colour,
        colour_rendering=text_of(element, "ColorRendering/CIE_CRI/Ra", "ColorRendering/Ra"),
    )
    ballast = optional_number(element, "BallastFactor", remarks)
    if ballast is not None and ballast != 1.0:
        text = f"a ballast factor of {ballast:g}, which is not applied: the intensities are as measured"
        remarks.append(Remark(text, element.find("BallastFactor").line))
    spectrum = read_spectrum(path, element, photometric_type, remarks)
    emitter = _Emitter(lamp, None, spectrum, element.line, rated_flux=rated)
    emitter.tilt = _tilt(path, element.find("TiltAngles"), remarks)
    for group, intensity, quantity in _QUANTITIES:
        holder = element.find(group)
        places = [holder.find(intensity)] if holder is not None else []
        if quantity == "luminous":
            # Where programs that do not keep to the schema put the data.
            places += [holder, element.find("IntensityDistribution")]
        table = next((place for place in places if _holds_data(place, intensity)), None)
        if table is None:
            continue
        emitter.line = table.line
        emitter.table = read_table(path, table, remarks)
        emitter.grid = to_grid(path, emitter.table, photometric_type, remarks)
        if quantity == "luminous":
            emitter.measured_flux = optional_number(holder, "LuminousFlux", remarks) or None
        else:
            factor = _candela_per_unit(path, holder, spectrum, quantity, table.line, remarks)
            emitter.grid.values[...] *= factor
        emitter.is_absolute = _is_absolute(table, remarks)
        break
    return emitter


def _holds_data(element: XmlElement | None, name: str) -> bool:
    if element is None:
        return False
    return element.tag == name or any(
        element.find(data) is not None for data in ("IntData", "IntensityData")
    )


def _quantity(element: XmlElement, remarks) -> int:
    value = optional_number(element, "Quantity", remarks)
    if value is None:
        return 0
    if value > MAXIMUM_QUANTITY:
        text = f"{value:g} as Quantity of emitters, taken as unknown"
        remarks.append(Remark(text, element.find("Quantity").line))
        return 0
    return round(value)


def _colour_temperature(element: XmlElement, remarks) -> float | None:
    for name in ("ColorTemperature/FixedCCT", "FixedCCT", "CCT"):
        value = optional_number(element, name, remarks)
        if value:
            return value
    limits = [
        optional_number(element, f"ColorTemperature/{name}", remarks)
        for name in ("MinCCT", "MaxCCT")
    ]
    if all(limits):
        text = f"a colour temperature from {limits[0]:g} to {limits[1]:g} K; the middle is taken"
        remarks.append(Remark(text, element.find("ColorTemperature").line))
        # The middle as the eye sees it, in reciprocal temperature.
        return 2.0 / (1.0 / limits[0] + 1.0 / limits[1])
    return None


def _tilt(path, element: XmlElement | None, remarks) -> TiltTable | None:
    if element is None:
        return None
    pairs = sorted(
        (attribute(path, item, "angle"), number_in(path, item, "a factor for the tilt"))
        for item in element.findall("Tilt")
    )
    angles = np.array([angle for angle, _ in pairs])
    factors = np.array([factor for _, factor in pairs])
    if not pairs or np.any(np.diff(angles) <= 0.0) or factors.min() < 0.0:
        raise FileFormatError(
            path, "TiltAngles without angles, each once, and factors from 0", element.line
        )
    text = "the position of the lamp to the tilt factors is not stated, taken as tilting with the luminaire"
    remarks.append(Remark(text, element.line))
    return TiltTable(3, angles, factors)


def _is_absolute(table: XmlElement, remarks) -> bool:
    stated = key_of(text_of(table, "AbsolutePhotometry", "Absolute"))
    if stated in {"false", "0"}:
        return False
    if stated not in {"true", "1"}:
        text = "whether the photometry is absolute is not stated, taken as absolute"
        remarks.append(Remark(text, table.line))
    return True


def _candela_per_unit(path, holder: XmlElement, spectrum, quantity, line, remarks) -> float:
    """Candela for a unit of radiant (W/sr) or photon intensity (umol/(s sr))."""
    if spectrum is None:
        raise FileFormatError(
            path,
            f"{quantity} intensities without a spectrum give no candela; add SpectralData or luminous"
            " intensities",
            line,
        )
    low, high = (
        optional_number(holder, name, remarks) for name in ("MinWavelength", "MaxWavelength")
    )
    factor = luminous_efficacy(path, spectrum, low, high, line, quantity == "photon")
    unit = "W" if quantity == "radiant" else "umol/s"
    text = f"{quantity} intensities, made candela with the spectrum ({factor:.4g} lm for 1 {unit})"
    remarks.append(Remark(text, line))
    return factor


def _sum(path, lit: list[_Emitter], remarks) -> Grid:
    """All emitters together."""
    grid = lit[0].grid
    if len(lit) == 1:
        return grid
    values = np.zeros_like(grid.values)
    for emitter in lit:
        other = emitter.grid
        if (
            other.values.shape != values.shape
            or not np.allclose(other.azimuth, grid.azimuth)
            or not np.allclose(other.polar, grid.polar)
        ):
            raise FileFormatError(
                path,
                "the emitters have intensities at different angles, expected the same; split them into files",
                emitter.line,
            )
        values += other.values
    same = all(emitter.grid.symmetry == grid.symmetry for emitter in lit)
    remarks.append(Remark(f"the intensities of {len(lit)} emitters are added", lit[0].line))
    return Grid(grid.azimuth, grid.polar, values, grid.symmetry if same else "none")


def _stated_flux(lit: list[_Emitter], is_absolute: bool) -> float | None:
    """The flux of all emitters: for absolute data that of the luminaire, otherwise that of the lamps."""
    stated = [
        (emitter.measured_flux or emitter.rated_flux) if is_absolute else emitter.rated_flux
        for emitter in lit
    ]
    return sum(stated) if all(stated) else None


def _compare_flux(computed: float, stated: float, is_absolute: bool, line: int, remarks) -> None:
    ratio = computed / stated
    least = 1.0 - TOLERANCE if is_absolute else LEAST_OUTPUT_RATIO
    if least <= ratio <= 1.0 + TOLERANCE:
        return
    text = f"the intensities give {computed:.4g} lm, but {stated:g} lm are stated; the intensities count"
    if ratio < least and LEAST_OUTPUT_RATIO <= computed / 1000.0 <= 1.0 + TOLERANCE:
        text += " (they look like candela per 1000 lm, which TM-33 does not know)"
    remarks.append(Remark(text, line))


def _mixed_spectrum(lit: list[_Emitter], remarks) -> Spectrum | None:
    """The spectrum of all emitters together, each by its flux."""
    known = [emitter for emitter in lit if emitter.spectrum is not None]
    if len(known) <= 1:
        if known and len(lit) > 1:
            text = f"a spectrum is stated for one of {len(lit)} emitters and taken for all"
            remarks.append(Remark(text, known[0].line))
        return known[0].spectrum if known else None
    wavelengths = np.unique(np.concatenate([emitter.spectrum[0] for emitter in known]))
    total = np.zeros(len(wavelengths))
    for emitter in known:
        own = Tabulated(*emitter.spectrum)
        weight = luminous_weight(own)
        if weight > 0.0:
            total += (
                _flux(emitter.grid)
                / weight
                * np.interp(wavelengths, *emitter.spectrum, left=0.0, right=0.0)
            )
    remarks.append(Remark(f"the spectra of {len(known)} emitters are mixed", known[0].line))
    return (wavelengths, total) if total.any() else None


def _flux(grid: Grid) -> float:
    """[lm]"""
    rows = azimuth_weights(np.deg2rad(grid.azimuth)) @ grid.values[:, :, 0]
    return float(rows @ polar_weights(np.deg2rad(grid.polar)))


def _metadata(header: XmlElement | None) -> dict[str, str]:
    found = {key: text_of(header, name) for key, name in _METADATA}
    for key, names in (("OTHER", ("Comment", "Comments")), ("_REFERENCE", ("Reference",))):
        items = [] if header is None else [item for item in header if item.tag in names]
        found[key] = "\n".join(" ".join((item.text or "").split()) for item in items)
    return {key: text for key, text in found.items() if text}
