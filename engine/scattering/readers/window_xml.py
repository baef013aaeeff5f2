"""WINDOW XML of LBNL: scattering of window layers by pairs of patches (Klems) or by tensor trees.

WINDOW's front is the outdoor side, and is our front: +z points outdoors. (Radiance calls that side the back.) The files
count azimuths in the frame of somebody who looks out, in which z points indoors and y up. So our frame is theirs after half
a turn about y: x is reversed. Incident directions are those in which light travels, so there x and y are reversed besides.
"""

import re
from pathlib import Path

import numpy as np

from ...errors import FileFormatError
from ...reading.remarks import Remark
from ...reading.safe_xml import XmlElement, parse_xml
from ...scene.scattering import PatchMatrix, Scatter
from ..data.patches import albedos, patch_of, transposed
from ..data.record import ScatteringFile
from ..data.tree import albedos_of_tree, transposed_tree
from .window_blocks import LONGEST_TEXT, Block, text_of
from .window_klems import incidences_of_rings, read_bases, read_matrix
from .window_trees import TREES, read_tree

SIDES = {
    "transmission front": "front_transmission",
    "transmission back": "back_transmission",
    "reflection front": "front_reflection",
    "reflection back": "back_reflection",
}
"""WavelengthDataDirection, and our names."""

TOO_MUCH = 1.01
"""Share of light from which on energy is not kept, after the rounding of simulations and instruments."""

_ROOT = re.compile(rb"<(?:[\w.-]+:)?WindowElement[\s>]")


def is_window_xml(data: bytes) -> bool:
    """Whether the first bytes of a file are of a WINDOW XML."""
    return _ROOT.search(data[: 1 << 16].replace(b"\0", b"")) is not None


def read_window_xml(data: bytes, path) -> ScatteringFile:
    """Read the light that a layer reflects and lets through; of wavelengths only what is weighted by the eye, or the sun.

    Raises
    ------
    FileFormatError    It is no such file, has no data, or they contradict each other; with the line.
    """
    root = parse_xml(data, path)
    if root.tag != "WindowElement":
        raise FileFormatError(
            path,
            f"begins with the element '{root.tag[:LONGEST_TEXT]}', expected 'WindowElement'",
            root.line,
        )
    layers = root.findall("Optical/Layer")
    if not layers:
        raise FileFormatError(path, "has no Optical/Layer", root.line)
    layer, remarks = layers[0], []
    if len(layers) > 1:
        remarks.append(Remark(f"has {len(layers)} layers; the first one is taken", layers[1].line))
    chosen = _choose_blocks(layer, path, remarks)
    structure = layer.find("DataDefinition/IncidentDataStructure")
    name = "" if structure is None else text_of(structure).lower()
    if name in TREES:
        sides = {
            side: read_tree(block, TREES[name], path, remarks) for side, block in chosen.items()
        }
    elif name in {"columns", "rows"}:
        bases = read_bases(layer, path, remarks)
        sides = {
            side: read_matrix(block, bases, name == "rows", path, remarks)
            for side, block in chosen.items()
        }
    else:
        raise FileFormatError(
            path,
            f"has the IncidentDataStructure '{name}', expected Columns, Rows, TensorTree3 or TensorTree4",
            layer.line if structure is None else structure.line,
        )
    _complete(sides, remarks)
    _check_energy(sides, remarks)
    found = {incidences_of_rings(s.incoming) for s in sides.values() if isinstance(s, PatchMatrix)}
    return ScatteringFile(
        path=Path(path),
        format="WINDOW XML, "
        + (f"tensor tree of rank {TREES[name]}" if name in TREES else "Klems"),
        sides=sides,
        name=text_of(layer.find("Material/Name")),
        source=text_of(layer.find("Material/Manufacturer")),
        incidences=np.array(sorted({angle for angles in found for angle in angles})),
        remarks=tuple(remarks),
    )


def _choose_blocks(layer: XmlElement, path, remarks: list[Remark]) -> dict[str, Block]:
    """The blocks that are read, by side; what is left out is remarked."""
    blocks = [
        Block(
            text_of(data.find("Wavelength")), text_of(block.find("WavelengthDataDirection")), block
        )
        for data in layer.findall("WavelengthData")
        for block in data.findall("WavelengthDataBlock")
    ]
    if not blocks:
        raise FileFormatError(
            path, "is a template without data: its layer has no WavelengthDataBlock", layer.line
        )
    bands = {block.band.lower(): block.band for block in blocks}
    used = next((band for band in ("visible", "solar") if band in bands), None)
    if used is None:
        raise FileFormatError(
            path, f"has data for {_listed(bands.values())}, expected Visible or Solar", layer.line
        )
    if used == "solar":
        remarks.append(Remark("has no Visible data; Solar is taken for them"))
    colours = [name for band, name in bands.items() if band in {"cie-x", "cie-z"}]
    if colours:
        remarks.append(Remark(f"colour is left out ({_listed(colours)})"))
    others = [n for band, n in bands.items() if band not in {used, "cie-x", "cie-z"}]
    if others:
        remarks.append(Remark(f"data for {_listed(others)} are left out"))
    chosen, unknown = {}, {}
    for block in blocks:
        if block.band.lower() != used:
            continue
        side = SIDES.get(block.direction.lower())
        if side is None:
            unknown.setdefault(block.direction, block.element.line)
        elif side in chosen:
            raise FileFormatError(
                path, f"has '{block.direction}' twice for {block.band}", block.element.line
            )
        else:
            chosen[side] = block
    if unknown:
        remarks.append(Remark(f"data for {_listed(unknown)} are left out", min(unknown.values())))
    if not chosen:
        raise FileFormatError(
            path, "has neither Transmission nor Reflection, Front or Back", layer.line
        )
    return chosen


def _listed(names) -> str:
    """Names for a message, the first few of many, each cut short."""
    names = [f"'{name[:40]}'" for name in names]
    return ", ".join(names[:4]) + (" and others" if len(names) > 4 else "")


def _complete(sides: dict[str, Scatter], remarks: list[Remark]) -> None:
    """Add the transmission that the file lacks while it has that of the other side."""
    for side, other in (("front", "back"), ("back", "front")):
        there, back = sides.get(f"{side}_transmission"), sides.get(f"{other}_transmission")
        if there is None and back is not None:
            is_matrix = isinstance(back, PatchMatrix)
            sides[f"{side}_transmission"] = transposed(back) if is_matrix else transposed_tree(back)
            place = "" if is_matrix or back.rank == 4 else ", on a grid"
            remarks.append(
                Remark(
                    f"tells only of light from the {other} what passes; "
                    f"that from the {side} follows by reciprocity{place}"
                )
            )
            return
        if there is not None and back is not None and there.values.any() > back.values.any():
            remarks.append(
                Remark(
                    f"lets no light from the {other} pass, but some from the {side}; this is not reciprocal"
                )
            )


def _check_energy(sides: dict[str, Scatter], remarks: list[Remark]) -> None:
    """Remark sides that send on more light than arrives."""
    azimuths = np.radians(np.arange(0.0, 360.0, 15.0))
    for front in ("front", "back"):
        scatters = [s for name, s in sides.items() if name.startswith(front)]
        if not scatters:
            continue
        totals = {}
        for degrees in range(0, 90, 5):
            sine = np.sin(np.radians(degrees))
            level = np.full_like(azimuths, np.cos(np.radians(degrees)))
            wi = np.stack([sine * np.cos(azimuths), sine * np.sin(azimuths), level], axis=1)
            totals[degrees] = float(np.max(sum(_shares(scatter, wi) for scatter in scatters)))
        worst = max(totals, key=totals.get)
        if totals[worst] > TOO_MUCH:
            remarks.append(
                Remark(
                    f"the {front} sends on {totals[worst]:.3g} of the light that arrives at "
                    f"{worst} degrees, more than there is"
                )
            )


def _shares(scatter: Scatter, wi: np.ndarray) -> np.ndarray:
    """Share of light from directions that is scattered. (n, 3) -> (n,)"""
    if isinstance(scatter, PatchMatrix):
        return albedos(scatter)[patch_of(scatter.incoming, wi), 0]
    return albedos_of_tree(scatter, wi)[:, 0]
