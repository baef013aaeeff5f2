"""The spectrum of a luminaire by what its photometric file says of the lamp, and the reason in one sentence.

Lamps are known by the names in use: plain words in English and German, and in the lamp's own fields also lamp codes (ZVEI,
ILCOS) and makers' brands. Their colour comes from a colour temperature, a colour code such as 840 (Ra 80 and more, 4000 K)
or a colour name.
"""

import re
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..photometry.spectra import GRID, evaluate_emission, observer, planck
from ..scene.spectrum import Blackbody, Daylight, Illuminant, Spectrum, Tabulated
from .formats.record import RADIANT, LuminaireFile

ULTRAVIOLET = "ultraviolet lamp"

KINDS = {
    ULTRAVIOLET: (r"excimer|germicid|\bUV-?C\b", None),
    "metal halide lamp": (
        r"metal[ -]*halide|halogen-?metall|metall-?halogen",
        r"\bMH(?![a-z])|\bHI(T|E|R|PE|PAR)\b|\bHQI|\bHCI|\bCDM|\bCMH|\bCPO\b|\bMHN|\bMHW",
    ),
    "low-pressure sodium lamp": (r"low[ -]*pressure[ -]*sodium", r"\bLPS\b|\bSOX\b|\bLST\b"),
    "high-pressure sodium lamp": (
        r"sodium|natrium(hoch|dampf)",
        r"\bHPS\b|\bHS[TE]\b|\bSON\b|\bNAV\b|\bSDW",
    ),
    "mercury lamp": (r"mercury[ -]*(vapou?r|lamp)|quecksilberdampf", r"\bHQL\b|\bHPL\b|\bHM[EL]\b"),
    "LED": (r"(?<![a-z])O?LEDs?(?![a-z])|light[ -]*emitting|leuchtdiode", r"\bLED|\bCOB\b|luxeon"),
    "halogen lamp": (r"halogen", r"\bQ(T|PAR|R|TDE)[ -]?\d*\b|\bMR ?1[16]\b|\bHALO(PAR|SPOT|STAR)"),
    "fluorescent lamp": (
        r"fluorescent|leuchtstoff|induction lamp|(?<![A-Z0-9])T ?(5|8|12|16|26)(HO|HE)?(?![A-Z0-9])",
        r"\bF[OPH]?\d+T\d|\bTL-?[5D]\b|\bCFL|\bTC-|\bPL-?[CLTSR]\b|DULUX|LUMILUX|ICETRON",
    ),
    "incandescent lamp": (
        r"incandescent|gl(ü|ue)hlampe",
        r"\bINC\b|tungsten|\bGLS\b|\bA-?19\b|\bR-?(20|30|40)\b",
    ),
}
"""Kinds of lamps in the order in which they are looked for: words by which they are known anywhere in a file, and words that
count only in what the file says of the lamp."""

SERIES = {
    "LED": (
        (80, {"LED-B1": 2733, "LED-B2": 2998, "LED-B3": 4103, "LED-B4": 5109, "LED-B5": 6598}),
        (90, {"LED-V1": 2724, "LED-V2": 4070}),
    ),
    "fluorescent lamp": (
        (80, {"FL12": 3000, "FL11": 4000, "FL10": 5000, "FL7": 6500}),
        (90, {"FL3.12": 2984, "FL3.13": 3896, "FL3.14": 5045, "FL3.15": 6509}),
        (50, {"FL4": 2940, "FL3": 3450, "FL2": 4230, "FL1": 6430}),
    ),
    "metal halide lamp": ((80, {"HP3": 3144, "HP4": 4002}),),
    "high-pressure sodium lamp": ((20, {"HP1": 1959, "HP2": 2506}),),
}
"""CIE illuminants of a kind of lamp with their colour temperature [K], in rows by the colour rendering index; the first row
counts if that is unknown. (CIE 15:2018, tables 9, 10.1 to 10.3, 11 and 12.1; FL7 stands for triphosphor lamps of 6500 K.)"""

USUAL = {
    "LED": 4000.0,
    "fluorescent lamp": 4000.0,
    "metal halide lamp": 4000.0,
    "high-pressure sodium lamp": 2000.0,
    "halogen lamp": 3000.0,
}
"""Colour temperature that is assumed if none is stated. [K]"""

COLOUR_NAMES = {
    r"warm[ -]*(white|wei(ß|ss))|\bww\b": 3000.0,
    r"(neutral|cool)[ -]*(white|wei(ß|ss))|\bnw\b|\bcw\b": 4000.0,
    r"tageslicht|day[ -]*light|\btw\b": 6500.0,
}
"""Colour names and the colour temperature that they stand for. [K] (EN 12464-1: below 3300 K, up to 5300 K, above)"""

NEAR = 0.03
"""Relative difference of colour temperature up to which an illuminant is taken as it is."""

COLDEST, HOTTEST = 1000.0, 25000.0
"""Colour temperatures that a lamp may have. [K]"""

DAYLIGHT_FROM = 5000.0
"""Colour temperature from which the reference illuminant is daylight, below a blackbody. [K] (CIE 13.3)"""

SODIUM_D = (588.995, 589.592)
"""Lines of a low-pressure sodium lamp. [nm]"""

_TENS = "18|20|22|25|27|30|35|40|50|57|60|65|80"
_UNITS = r"\s*(lm|lumen|ma|mm|m|w|watt|v|cd|h|k|°)"
_CODE = re.compile(rf"(?<![\d.,])([6-9])({_TENS})(?![\d.,]*\d|{_UNITS}(?![a-z]))", re.IGNORECASE)
_KELVIN = re.compile(r"(?<![\d.,])(\d{1,2})[ .,']?(\d{3})\s*°?\s*K(elvin)?\b", re.IGNORECASE)
_BARE_KELVIN = re.compile(r"(?<![\d.,])(\d{4,5})(?![\d.,]*\d)")
_RENDERING = re.compile(r"(?<![\d.])(\d{2,3})(?!\d)")
_RENDERING_NAMED = re.compile(r"\b(?:CRI|IRC|Ra)[ :=>≥]*(\d{2})\b", re.IGNORECASE)
_RENDERING_GROUPS = {"1A": 90.0, "1B": 80.0, "2A": 70.0, "2B": 60.0}
_NUMBER_KEY = re.compile(r"LUMEN|WATT|POSITION", re.IGNORECASE)
_TEMPERATURE_KEY = re.compile(r"CCT|KELVIN|COLOU?R_?TEMP|TEMP_?COLOU?R", re.IGNORECASE)


@dataclass(frozen=True)
class LampSpectrum:
    """A spectrum, and why it was chosen in one sentence for people.

    There is none of radiant intensities without one: what of them is visible, nobody knows. ``is_ultraviolet``: the file
    names an ultraviolet lamp.
    """

    spectrum: Spectrum | None
    reason: str
    is_ultraviolet: bool = False


@dataclass(frozen=True)
class _Lamp:
    """What a file says of its lamp; ``words`` are those that tell its kind."""

    kind: str | None
    words: str
    temperature: float | None
    rendering: float | None


def choose_spectrum(file: LuminaireFile) -> LampSpectrum:
    """Choose the spectrum of a luminaire.

    In this order: the spectral distribution in the file; a CIE illuminant of the kind of lamp, or two neighbours mixed to
    the colour temperature; the reference illuminant of the colour temperature; D65 if nothing is known. What is assumed is
    said. Nothing is assumed of radiant intensities.
    """
    if file.spectrum is not None:
        nm, values = file.spectrum
        reason = f"The file's own spectral distribution, {nm[0]:g} to {nm[-1]:g} nm."
        return LampSpectrum(Tabulated(nm, values, name="photometric file"), reason)
    lamp = _read_lamp(file)
    if file.quantity == RADIANT:
        is_ultraviolet = lamp.kind == ULTRAVIOLET
        start = (
            f"{ULTRAVIOLET[0].upper()}{ULTRAVIOLET[1:]} ('{lamp.words}'): the"
            if is_ultraviolet
            else "The"
        )
        reason = f"{start} file states watts (W/sr) and no spectrum, so it lights nothing visible."
        return LampSpectrum(None, reason, is_ultraviolet)
    if lamp.kind is None and lamp.temperature is None:
        reason = "The file tells neither the kind of lamp nor its colour: neutral white, CIE D65."
        return LampSpectrum(Illuminant("D65"), reason)
    if lamp.kind is None:
        return _reference(f"{lamp.temperature:g} K, the kind of lamp is not told", lamp.temperature)
    start = f"{lamp.kind[0].upper()}{lamp.kind[1:]} ('{lamp.words}')"
    match lamp.kind:
        case "ultraviolet lamp":
            reason = f"{start}: it gives hardly any visible light, yet the file states candelas; CIE D65 stands for it."
            return LampSpectrum(Illuminant("D65"), reason, is_ultraviolet=True)
        case "mercury lamp" if lamp.temperature is None:
            reason = f"{start}, of which there is no CIE illuminant: neutral white, CIE D65."
            return LampSpectrum(Illuminant("D65"), reason)
        case "mercury lamp":
            start = f"{start} of {lamp.temperature:g} K, of which there is no CIE illuminant"
            return _reference(start, lamp.temperature)
        case "low-pressure sodium lamp":
            return LampSpectrum(_sodium_lines(), f"{start}: the two sodium lines at 589 nm.")
        case "incandescent lamp" if lamp.temperature is None:
            return LampSpectrum(Illuminant("A"), f"{start}: CIE illuminant A, 2856 K.")
    temperature = lamp.temperature or USUAL[lamp.kind]
    stated = f"of {temperature:g} K"
    if lamp.temperature is None:
        stated = f"of unstated colour, {temperature:g} K assumed"
    if lamp.kind in {"incandescent lamp", "halogen lamp"}:
        return LampSpectrum(Blackbody(temperature), f"{start} {stated}: blackbody.")
    made, told = _from_series(SERIES[lamp.kind], temperature, lamp.rendering)
    return LampSpectrum(made, f"{start} {stated}: {told}.")


# ---- what the file says ----


def _read_lamp(file: LuminaireFile) -> _Lamp:
    lamp = file.lamps[0] if file.lamps else None
    own = [lamp.name, lamp.colour] if lamp else []
    keywords = [(key, text) for key, text in file.metadata.items() if not _NUMBER_KEY.search(key)]
    own += [text for key, text in keywords if "LAMP" in key.upper()]
    rest = [text for key, text in keywords if "LAMP" not in key.upper()]
    kind, words = _find_kind(own, rest)
    temperature, code = _find_temperature(file, own, rest)
    rendering = _find_rendering(file, [*own, *rest])
    return _Lamp(kind, words, temperature, code if rendering is None else rendering)


def _find_kind(own, rest) -> tuple[str | None, str]:
    """Kind of lamp and the text that tells it; the lamp's own fields come first."""
    for texts, is_own in ((own, True), (rest, False)):
        for text in texts:
            for kind, (anywhere, codes) in KINDS.items():
                words = f"{anywhere}|{codes}" if is_own and codes else anywhere
                if re.search(words, text, re.IGNORECASE):
                    return kind, _shorten(text)
    return None, ""


def _shorten(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= 40 else line[:37].rstrip() + "..."


def _find_temperature(file, own, rest) -> tuple[float | None, float | None]:
    """Colour temperature [K], and the colour rendering index if a colour code tells both."""
    lamp = file.lamps[0] if file.lamps else None
    code = next((found for text in own if (found := _CODE.search(text))), None)
    rendering = 10.0 * float(code[1]) if code else None
    if lamp and lamp.colour_temperature and COLDEST <= lamp.colour_temperature <= HOTTEST:
        return lamp.colour_temperature, rendering
    bare = [text for key, text in file.metadata.items() if _TEMPERATURE_KEY.search(key)]
    if lamp:
        bare.insert(0, lamp.colour)
    numbers = [found[1] + found[2] for text in (*own, *rest) if (found := _KELVIN.search(text))]
    numbers += [found[1] for text in bare if (found := _BARE_KELVIN.search(text))]
    for number in numbers:
        if COLDEST <= float(number) <= HOTTEST:
            return float(number), rendering
    if code:
        return 100.0 * float(code[2]), rendering
    for text in (*own, *rest):
        for name, temperature in COLOUR_NAMES.items():
            if re.search(name, text, re.IGNORECASE):
                return temperature, None
    return None, None


def _find_rendering(file, texts) -> float | None:
    stated = [file.lamps[0].colour_rendering] if file.lamps else []
    stated += [text for key, text in file.metadata.items() if key.upper().strip("_") == "CRI"]
    for text in stated:
        numbers = [float(number) for number in _RENDERING.findall(text)]
        numbers = [number for number in numbers if 20.0 <= number <= 100.0]
        if numbers:
            return numbers[0]
        if text.strip()[:2].upper() in _RENDERING_GROUPS:
            return _RENDERING_GROUPS[text.strip()[:2].upper()]
    for text in texts:
        if found := _RENDERING_NAMED.search(text):
            return float(found[1])
    return None


# ---- what is made of it ----


def _reference(start: str, temperature: float) -> LampSpectrum:
    if temperature < DAYLIGHT_FROM:
        return LampSpectrum(Blackbody(temperature), f"{start}: blackbody.")
    return LampSpectrum(Daylight(temperature), f"{start}: CIE daylight.")


def _from_series(rows, temperature, rendering) -> tuple[Spectrum, str]:
    """Illuminant of a series, or two neighbours mixed; and words for it."""
    fitting = [row for row in rows if rendering is not None and row[0] <= rendering]
    wanted = max(fitting, key=lambda row: row[0]) if fitting else rows[0]
    if rendering is not None and not fitting:
        wanted = min(rows, key=lambda row: row[0])
    # A row that reaches the colour is better than one that renders colours as stated.
    for _, members in (wanted, *rows):
        name = min(members, key=lambda key: abs(members[key] / temperature - 1.0))
        if abs(members[name] / temperature - 1.0) <= NEAR:
            return Illuminant(name), f"CIE {name}, {members[name]} K"
        cooler = [key for key in members if members[key] < temperature]
        hotter = [key for key in members if members[key] > temperature]
        if cooler and hotter:
            pair = (cooler[-1], hotter[0])
            share = mixing_share(*pair, temperature)
            told = f"CIE {pair[0]} and {pair[1]} mixed, {100 * (1 - share):.0f} and {100 * share:.0f} % of the flux"
            return _mixture(*pair, share), told
    members = wanted[1]
    name = min(members, key=lambda key: abs(members[key] / temperature - 1.0))
    return Illuminant(name), f"the nearest of its kind is CIE {name}, {members[name]} K"


@lru_cache
def mixing_share(first: str, second: str, temperature: float) -> float:
    """Share of the flux that the second of two illuminants gives to a mixture of a correlated colour temperature [K].

    The mixture lies on the isotherm: the line through the blackbody's point at right angles to the locus in the CIE 1960
    (u, v) diagram. The distance from it, times X + 15 Y + 3 Z, is linear in the tristimulus values, so the share is in
    closed form.
    """

    def tristimulus(power):
        value = power @ observer()
        return value / value[1]

    def point(kelvin):
        x, y, z = tristimulus(planck(GRID, kelvin))
        return np.array([4.0 * x, 6.0 * y]) / (x + 15.0 * y + 3.0 * z)

    along = point(temperature * 1.001) - point(temperature * 0.999)

    def side(name):
        x, y, z = tristimulus(evaluate_emission(Illuminant(name), GRID))
        numerator = np.array([4.0 * x, 6.0 * y])
        return (numerator - (x + 15.0 * y + 3.0 * z) * point(temperature)) @ along

    return float(np.clip(side(first) / (side(first) - side(second)), 0.0, 1.0))


def _mixture(first: str, second: str, share: float) -> Tabulated:
    """Two illuminants mixed so that the second gives a share of the flux."""
    values = np.zeros(len(GRID))
    for name, part in ((first, 1.0 - share), (second, share)):
        power = evaluate_emission(Illuminant(name), GRID)
        values += part * power / (power @ observer()[:, 1])
    return Tabulated(GRID, values / values.max(), name=f"{first} and {second}")


def _sodium_lines() -> Tabulated:
    """Both lines within the nanometre between two points of the wavelength grid, as wide as the grid can tell."""
    middle = round(sum(SODIUM_D) / 2.0)
    return Tabulated(
        np.array([middle - 1.0, middle, middle + 1.0]), np.array([0.0, 1.0, 0.0]), "Na D"
    )
