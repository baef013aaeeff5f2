"""Spectra of TM-33 documents, and data in watts and photons that need one."""

import numpy as np
import pytest
from tm33_files import (
    FINE,
    FLAT,
    UNIFORM,
    at_45,
    data,
    emitter,
    luminous,
    parsed,
    refused,
    spectral,
)

from lumenray.engine.luminaires.distribution import flux

K_M = 683.002
"""[lm/W]"""


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
