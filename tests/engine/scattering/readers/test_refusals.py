"""Scattering files that are wrong: one sentence says what and where."""

import struct

import numpy as np
import pytest
from scattering_files import (
    anisotropic,
    anisotropic_binary,
    brdf_text,
    bsdf180,
    coated,
    lighttools,
    mdl,
    mdl_block,
    packed,
    scattering,
    simple,
    zemax,
)
from scattering_readings import read_back

from lumenray.engine.errors import FileFormatError


def changed(data: bytes, old: bytes, new: bytes) -> bytes:
    assert old in data
    return data.replace(old, new, 1)


FOUR_GIGABYTES = struct.pack("<I", 0xFFFFFFFF)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (changed(zemax(), b"Asymmetrical", b"Twisted"), "states 'Twisted' as symmetry"),
        (changed(zemax(), b"BRDF", b"BSSRDF"), "states 'BSSRDF' as scattertype"),
        (changed(zemax(), b"SampleRotation 1\n0\n", b""), "lacks the keyword 'samplerotation'"),
        (changed(zemax(), b"ScatterRadial 31", b"ScatterRadial 30"), "has the keyword '180'"),
        (changed(zemax(), b"ScatterRadial 31", b"ScatterRadial 900"), "has 'Monochrome' among angles"),
        (changed(zemax(), b"ScatterRadial 31", b"ScatterRadial 90000"), "more than the file can hold"),
        (changed(zemax(), b"ScatterAzimuth 25", b"ScatterAzimuth 99999999999"), "expected a whole number"),
        (changed(zemax(), b"0\t30\t60", b"0\t30\t95"), "expected 0 to 90"),
        (changed(zemax(), b"0\t30\t60", b"0\t30\t30"), "same angle of incidence twice"),
        (changed(zemax(), b"TIS 0", b"TIS 3"), "as TIS, expected a number from 0 to 1.02"),
        (changed(zemax(), b"0\t6\t12", b"0\t6\t6"), "do not ascend"),
        (changed(zemax(), b"DataEnd", b""), "ends before 'dataend'"),
        (zemax(azimuths=range(0, 181, 15)), "expected 0 to 360"),
        (zemax()[:-4000], "ends after"),
        (b"MATE A\n.5 1.5 0\nCOAT AR\nA .25\nscarce", "thin-film coatings"),
        (changed(lighttools(), b"Side Front", b"Side Top"), "has the side 'top'"),
        (changed(lighttools(), b"AOI 30", b"AOI 0"), "expected one for each"),
        (lighttools(azimuths=range(45, 180, 15)), "leave out one side"),
        (b"OPTIS - Spectrum file v1.0\n", "begins with 'OPTIS - Spectrum file v1.0'"),
        (changed(anisotropic(), b"description\n1\t0", b"description\n1\tx"), "has 'x' among the direction"),
        (changed(anisotropic(), b"16 25\n", b"16 24\n"), "has polar angles that do not ascend"),
        (changed(anisotropic(), b"16 25\n", b"9000 9000\n"), "81000000 values"),
        (changed(anisotropic(), b"\n11\n", b"\n100001\n"), "length of the description"),
        (anisotropic(spectrum=((700, 50.0), (400, 50.0))), "wavelengths that do not ascend"),
        (anisotropic(lambda wi, wo: np.zeros(len(wi))), "has no light"),
        (anisotropic(phis=range(0, 136, 15)), "neither all around nor from 0 to 180"),
        (anisotropic() + b"5 5 5", None),
        (changed(anisotropic_binary(), b"\n1\x03", b"\n1\x04"), "export the file in text mode"),
        (anisotropic_binary()[:900], "cut short"),
        (changed(anisotropic_binary(), struct.pack("<II", 16, 25), struct.pack("<II", 16, 26)), "expected"),
        (changed(brdf_text(), b"\n0\ncomment", b"\n1\ncomment"), "text mode"),
        (changed(scattering(), b"2 2", b"2 3"), "wavelengths"),
        (changed(scattering(), b"\t4\t", b"\t400\t"), "expected|not 0 to 100"),
        (simple("20 30 90 20"), "at most 100 together"),
        (simple(mode="Glow"), "expected Reflection or Transmission"),
        (changed(coated(), b"95", b"99"), "expected 0 to 100"),
        (changed(bsdf180(), b"Coated surface file v2", b"Coated surface file v3"), "another kind"),
        (bsdf180()[:-10], "cut short"),
        (b"OPTIS - BSDF180 file v1\n\4\0\0\0" + packed(b"both", 1 << 30), "which cannot be"),
        (b"OPTIS - BSDF180 file v1\n\4\0\0\0" + packed(bytes(900), 800), "to another size"),
        (b"NVIDIA ARC MBSDF V1\n", "has no data"),
        (b"file format error NVIDIA ARC MBSDF V1\n", "expected to begin with"),
        (mdl()[:-1], "cut short"),
        (mdl() + b"\0", "1 bytes after the data"),
        (changed(mdl(), struct.pack("<I", 24), FOUR_GIGABYTES), "expected 1 to"),
        (changed(mdl(), struct.pack("<I", 15), struct.pack("<I", 9999)), "cut short"),
        (b"NVIDIA ARC MBSDF V1\nMBSDF_DATA=\n" + mdl_block(np.full((1, 1, 2), np.nan)), "no numbers up to"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_in_one_sentence(data, message):
    if message is None:
        assert read_back(data).sides
        return
    with pytest.raises(FileFormatError, match=message) as caught:
        read_back(data)
    assert str(caught.value).startswith("surface")
    assert "\n" not in str(caught.value)
