"""Names in panels, operators and the guide: written as Blender writes its own, and the same everywhere."""

import ast
import re

import bpy
import pytest
from folders import ROOT

from lumenray import operators, ui
from lumenray.blender_addon import feedback, preferences, properties, readout

GROUPS = (*properties.CLASSES, *preferences.CLASSES, *feedback.CLASSES)

OPERATORS = [kind for kind in operators.CLASSES if issubclass(kind, bpy.types.Operator)]

SMALL = {"cm", "for"}
"""What is small in names beside what labels of figures have."""


def check_title(name, where):
    words = " ".join(word for word in name.split(" ") if word not in SMALL)
    assert readout.title_case(words) == words, f"{where}: '{name}'"


def check_titles(entries):
    """Check the names of settings, and of what they can be chosen to be."""
    for entry in entries:
        is_group = entry.type in {"POINTER", "COLLECTION"}
        # Blender calls what has no name by its identifier: files of operators, which its browser shows.
        if entry.name == entry.identifier or is_group or entry.is_hidden:
            continue
        check_title(entry.name, entry.identifier)
        for item in entry.enum_items if entry.type == "ENUM" else ():
            check_title(item.name, entry.identifier)


@pytest.mark.parametrize("group", GROUPS, ids=lambda group: group.__name__)
def test_names_of_settings_are_written_as_blender_writes_its_own(group):
    check_titles(entry for entry in group.bl_rna.properties if entry.identifier != "name")


@pytest.mark.parametrize("kind", OPERATORS, ids=lambda kind: kind.bl_idname)
def test_names_of_operators_and_their_settings_are_written_as_blender_writes_its_own(kind):
    check_title(kind.bl_label, kind.bl_idname)
    made = getattr(bpy.ops.lumenray, kind.bl_idname.partition(".")[2])
    entries = made.get_rna_type().properties
    assert {entry.identifier for entry in entries} >= set(kind.__annotations__)
    check_titles(entries)


LABELS = {"prop": "text", "operator": "text", "row": "heading", "column": "heading"}


def test_labels_in_panels_are_written_as_blender_writes_its_own():
    """Texts that panels and preferences put in place of the names of settings and operators."""
    count = 0
    for path in (*(ROOT / "ui").glob("*.py"), ROOT / "blender_addon" / "preferences.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)):
                continue
            for word in node.keywords:
                if word.arg == LABELS.get(node.func.attr) and isinstance(word.value, ast.Constant):
                    check_title(word.value.value, f"{path.name}:{node.lineno}")
                    count += 1
    assert count > 50
    for kind in ui.CLASSES:
        check_title(getattr(kind, "bl_label", ""), kind.__name__)


BLENDERS = {
    "Add",
    "Adjust Last Operation",
    "Background Images",
    "Camera",
    "Deformation",
    "Developer Extras",
    "Environment Texture",
    "Extensions",
    "Get Extensions",
    "IES Texture",
    "Install from Disk",
    "Interface",
    "Mapping",
    "Motion Blur",
    "Position",
    "Preferences",
    "Ray Visibility",
    "Render",
    "Rendered",
    "Shadow Catcher",
    "Shape",
    "Show Emitter",
    "Shutter",
    "Sidebar",
    "Standard",
    "Sky Texture",
    "Strands",
    "View Layer",
    "Volume Absorption",
    "Volume Coefficients",
}
"""Names in the guide that are Blender's own."""

EMPHASIS = {
    "Lux maps",
    "Pictures and sensors",
    "The same at all",
    "Uneven sides",
    "isotropic",
    "orthotropic",
    "second witness",
}
"""What the guide stresses, and what panels say of a file."""


def test_names_in_the_guide_are_those_of_the_interface():
    guide = "".join(
        (ROOT / "docs" / name).read_text(encoding="utf-8")
        for name in ("guide.md", "first_hour.md", "light_mix.md")
    )
    plain = re.sub(r"```.*?```|`[^`]*`|\*\*|\\\*", "", guide, flags=re.DOTALL)
    starred = [" ".join(name.split()) for name in re.findall(r"\*([^*]+)\*", plain)]
    assert len(starred) > 100
    names = {name for path in starred for name in path.split(" > ")}
    known = {
        node.value
        for folder in ("ui", "operators", "blender_addon")
        for path in (ROOT / folder).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }
    assert names - known - BLENDERS - EMPHASIS == set()
    # The lists are short: what the guide does not say, or the source does, is not on them.
    assert (BLENDERS | EMPHASIS) - names == set()
