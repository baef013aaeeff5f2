"""Options of commands that panels have as settings too: they are called as there."""

import re

import bpy
import pytest
from panels import Drawn, Layout, context, interface

from lumenray.command_line.main import build_parser

pytestmark = pytest.mark.usefixtures("empty_file")

PANELS = (
    "sampling", "film", "passes", "advanced", "lux_bake", "lux_bake_layout", "lux_bake_light", "lux_bake_output",
    "light_mix",
)  # fmt: skip

CLUSTER = ("cluster", "tls-ca", "tls-cert", "tls-key")

OWN = {
    "render": {
        "file", "output", "force", "help", "size", "accept-missing", "mix", "false-colour", "scale-to", "log-scale", "model",
        "tone", "values", *CLUSTER,
    },
    "bake": {
        "file", "output", "force", "help", "objects", "accept-missing", "witness", "resume", "save", "require",
        "requirements", "maintenance", "modified", "model", "arrays", *CLUSTER,
    },
}  # fmt: skip
"""Options that no panel has."""


def names_of_panels():
    """Names in the panels as options have them: with their unit, and without it."""
    found = set()

    class Labelled(Layout):
        def _part(self, heading="", **_):
            found.add(heading)
            return self

        row = column = box = split = _part

        def prop(self, data, name, text=None, **options):
            found.add(text or data.bl_rna.properties[name].name)

    with interface():
        for name in PANELS:
            kind = getattr(bpy.types, f"LUMENRAY_PT_{name}")
            kind.draw(Drawn(kind, Labelled()), context())
    plain = [re.sub(r"[\[\](),.]", "", name) for name in found]
    plain += [re.sub(r" [\[(].*", "", name) for name in found]
    return {name.lower().replace(" ", "-") for name in plain}


@pytest.mark.parametrize("command", OWN)
def test_options_are_called_as_in_the_panels(registered, command):
    bpy.context.scene.render.engine = "LUMENRAY"
    parser = build_parser()._subparsers._group_actions[0].choices[command]
    options = {action.dest.replace("_", "-") for action in parser._actions}
    assert options - names_of_panels() == OWN[command]
