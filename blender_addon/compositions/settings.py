"""Properties that settings of compositions share."""

from collections.abc import Callable

from bpy.props import EnumProperty, FloatVectorProperty, StringProperty

from ..foundation.settings import tag_owner


def content_property():
    """What a description states beside what panels edit, as JSON text."""
    return StringProperty(description="What else the description states", options={"HIDDEN"})


def quality_property(of_draft: str, of_final: str):
    """How finely tables are computed."""
    return EnumProperty(
        name="Quality",
        description="How finely the table is computed. Default Draft: for a look, in seconds to minutes",
        items=[("DRAFT", "Draft", of_draft), ("FINAL", "Final", of_final)],
        default="DRAFT",
        update=tag_owner,
    )


def swatch_property(title: str, description: str, find: Callable):
    """Colour that is read of a table; ``find`` gives it of the settings."""
    return FloatVectorProperty(
        name=title, description=description, subtype="COLOR", size=3, min=0.0, max=1.0, get=find
    )
