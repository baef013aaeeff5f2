"""Compositions between settings and the JSON that describes them; what panels do not edit goes through unchanged."""

import hashlib
import json
import math

SAME = 1e-6
"""Relative difference up to which a number is the one that was stated: settings hold single precision."""

LAYER = {
    "thickness_um": ("thickness_um",),
    "binder_index": ("binder", "index"),
    "substrate": ("substrate", "reflectance"),
}
"""What settings edit of a layer, and where it stands in a description."""

PIGMENT = {"volume_fraction": 0.0, "median_um": 0.0, "log_spread": 0.0, "shape": "sphere"}
"""What settings edit of a pigment, and what counts where nothing is stated."""

FALLBACK = {"lumenray_ink": 1, "name": "Print", "thickness_um": 1.0, "binder": {"index": 1.558}}
"""Of what a description has to state."""


def describe(settings) -> dict:
    """Return the description of a layer as its settings state it."""
    content = FALLBACK | {"substrate": {"reflectance": 0.9}} | json.loads(settings.content or "{}")
    if settings.name:
        content["name"] = settings.name
    for name, path in LAYER.items():
        stated, value = _read(content, path), getattr(settings, name)
        if layer_states(settings, name) and not _is_same(stated, value):
            _write(content, path, _rounded(value))
    content["pigments"] = [_describe_pigment(each) for each in settings.pigments]
    return content


def adopt(settings, content: dict) -> None:
    """Let settings state a layer. ``content``: its description, which has been checked."""
    settings.content = to_text({k: v for k, v in content.items() if k != "pigments"})
    settings.name = content.get("name", "")
    for name, path in LAYER.items():
        if layer_states(settings, name):
            setattr(settings, name, _read(content, path))
    settings.pigments.clear()
    for pigment in content.get("pigments", []):
        own = settings.pigments.add()
        own.content = to_text(pigment)
        for name, fallback in PIGMENT.items():
            setattr(own, name, pigment.get(name, fallback))


def layer_states(settings, name: str) -> bool:
    """Tell whether one number states what a setting edits, and not a table or a name."""
    stated = _read(
        FALLBACK | {"substrate": {"reflectance": 0.9}} | json.loads(settings.content or "{}"),
        LAYER[name],
    )
    return isinstance(stated, int | float)


def name_of(pigment) -> str:
    """Return the name of a pigment for people."""
    return json.loads(pigment.content or "{}").get("name") or "Pigment"


def to_text(content: dict) -> str:
    """Return a description as JSON text, the same for the same content."""
    return json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False)


def digest_of(content: dict, quality: str) -> str:
    """Return SHA-256 of a description and how finely it is solved, in hexadecimal."""
    return hashlib.sha256(f"{quality} {to_text(content)}".encode()).hexdigest()


def _describe_pigment(settings) -> dict:
    content = {"index": 1.4} | json.loads(settings.content or "{}")
    for name, fallback in PIGMENT.items():
        value, stated = getattr(settings, name), content.get(name, fallback)
        if not _is_same(stated, value):
            content[name] = _rounded(value)
    content.setdefault("volume_fraction", 0.0)
    return content


def _read(content: dict, path):
    for name in path:
        content = content.get(name) if isinstance(content, dict) else None
    return content


def _write(content: dict, path, value) -> None:
    if len(path) == 1:
        content[path[0]] = value
    else:
        content[path[0]] = content[path[0]] | {path[1]: value}


def _is_same(stated, value) -> bool:
    if isinstance(value, str):
        return stated == value
    return math.isclose(stated, value, rel_tol=SAME, abs_tol=1e-12)


def _rounded(value):
    """A number of single precision as people would write it."""
    return value if isinstance(value, str) else float(f"{value:.7g}")
