"""Tensor trees of WINDOW XML: nested braces of values on finer and finer grids."""

import re
from array import array

import numpy as np

from ...errors import FileFormatError, SceneError
from ...reading.remarks import Remark
from ...scene.scattering import TensorTree
from ..data.tree import MOST_LEVELS, grow_children, levels_of, mirrored_tree
from .window_blocks import NEUTRAL, Block, clip, parse_value, text_of, values_of

TREES = {"tensortree3": 3, "tensortree4": 4}
"""Ranks by IncidentDataStructure."""

MOST_LEAVES = 1 << 22
"""Values that a tree may have."""

_FOREIGN = re.compile(r"[^0-9eE.+\-\s,{}]", re.ASCII)


def read_tree(block: Block, rank: int, path, remarks: list[Remark]) -> TensorTree:
    """Read one side, a tree of a rank."""
    basis = text_of(block.element.find("AngleBasis")).lower()
    if basis not in {"", "lbnl/shirley-chiu"}:
        raise FileFormatError(
            path,
            f"has the AngleBasis '{basis}', expected LBNL/Shirley-Chiu",
            block.element.line,
        )
    text, line = values_of(block, _FOREIGN, path)
    children, values = _TreeParser(text, rank, path, line).parse()
    tree = TensorTree(rank, children, np.array([NEUTRAL]), clip(values, block, remarks)[:, None])
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
            value = parse_value(token)
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
