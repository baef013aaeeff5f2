"""TM-33 documents under damage: a luminaire with a sensible flux, or a refusal; never a crash, a hang or nonsense."""

import os
import time

import numpy as np
import pytest
from mutations import damage

from lumenray.engine.errors import FileFormatError
from lumenray.engine.luminaires.distribution import flux
from lumenray.engine.luminaires.formats.reader import parse_luminaire
from lumenray.engine.luminaires.formats.tm33.reader import parse_tm33

CHUNKS = 16
MUTATIONS = (8000 if os.environ.get("LUMENRAY_ALL_SEEDS") else 1200) // CHUNKS
"""Damaged files in each of the chunks; set LUMENRAY_ALL_SEEDS for the full number."""

LONGEST = 1.0
"""No file takes longer. [s]"""


def data(horizontal, vertical, seed):
    rng = np.random.default_rng(seed)
    count = len(horizontal) * len(vertical)
    items = "\n".join(
        f'<IntData h="{h}" v="{v}">{400 * rng.random():.3f}</IntData>'
        for h in horizontal
        for v in vertical
    )
    return (
        f"<NumberMeasured>{count}</NumberMeasured><NumberHorz>{len(horizontal)}</NumberHorz>\n"
        f"<NumberVert>{len(vertical)}</NumberVert>\n{items}"
    )


SPECTRUM = """<SpectralData><EmitterSpectral><NumberWavelength>5</NumberWavelength>
<PwrData w="400">0.1</PwrData><PwrData w="450">1</PwrData><PwrData w="500">0.4</PwrData>
<PwrData w="600">0.9</PwrData><PwrData w="700">0.1</PwrData></EmitterSpectral></SpectralData>"""

AREAS = """<EmissionAreas><BottomFace><NumberBottom>1</NumberBottom><BottomArea><Length>1.1</Length>
<Width>0.2</Width><LengthOffset>0.0</LengthOffset><WidthOffset>0.1</WidthOffset></BottomArea></BottomFace>
<C0Face><NumberC0>1</NumberC0><C0Area><Length>1.1</Length><Height>0.05</Height></C0Area></C0Face>
</EmissionAreas>"""


def document(content, goniometer="IES_C", root="IESTM33-22"):
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<{root} xmlns="u">
<Version>1.1</Version>
<Header><Manufacturer>Öst</Manufacturer><ReportDate>2024-05-06</ReportDate></Header>
<Luminaire><Dimensions><Length>1.2</Length><Width>0.3</Width><Height>0.06</Height></Dimensions></Luminaire>
<Equipment><Gonioradiometer><Type>{goniometer}</Type></Gonioradiometer></Equipment>
<Emitter><Quantity>2</Quantity><RatedLumens>1000</RatedLumens><InputWattage>12.5</InputWattage>
<ColorTemperature><MinCCT>2700</MinCCT><MaxCCT>6500</MaxCCT></ColorTemperature>
<TiltAngles><NumberAngles>2</NumberAngles><Tilt angle="0">1</Tilt><Tilt angle="90">0.9</Tilt></TiltAngles>
{content}
</Emitter>
</{root}>
""".encode()


TEXTS = [
    document(
        "<LuminousData><LuminousIntensity><AbsolutePhotometry>true</AbsolutePhotometry>"
        "<Symm>Symm _ Quad</Symm><Multiplier>1.5</Multiplier>\n"
        + data([0, 30, 60, 90], [0, 20, 45, 90], 1)
        + "</LuminousIntensity><LuminousFlux>900</LuminousFlux></LuminousData>"
        + SPECTRUM
        + AREAS
    ),
    document(
        "<PhotonData><MinWavelength>400</MinWavelength><MaxWavelength>700</MaxWavelength><PhotonIntensity>"
        + data([0, 90, 180, 270, 360], [0, 45, 90, 180], 2)
        + "</PhotonIntensity></PhotonData>"
        + SPECTRUM,
        root="IESTM33",
    ),
    document(
        "<LuminousData><LuminousIntensity>"
        + data([-90, -30, 0, 30, 90], [0, 45, 90], 3)
        + "</LuminousIntensity></LuminousData><SpectralData><AngularSpectral>"
        + "".join(
            f'<IntData h="{h}" v="{v}" w="{w}">{h + v + w}</IntData>\n'
            for h in (0, 90)
            for v in (0, 90)
            for w in (450, 550, 650)
        )
        + "</AngularSpectral></SpectralData>",
        "IES_B",
    ),
]


@pytest.mark.parametrize("data", TEXTS)
def test_the_undamaged_documents_are_read(data):
    assert flux(parse_luminaire(data, "a.xml").distribution) > 0.0


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_damaged_documents_are_read_sensibly_or_refused(chunk):
    rng = np.random.default_rng([33, chunk])
    for i in range(MUTATIONS):
        damaged = damage(TEXTS[i % len(TEXTS)], rng)
        parse = (parse_tm33, parse_luminaire)[i % 3 == 1]
        start = time.process_time()
        try:
            file = parse(damaged, "damaged.xml")
        except FileFormatError as error:
            assert len(str(error)) > 20
            continue
        finally:
            assert time.process_time() - start < LONGEST
        total = flux(file.distribution)
        assert np.isfinite(total)
        assert total > 0.0
        assert np.all(np.isfinite(file.distribution.intensity))
        assert np.all(np.diff(file.distribution.azimuth) > 0.0)
        assert np.all(np.diff(file.distribution.polar) > 0.0)
        assert all(0.0 <= side < 1e4 for side in file.opening.size)
        if file.spectrum is not None:
            assert np.all(np.isfinite(file.spectrum))
            assert file.spectrum[1].max() > 0.0
