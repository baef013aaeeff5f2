"""Compositions between settings and the JSON that describes them; what panels do not edit goes through unchanged."""

import json

from ..compositions.description import is_same, read, rounded, to_text, write

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
        stated, value = read(content, path), getattr(settings, name)
        if layer_states(settings, name) and not is_same(stated, value):
            write(content, path, rounded(value))
    content["pigments"] = [_describe_pigment(each) for each in settings.pigments]
    return content


def adopt(settings, content: dict) -> None:
    """Let settings state a layer. ``content``: its description, which has been checked."""
    settings.content = to_text({k: v for k, v in content.items() if k != "pigments"})
    settings.name = content.get("name", "")
    for name, path in LAYER.items():
        if layer_states(settings, name):
            setattr(settings, name, read(content, path))
    settings.pigments.clear()
    for pigment in content.get("pigments", []):
        own = settings.pigments.add()
        own.content = to_text(pigment)
        for name, fallback in PIGMENT.items():
            setattr(own, name, pigment.get(name, fallback))


def layer_states(settings, name: str) -> bool:
    """Tell whether one number states what a setting edits, and not a table or a name."""
    stated = read(
        FALLBACK | {"substrate": {"reflectance": 0.9}} | json.loads(settings.content or "{}"),
        LAYER[name],
    )
    return isinstance(stated, int | float)


def name_of(pigment) -> str:
    """Return the name of a pigment for people."""
    return json.loads(pigment.content or "{}").get("name") or "Pigment"


def _describe_pigment(settings) -> dict:
    content = {"index": 1.4} | json.loads(settings.content or "{}")
    for name, fallback in PIGMENT.items():
        value, stated = getattr(settings, name), content.get(name, fallback)
        if not is_same(stated, value):
            content[name] = rounded(value)
    content.setdefault("volume_fraction", 0.0)
    return content
