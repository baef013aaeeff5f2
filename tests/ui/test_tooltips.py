"""Every setting and every operator says what it means, its unit, and why its default is what it is."""

import math
import re

import bpy
import pytest
from panels import interface

from lumenray import operators
from lumenray.blender_addon import feedback, preferences, properties, shown_lights
from lumenray.blender_addon.bake import tables


@pytest.fixture(scope="module", autouse=True)
def _interface(registered):
    with interface():
        yield


STATES = (*feedback.CLASSES, *shown_lights.CLASSES, *tables.CLASSES)
"""What Lumenray tells; nobody sets it, so that its defaults need no reason."""

SETTINGS = tuple(
    group for group in (*properties.CLASSES, *preferences.CLASSES) if group not in STATES
)
OPERATORS = tuple(kind for kind in operators.CLASSES if issubclass(kind, bpy.types.Operator))

UNITLESS = {"ANGLE", "COLOR", "DISTANCE", "PERCENTAGE", "TRANSLATION"}
"""Subtypes of numbers that Blender shows with their unit, or that need none."""

UNIT = re.compile(
    r"\b(cd/m²|W/m²|lx|lm|lumens|kelvins|metres?|millimetres|micrometres|nm|GiB|seconds|minutes|hours|year|pixels|lumels|shares?|factor"
    r"|index|0 to 1|exposure value|number|in units of Blender|in its unit|the unit of the quantity|the unit of the row)\b"
    r"|µm²",
    re.IGNORECASE,
)

DEFAULT = re.compile(r"Default (?P<value>.+): (?P<reason>[^:]+)$")

BLENDERS = {"remove_name", "remove_active"}
"""Settings of Blender's own operator of presets."""


def entries(kinds):
    """Give the settings of groups and operators that people meet, each with the name of its owner."""
    for kind in kinds:
        rna = kind.bl_rna
        if issubclass(kind, bpy.types.Operator):
            rna = getattr(bpy.ops.lumenray, kind.bl_idname.partition(".")[2]).get_rna_type()
        names = {name for base in kind.__mro__ for name in vars(base).get("__annotations__", {})}
        for entry in rna.properties:
            is_group = entry.type == "POINTER" and entry.is_readonly
            is_list = entry.type == "COLLECTION" and kind not in OPERATORS
            if entry.identifier in names - BLENDERS and not (
                entry.is_hidden or is_group or is_list
            ):
                yield f"{kind.__name__}.{entry.identifier}", entry


def shown_default(entry):
    """Return the default of a setting as people see it; None: it has none of its own that needs a reason."""
    if entry.type == "BOOLEAN":
        return "on" if entry.default else "off"
    if entry.type == "ENUM":
        return entry.enum_items[entry.default].name
    if entry.type in {"INT", "FLOAT"} and not entry.is_array:
        return math.degrees(entry.default) if entry.subtype == "ANGLE" else entry.default
    return None


def says(text: str, default) -> bool:
    if isinstance(default, str):
        return text == default
    number = re.fullmatch(r"([\d.]+)°?", text)
    return number is not None and float(number[1]) == pytest.approx(default, rel=0.01, abs=1e-9)


def test_everything_is_described_in_some_words_and_without_a_full_stop():
    bad = {
        where: entry.description
        for where, entry in entries((*STATES, *SETTINGS, *OPERATORS))
        if len(entry.description.split()) < 4
        or entry.description.endswith(".")
        or not re.match(r"[A-Z0-9]", entry.description)
    }
    assert bad == {}


def test_every_operator_says_what_it_does():
    for kind in OPERATORS:
        text = (
            getattr(bpy.ops.lumenray, kind.bl_idname.partition(".")[2]).get_rna_type().description
        )
        assert len(text.split()) >= 6, kind.bl_idname
        assert not text.endswith("."), kind.bl_idname
        assert text != kind.bl_label, kind.bl_idname


def test_every_number_says_its_unit():
    bad = {
        where: entry.description
        for where, entry in entries((*STATES, *SETTINGS, *OPERATORS))
        if entry.type in {"INT", "FLOAT"} and entry.subtype not in UNITLESS
        if not (entry.identifier.endswith("_index") or UNIT.search(entry.description))
    }
    # Where new luminaires shine to is a direction.
    assert set(bad) == {"LUMENRAY_OT_drop_luminaire.normal"}


def test_every_default_is_stated_with_its_reason():
    bad = {}
    for where, entry in entries((*SETTINGS, *OPERATORS)):
        default = shown_default(entry)
        # What is computed when it is read, such as a share in per cent, has the default of what it is computed from.
        is_computed = "get" in _keywords(where)
        if default is None or is_computed or entry.identifier.endswith("_index"):
            continue
        said = DEFAULT.search(entry.description)
        if said is None or not says(said["value"], default) or len(said["reason"].split()) < 2:
            bad[where] = (default, entry.description)
    assert bad == {}


def test_shares_in_per_cent_have_the_default_of_the_share():
    for group in (properties.LumenrayBakeSettings, properties.LumenrayRenderSettings):
        rna = group.bl_rna.properties
        said = DEFAULT.search(rna["error_percent"].description)
        assert said["value"] == f"{100.0 * rna['error'].default:.3g} %"


def _keywords(where: str) -> dict:
    """Return what a setting was declared with."""
    owner, _, name = where.partition(".")
    kind = next(kind for kind in (*SETTINGS, *OPERATORS) if kind.__name__ == owner)
    declared = next(
        vars(base)["__annotations__"][name]
        for base in kind.__mro__
        if name in vars(base).get("__annotations__", {})
    )
    return declared.keywords


@pytest.mark.parametrize(
    ("text", "default", "expected"),
    [("off", "off", True), ("on", "off", False), ("57°", 57.29, True), ("5", 8.0, False)],
)
def test_says_tells_a_wrong_default(text, default, expected):
    assert says(text, default) is expected
