"""WINDOW XML of LBNL: scattering of window layers by pairs of patches (Klems) or by tensor trees.

WINDOW's front is the outdoor side, and is our front: +z points outdoors. (Radiance calls that side the back.) The files
count azimuths in the frame of somebody who looks out, in which z points indoors and y up. So our frame is theirs after half
a turn about y: x is reversed. Incident directions are those in which light travels, so there x and y are reversed besides.
"""

import re
from array import array
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import FileFormatError, SceneError
from ...reading.remarks import Remark
from ...reading.safe_xml import XmlElement, parse_xml
from ...scene.scattering import PatchBasis, PatchMatrix, Scatter, TensorTree
from ..data.patches import MOST_PATCHES, albedos, patch_of, starts_of, transposed
from ..data.record import ScatteringFile
from ..data.tree import (
    MOST_LEVELS,
    albedos_of_tree,
    grow_children,
    levels_of,
    mirrored_tree,
    transposed_tree,
)

SIDES = {
    "transmission front": "front_transmission",
    "transmission back": "back_transmission",
    "reflection front": "front_reflection",
    "reflection back": "back_reflection",
}
"""WavelengthDataDirection, and our names."""

KLEMS = {
    "lbnl/klems full": (
        (0.0, 5.0, 15.0, 25.0, 35.0, 45.0, 55.0, 65.0, 75.0, 90.0),
        (1, 8, 16, 20, 24, 24, 24, 16, 12),
    ),
    "lbnl/klems half": (
        (0.0, 6.5, 19.5, 32.5, 45.5, 58.5, 71.5, 90.0),
        (1, 8, 12, 16, 20, 12, 8),
    ),
    "lbnl/klems quarter": ((0.0, 9.0, 27.0, 45.0, 63.0, 90.0), (1, 8, 12, 12, 8)),
}
"""Bases that files need not define: bounds of the rings [degree] and patches of each."""

TREES = {"tensortree3": 3, "tensortree4": 4}
"""Ranks by IncidentDataStructure."""

NEUTRAL = 555.0
"""Wavelength of values that hold for all. [nm]"""

MOST_LEAVES = 1 << 22
"""Values that a tree may have."""

LONGEST_TEXT = 100
"""Of names. [character]"""

LARGEST = 1e30
"""Bound of values, well within single precision. [1/sr]"""

TOO_MUCH = 1.01
"""Share of light from which on energy is not kept, after the rounding of simulations and instruments."""

_FOREIGN = re.compile(r"[^0-9eE.+\-\s,]", re.ASCII)

_FOREIGN_TO_TREES = re.compile(r"[^0-9eE.+\-\s,{}]", re.ASCII)

_ROOT = re.compile(rb"<(?:[\w.-]+:)?WindowElement[\s>]")


@dataclass(frozen=True)
class _Block:
    """One side's data: ``element`` is its WavelengthDataBlock."""

    band: str
    direction: str
    element: XmlElement


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
    name = "" if structure is None else _text(structure).lower()
    if name in TREES:
        sides = {
            side: _read_tree(block, TREES[name], path, remarks) for side, block in chosen.items()
        }
    elif name in {"columns", "rows"}:
        bases = _read_bases(layer, path, remarks)
        sides = {
            side: _read_matrix(block, bases, name == "rows", path, remarks)
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
    found = {_incidences(s.incoming) for s in sides.values() if isinstance(s, PatchMatrix)}
    return ScatteringFile(
        path=Path(path),
        format="WINDOW XML, "
        + (f"tensor tree of rank {TREES[name]}" if name in TREES else "Klems"),
        sides=sides,
        name=_text(layer.find("Material/Name")),
        source=_text(layer.find("Material/Manufacturer")),
        incidences=np.array(sorted({angle for angles in found for angle in angles})),
        remarks=tuple(remarks),
    )


def _text(element: XmlElement | None) -> str:
    """Text of an element in one line, as much as a message or a name may hold."""
    return "" if element is None else " ".join((element.text or "").split())[:LONGEST_TEXT]


def _choose_blocks(layer: XmlElement, path, remarks: list[Remark]) -> dict[str, _Block]:
    """The blocks that are read, by side; what is left out is remarked."""
    blocks = [
        _Block(_text(data.find("Wavelength")), _text(block.find("WavelengthDataDirection")), block)
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


def _data(block: _Block, path) -> tuple[str, int]:
    """Text of the values, and the line where it begins."""
    element = block.element.find("ScatteringData")
    if element is None or not (element.text or "").strip():
        raise FileFormatError(
            path, f"has no ScatteringData for {block.direction}", block.element.line
        )
    return element.text, element.line


def _clip(values: np.ndarray, block: _Block, remarks: list[Remark]) -> np.ndarray:
    """Values as stored, none below 0."""
    below = int((values < 0.0).sum())
    if below:
        remarks.append(
            Remark(
                f"{below} values of {block.direction} are negative; taken as 0", block.element.line
            )
        )
    return np.maximum(values, 0.0).astype(np.float32)


def _refuse_foreign(pattern, text: str, path, line: int) -> None:
    if found := pattern.search(text):
        line += text.count("\n", 0, found.start())
        raise FileFormatError(path, f"has {found.group()!r} among ScatteringData", line)


def _parse_value(token: str) -> float | None:
    """The number that a token stands for; None if it is none, or too large for single precision."""
    try:
        value = float(token)
    except ValueError:
        return None
    return value if abs(value) < LARGEST else None


# ---- Klems ----


def _read_bases(layer: XmlElement, path, remarks: list[Remark]) -> dict[str, PatchBasis]:
    """Bases by their names in small letters: those that everybody knows, and those that the file defines."""
    bases = {
        name: PatchBasis(np.radians(bounds), np.array(counts, dtype=np.int32))
        for name, (bounds, counts) in KLEMS.items()
    }
    for element in layer.findall("DataDefinition/AngleBasis"):
        name = _text(element.find("AngleBasisName")).lower()
        basis = _read_basis(element, name, path)
        known = bases.get(name)
        if name in KLEMS and not (
            np.array_equal(known.counts, basis.counts)
            and np.allclose(known.bounds, basis.bounds, atol=1e-4)
        ):
            remarks.append(
                Remark(f"defines the basis '{name}' otherwise than LBNL does", element.line)
            )
        bases[name] = basis
    return bases


def _read_basis(element: XmlElement, name: str, path) -> PatchBasis:
    bounds, counts = [0.0], []
    for block in element.findall("AngleBasisBlock"):
        lower, upper, count = (
            _number(block, tag, path)
            for tag in ("ThetaBounds/LowerTheta", "ThetaBounds/UpperTheta", "nPhis")
        )
        if abs(lower - bounds[-1]) > 1e-3 or not bounds[-1] < upper <= 90.001:
            raise FileFormatError(
                path,
                f"has a ring from {lower:g} to {upper:g} degrees in the basis '{name}', "
                f"expected one that begins at {bounds[-1]:g}",
                block.line,
            )
        if count != round(count) or not 1 <= count <= MOST_PATCHES - sum(counts):
            raise FileFormatError(
                path,
                f"has the nPhis {count:g}, expected a whole number; a basis has at most {MOST_PATCHES} patches",
                block.line,
            )
        bounds.append(upper)
        counts.append(int(count))
    if abs(bounds[-1] - 90.0) > 1e-3:
        raise FileFormatError(
            path,
            f"has the basis '{name}' whose rings end at {bounds[-1]:g} degrees, expected 90",
            element.line,
        )
    bounds[-1] = 90.0
    return PatchBasis(np.radians(bounds), np.array(counts, dtype=np.int32))


def _number(element: XmlElement, tag: str, path) -> float:
    found = element.find(tag)
    text = _text(found)
    try:
        value = float(text) if text.isascii() and "_" not in text else np.nan
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise FileFormatError(
            path,
            f"has the {tag} '{text}', expected a number",
            element.line if found is None else found.line,
        )
    return value


def _read_matrix(block: _Block, bases, by_rows: bool, path, remarks: list[Remark]) -> PatchMatrix:
    """Read one side, row after row: a row is an outgoing patch where incidence goes by columns, else an incoming one.

    The column's basis is that of incidence in both cases, as Radiance takes it.
    """
    incoming, outgoing = (_basis_of(block, tag, bases, path) for tag in ("Column", "Row"))
    text, line = _data(block, path)
    _refuse_foreign(_FOREIGN, text, path, line)
    shape = tuple(
        int(basis.counts.sum())
        for basis in ((incoming, outgoing) if by_rows else (outgoing, incoming))
    )
    count = shape[0] * shape[1]
    tokens = text.replace(",", " ").split(None, count)
    if len(tokens) != count:
        raise FileFormatError(
            path,
            f"has {'more' if len(tokens) > count else len(tokens)} values of {block.direction}, "
            f"expected {shape[0]} rows of {shape[1]} by its bases",
            line,
        )
    values = [_parse_value(token) for token in tokens]
    if None in values:
        token = tokens[values.index(None)]
        line += text.count("\n", 0, text.find(token))
        raise FileFormatError(path, f"has '{token[:40]}', expected a number", line)
    values = _clip(np.array(values).reshape(shape), block, remarks)
    for basis in (incoming, outgoing):
        odd = basis.counts[(basis.counts > 1) & (basis.counts % 2 == 1)]
        if odd.size:
            raise FileFormatError(
                path,
                f"has a ring with {odd[0]} patches, expected 1 or an even number: opposite directions need patches alike",
                line,
            )
    values = values if by_rows else values.T
    ours = values[np.ix_(_turned(incoming, False), _turned(outgoing, True))]
    return PatchMatrix(
        incoming, outgoing, np.array([NEUTRAL]), np.ascontiguousarray(ours[..., None])
    )


def _basis_of(block: _Block, kind: str, bases: dict[str, PatchBasis], path) -> PatchBasis:
    element = block.element.find(f"{kind}AngleBasis")
    name = _text(element)
    if name.lower() not in bases:
        raise FileFormatError(
            path,
            f"has the {kind}AngleBasis '{name}', which it does not define",
            (block.element if element is None else element).line,
        )
    return bases[name.lower()]


def _turned(basis: PatchBasis, half: bool) -> np.ndarray:
    """Numbers of the patches at the azimuths -phi, or pi - phi for ``half``."""
    place = np.concatenate([np.arange(n) for n in basis.counts])
    count = np.repeat(basis.counts, basis.counts)
    return np.repeat(starts_of(basis), basis.counts) + (count // 2 * half - place) % count


def _incidences(basis: PatchBasis) -> tuple[float, ...]:
    """Angles of incidence in the middle of rings. [rad]"""
    middle = np.where(basis.counts > 1, 0.5 * (basis.bounds[1:] + basis.bounds[:-1]), 0.0)
    return tuple(middle.tolist())


# ---- tensor trees ----


def _read_tree(block: _Block, rank: int, path, remarks: list[Remark]) -> TensorTree:
    basis = _text(block.element.find("AngleBasis")).lower()
    if basis not in {"", "lbnl/shirley-chiu"}:
        raise FileFormatError(
            path,
            f"has the AngleBasis '{basis}', expected LBNL/Shirley-Chiu",
            block.element.line,
        )
    text, line = _data(block, path)
    _refuse_foreign(_FOREIGN_TO_TREES, text, path, line)
    children, values = _TreeParser(text, rank, path, line).parse()
    tree = TensorTree(rank, children, np.array([NEUTRAL]), _clip(values, block, remarks)[:, None])
    try:
        levels_of(tree)
    except SceneError:
        raise FileFormatError(
            path, f"has braces nested deeper than {MOST_LEVELS} levels", line
        ) from None
    # In x and out x of theirs are reversed as the text at the top tells, and in x and in y once more. An isotropic tree is
    # turned to the incident azimuth, so only the sense of the azimuth changes.
    return mirrored_tree(tree, 0b0110 if rank == 4 else 0b100)


class _TreeParser:
    """Makes a tree of nested braces, without Python's own stack: open braces are held in a list.

    Nodes are numbered as their braces close, so that the root is the last.
    """

    def __init__(self, text: str, rank: int, path, line: int):
        self.rank, self.fan = rank, 1 << rank
        self._text, self._path, self._line = text, path, line
        self._rows, self._values = array("i"), array("d")
        # What each open brace holds so far, as in `TensorTree.children`.
        self._opened: list[list[int]] = []
        self._root: int | None = None

    def parse(self) -> tuple[np.ndarray, np.ndarray]:
        """Return children, numbered from the root, and values as stored. (n, 2 ** rank) int32, (v,) float64"""
        for piece in re.finditer(r"[{}]|[^{}]+", self._text):
            content, at = piece.group(), piece.start()
            if content == "{":
                self._open(at)
            elif content == "}":
                self._close(at)
            elif content.strip(" \t\r\n,"):
                self._take(content, at)
        if self._opened or self._root is None:
            raise FileFormatError(
                self._path, "has ScatteringData whose braces do not close", self._line
            )
        rows = np.frombuffer(self._rows, dtype=np.int32) if self._rows else np.empty(0, np.int32)
        if self._root < 0:
            rows = np.full(self.fan, self._root, dtype=np.int32)
        children = rows.reshape(-1, self.fan)[::-1]
        return self._renumbered(children, len(children) - 1), np.array(self._values)

    @staticmethod
    def _renumbered(children: np.ndarray, last: int) -> np.ndarray:
        """Children with node k called ``last - k``."""
        return np.where(children >= 0, last - children, children).astype(np.int32)

    def _fail(self, message: str, at: int):
        raise FileFormatError(self._path, message, self._line + self._text.count("\n", 0, at))

    def _open(self, at: int) -> None:
        if self._root is not None:
            self._fail("has something after the last brace of ScatteringData", at)
        if len(self._opened) > MOST_LEVELS:
            self._fail(f"has braces nested deeper than {MOST_LEVELS} levels", at)
        self._opened.append([])

    def _close(self, at: int) -> None:
        if not self._opened:
            self._fail("has a closing brace without an opening one", at)
        branches = self._opened.pop()
        if len(branches) == self.fan:
            self._rows.extend(branches)
            made = len(self._rows) // self.fan - 1
        elif len(branches) == 1:
            made = branches[0]
        else:
            self._fail(
                f"has {len(branches)} branches in braces, expected {self.fan}, or values", at
            )
        if self._opened:
            self._opened[-1].append(made)
        else:
            self._root = made

    def _take(self, content: str, at: int) -> None:
        """Take the numbers in a pair of braces: one, or those of a grid."""
        if not self._opened or self._opened[-1]:
            self._fail("has numbers beside braces, expected them within", at)
        first = len(self._values)
        tokens = content.replace(",", " ").split(None, MOST_LEAVES - first)
        if first + len(tokens) > MOST_LEAVES:
            self._fail(f"has more than {MOST_LEAVES} values in a tree", at)
        levels = (len(tokens).bit_length() - 1) // self.rank
        if len(tokens) != 1 << self.rank * levels:
            self._fail(f"has {len(tokens)} values in braces, expected a power of {self.fan}", at)
        for token in tokens:
            value = _parse_value(token)
            if value is None:
                self._fail(f"has '{token[:40]}', expected a number", at + content.find(token))
            self._values.append(value)
        self._opened[-1].append(self._add_grid(levels, first) if levels else -1 - first)

    def _add_grid(self, levels: int, first: int) -> int:
        """Add the nodes of a grid whose values begin at ``first``; return the number of its root."""
        grid = grow_children(self.rank, levels)
        last = len(self._rows) // self.fan + len(grid) - 1
        grid = self._renumbered(np.where(grid < 0, grid - first, grid), last)
        self._rows.frombytes(grid[::-1].tobytes())
        return last


# ---- both ----


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
