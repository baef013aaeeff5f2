"""The containers of glTF 2.0: one buffer with its views and accessors, written as .glb or as .gltf with files beside it.

References
----------
Khronos Group: glTF 2.0 Specification (ISO/IEC 12113:2022), 3.6 (binary data), 4.4 (GLB).
"""

import json
import struct
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import quote

import numpy as np

from ..errors import FileFormatError
from ..reading.whole_file import write_whole

VERTEX_BYTES = 34962
"""Target of a view that holds what vertices are made of."""

INDEX_BYTES = 34963
"""Target of a view that holds which vertices make triangles."""

LARGEST_BINARY = 0xFFFFFFFF
"""Bytes that the header of a .glb can count."""

RESTART = 0xFFFF
"""The one 16-bit index that must not be used. (3.7.2.1)"""

_COMPONENTS = {np.dtype(np.float32): 5126, np.dtype(np.uint16): 5123, np.dtype(np.uint32): 5125}
_SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}


@dataclass
class _View:
    """Bytes of one kind that lie together."""

    parts: list[bytes | np.ndarray] = field(default_factory=list)
    length: int = 0
    fields: dict = field(default_factory=dict)


class Buffer:
    """Collects arrays and pictures. All arrays of a kind share a view; everything begins at a multiple of 4 bytes."""

    def __init__(self):
        self.accessors: list[dict] = []
        self._views: list[_View] = []
        self._kinds: dict[tuple, int] = {}

    def add_vertices(self, values: np.ndarray, with_bounds: bool = False) -> int:
        """Add (n, 2) or (n, 3) numbers, kept as float32, and return the number of their accessor.

        The bounds, which positions must state, are those of the numbers as they are in the file.
        """
        values = np.ascontiguousarray(values, dtype=np.float32)
        fields = {"byteStride": values.itemsize * values.shape[1], "target": VERTEX_BYTES}
        number = self._add_array(values, fields)
        if with_bounds:
            for name, bound in (("min", values.min(axis=0)), ("max", values.max(axis=0))):
                self.accessors[number][name] = [float(v) for v in bound]
        return number

    def add_indices(self, values: np.ndarray, vertex_count: int) -> int:
        """Add vertex indices (n,), in 16 bits if the number of vertices allows it, and return their accessor's number."""
        kind = np.uint16 if vertex_count <= RESTART else np.uint32
        return self._add_array(values.astype(kind), {"target": INDEX_BYTES})

    def add_picture(self, data: bytes) -> int:
        """Add a picture's file and return the number of its view."""
        self._views.append(_View())
        self._append(self._views[-1], data)
        return len(self._views) - 1

    def describe(self) -> tuple[list[dict], int]:
        """Return the views as the file states them, and the length of the buffer. [byte]"""
        views, start = [], 0
        for view in self._views:
            views.append(
                {"buffer": 0, "byteOffset": start, "byteLength": view.length, **view.fields}
            )
            start += view.length + -view.length % 4
        return views, start

    def write(self, stream) -> None:
        """Write all bytes, in the order of the views."""
        for view in self._views:
            for part in view.parts:
                stream.write(part)
            stream.write(bytes(-view.length % 4))

    def _add_array(self, values: np.ndarray, fields: dict) -> int:
        width = values.shape[1] if values.ndim == 2 else 1
        kind = (values.dtype, width)
        if kind not in self._kinds:
            self._kinds[kind] = len(self._views)
            self._views.append(_View(fields=fields))
        number = self._kinds[kind]
        start = self._append(self._views[number], values)
        self.accessors.append(
            {
                "bufferView": number,
                "byteOffset": start,
                "componentType": _COMPONENTS[values.dtype],
                "count": len(values),
                "type": _SHAPES[width],
            }
        )
        return len(self.accessors) - 1

    def _append(self, view: _View, part: bytes | np.ndarray) -> int:
        gap = -view.length % 4
        if gap:
            view.parts.append(bytes(gap))
        start = view.length + gap
        view.parts.append(part)
        view.length = start + (part.nbytes if isinstance(part, np.ndarray) else len(part))
        return start


def write_container(
    path: Path, content: dict, buffer: Buffer, pictures: list[tuple[str, bytes]]
) -> list[Path]:
    """Write a file: ``.glb`` holds all in one, ``.gltf`` has the buffer and the pictures in files beside it.

    Parameters
    ----------
    path : Path    Its folder is made if need be.
    content : dict    The file's JSON without what only says where bytes lie: buffers, views, accessors and images.
    buffer : Buffer
    pictures : list of (str, bytes)    Name and PNG file of every image, in order.

    Returns
    -------
    list of Path    What was written, the named file first.

    Raises
    ------
    FileFormatError    It cannot be written, or is larger than the format allows.
    """
    is_binary = path.suffix.lower() == ".glb"
    images, files = [], []
    for name, data in pictures:
        if is_binary:
            view = buffer.add_picture(data)
            images.append({"name": name, "mimeType": "image/png", "bufferView": view})
        else:
            file = path.with_name(f"{path.stem}_{name}.png")
            images.append({"name": name, "mimeType": "image/png", "uri": quote(file.name)})
            files.append((file, data))
    views, length = buffer.describe()
    described = {"byteLength": length}
    if not is_binary:
        described["uri"] = quote(path.with_suffix(".bin").name)
    content = {
        **content,
        **({"images": images} if images else {}),
        "accessors": buffer.accessors,
        "bufferViews": views,
        "buffers": [described],
    }
    text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()
    if is_binary:
        _write_binary(path, text, buffer, length)
        return [path]
    # The file that names the others comes last.
    for file, data in files:
        with write_whole(file) as stream:
            stream.write(data)
    with write_whole(path.with_suffix(".bin")) as stream:
        buffer.write(stream)
    with write_whole(path) as stream:
        stream.write(text)
    return [path, path.with_suffix(".bin"), *(file for file, _ in files)]


def _write_binary(path: Path, text: bytes, buffer: Buffer, length: int) -> None:
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + length
    if total > LARGEST_BINARY:
        raise FileFormatError(
            path,
            f"a .glb cannot hold {total} bytes, {LARGEST_BINARY} is the most; write a .gltf or fewer objects",
        )
    with write_whole(path) as stream:
        stream.write(struct.pack("<4sII", b"glTF", 2, total))
        stream.write(struct.pack("<I4s", len(text), b"JSON"))
        stream.write(text)
        stream.write(struct.pack("<I4s", length, b"BIN\0"))
        buffer.write(stream)
