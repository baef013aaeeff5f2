"""WINDOW XML files of few values, written by hand."""

import numpy as np

KLEMS_FULL = "LBNL/Klems Full"

SMALL = "Small"
"""Name of the basis that `SMALL_BASIS` defines."""

SMALL_RINGS = ((0.0, 30.0, 1), (30.0, 60.0, 4), (60.0, 90.0, 2))
"""From, to [degree], and patches."""

SMALL_COUNT = 7


def basis(name: str, rings) -> str:
    blocks = "".join(
        f"<AngleBasisBlock><Theta>{(low + high) / 2}</Theta><nPhis>{count}</nPhis>"
        f"<ThetaBounds><LowerTheta>{low}</LowerTheta><UpperTheta>{high}</UpperTheta></ThetaBounds>"
        "</AngleBasisBlock>\n"
        for low, high, count in rings
    )
    return f"<AngleBasis><AngleBasisName>{name}</AngleBasisName>\n{blocks}</AngleBasis>"


SMALL_BASIS = basis(SMALL, SMALL_RINGS)


def block(direction: str, data, bases=None, band: str = "Visible") -> str:
    """A WavelengthData; ``data`` text or numbers, ``bases`` of column and row, None: of trees."""
    if not isinstance(data, str):
        data = "\n".join(" ".join(f"{value:.9g}" for value in row) for row in np.atleast_2d(data))
    names = (
        f"<ColumnAngleBasis>{bases[0]}</ColumnAngleBasis><RowAngleBasis>{bases[1]}</RowAngleBasis>"
        if bases
        else "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>"
    )
    return f"""<WavelengthData><LayerNumber>System</LayerNumber><Wavelength unit="Integral">{band}</Wavelength>
<WavelengthDataBlock><WavelengthDataDirection>{direction}</WavelengthDataDirection>
{names}<ScatteringDataType>BTDF</ScatteringDataType>
<ScatteringData>
{data}
</ScatteringData></WavelengthDataBlock></WavelengthData>
"""


def window_xml(structure: str, *blocks: str, bases: str = "") -> bytes:
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<WindowElement xmlns="http://windows.lbl.gov"><WindowElementType>System</WindowElementType>
<FileType>BSDF</FileType><Optical><Layer>
<Material><Name>Pane  one</Name><Manufacturer>Works</Manufacturer><Thickness unit="meter">0.1</Thickness></Material>
<DataDefinition><IncidentDataStructure>{structure}</IncidentDataStructure>{bases}</DataDefinition>
{"".join(blocks)}</Layer></Optical></WindowElement>""".encode()


def klems(direction: str, values, name: str = KLEMS_FULL, structure: str = "Columns") -> bytes:
    """A file with one side; a row of ``values`` is an outgoing patch."""
    return window_xml(structure, block(direction, values, (name, name)))


def tree(direction: str, data: str, rank: int = 4) -> bytes:
    return window_xml(f"TensorTree{rank}", block(direction, data))
