"""TM-33 documents as they are read: angles, symmetries, several emitters and bodies."""

import numpy as np
import pytest
from folders import WILD
from tm33_files import UNIFORM, at_45, emitter, grid, luminous, parsed, refused, spectral

from lumenray.engine.luminaires.distribution import flux, intensity
from lumenray.engine.luminaires.formats.reader import read_luminaire
from lumenray.engine.scene.distribution import Opening

DATA = WILD / "ies" / "tm33"

AREA = (
    "<EmissionAreas><BottomFace><NumberBottom>1</NumberBottom><BottomArea><Length>1.15</Length>"
    "<Width>0.25</Width><LengthOffset>0</LengthOffset><WidthOffset>0</WidthOffset></BottomArea></BottomFace>"
    "</EmissionAreas>"
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


@pytest.mark.parametrize("path", sorted(DATA.glob("*.xml")), ids=lambda path: path.stem)
def test_real_files_are_read_with_remarks_on_what_the_schema_does_not_know(path):
    file = read_luminaire(path)
    assert flux(file.distribution) > 0.0
    assert any("schema does not know" in r.text and r.line for r in file.remarks)
    assert any("look like candela per 1000 lm" in r.text for r in file.remarks)
