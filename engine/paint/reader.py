"""Files of paints and of their constituents: JSON by the schema in ``libraries/paints``."""

import json
import math
from functools import lru_cache
from pathlib import Path

import numpy as np

from ...libraries import paints
from ..errors import FileFormatError
from ..optical_constants.curves import Curve, Spectrum
from ..optical_constants.quantities import Quantities, find_named, read_pairs
from ..reading.content import read_json
from ..reading.json_schema import SchemaError, check_value
from ..scene.scattering import ScatterTable
from .composition import (
    MEAN_TILT,
    RMS_TILT,
    Amount,
    Binder,
    Diameters,
    Film,
    Flakes,
    Grains,
    Layer,
    Medium,
    Mirror,
    Paint,
    Stack,
    volume_fractions,
)

LARGEST_FILE = 4 << 20
"""[byte]"""

TILT = 5.0
"""Tilt where none is stated. [deg]"""

FLAKE_DENSITY, GRAIN_DENSITY = 3.0, 4.0
"""Density of particles where none is stated. [g/cm3]"""

OPAQUE_THICKNESS = 100.0
"""Thickness of mirrors of which the reflectance alone is stated. [nm]"""

_TILTS = {"slope_per_axis": 1.0, "mean": MEAN_TILT, "rms": RMS_TILT}

_WAYS = {"flakes": {"mirror", "stack"}, "pigments": {"grains", "medium"}}

_KINDS = ("indices", "binders", "flakes", "pigments")


@lru_cache
def schema() -> dict:
    """Return the JSON schema of a composition."""
    return json.loads(paints.SCHEMA.read_text(encoding="utf-8"))


def read_paint(path, constituents: dict | None = None) -> Paint:
    """Read a file of a paint.

    Parameters
    ----------
    path : str or Path
    constituents : dict or None    As `known_constituents` returns them, which also are the default.

    Raises
    ------
    FileFormatError    It cannot be read, or says what cannot be; the text says where.
    """
    return parse_paint(read_json(path, LARGEST_FILE), constituents, path)


def parse_paint(content: dict, constituents: dict | None = None, path="paint") -> Paint:
    """Make a paint of its description, as JSON gives it.

    Parameters
    ----------
    path : str or Path    Named by errors; files that the description names lie beside it.

    Raises
    ------
    FileFormatError    As of `read_paint`.
    """
    parts = known_constituents() if constituents is None else constituents
    try:
        check_value(content, schema())
        content = _filled(content, parts)
        check_value(content, schema())
        return _Maker(parts["indices"], path).paint(content)
    except (SchemaError, ValueError) as error:
        raise FileFormatError(path, str(error)) from None


@lru_cache
def _shipped() -> dict:
    return _read_constituents(paints.CONSTITUENTS)


def known_constituents(paths=()) -> dict[str, dict]:
    """Constituents that ship, and those of users' files, which count where both have a name.

    Returns
    -------
    dict of str to dict    ``indices``, ``binders``, ``flakes`` and ``pigments`` by name, each as it stands in the file.

    Raises
    ------
    FileFormatError    A file cannot be read, or has something else.
    """
    known = {kind: dict(own) for kind, own in _shipped().items()}
    for path in paths:
        for kind, own in _read_constituents(path).items():
            known[kind] |= own
    return known


def settle_names(content: dict, constituents: dict) -> dict:
    """A description, as `Paint` keeps it, that needs no other constituents than those that ship.

    Parameters
    ----------
    constituents : dict    As `known_constituents` returns them, by which it was read.
    """
    own = _beside_shipped(constituents)
    layers = []
    for layer in content["layers"]:
        parts = {
            kind: [_settled(each, own, kind) for each in layer.get(kind, [])]
            for kind in ("flakes", "pigments")
        }
        layers.append(layer | parts | {"binder": _with_indices(layer["binder"], own["indices"])})
    return content | {"layers": layers}


def _beside_shipped(constituents: dict) -> dict[str, dict]:
    """Constituents that do not ship, or stand for others."""
    return {
        kind: {name: each for name, each in own.items() if _shipped()[kind].get(name) != each}
        for kind, own in constituents.items()
    }


def _settled(part: dict, own: dict, kind: str) -> dict:
    if part.get("constituent") in own[kind]:
        part = {name: value for name, value in part.items() if name != "constituent"}
    return _with_indices(part, own["indices"])


def _with_indices(value, indices: dict):
    """A description's part with indices in the places of their names."""
    if isinstance(value, list):
        return [_with_indices(each, indices) for each in value]
    if not isinstance(value, dict):
        return value
    made = {name: _with_indices(each, indices) for name, each in value.items()}
    while isinstance(made.get("index"), str) and made["index"] in indices:
        made["index"] = indices[made["index"]]["index"]
    return made


def _read_constituents(path) -> dict[str, dict]:
    content = read_json(path, LARGEST_FILE)
    try:
        check_value(content, schema() | schema()["$defs"]["constituents"])
    except SchemaError as error:
        raise FileFormatError(path, str(error)) from None
    return {kind: content.get(kind, {}) for kind in _KINDS}


def _filled(content: dict, parts: dict) -> dict:
    """A description with what its constituents state in their places."""
    layers = []
    for number, layer in enumerate(content["layers"]):
        own = dict(layer)
        if isinstance(layer["binder"], str):
            own["binder"] = find_named(
                parts["binders"], "binders", layer["binder"], f"layers[{number}].binder"
            )
        for kind in ("flakes", "pigments"):
            own[kind] = [
                _merged(parts, kind, each, f"layers[{number}].{kind}[{k}]")
                for k, each in enumerate(layer.get(kind, []))
            ]
        layers.append(own)
    return content | {"layers": layers}


def _merged(parts: dict, kind: str, own: dict, place: str) -> dict:
    group = _WAYS[kind]
    whole = own
    if "constituent" in own:
        named = find_named(parts[kind], kind, own["constituent"], place)
        # Of things that exclude each other the own one counts.
        named = {
            name: value
            for name, value in named.items()
            if not (name in group and group & own.keys())
        }
        whole = {"name": own["constituent"]} | named | own
    if len(group & whole.keys()) != 1:
        raise ValueError(f"{place} needs one of {' and '.join(sorted(group))}")
    if "grains" in whole and "amount" not in whole:
        raise ValueError(f"{place} lacks 'amount'")
    return whole


class _Maker(Quantities):
    """Makes a paint of a checked description without constituents left out."""

    def paint(self, content: dict) -> Paint:
        layers = tuple(self.layer(own, f"layers[{k}]") for k, own in enumerate(content["layers"]))
        peel = content.get("surface", {}).get("orange_peel_slope_deg", 0.0)
        texts = (content.get(name, "") for name in ("name", "description", "source"))
        return Paint(
            layers,
            self.substrate(content["substrate"]),
            math.tan(math.radians(peel)),
            *texts,
            content,
        )

    def substrate(self, content: dict) -> Spectrum | ScatterTable:
        if "reflectance" in content:
            return self.spectrum(content["reflectance"], "substrate.reflectance", most=1.0)
        # Readers of scattering are many, and most paints need none.
        from ..scattering.readers.reader import read_scattering

        path = Path(self.path).parent / content["table"]
        side = read_scattering(path).sides.get("front_reflection")
        if not isinstance(side, ScatterTable) or not side.is_isotropic:
            raise ValueError(f"substrate.table: {path.name} has no isotropic reflection as a table")
        return side

    def layer(self, content: dict, place: str) -> Layer:
        layer = Layer(
            float(content["thickness_um"]),
            self.binder(content["binder"], f"{place}.binder"),
            tuple(
                self.flakes(own, f"{place}.flakes[{k}]") for k, own in enumerate(content["flakes"])
            ),
            tuple(
                self.pigment(own, f"{place}.pigments[{k}]")
                for k, own in enumerate(content["pigments"])
            ),
            content.get("name", ""),
        )
        try:
            volume_fractions(layer)
        except ValueError as error:
            raise ValueError(f"{place}: {error}") from None
        return layer

    def binder(self, content: dict, place: str) -> Binder:
        index = self.index(content["index"], f"{place}.index")
        absorption = self.spectrum(
            content.get("absorption_per_mm", 0.0), f"{place}.absorption_per_mm"
        )
        absorption = Curve(absorption.wavelengths, absorption.values * 1e-3)
        return Binder(index, absorption, float(content.get("density_g_per_cm3", 1.0)))

    def flakes(self, content: dict, place: str) -> Flakes:
        if "mirror" in content:
            own, where = content["mirror"], f"{place}.mirror"
            thickness = own.get("thickness_nm", OPAQUE_THICKNESS)
            if "reflectance" in own:
                optics = Mirror(
                    self.spectrum(own["reflectance"], f"{where}.reflectance", most=1.0),
                    self.spectrum(
                        own.get("transmittance", 0.0), f"{where}.transmittance", most=1.0
                    ),
                )
                bands = np.union1d(optics.reflectance.wavelengths, optics.transmittance.wavelengths)
                if (
                    optics.reflectance.at(bands) + optics.transmittance.at(bands)
                ).max() > 1.0 + 1e-9:
                    raise ValueError(f"{where} reflects and lets pass more than comes")
            else:
                optics = Stack(Film(self.index(own["index"], f"{where}.index"), thickness))
        else:
            optics = self.stack(content["stack"], f"{place}.stack")
            thickness = optics.thickness_nm
        tilt = content.get("tilt_deg", TILT) / _TILTS[content.get("tilt_measure", "slope_per_axis")]
        return Flakes(
            optics,
            _amount(content["amount"]),
            math.radians(tilt),
            float(content.get("density_g_per_cm3", FLAKE_DENSITY)),
            float(thickness),
            _diameters(content["diameter"], f"{place}.diameter", 2)
            if "diameter" in content
            else None,
            content.get("name", ""),
        )

    def stack(self, content: dict, place: str) -> Stack:
        films = [
            Film(self.index(own["index"], f"{place}.{where}.index"), float(own["thickness_nm"]))
            for where, own in (
                ("core", content["core"]),
                *((f"coatings[{k}]", own) for k, own in enumerate(content.get("coatings", []))),
            )
        ]
        return Stack(films[0], tuple(films[1:]), content["core"].get("thickness_spread", 0.0))

    def pigment(self, content: dict, place: str) -> Grains | Medium:
        name = content.get("name", "")
        if "grains" in content:
            if "area_per_volume_per_um" in content["amount"]:
                raise ValueError(f"{place}.amount: an area by volume is that of flakes alone")
            own, where = content["grains"], f"{place}.grains"
            return Grains(
                self.index(own["index"], f"{where}.index"),
                _diameters(own["diameter"], f"{where}.diameter", 3),
                _amount(content["amount"]),
                float(content.get("density_g_per_cm3", GRAIN_DENSITY)),
                name,
            )
        own, where = content["medium"], f"{place}.medium"
        phase = None
        if "phase_angles_deg" in own:
            angles, values = read_pairs(
                own["phase_angles_deg"], own["phase_values"], f"{where}.phase_values"
            )
            phase = Curve(np.radians(angles), values)
            if not values.any():
                raise ValueError(f"{where}.phase_values are all 0")
        return Medium(
            self.spectrum(own["extinction_per_um"], f"{where}.extinction_per_um"),
            self.spectrum(own["albedo"], f"{where}.albedo", most=1.0),
            float(own.get("asymmetry", 0.0)),
            phase,
            name,
        )


def _amount(content: dict) -> Amount:
    ((kind, value),) = content.items()
    return Amount(kind, float(value))


def _diameters(content: dict, place: str, power: int) -> Diameters:
    if "median_um" in content:
        return Diameters(float(content["median_um"]), float(content.get("log_spread", 0.0)))
    sizes = [float(each) for each in content["mass_percentiles_um"]]
    if not sizes[0] < sizes[1] < sizes[2]:
        raise ValueError(f"{place}.mass_percentiles_um do not ascend")
    return Diameters.of_mass(*sizes, power=power)
