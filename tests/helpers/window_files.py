"""WINDOW XML files of few values, written by hand."""

import numpy as np
from scattering_models import towards

from lumenray.engine.scattering.data.patches import albedos, evaluate_patches, patch_of
from lumenray.engine.scattering.data.tree import albedos_of_tree, evaluate_tree
from lumenray.engine.scattering.readers.window_xml import read_window_xml
from lumenray.engine.scene.scattering import PatchMatrix

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


NORMAL = np.array([[0.0, 0.0, 1.0]])

MIRROR_X = np.array([-1.0, 1.0, 1.0])
HALF_TURN = np.array([-1.0, -1.0, 1.0])


def read_window(data: bytes, side: str | None = None):
    """Read a file, or what it holds of one side."""
    file = read_window_xml(data, "pane.xml")
    return file if side is None else file.sides[side]


def evaluate_window(scatter, wi, wo):
    """Values of a matrix or a tree in its first band. (n,) [1/sr]"""
    found = evaluate_patches if isinstance(scatter, PatchMatrix) else evaluate_tree
    return found(scatter, wi, wo)[:, 0]


def shares_sent(scatter, wi):
    """Share of the light from directions that a matrix or a tree sends on. (n,)"""
    if isinstance(scatter, PatchMatrix):
        return albedos(scatter)[patch_of(scatter.incoming, wi), 0]
    return albedos_of_tree(scatter, wi)[:, 0]


def row_towards(polar, azimuth):
    """One direction as a row. (1, 3) [degree]"""
    return towards(polar, azimuth)[None]


GRID = " ".join(f"{k}" for k in range(16))
"""Of one halving; the last coordinate is the fastest."""
