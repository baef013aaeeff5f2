"""Compositions between settings and the JSON that describes them; what panels do not edit goes through unchanged."""

import json
import math

from ...engine.cloth.reader import INDEX, ROUGHNESS
from ..compositions.description import is_same, read, rounded, scaled, to_text, write

YARN = {
    "width_mm": (("width_mm",), 0.2),
    "height_mm": (("height_mm",), None),
    "index": (("index",), INDEX),
    "roughness": (("roughness",), ROUGHNESS),
    "scattering": (("scatterers", 0, "volume_fraction"), None),
}
"""What settings edit of a yarn, where it stands in a description, and what counts where nothing is stated; None: nothing."""

PILE = {"pile_height_mm": "height_mm", "density_per_mm2": "density_per_mm2"}
"""What settings edit of a pile, and where it stands."""

PITCHES = ("warp_pitch_mm", "weft_pitch_mm")

SIMPLEST = {"width_mm": 0.2}

FALLBACK = {
    "lumenray_cloth": 1,
    "name": "Cloth",
    "warp": SIMPLEST,
    "weft": SIMPLEST,
    "weave": {"pattern": "plain", "warp_pitch_mm": 0.25, "weft_pitch_mm": 0.25},
}
"""Of what a description has to state."""


def describe(settings) -> dict:
    """Return the description of a cloth as its settings state it."""
    content = FALLBACK | json.loads(settings.content or "{}")
    if settings.name:
        content["name"] = settings.name
    content["weave"] = _describe_weave(settings, content["weave"])
    content["warp"] = _describe_yarn(settings.warp)
    content["weft"] = (
        dict(content["warp"]) if settings.is_weft_as_warp else _describe_yarn(settings.weft)
    )
    if "pile" in content:
        pile = dict(content["pile"])
        for name, place in PILE.items():
            _edit(pile, (place,), getattr(settings, name))
        if not is_same(pile.get("lean_deg", 0.0), _degrees(settings.lean)):
            pile["lean_deg"] = _degrees(settings.lean)
        content["pile"] = pile | {"yarn": _describe_yarn(settings.pile_yarn)}
    return content


def adopt(settings, content: dict) -> None:
    """Let settings state a cloth. ``content``: its description, which has been checked and names no other file."""
    rest = {name: value for name, value in content.items() if name not in {"warp", "weft"}}
    if "pile" in rest:
        rest["pile"] = {name: value for name, value in rest["pile"].items() if name != "yarn"}
        for name, place in PILE.items():
            setattr(settings, name, rest["pile"][place])
        settings.lean = math.radians(rest["pile"].get("lean_deg", 0.0))
        _adopt_yarn(settings.pile_yarn, content["pile"]["yarn"])
    settings.content = to_text(rest)
    settings.name = content.get("name", "")
    _adopt_yarn(settings.warp, content["warp"])
    _adopt_yarn(settings.weft, content["weft"])
    settings.is_weft_as_warp = content["weft"] == content["warp"]
    weave = content["weave"]
    for name in PITCHES:
        setattr(settings, name, weave[name])
    settings.weave = next(kind for kind, states in KINDS.items() if states(weave))
    if "twill" in weave:
        settings.twill_over, settings.twill_under = map(int, weave["twill"])
    if "satin" in weave:
        settings.satin_ends, settings.satin_step = (
            int(weave["satin"][n]) for n in ("ends", "step")
        )


KINDS = {
    "PLAIN": lambda weave: "pattern" in weave,
    "TWILL": lambda weave: "twill" in weave,
    "SATIN": lambda weave: "satin" in weave,
    "OWN": lambda weave: True,
}
"""Kinds of weaves by the names of settings, and whether a description states one, the first that does."""


def has_pile(settings) -> bool:
    """Tell whether a cloth has a pile."""
    return "pile" in json.loads(settings.content or "{}")


def has_own_pattern(settings) -> bool:
    """Tell whether a cloth's description draws its weave crossing by crossing."""
    return "rows" in json.loads(settings.content or "{}").get("weave", {})


def yarn_states(settings, name: str) -> bool:
    """Tell whether a yarn has what a setting edits."""
    content = json.loads(settings.content or "{}")
    if name == "dye":
        return _has_dye(content)
    return name != "scattering" or read(content, YARN[name][0]) is not None


def _describe_weave(settings, stated: dict) -> dict:
    weave = dict(stated)
    for name in PITCHES:
        _edit(weave, (name,), getattr(settings, name))
    own = {
        "PLAIN": {"pattern": "plain"},
        "TWILL": {"twill": [settings.twill_over, settings.twill_under]},
        "SATIN": {"satin": {"ends": settings.satin_ends, "step": settings.satin_step}},
    }.get(settings.weave)
    # A description without rows is no weave of its own, whatever the settings say.
    if own is None and "rows" in weave:
        return weave
    return {name: weave[name] for name in PITCHES} | (own or {"pattern": "plain"})


def _describe_yarn(settings) -> dict:
    content = SIMPLEST | json.loads(settings.content or "{}")
    if yarn_states(settings, "dye") and not is_same(settings.dye, 1.0):
        content["absorption_per_mm"] = scaled(content["absorption_per_mm"], settings.dye)
    for name, (path, fallback) in YARN.items():
        value = getattr(settings, name)
        if name == "height_mm":
            # Round where nothing is stated.
            fallback = settings.width_mm  # noqa: PLW2901
        if yarn_states(settings, name):
            _edit(content, path, value, fallback)
    return content


def _adopt_yarn(settings, content: dict) -> None:
    settings.content, settings.dye = to_text(content), 1.0
    for name, (path, fallback) in YARN.items():
        value = read(content, path)
        if value is None:
            value = content["width_mm"] if name == "height_mm" else fallback
        if value is not None:
            setattr(settings, name, value)


def _has_dye(content: dict) -> bool:
    return content.get("absorption_per_mm", 0.0) != 0.0


def _edit(content: dict, path: tuple, value, fallback=None) -> None:
    """Change a description where a setting differs from what it states."""
    stated = read(content, path)
    if not is_same(fallback if stated is None else stated, value):
        write(content, path, rounded(value))


def _degrees(angle: float) -> float:
    return float(f"{math.degrees(angle):.6g}")
