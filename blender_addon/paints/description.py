"""Compositions between settings and the JSON that describes them; what panels do not edit goes through unchanged."""

import json
import math
from collections.abc import Callable
from dataclasses import dataclass

from ...engine.paint.composition import Diameters
from ...engine.paint.reader import TILT, known_constituents
from ..compositions.description import is_same, rounded, scaled, to_text

VERSION = 1
"""Of descriptions."""


def describe(settings) -> dict:
    """Return the description of a paint as its settings state it."""
    content = json.loads(settings.content or "{}")
    if settings.name:
        content["name"] = settings.name
    _edit(content, settings, PAINT, content)
    content["layers"] = [_describe_layer(layer) for layer in settings.layers]
    return {"lumenray_paint": VERSION, "name": "Paint", "substrate": {"reflectance": 0.0}} | content


def adopt(settings, content: dict) -> None:
    """Let settings state a paint. ``content``: its description, which has been checked."""
    rest = {name: value for name, value in content.items() if name != "layers"}
    settings.content = to_text(rest)
    settings.name = content.get("name", "")
    _fill(settings, PAINT, content)
    settings.layers.clear()
    for layer in content["layers"]:
        adopt_layer(settings.layers.add(), layer)
    # What makes the effect is looked at first.
    flaky = [number for number, layer in enumerate(content["layers"]) if layer.get("flakes")]
    settings.layer_index = flaky[0] if flaky else 0


def adopt_layer(settings, content: dict) -> None:
    """Let settings state a layer."""
    rest = {name: v for name, v in content.items() if name not in {"flakes", "pigments"}}
    settings.content = to_text(rest)
    settings.name = content.get("name", "")
    _fill(settings, LAYER, content)
    for kind in PARTS:
        group = getattr(settings, kind)
        group.clear()
        for part in content.get(kind, []):
            adopt_part(group.add(), kind, part)


def adopt_part(settings, kind: str, content: dict) -> None:
    """Let settings state ``flakes`` or ``pigments``."""
    settings.content = to_text(content)
    whole = whole_of(content, kind)
    if "amount" in whole:
        ((settings.amount_kind, settings.amount),) = whole["amount"].items()
    _fill(settings, PARTS[kind], whole)


def whole_of(content: dict, kind: str) -> dict:
    """Return what is stated of flakes or pigments, with what their constituent states."""
    named = known_constituents()[kind].get(content.get("constituent"), {})
    return {name: v for name, v in named.items() if name != "source"} | content


def name_of(settings, kind: str) -> str:
    """Return the name of flakes or a pigment for people."""
    content = json.loads(settings.content or "{}")
    return content.get("name") or content.get("constituent") or kind.capitalize()


def states(settings, kind: str, field: str) -> bool:
    """Tell whether a part has what a setting edits."""
    whole = whole_of(json.loads(settings.content or "{}"), kind)
    return "amount" in whole if field == "amount" else PARTS[kind][field].read(whole) is not None


def layer_states(settings, field: str) -> bool:
    """Tell whether a layer has what a setting edits."""
    return LAYER[field].read(json.loads(settings.content or "{}")) is not None


def has_matt_substrate(settings) -> bool:
    """Tell whether one number says what the layers lie on."""
    return PAINT["substrate"].read(json.loads(settings.content or "{}")) is not None


# ---- private ----


@dataclass(frozen=True)
class _Field:
    """A number that a setting edits.

    Parameters
    ----------
    read : callable    From a content to the number, None where it has none.
    write : callable    Changes a content, given the number and the whole with what the constituent states.
    """

    read: Callable
    write: Callable


def _describe_layer(settings) -> dict:
    content = json.loads(settings.content or "{}")
    if settings.name:
        content["name"] = settings.name
    content.setdefault("binder", {"index": settings.binder_index})
    content.setdefault("thickness_um", settings.thickness_um)
    _edit(content, settings, LAYER, content)
    for kind in PARTS:
        content[kind] = [_describe_part(part, kind) for part in getattr(settings, kind)]
    return content


def _describe_part(settings, kind: str) -> dict:
    content = json.loads(settings.content or "{}")
    whole = whole_of(content, kind)
    if "amount" in whole:
        ((name, value),) = whole["amount"].items()
        if name != settings.amount_kind or not is_same(value, settings.amount):
            content["amount"] = {settings.amount_kind: rounded(settings.amount)}
    _edit(content, settings, PARTS[kind], whole)
    return content


def _edit(content: dict, settings, fields: dict, whole: dict) -> None:
    """Change a content where settings differ from what it states."""
    for name, field in fields.items():
        stated, value = field.read(whole), getattr(settings, name)
        if stated is not None and not is_same(stated, value):
            field.write(content, rounded(value), whole)


def _fill(settings, fields: dict, content: dict) -> None:
    for name, field in fields.items():
        value = field.read(content)
        if value is not None:
            setattr(settings, name, value)


def _number(content: dict, name: str, default: float | None = None):
    value = content.get(name, default)
    return value if isinstance(value, int | float) else None


def _degrees(angle: float) -> float:
    return float(f"{math.degrees(angle):.6g}")


def _write_tilt(content, value, _whole):
    content["tilt_deg"] = _degrees(value)


def _set(name: str) -> Callable:
    def write(content, value, _whole):
        content[name] = value

    return write


def _read_diameters(content: dict) -> Diameters:
    stated = content.get("diameter")
    if stated is None:
        return Diameters(0.0)
    if "median_um" in stated:
        return Diameters(stated["median_um"], stated.get("log_spread", 0.0))
    return Diameters.of_mass(*stated["mass_percentiles_um"])


def _write_median(content, value, whole):
    if value <= 0.0:
        content.pop("diameter", None)
        return
    content["diameter"] = {"median_um": value, "log_spread": _read_diameters(whole).log_spread}


def _write_spread(content, value, whole):
    # The median may have been changed just before.
    median = _read_diameters(content if "diameter" in content else whole).median_um
    if median > 0.0:
        content["diameter"] = {"median_um": rounded(median), "log_spread": value}


def _read_core(content):
    return content["stack"]["core"]["thickness_nm"] if "stack" in content else None


def _write_core(content, value, whole):
    own = content.get("stack", whole["stack"])
    content["stack"] = own | {"core": own["core"] | {"thickness_nm": value}}


def _read_coating(content):
    coatings = content.get("stack", {}).get("coatings")
    return coatings[0]["thickness_nm"] if coatings else None


def _write_coating(content, value, whole):
    own = content.get("stack", whole["stack"])
    first, *others = own["coatings"]
    content["stack"] = own | {"coatings": [first | {"thickness_nm": value}, *others]}


def _read_index(content):
    binder = content.get("binder", {})
    return _number(binder, "index") if isinstance(binder, dict) else None


def _write_index(content, value, _whole):
    content["binder"] = content["binder"] | {"index": value}


def _read_dye(content):
    binder = content.get("binder", {})
    return 1.0 if isinstance(binder, dict) and "absorption_per_mm" in binder else None


def _write_dye(content, value, _whole):
    binder = content["binder"]
    content["binder"] = binder | {"absorption_per_mm": scaled(binder["absorption_per_mm"], value)}


def _write_strength(content, value, whole):
    medium = whole["medium"]
    content["medium"] = medium | {"extinction_per_um": scaled(medium["extinction_per_um"], value)}


def _write_substrate(content, value, _whole):
    content["substrate"] = {"reflectance": value}


def _write_peel(content, value, _whole):
    content["surface"] = content.get("surface", {}) | {"orange_peel_slope_deg": _degrees(value)}


PAINT = {
    "substrate": _Field(lambda c: _number(c.get("substrate", {}), "reflectance"), _write_substrate),
    "orange_peel": _Field(
        lambda c: math.radians(_number(c.get("surface", {}), "orange_peel_slope_deg", 0.0)),
        _write_peel,
    ),
}

LAYER = {
    "thickness_um": _Field(lambda c: _number(c, "thickness_um"), _set("thickness_um")),
    "binder_index": _Field(_read_index, _write_index),
    "dye": _Field(_read_dye, _write_dye),
}

FLAKES = {
    "tilt": _Field(lambda c: math.radians(_number(c, "tilt_deg", TILT)), _write_tilt),
    "median_um": _Field(lambda c: _read_diameters(c).median_um, _write_median),
    "log_spread": _Field(lambda c: _read_diameters(c).log_spread, _write_spread),
    "core_nm": _Field(_read_core, _write_core),
    "coating_nm": _Field(_read_coating, _write_coating),
}

PIGMENT = {
    "strength": _Field(lambda c: 1.0 if "medium" in c else None, _write_strength),
}

PARTS = {"flakes": FLAKES, "pigments": PIGMENT}
"""What settings edit of the parts of a layer, by their names in descriptions."""
