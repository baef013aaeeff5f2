"""The spectrum of a luminaire by what its file says of the lamp."""

import numpy as np
import pytest

from lumenray.engine.luminaires.formats.record import LampSet, LuminaireFile
from lumenray.engine.luminaires.lamp_spectrum import NEAR, SERIES, USUAL, choose_spectrum
from lumenray.engine.photometry.spectra import GRID, evaluate_emission, luminous_weight
from lumenray.engine.scene.distribution import IntensityDistribution, Opening
from lumenray.engine.scene.spectrum import Blackbody, Daylight, Illuminant, Tabulated


def file_of(lamp=None, metadata=None, spectrum=None):
    globe = IntensityDistribution(np.zeros(1), np.array([0.0, np.pi]), np.ones((1, 2)))
    return LuminaireFile(
        "made here",
        "C",
        "rotational",
        globe,
        Opening(),
        np.zeros(1),
        np.array([0.0, 180.0]),
        True,
        lamps=(lamp,) if lamp else (),
        metadata=metadata or {},
        spectrum=spectrum,
    )


def chosen(name="", colour="", rendering="", temperature=None, **metadata):
    lamp = LampSet(
        name=name, colour=colour, colour_rendering=rendering, colour_temperature=temperature
    )
    return choose_spectrum(file_of(lamp, metadata))


@pytest.mark.parametrize(
    ("name", "colour", "rendering", "illuminant"),
    [
        ("LED 25W", "3000K", "1B/80", "LED-B2"),
        ("LED60/740", "740", "", "LED-B3"),
        ("24 LEDs", "tw/6500", "80", "LED-B5"),
        ("LED-Modul", "2700", "1A", "LED-V1"),
        ("COB", "5000", "95", "LED-B4"),
        ("T16 28W/830", "", "", "FL12"),
        ("FP54T5HO/841", "", "", "FL11"),
        ("T 26 58W", "4000", "1A/95", "FL3.13"),
        ("TL-D 36W/765", "", "", "FL1"),
        ("Leuchtstofflampe", "tw/6500", "1B/86", "FL7"),
        ("HIT-DE 250W", "nw/4000", "1B/86", "HP4"),
        ("HALOGEN-METALLDAMPFLAMPE", "ww/3000", "", "HP3"),
        ("SON-TPP250W", "2000K", "25", "HP1"),
        ("HST-CRI 70W", "2500", "", "HP2"),
        ("60W A19 INCANDESCENT", "", "", "A"),
    ],
)
def test_lamps_are_known_by_the_names_in_use(name, colour, rendering, illuminant):
    made = chosen(name, colour, rendering)
    assert made.spectrum == Illuminant(illuminant)
    assert illuminant in made.reason
    assert name.split()[0] in made.reason


def test_the_colour_temperature_of_the_record_comes_first():
    assert chosen("LED 830", "3000", temperature=5000.0).spectrum == Illuminant("LED-B4")


def test_keywords_of_a_file_tell_lamp_and_colour():
    made = choose_spectrum(
        file_of(metadata={"LAMP": "THREE LIGHT EMITTING DIODES", "_CCT": "6500"})
    )
    assert made.spectrum == Illuminant("LED-B5")
    made = choose_spectrum(file_of(metadata={"LUMINAIRE": "Downlight LED 4000K", "LAMP": "49"}))
    assert made.spectrum == Illuminant("LED-B3")


def test_glowing_lamps_are_blackbodies_of_their_colour():
    assert chosen("QT12-ax 50W", "", "", 3100.0).spectrum == Blackbody(3100.0)
    assert chosen("Halogen 50W").spectrum == Blackbody(3000.0)
    assert "3000 K assumed" in chosen("Halogen 50W").reason


def test_what_is_assumed_is_said():
    assert "4000 K assumed" in chosen("LED").reason
    assert "assumed" not in chosen("LED", "4000 K").reason
    assert "nearest" in chosen("HIT 70W", "6000").reason


def test_an_unknown_lamp_is_neutral_and_says_so():
    made = chosen(
        "Generic", metadata_lumens="930 lm", MANUFAC="Acme Lighting, Inc.", TEST="T0817840"
    )
    assert made.spectrum == Illuminant("D65")
    assert "neither" in made.reason


def test_a_colour_alone_gives_the_reference_illuminant():
    assert chosen("49", "3500").spectrum == Blackbody(3500.0)
    assert chosen("49", "5700").spectrum == Daylight(5700.0)


@pytest.mark.parametrize("text", ["940 lm,14 W", "650W", "830 mA", "1840", "LUMENS 8400"])
def test_amounts_are_no_colour_codes(text):
    assert chosen(f"LED {text}").spectrum == chosen("LED").spectrum
    assert "assumed" in chosen(f"LED {text}").reason


def test_the_spectrum_in_the_file_comes_before_all():
    nm, values = np.array([400.0, 555.0, 700.0]), np.array([0.0, 1.0, 0.0])
    made = choose_spectrum(file_of(LampSet(name="LED 840"), spectrum=(nm, values)))
    assert made.spectrum.wavelengths is nm
    assert made.spectrum.values is values
    assert "400 to 700 nm" in made.reason


def test_low_pressure_sodium_is_its_two_lines():
    made = chosen("SOX 90W")
    power = evaluate_emission(made.spectrum, GRID)
    assert (power @ GRID) / power.sum() == pytest.approx(589.3, abs=0.5)
    assert luminous_weight(made.spectrum) > 0.0


def test_lamps_without_an_illuminant_say_so():
    assert chosen("HQL 125W").spectrum == Illuminant("D65")
    assert "no CIE illuminant" in chosen("HQL 125W").reason
    assert chosen("HQL 125W", "4200").spectrum == Blackbody(4200.0)
    assert "hardly any visible light" in chosen("Excimer lamp").reason


# ---- against an independent program ----


def distribution_of(spectrum):
    colour = pytest.importorskip("colour")
    nm = np.arange(380.0, 781.0, 1.0)
    return colour.SpectralDistribution(dict(zip(nm, evaluate_emission(spectrum, nm), strict=True)))


def colour_temperature(spectrum):
    colour = pytest.importorskip("colour")
    tristimulus = colour.sd_to_XYZ(distribution_of(spectrum))
    uv = colour.xy_to_UCS_uv(colour.XYZ_to_xy(tristimulus))
    return colour.uv_to_CCT(uv, method="Ohno 2013")[0]


@pytest.mark.parametrize(
    ("name", "rendering", "temperature"),
    [
        ("LED", "80", 3500.0),
        ("LED", "80", 5700.0),
        ("LED", "95", 3300.0),
        ("T8", "80", 3500.0),
        ("T8", "80", 5600.0),
        ("T8", "95", 5800.0),
        ("T8", "60", 3700.0),
        ("HIT", "80", 3600.0),
        ("NAV", "20", 2200.0),
    ],
)
def test_mixtures_have_the_stated_colour_temperature(name, rendering, temperature):
    made = chosen(name, "", rendering, temperature)
    assert isinstance(made.spectrum, Tabulated)
    assert "mixed" in made.reason
    assert colour_temperature(made.spectrum) == pytest.approx(temperature, rel=5e-4)


@pytest.mark.parametrize("kind", SERIES)
def test_the_series_have_their_colour_temperatures(kind):
    for _, members in SERIES[kind]:
        assert list(members.values()) == sorted(members.values())
        for name, temperature in members.items():
            assert colour_temperature(Illuminant(name)) == pytest.approx(temperature, rel=2e-3), (
                name
            )
    nearest = [abs(t / USUAL[kind] - 1.0) for t in SERIES[kind][0][1].values()]
    assert min(nearest) <= NEAR


@pytest.mark.parametrize("kind", ["LED", "fluorescent lamp", "metal halide lamp"])
def test_the_series_render_colours_as_their_row_says(kind):
    colour = pytest.importorskip("colour")
    for rendering, members in SERIES[kind]:
        for name in members:
            found = colour.colour_rendering_index(distribution_of(Illuminant(name)))
            assert found > rendering - 5.0, name
