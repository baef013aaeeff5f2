"""Spectra from the colours of scattering files."""

import numpy as np
from scattering_files import mdl
from scattering_readings import read_back, told

from lumenray.engine.photometry.colour import XYZ_TO_REC709
from lumenray.engine.photometry.spectra import GRID, illuminant, observer
from lumenray.engine.scattering.data.evaluation import total
from lumenray.engine.scattering.readers.colour import spectra_of_rgb


def test_colours_come_back_under_daylight():
    rng = np.random.default_rng(3)
    wanted = np.concatenate([np.eye(3), 1.0 - np.eye(3), rng.random((200, 3))])
    wavelengths, spectra = spectra_of_rgb(wanted)
    fine = np.stack([np.interp(GRID, wavelengths, each) for each in spectra])
    light = illuminant(GRID, "D65")
    xyz = fine @ (light[:, None] * observer()) / (light @ observer()[:, 1])
    np.testing.assert_allclose(xyz @ XYZ_TO_REC709.T, wanted, atol=1e-5)
    assert spectra.min() >= 0.0
    assert spectra.max() <= 1.0


def test_greys_are_the_same_at_all_wavelengths_and_nothing_is_negative():
    greys = np.array([0.0, 1e-6, 0.18, 1.0, 300.0])
    spectra = spectra_of_rgb(np.repeat(greys[:, None], 3, axis=1))[1]
    assert (spectra == greys[:, None]).all()
    wild = spectra_of_rgb(np.random.default_rng(4).normal(size=(500, 3)))[1]
    assert wild.min() >= 0.0


def test_mdl_colours_become_spectra():
    file = read_back(mdl(lambda wi, wo: np.full(len(wi), 0.5 / np.pi), colour=(0.8, 0.2, 0.1)))
    assert "Rec. 709" in told(file)
    table = file.sides["front_reflection"]
    wavelengths, spectra = spectra_of_rgb([[0.4, 0.1, 0.05]])
    wanted = np.interp(table.wavelengths, wavelengths, spectra[0])
    np.testing.assert_allclose(total(table, np.radians(33.0)), wanted, rtol=2e-3)
