"""Panes known by a table, and the goniometer: against the table itself, Fresnel's formulas and energy."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Output, PointLight, Quantity, UniformWorld
from lumenray.engine.scene.material import (
    Black,
    Cauchy,
    Coated,
    Dielectric,
    Diffuse,
    Glossy,
    Material,
    Mix,
    TabulatedPane,
    ThinGlass,
)
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Constant, Tabulated
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.session import Session
from lumenray.engine.views import Display, LiveSettings
from lumenray.engine.worker.codec import decode, encode

pytestmark = pytest.mark.mitsuba

SHEET = TabulatedPane(
    np.array([0.0, 20.0, 50.0, 60.0, 75.0, 90.0]),
    np.array([0.80, 0.78, 0.70, 0.55, 0.30, 0.0]),
    np.array([0.08, 0.08, 0.12, 0.22, 0.55, 1.0]),
)
"""A data sheet with kinks."""

ANGLES = np.array([0.0, 7.0, 20.0, 33.0, 55.0, 60.0, 71.0, 82.0, 88.0])

INTENSITY = Output(Quantity.LUMINOUS_INTENSITY, 1000.0)


def fresnel(degrees, index):
    """Reflectances of both polarisations from outside and the cosine inside; beyond the critical angle 1."""
    cosine = np.cos(np.radians(degrees))
    inside = np.sqrt(1.0 - (1.0 - cosine**2) / index**2 + 0j)
    s = np.abs((cosine - index * inside) / (cosine + index * inside)) ** 2
    p = np.abs((index * cosine - inside) / (index * cosine + inside)) ** 2
    return s, p, inside.real


def slab(degrees, index, internal):
    """Reflectance and transmittance of a plane-parallel slab, by the sum over all its inner reflections."""
    s, p, inside = fresnel(degrees, index)
    body = internal ** (1.0 / inside)
    reflected = transmitted = 0.0
    for r in (s, p):
        passing = (1.0 - r) * body
        for _ in range(200):
            transmitted = transmitted + 0.5 * passing * (1.0 - r)
            passing = passing * r * body
            reflected = reflected + 0.5 * passing * (1.0 - r)
            passing = passing * r * body
        reflected = reflected + 0.5 * r
    return reflected, transmitted


def hemispherical(share):
    """Value for even light: integral of share(degrees) 2 sin cos over a quarter turn."""
    edges = np.linspace(0.0, np.pi / 2, 20001)
    theta = 0.5 * (edges[1:] + edges[:-1])
    return float((share(np.degrees(theta)) * np.sin(2.0 * theta)).sum() * edges[1])


def from_table(values):
    return lambda degrees: np.interp(degrees, SHEET.angles, values)


# ---- tables ----


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("side", [1.0, -1.0], ids=["front", "back"])
@pytest.mark.parametrize("angle", [0.0, 12.0, 50.0, 57.0, 80.0])
def test_a_lamp_behind_a_tabulated_pane_shines_as_the_table_says(transport, angle, side):
    tilt = np.radians(angle)
    towards = side * np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    items = [
        Material("sheet", "sheet", SHEET),
        quad("pane", (-100, -100, 0), (200, 0, 0), (0, 200, 0), "sheet"),
        PointLight("lamp", "lamp", INTENSITY, 3.0 * towards),
    ]
    made = session_of(*items).measure(
        [-2.0 * towards], [towards], StopRule(samples=64), transport=transport
    )
    expected = 1000.0 / 25.0 * np.interp(angle, SHEET.angles, SHEET.transmittance)
    assert made.illuminance[0] == pytest.approx(expected, rel=2e-5)


@pytest.mark.parametrize(
    ("screen", "values"),
    [(-0.2, SHEET.transmittance), (0.2, SHEET.reflectance)],
    ids=["sky through the pane", "sky in the pane"],
)
def test_a_sky_is_seen_through_and_in_a_tabulated_pane(screen, values):
    # A black screen takes one half of the sky away, below the sensor or above the pane.
    items = [
        Material("sheet", "sheet", SHEET),
        Material("black", "black", Black()),
        quad("pane", (-300, -300, 0.1), (600, 0, 0), (0, 600, 0), "sheet"),
        quad("screen", (-600, -600, screen), (1200, 0, 0), (0, 1200, 0), "black"),
        UniformWorld(100.0),
    ]
    made = session_of(*items).measure([[0, 0, 0]], [[0, 0, 1]], StopRule(samples=1 << 17))
    expected = np.pi * 100.0 * hemispherical(from_table(values))
    assert made.standard_error[0] < 0.005 * expected
    assert abs(made.illuminance[0] - expected) < 3.5 * made.standard_error[0] + 1e-3 * expected


def test_a_table_holds_its_end_values_and_may_have_one_row():
    ends = TabulatedPane(np.array([30.0, 40.0]), np.array([0.6, 0.4]), np.array([0.1, 0.3]))
    made = Session(witness=False).probe(ends, [5.0, 35.0, 70.0, 150.0])
    np.testing.assert_allclose(made.transmittance, [0.6, 0.5, 0.4, 0.6], atol=3e-4)
    np.testing.assert_allclose(made.reflectance, [0.1, 0.2, 0.3, 0.1], atol=3e-4)
    single = TabulatedPane(np.array([0.0]), np.array([0.5]), np.array([0.25]))
    made = Session(witness=False).probe(single, [0.0, 89.0])
    np.testing.assert_allclose(made.transmittance, 0.5, atol=3e-4)
    np.testing.assert_allclose(made.reflectance, 0.25, atol=3e-4)


def test_a_probe_reads_the_table():
    made = Session(witness=False).probe(SHEET, ANGLES)
    assert (made.transmittance_error < 2e-4).all()
    for found, values in (
        (made.transmittance, SHEET.transmittance),
        (made.reflectance, SHEET.reflectance),
    ):
        np.testing.assert_allclose(found, from_table(values)(ANGLES), atol=4e-4)


def test_tables_of_any_values_and_length_meet_known_kernels():
    import drjit as dr

    frame = np.eye(4)
    frame[2, 3] = 3.0
    session = session_of(
        UniformWorld(100.0),
        quad("pane", (-5, -5, 1), (10, 0, 0), (0, 10, 0), "sheet"),
        quad("floor", (-5, -5, 0), (10, 0, 0), (0, 10, 0), "paint"),
        Material("sheet", "sheet", SHEET),
        Material("paint", "paint", Diffuse(Constant(0.5))),
    )
    session.watch(
        Camera(frame, Projection.PERSPECTIVE, 48, 36, 1.2, 0.9), LiveSettings(), Display()
    )
    counts = []
    dr.set_flag(dr.JitFlag.KernelHistory, True)
    try:
        for k, length in enumerate((6, 11, 2, 90, 901)):
            dr.kernel_history_clear()
            angles = np.linspace(0.0, 90.0, length)
            share = np.cos(np.radians(angles)) * 0.5
            table = TabulatedPane(angles, share, 0.9 - share)
            session.apply(SceneDelta(changed=(Material("sheet", "sheet", table),)))
            for _ in range(3):
                session.refine()
            kernels = [e for e in dr.kernel_history() if e["type"] == dr.KernelType.JIT]
            counts.append(len(kernels))
            if k >= 2:
                assert all(entry["cache_hit"] for entry in kernels)
    finally:
        dr.set_flag(dr.JitFlag.KernelHistory, False)
    assert counts[-1] > 0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"angles": np.array([0.0, 50.0])}, "as many angles"),
        ({"angles": np.array([0.0, 60.0, 60.0])}, "ascend"),
        ({"angles": np.array([-5.0, 60.0, 90.0])}, "0 to 90"),
        ({"angles": np.array([0.0, 60.0, 91.0])}, "0 to 90"),
        ({"angles": np.array([0.0, np.nan, 90.0])}, "angle that is not a finite number"),
        ({"transmittance": np.array([0.8, np.inf, 0.0])}, "transmittance that is not a finite"),
        ({"transmittance": np.array([0.8, -0.1, 0.0])}, "transmittance is -0.1"),
        ({"reflectance": np.array([0.1, 1.2, 0.0])}, "reflectance is 1.2"),
        ({"reflectance": np.array([0.1, 0.5, 0.2])}, "1.1 of the light at 60 degrees"),
        (dict.fromkeys(("angles", "transmittance", "reflectance"), np.zeros(0)), "one at least"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_table_that_makes_no_sense_is_refused_with_the_material_s_name(changes, words):
    good = TabulatedPane(
        np.array([0.0, 60.0, 90.0]), np.array([0.8, 0.6, 0.0]), np.array([0.1, 0.2, 0.2])
    )
    session = session_of(
        Material("sheet", "Front glass", replace(good, **changes)),
        quad("pane", (0, 0, 0), (1, 0, 0), (0, 1, 0), "sheet"),
        UniformWorld(1.0),
    )
    with pytest.raises(SceneError, match=words) as caught:
        session.measure([[0, 0, -1]], [[0, 0, 1]], StopRule(samples=16))
    assert "material 'Front glass'" in str(caught.value)
    # The session goes on once it is put right.
    session.apply(SceneDelta(changed=(Material("sheet", "Front glass", good),)))
    assert session.measure([[0, 0, -1]], [[0, 0, 1]], StopRule(samples=16)).illuminance[0] > 0.0


def test_a_table_travels_to_the_worker():
    tree, parts, size = encode(SHEET)
    block = np.zeros(size, np.uint8)
    for offset, array in parts:
        block[offset : offset + array.nbytes] = array.reshape(-1).view(np.uint8)
    back = decode(tree, block)
    assert isinstance(back, TabulatedPane)
    np.testing.assert_array_equal(back.transmittance, SHEET.transmittance)


# ---- the goniometer ----


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("internal", [1.0, 0.9584])
def test_a_probed_pane_follows_the_sum_of_its_inner_reflections(transport, internal):
    pane = ThinGlass(1.52, Constant(internal))
    made = Session(witness=False).probe(pane, ANGLES, transport=transport)
    reflected, transmitted = slab(ANGLES, 1.52, internal)
    np.testing.assert_allclose(made.reflectance, reflected, atol=4e-4)
    np.testing.assert_allclose(made.transmittance, transmitted, atol=4e-4)
    even = Session(witness=False).probe(pane, transport=transport)
    expected = hemispherical(lambda degrees: slab(degrees, 1.52, internal)[1])
    assert abs(even.transmittance[0] - expected) < 4.0 * even.transmittance_error[0] < 2e-3


def test_a_probed_boundary_follows_fresnel_from_both_sides(transport):
    made = Session(witness=False).probe(Dielectric(Cauchy(1.5)), ANGLES, transport=transport)
    s, p, _ = fresnel(ANGLES, 1.5)
    np.testing.assert_allclose(made.reflectance, 0.5 * (s + p), atol=4e-4)
    np.testing.assert_allclose(made.transmittance, 1.0 - 0.5 * (s + p), atol=4e-4)
    # From behind is from inside: total reflection beyond 41.8 degrees.
    made = Session(witness=False).probe(
        Dielectric(Cauchy(1.5)), 180.0 - ANGLES, transport=transport
    )
    s, p, _ = fresnel(ANGLES, 1.0 / 1.5)
    np.testing.assert_allclose(made.reflectance, 0.5 * (s + p), atol=4e-4)
    total = np.sin(np.radians(ANGLES)) > 1.0 / 1.5
    assert total.any()
    np.testing.assert_allclose(made.reflectance[total], 1.0, atol=1e-6)
    np.testing.assert_array_equal(made.transmittance[total], 0.0)


@pytest.mark.parametrize(
    "surface",
    [
        Dielectric(Cauchy(1.7)),
        ThinGlass(1.6, Constant(1.0)),
        Diffuse(Constant(0.3), Constant(0.7)),
        Glossy(Constant(1.0), 0.0),
        Coated(Constant(1.0), 1.5, 1.0, 0.0),
        Mix(ThinGlass(1.5, Constant(1.0)), Glossy(Constant(1.0), 0.0), 0.3),
    ],
    ids=lambda surface: type(surface).__name__,
)
def test_what_absorbs_nothing_loses_nothing(surface):
    made = Session(witness=False).probe(surface, [0.0, 40.0, 85.0, 120.0])
    np.testing.assert_allclose(made.reflectance + made.transmittance, 1.0, atol=1e-4)


def test_probes_of_plain_surfaces_give_what_they_state():
    made = Session(witness=False).probe(Diffuse(Constant(0.3), Constant(0.4)), [0.0, 60.0, 130.0])
    np.testing.assert_allclose(made.reflectance, 0.3, atol=4e-4)
    np.testing.assert_allclose(made.transmittance, 0.4, atol=4e-4)
    made = Session(witness=False).probe(Black())
    assert made.angles is None
    assert made.reflectance[0] == made.transmittance[0] == made.reflectance_error[0] == 0.0
    ramp = Tabulated(np.array([400.0, 700.0]), np.array([0.1, 0.7]))
    for wavelength, expected in ((400.0, 0.1), (550.0, 0.4), (650.0, 0.6)):
        found = (
            Session(witness=False)
            .probe(Diffuse(ramp), [30.0], wavelength=wavelength)
            .reflectance[0]
        )
        # Spectra of plain surfaces are kept every 5 nm.
        assert found == pytest.approx(expected, abs=2e-3)


def test_stated_errors_of_probes_are_those_that_seeds_show():
    truth = slab(ANGLES, 1.52, 0.9)[0]
    session, deviations = Session(witness=False), []
    for seed in range(24):
        made = session.probe(ThinGlass(1.52, Constant(0.9)), ANGLES, 1 << 14, seed)
        deviations.append((made.reflectance - truth, made.reflectance_error))
    difference, stated = np.transpose(deviations, (1, 0, 2))
    # 216 values: the ratio of the variances lies within 0.6 and 1.6 but for five in a million.
    assert 0.6 < (difference**2).mean() / (stated**2).mean() < 1.6
    again = session.probe(ThinGlass(1.52, Constant(0.9)), ANGLES, 1 << 14, 0)
    np.testing.assert_array_equal(again.reflectance - truth, difference[0])


def test_a_probe_leaves_the_scene_as_it_is():
    session = session_of(
        quad("floor", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "paint"),
        Material("paint", "paint", Diffuse(Constant(0.5))),
        UniformWorld(10.0),
    )
    rule = StopRule(samples=1 << 10)
    before = session.measure([[0, 0, 0.1]], [[0, 0, 1]], rule, transport="mono")
    session.probe(Dielectric(Cauchy(1.5, 0.004)), [10.0], transport="spectral")
    after = session.measure([[0, 0, 0.1]], [[0, 0, 1]], rule, transport="mono")
    assert before.illuminance[0] == after.illuminance[0]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"angles": [10.0, 181.0]}, "181 degrees"),
        ({"angles": [90.0]}, "90 degrees"),
        ({"angles": [np.nan]}, "nan degrees"),
        ({"samples": 0}, "0 samples"),
        ({"wavelength": 300.0}, "not at 300 nm"),
        ({"transport": "fast"}, "expected auto, mono or spectral"),
        ({"surface": Diffuse(ImageTexture(np.zeros((2, 2, 3), np.float32)))}, "pictures"),
        ({"surface": replace(SHEET, reflectance=np.ones(6))}, "more than all of it"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_probe_refuses_what_it_cannot_answer(given, words):
    with pytest.raises(SceneError, match=words):
        Session(witness=False).probe(**({"surface": Black(), "angles": [0.0]} | given))
