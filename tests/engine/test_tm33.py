"""TM-33 documents: angles, spectra, radiant and photon data, several emitters, and what is refused."""

import re
from pathlib import Path

import numpy as np
import pytest
from lumenray.engine.errors import FileFormatError
from lumenray.engine.luminaires.distribution import flux, intensity
from lumenray.engine.luminaires.formats.tm33.reader import parse_tm33, read_tm33
from lumenray.engine.reading import safe_xml
from lumenray.engine.reading.safe_xml import MAXIMUM_DEPTH, parse_xml
from lumenray.engine.scene.distribution import Opening

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "ies" / "tm33"

K_M = 683.002
"""[lm/W]"""


def data(rows, extra=""):
    """Elements of a table of (h, v, value)."""
    items = "\n".join(f'<IntData h="{h}" v="{v}">{value}</IntData>' for h, v, value in rows)
    return f"{extra}<NumberMeasured>{len(rows)}</NumberMeasured>\n{items}"


def luminous(rows, extra="<AbsolutePhotometry>true</AbsolutePhotometry>", tail=""):
    return f"<LuminousData><LuminousIntensity>{data(rows, extra)}</LuminousIntensity>{tail}</LuminousData>"


def emitter(*content):
    return (
        "<Emitter><Quantity>1</Quantity><Description>LED</Description>"
        + "\n".join(content)
        + "</Emitter>"
    )


AREA = (
    "<EmissionAreas><BottomFace><NumberBottom>1</NumberBottom><BottomArea><Length>1.15</Length>"
    "<Width>0.25</Width><LengthOffset>0</LengthOffset><WidthOffset>0</WidthOffset></BottomArea></BottomFace>"
    "</EmissionAreas>"
)


def document(*emitters, goniometer="IES_C", root="IESTM33", body=(1.2, 0.3, 0.06)):
    """A document, which departs from nothing if its emitters do not."""
    length, width, height = body
    equipment = (
        f"<Gonioradiometer><Type>{goniometer}</Type></Gonioradiometer>" if goniometer else ""
    )
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<{root} xmlns="http://example.org/any">
<Version>1.0</Version>
<Header><Manufacturer>A &amp; B</Manufacturer><CatalogNumber>L-1</CatalogNumber>
<Description>Lamp</Description><Laboratory>Lab</Laboratory><ReportNumber>R1</ReportNumber>
<ReportDate>2024-05-06</ReportDate><Comment>one</Comment><Comment>two</Comment></Header>
<Luminaire><Dimensions><Length>{length}</Length><Width>{width}</Width><Height>{height}</Height></Dimensions>
<NumEmitter>{len(emitters)}</NumEmitter></Luminaire>
<Equipment>{equipment}</Equipment>
{"".join(emitters)}
</{root}>""".encode()


def parsed(*emitters, **kinds):
    return parse_tm33(document(*emitters, **kinds), "a.xml")


def refused(*emitters, **kinds):
    with pytest.raises(FileFormatError) as caught:
        parsed(*emitters, **kinds)
    assert str(caught.value).startswith("a.xml, line ")
    return caught.value


def grid(planes, polars=(0, 45, 90)):
    """Rows of a table from the values at 45 (or the middle) of each plane; 300 below, 0 at the horizontal."""
    return [
        (h, v, value)
        for h, middle in planes.items()
        for v, value in zip(polars, (300, middle, 0), strict=True)
    ]


def at_45(file, *azimuths):
    c = np.deg2rad(azimuths)
    return intensity(file.distribution, np.stack([np.cos(c), np.sin(c), -np.ones_like(c)], axis=1))


UNIFORM = [(0, 0, 100), (0, 90, 100), (0, 180, 100)]
FLAT = [(400, 1.0), (500, 1.0), (600, 1.0), (700, 1.0)]


def spectral(pairs, extra=""):
    items = "".join(f'<PwrData w="{w}">{value}</PwrData>' for w, value in pairs)
    return (
        "<SpectralData><EmitterSpectral>"
        f"<NumberWavelength>{len(pairs)}</NumberWavelength>{extra}{items}</EmitterSpectral></SpectralData>"
    )


def test_a_plain_document_is_read_whole_without_remarks():
    content = (
        "<RatedLumens>1300</RatedLumens><InputWattage>12.5</InputWattage>",
        "<ColorTemperature><FixedCCT>4000</FixedCCT></ColorTemperature>",
        "<ColorRendering><CIE_CRI><Ra>92</Ra></CIE_CRI></ColorRendering>",
    )
    tail = "<LuminousFlux>1256.6</LuminousFlux>"
    file = parsed(emitter(*content, luminous(UNIFORM, tail=tail), AREA))
    assert not [r for r in file.remarks if "absolute" not in r.text]
    assert flux(file.distribution) == pytest.approx(400 * np.pi)
    assert (file.format, file.photometric_type, file.symmetry) == ("TM-33-18", "C", "rotational")
    assert (file.is_absolute, file.stated_flux, file.watts) == (True, 1256.6, 12.5)
    assert file.opening == Opening("rectangle", (0.25, 1.15, 0.0), "z")
    assert file.housing == (0.3, 1.2, 0.06)
    (lamp,) = file.lamps
    assert (lamp.count, lamp.luminous_flux, lamp.colour_temperature) == (1, 1300.0, 4000.0)
    assert (lamp.name, lamp.colour_rendering) == ("LED", "92")
    assert file.metadata == {
        "MANUFAC": "A & B",
        "LUMCAT": "L-1",
        "LUMINAIRE": "Lamp",
        "TESTLAB": "Lab",
        "TEST": "R1",
        "ISSUEDATE": "2024-05-06",
        "OTHER": "one\ntwo",
    }


EIGHT = [0, 45, 90, 135, 180, 225, 270, 315]


@pytest.mark.parametrize(
    ("planes", "symmetry", "expected"),
    [
        ({0: 77}, "rotational", [77] * 8),
        ({0: 10, 45: 20, 90: 30}, "quadrant", [10, 20, 30, 20, 10, 20, 30, 20]),
        ({0: 1, 45: 2, 90: 3, 135: 4, 180: 5}, "C0-C180", [1, 2, 3, 4, 5, 4, 3, 2]),
        ({90: 3, 135: 4, 180: 5, 225: 6, 270: 7}, "C90-C270", [5, 4, 3, 4, 5, 6, 7, 6]),
        ({-90: 7, -45: 6, 0: 5, 45: 4, 90: 3}, "C90-C270", [5, 4, 3, 4, 5, 6, 7, 6]),
        ({c: c / 45 + 1 for c in EIGHT}, "none", range(1, 9)),
        ({c: c % 360 / 45 + 1 for c in [*EIGHT, 360]}, "none", range(1, 9)),
    ],
)
def test_planes_stand_for_the_turn_that_their_angles_tell(planes, symmetry, expected):
    file = parsed(emitter(luminous(grid(planes))))
    assert np.allclose(at_45(file, *EIGHT), list(expected))
    assert file.symmetry == symmetry


@pytest.mark.parametrize(
    ("stated", "planes", "symmetry", "remarked"),
    [
        ("Symm _ Quad", {0: 10, 45: 20, 90: 30}, "quadrant", False),
        ("Bi_90", {90: 3, 180: 5, 270: 7}, "C90-C270", False),
        ("Symm_Full", {0: 5}, "rotational", False),
        ("Symm _ Bi _ 0", {0: 10, 90: 20, 180: 10, 270: 20, 360: 10}, "C0-C180", True),
        ("Symm_Quad", {0: 10, 90: 20, 180: 11, 270: 20, 360: 10}, "none", True),
        ("Symm_None", {0: 5}, "rotational", True),
        ("Oblique", {0: 10, 90: 30}, "quadrant", True),
    ],
)
def test_the_stated_symmetry_is_compared_with_the_angles(stated, planes, symmetry, remarked):
    extra = f"<AbsolutePhotometry>true</AbsolutePhotometry><Symm>{stated}</Symm>"
    file = parsed(emitter(luminous(grid(planes), extra), AREA), root="IESTM33-22")
    assert file.format == "TM-33-23"
    assert file.symmetry == symmetry
    assert bool(file.remarks) == remarked


def test_intensities_come_in_any_order_and_are_multiplied():
    rows = grid({0: 10, 45: 20, 90: 30})
    shuffled = [rows[i] for i in np.random.default_rng(1).permutation(len(rows))]
    extra = "<AbsolutePhotometry>true</AbsolutePhotometry><Multiplier>2.5</Multiplier>"
    file = parsed(emitter(luminous(shuffled, extra)))
    assert np.allclose(at_45(file, 0, 45, 90), [25, 50, 75])


def test_type_b_turns_about_the_horizontal_axis():
    rows = [(h, v, 5000 if (h, v) == (0, 0) else 0) for h in (-90, 0, 90) for v in (-90, 0, 90)]
    rows = [(h, v, 800 if (h, v) == (0, 90) else value) for h, v, value in rows]
    file = parsed(emitter(luminous(rows)), goniometer="IES_B")
    # The beam is -z; V counts up, which is +y.
    assert np.allclose(
        intensity(file.distribution, [[0, 0, -1], [0, 1, 0], [0, -1, 0]]), [5000, 800, 0]
    )
    assert file.stored_polars.tolist() == [-90, 0, 90]


def test_type_a_has_its_pole_above_and_mirrors_what_begins_at_0():
    rows = [(h, v, 5000 - 10 * h + v) for h in (0, 45, 90) for v in (-90, 0, 90)]
    rows = [(h, v, 4000 + v if v else value) for h, v, value in rows]
    file = parsed(emitter(luminous(rows)), goniometer="IES_A")
    found = intensity(file.distribution, [[0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])
    assert np.allclose(found, [5000, 4100, 4100, 4090, 3910])
    assert file.symmetry == "C90-C270"


@pytest.mark.parametrize("kind", ["CIE _ C", "IES_C", "Type C"])
def test_names_of_type_c_are_known(kind):
    assert parsed(emitter(luminous(UNIFORM)), goniometer=kind).photometric_type == "C"


def test_a_missing_goniometer_is_type_c_with_a_remark():
    assert "taken as type C" in str(parsed(emitter(luminous(UNIFORM)), goniometer="").remarks)


def test_relative_photometry_refers_to_the_rated_lumens():
    extra = "<AbsolutePhotometry>false</AbsolutePhotometry>"
    file = parsed(emitter("<RatedLumens>2000</RatedLumens>", luminous(UNIFORM, extra), AREA))
    assert (file.is_absolute, file.stated_flux) == (False, 2000.0)
    assert not file.remarks
    wrong = parsed(emitter("<RatedLumens>1000</RatedLumens>", luminous(UNIFORM, extra)))
    assert "give 1257 lm, but 1000 lm are stated" in str(wrong.remarks)


# ---- spectra ----


FINE = [(nm, 1.0 if 400 < nm < 760 else 0.0) for nm in range(380, 785, 5)]


@pytest.mark.parametrize(
    ("pairs", "words"),
    [
        (FINE, None),
        ([p for p in FINE if not 500 < p[0] < 620], "has no value between 500 and 620 nm"),
        ([p for p in FINE if p[0] > 450], "begins at 455 nm with 100% of its largest value"),
        # An ultraviolet lamp, whose file would be refused as a spectrum's of its own.
        ([(nm, 1.0) for nm in range(200, 395, 5)], "ends at 390 nm with 100%"),
        ([*FINE[:9], FINE[10], FINE[9], *FINE[11:]], "stands beside"),
    ],
)
def test_a_spectrum_that_is_odd_is_told_and_used(pairs, words):
    file = parsed(emitter(luminous(UNIFORM), spectral(pairs)))
    assert file.spectrum[0].tolist() == sorted(nm for nm, _ in pairs)
    told = [r.text for r in file.remarks if r.text.startswith("the spectrum")]
    assert len(told) == (words is not None)
    assert words is None or words in told[0]


def test_lists_of_a_spectrum_are_checked_for_gaps_too():
    nm = [nm for nm, _ in FINE if not 500 < nm < 620]
    lists = (
        f"<SpectralDistribution><Wavelengths>{' '.join(map(str, nm))}</Wavelengths>"
        f"<Values>{' '.join('1' for _ in nm)}</Values></SpectralDistribution>"
    )
    file = parsed(emitter(luminous(UNIFORM), lists))
    assert any("no value between 500 and 620 nm" in remark.text for remark in file.remarks)


def test_the_spectrum_is_sorted_and_kept():
    file = parsed(emitter(luminous(UNIFORM), spectral([(600, 3), (400, 1), (500, 2)])))
    assert file.spectrum[0].tolist() == [400, 500, 600]
    assert file.spectrum[1].tolist() == [1, 2, 3]


def radiant(rows, low=380, high=780):
    return (
        f"<RadiantData><MinWavelength>{low}</MinWavelength><MaxWavelength>{high}</MaxWavelength>"
        f"<RadiantIntensity>{data(rows)}</RadiantIntensity></RadiantData>"
    )


def photon(rows, low=400, high=700):
    return radiant(rows, low, high).replace("Radiant", "Photon")


BAND = [(550, 0), (550.001, 1), (560, 1), (560.001, 0)]
"""A narrow band at the maximum of V(lambda), whose mean there is 0.9983 (CIE 18.2)."""


def test_watts_at_the_maximum_of_v_lambda_are_683_lumens_each():
    file = parsed(emitter(radiant([(h, v, 2) for h, v, _ in UNIFORM]), spectral(BAND)))
    assert flux(file.distribution) == pytest.approx(8 * np.pi * 0.9983 * K_M, rel=1e-4)
    assert any("radiant intensities, made candela" in r.text for r in file.remarks)


def test_photons_of_a_narrow_band_have_the_energy_of_their_wavelength():
    file = parsed(emitter(photon([(h, v, 1) for h, v, _ in UNIFORM]), spectral(BAND)))
    # One micromole of photons of 555 nm carries h c N_A / 555 nm = 0.21554 J.
    assert at_45(file, 0) == pytest.approx(0.21554 * 0.9983 * K_M, rel=1e-3)


def test_watts_count_only_between_the_stated_wavelengths():
    spectrum = spectral([(300, 1), (800, 1)])
    whole = parsed(emitter(radiant(UNIFORM, 300, 800), spectrum))
    half = parsed(emitter(radiant(UNIFORM, 300, 550), spectrum))
    assert flux(half.distribution) == pytest.approx(2 * flux(whole.distribution))
    # The integral of V(lambda) is 106.857 nm (CIE 18.2), of which 0.02 lie beyond 800 nm and below 380 nm.
    assert flux(whole.distribution) == pytest.approx(400 * np.pi * K_M * 106.85 / 500, rel=1e-3)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (radiant(UNIFORM), "radiant intensities without a spectrum"),
        (photon(UNIFORM), "photon intensities without a spectrum"),
        (radiant(UNIFORM) + spectral([(900, 1), (1000, 1)]), "no visible light"),
        (radiant(UNIFORM, 800, 900) + spectral(FLAT), "no power between"),
    ],
)
def test_watts_and_photons_without_a_fitting_spectrum_are_refused(content, words):
    assert words in str(refused(emitter(content)))


def test_luminous_data_are_taken_before_radiant_ones():
    file = parsed(emitter(radiant(UNIFORM), luminous(UNIFORM), spectral(FLAT)))
    assert flux(file.distribution) == pytest.approx(400 * np.pi)


def test_a_spectrum_by_angle_is_averaged_over_the_sphere():
    items = "".join(
        f'<IntData h="0" v="{v}" w="{w}">{value}</IntData>'
        for v, w, value in [
            *((v, 500, 1.0) for v in (0, 60, 60.0001, 180)),
            *((v, 600, value) for v, value in ((0, 8.0), (60, 8.0), (60.0001, 0.0), (180, 0.0))),
        ]
    )
    content = f"<SpectralData><AngularSpectral>{items}</AngularSpectral></SpectralData>"
    file = parsed(emitter(luminous(UNIFORM), content))
    # A cone of 60 degrees is a quarter of the sphere.
    assert file.spectrum[1][1] / file.spectrum[1][0] == pytest.approx(2.0, rel=1e-4)
    assert any("mean over all directions" in r.text for r in file.remarks)


# ---- several emitters ----


def test_emitters_with_equal_angles_are_added():
    double = [(h, v, 2 * value) for h, v, value in UNIFORM]
    file = parsed(
        emitter(
            "<InputWattage>5</InputWattage>", luminous(UNIFORM), spectral([(500, 1), (600, 0)])
        ),
        emitter("<InputWattage>6</InputWattage>", luminous(double), spectral([(500, 0), (600, 1)])),
    )
    assert flux(file.distribution) == pytest.approx(1200 * np.pi)
    assert (file.watts, len(file.lamps)) == (11.0, 2)
    assert any("intensities of 2 emitters are added" in r.text for r in file.remarks)
    assert file.spectrum[0].tolist() == [500, 600]


def test_an_emitter_without_intensities_adds_nothing():
    file = parsed(emitter(luminous(UNIFORM)), emitter("<InputWattage>1</InputWattage>"))
    assert flux(file.distribution) == pytest.approx(400 * np.pi)


def test_emitters_with_different_angles_are_refused():
    other = [(0, v, 100) for v in (0, 45, 90)]
    error = refused(emitter(luminous(UNIFORM)), emitter(luminous(other)))
    assert "different angles" in str(error)


# ---- body ----


def face(name, *sides, round_=False):
    names = {"Top": ("Length", "Width"), "Bottom": ("Length", "Width")}
    names |= {"C0": ("Length", "Height"), "C90": ("Width", "Height")}
    items = "".join(f"<{n}>{s}</{n}>" for n, s in zip(names[name], sides, strict=True))
    items += f"<Circular>{str(round_).lower()}</Circular>"
    return f"<{name}Face><{name}Area>{items}</{name}Area></{name}Face>"


@pytest.mark.parametrize(
    ("faces", "opening"),
    [
        (face("Bottom", 0.2, 0.2, round_=True), Opening("ellipse", (0.2, 0.2, 0.0), "z")),
        (face("Bottom", 1.0, 0.2) + face("Top", 1.1, 0.1), Opening("box", (0.2, 1.1, 0.06), "z")),
        (face("C0", 1.0, 0.05), Opening("rectangle", (0.0, 1.0, 0.05), "x")),
        (face("C90", 0.2, 0.05), Opening("rectangle", (0.2, 0.0, 0.05), "y")),
        (face("Bottom", 1.0, 0.2) + face("C0", 1.0, 0.05), Opening("box", (0.2, 1.0, 0.05), "z")),
        ("", Opening()),
    ],
)
def test_emission_areas_become_one_body(faces, opening):
    file = parsed(emitter(luminous(UNIFORM), f"<EmissionAreas>{faces}</EmissionAreas>"))
    assert file.opening.shape == opening.shape
    assert file.opening.axis == opening.axis
    assert file.opening.size == pytest.approx(opening.size)


def test_bodies_in_millimetres_are_recognised():
    file = parsed(emitter(luminous(UNIFORM)), body=(1200, 300, 60))
    assert file.housing == pytest.approx((0.3, 1.2, 0.06))
    assert "mm instead of m" in str(file.remarks)
    assert parsed(emitter(luminous(UNIFORM)), body=(12, 0.1, 0.1)).housing == (0.1, 12.0, 0.1)


# ---- refused ----

ROWS = grid({0: 10, 45: 20, 90: 30})


def with_row(at, row):
    return [row if i == at else r for i, r in enumerate(ROWS)]


REFUSED = {
    "a value too few": (
        luminous(ROWS[:-1]),
        0,
        "1 of 9 intensities are missing, the first at h=90, v=90",
    ),
    "a plane too few": (
        luminous(ROWS, "<NumberHorz>4</NumberHorz>"),
        0,
        "NumberHorz says 4, but there are 3 angles h",
    ),
    "a wrong count": (
        luminous(ROWS).replace("<NumberMeasured>9", "<NumberMeasured>12"),
        0,
        "NumberMeasured says 12, but there are 9",
    ),
    "two values": (luminous([*ROWS, (45, 45, 21)]), 10, "two different intensities at h=45, v=45"),
    "negative": (luminous(with_row(4, (45, 45, -2))), 5, "a negative intensity (-2) at h=45, v=45"),
    "NaN": (
        luminous(with_row(4, (45, 45, "NaN"))),
        5,
        "expected an intensity, a number, found 'NaN'",
    ),
    "infinite": (luminous(with_row(4, (45, 45, "INF"))), 5, "found 'INF'"),
    "no number": (luminous(with_row(4, (45, "x", 1))), 5, "expected a number as v of IntData"),
    "an angle too far": (luminous(with_row(4, (45, 200, 1))), 0, "are missing"),
    "all dark": (luminous([(0, 0, 0), (0, 90, 0)]), 0, "all intensities are 0"),
    "no data": (luminous([]), 0, "holds no IntData"),
    "nothing": ("", 0, "holds no luminous, radiant or photon intensities"),
    "too bright": (luminous([(0, 0, 1e15), (0, 90, 0)]), 0, "largest intensity of 1e+15 cd"),
    "much too bright": (
        luminous([(0, 0, "1e300"), (0, 90, 0)], "<Multiplier>1e11</Multiplier>"),
        0,
        "too large",
    ),
    "multiplier of 0": (luminous(UNIFORM, "<Multiplier>0</Multiplier>"), 0, "0 as Multiplier"),
    "a third": (luminous(grid({0: 1, 60: 2, 120: 3})), 0, "angles h go from 0 to 120"),
    "too little for Symm": (
        luminous(ROWS, "<Symm>Symm_None</Symm>"),
        0,
        "not enough for the stated symmetry (none)",
    ),
    "one polar angle": (luminous([(0, 0, 1)]), 0, "a single angle v"),
    "a short spectrum": (luminous(UNIFORM) + spectral([(500, 1)]), 3, "a spectrum of 1 values"),
    "a doubled wavelength": (
        luminous(UNIFORM) + spectral([(500, 1), (500, 1)]),
        3,
        "two spectral powers at 500 nm",
    ),
    "a negative power": (
        luminous(UNIFORM) + spectral([(500, 1), (600, -1)]),
        3,
        "a negative spectral power",
    ),
    "a digit too many": (
        luminous(UNIFORM) + spectral([*FINE[:40], (5850, 1.0)]),
        3,
        "the spectrum: wavelength 5850 nm, while the others lie 5 nm apart",
    ),
    "micrometres": (luminous(UNIFORM) + spectral([(0.5, 1), (0.6, 1)]), 3, "expected nanometres"),
    "a wrong number of powers": (
        luminous(UNIFORM) + spectral(FLAT).replace("<NumberWavelength>4", "<NumberWavelength>5"),
        3,
        "NumberWavelength says 5",
    ),
}
"""Content, lines that the place lies behind the emitter's first, words."""


@pytest.mark.parametrize("what", REFUSED)
def test_what_cannot_be_read_safely_is_refused_with_its_line(what):
    content, behind, words = REFUSED[what]
    error = refused(emitter(content))
    assert words in str(error)
    first = document(emitter("")).decode().split("<Emitter>")[0].count("\n") + 1
    assert error.line == first + behind


@pytest.mark.parametrize("kind", ["CIE_A", "CIE _ B", "CUSTOM"])
def test_goniometers_whose_axes_are_not_settled_are_refused(kind):
    error = refused(emitter(luminous(UNIFORM)), goniometer=kind)
    assert "convert the file" in str(error)
    assert error.line == 9


def test_another_root_is_refused_by_name():
    with pytest.raises(FileFormatError, match="root element svg, expected IESTM33"):
        parse_tm33(b"<svg/>", "a.xml")


# ---- XML ----


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (b"", 1, "not well-formed XML"),
        (b"<a>\n<b></a>", 2, "mismatched tag"),
        (b"<a>\n&nbsp;</a>", 2, "undefined entity"),
        (b'<!DOCTYPE a [\n<!ENTITY b "c">]><a>&b;</a>', 1, "DOCTYPE"),
        (b'<?xml version="1.0"?>\n<!DOCTYPE a SYSTEM "file:///etc/passwd"><a/>', 2, "DOCTYPE"),
        (b"<a>" * (MAXIMUM_DEPTH + 1), 1, "nested deeper"),
        (b"<a>" + b"<b/>\n" * 1000, 1000, "more than 1000 XML elements"),
        (b"<a " + b" ".join(b'b%d=""' % i for i in range(99)) + b"/>", 1, "attributes"),
        (b'<?xml version="1.0" encoding="klingon"?><a/>', 1, "unknown encoding"),
    ],
)
def test_hostile_and_broken_xml_is_refused_with_its_line(text, line, words, monkeypatch):
    monkeypatch.setattr(safe_xml, "MAXIMUM_ELEMENTS", 1000)
    with pytest.raises(FileFormatError, match=re.escape(words)) as caught:
        parse_xml(text, "a.xml")
    assert caught.value.line == line


def test_elements_know_their_lines_texts_and_attributes_without_namespaces():
    text = '<x:a xmlns:x="u" xmlns="v">\n one<!-- no -->two\n<b x:c="d">é</b>tail</x:a>'
    for encoding in ("utf-8", "utf-16"):
        root = parse_xml(text.encode(encoding), "a.xml")
        (child,) = root
        assert (root.tag, root.line, root.text.split()) == ("a", 1, ["onetwo"])
        assert (child.tag, child.line, child.get("c"), child.text) == ("b", 3, "d", "é")
        assert child.tail == "tail"


# ---- real files ----


@pytest.mark.parametrize("path", sorted(DATA.glob("*.xml")), ids=lambda path: path.stem)
def test_real_files_are_read_with_remarks_on_what_the_schema_does_not_know(path):
    file = read_tm33(path)
    assert flux(file.distribution) > 0.0
    assert any("schema does not know" in r.text and r.line for r in file.remarks)
    assert any("look like candela per 1000 lm" in r.text for r in file.remarks)
