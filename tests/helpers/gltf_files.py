"""A reader of glTF files that shares nothing with the writer, and holds them against the specification."""

import json
import struct
from io import BytesIO
from pathlib import Path
from urllib.parse import unquote

import numpy as np
from PIL import Image

TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class GltfFile:
    """A file's content with its bytes."""

    def __init__(self, path):
        path = Path(path)
        data = path.read_bytes()
        if path.suffix == ".glb":
            magic, version, length = struct.unpack("<4sII", data[:12])
            assert (magic, version, length) == (b"glTF", 2, len(data))
            chunks, at = [], 12
            while at < length:
                size, kind = struct.unpack("<I4s", data[at : at + 8])
                assert size % 4 == 0
                chunks.append((kind, data[at + 8 : at + 8 + size]))
                at += 8 + size
            assert [kind for kind, _ in chunks] == [b"JSON", b"BIN\0"]
            self.json, self.bytes = json.loads(chunks[0][1]), chunks[1][1]
            assert "uri" not in self.json["buffers"][0]
        else:
            self.json = json.loads(data)
            self.bytes = (path.parent / unquote(self.json["buffers"][0]["uri"])).read_bytes()
        self.folder = path.parent

    def view(self, number):
        """Bytes of a view."""
        view = self.json["bufferViews"][number]
        start = view["byteOffset"]
        assert view["buffer"] == 0
        assert start % 4 == 0
        assert (
            start + view["byteLength"] <= self.json["buffers"][0]["byteLength"] <= len(self.bytes)
        )
        return self.bytes[start : start + view["byteLength"]]

    def array(self, number):
        """Numbers of an accessor, (n,) or (n, c)."""
        accessor = self.json["accessors"][number]
        dtype, width = np.dtype(TYPES[accessor["componentType"]]), WIDTHS[accessor["type"]]
        view = self.json["bufferViews"][accessor["bufferView"]]
        start, step = accessor["byteOffset"], dtype.itemsize * width
        assert view.get("byteStride", step) == step
        assert start % 4 == 0
        end = start + step * accessor["count"]
        assert accessor["count"] > 0
        assert end <= view["byteLength"]
        values = np.frombuffer(self.view(accessor["bufferView"])[start:end], dtype)
        return values if width == 1 else values.reshape(-1, width)

    def picture(self, number):
        """Picture of a texture."""
        image = self.json["images"][self.json["textures"][number]["source"]]
        assert image["mimeType"] == "image/png"
        if "bufferView" in image:
            return Image.open(BytesIO(self.view(image["bufferView"])))
        return Image.open(self.folder / unquote(image["uri"]))

    def primitives(self):
        """Yield every node with each of its primitives."""
        for node in self.json["nodes"]:
            for primitive in self.json["meshes"][node["mesh"]]["primitives"]:
                yield node, primitive

    def corners(self, node, primitive):
        """World places (t, 3, 3) of a primitive's corners in double precision, and their texture coordinates or None."""
        index = self.array(primitive["indices"])
        places = self.array(primitive["attributes"]["POSITION"]).astype(np.float64)
        places = (places + np.array(node["translation"]))[index].reshape(-1, 3, 3)
        if "TEXCOORD_0" not in primitive["attributes"]:
            return places, None
        return places, self.array(primitive["attributes"]["TEXCOORD_0"])[index].reshape(-1, 3, 2)

    def material(self, primitive, variant=None):
        """Material of a primitive, in a variant by its name."""
        number = primitive["material"]
        if variant is not None:
            names = [
                v["name"] for v in self.json["extensions"]["KHR_materials_variants"]["variants"]
            ]
            extension = primitive.get("extensions", {}).get("KHR_materials_variants", {})
            for mapping in extension.get("mappings", []):
                if names.index(variant) in mapping["variants"]:
                    number = mapping["material"]
        return self.json["materials"][number]

    def check(self):
        """Hold the file against glTF 2.0."""
        content = self.json
        assert content["asset"]["version"] == "2.0"
        used = set(content["extensionsUsed"])
        assert used >= {"KHR_materials_unlit"}
        assert sorted(content["scenes"][content["scene"]]["nodes"]) == list(
            range(len(content["nodes"]))
        )
        for view in range(len(content["bufferViews"])):
            self.view(view)
        for node, primitive in self.primitives():
            assert set(node) <= {"name", "mesh", "translation", "extras"}
            attributes = primitive["attributes"]
            counts = {content["accessors"][n]["count"] for n in attributes.values()}
            assert len(counts) == 1
            index = self.array(primitive["indices"])
            accessor = content["accessors"][primitive["indices"]]
            assert index.ndim == 1
            assert len(index) % 3 == 0
            assert accessor["componentType"] in (5123, 5125)
            # The highest index would restart the primitive.
            assert index.max() < min(counts.pop(), np.iinfo(index.dtype).max)
            places = self.array(attributes["POSITION"])
            bounds = content["accessors"][attributes["POSITION"]]
            assert np.array_equal(places.min(axis=0), bounds["min"])
            assert np.array_equal(places.max(axis=0), bounds["max"])
            if "NORMAL" in attributes:
                length = np.linalg.norm(self.array(attributes["NORMAL"]), axis=1)
                assert np.allclose(length, 1.0, atol=1e-5)
            numbers = [primitive["material"]]
            extension = primitive.get("extensions", {}).get("KHR_materials_variants", {})
            numbers += [m["material"] for m in extension.get("mappings", [])]
            for number in numbers:
                self._check_material(content["materials"][number], "TEXCOORD_0" in attributes)
        for number, texture in enumerate(content.get("textures", [])):
            assert texture["sampler"] < len(content["samplers"])
            self.picture(number).load()

    def _check_material(self, material, has_places):
        shading = material["pbrMetallicRoughness"]
        assert all(0.0 <= v <= 1.0 for v in shading["baseColorFactor"])
        assert "KHR_materials_unlit" in material["extensions"]
        if "baseColorTexture" in shading:
            assert has_places
            assert shading["baseColorTexture"]["index"] < len(self.json["textures"])
