"""What settings of files that can be embedded have in common."""

import bpy
from bpy.props import PointerProperty

from ..foundation.settings import tag_owner

LIGHT_TYPES = ("POINT", "SPOT", "AREA")
"""Kinds of Blender's lights that can shine as a file says."""


LIGHT_FILES = ("luminaire", "rayset")
"""Settings of ``light.lumenray`` that each name a file by which the light may shine."""


def switch(self, context):
    """A light shines by one file: switching this one on switches the other off."""
    for name in LIGHT_FILES if self.use_file else ():
        other = getattr(self.id_data.lumenray, name, None)
        if other is not None and other != self and other.use_file:
            other.use_file = False
    tag_owner(self, context)


def settings_of_light(light, name: str):
    """Return settings of a light by their name in `LIGHT_FILES`, None where it cannot shine by a file."""
    return getattr(light.lumenray, name) if light.type in LIGHT_TYPES else None


def settings_used(light, name: str):
    """Return settings of a light by their name in `LIGHT_FILES`, None where it does not shine by their file."""
    settings = settings_of_light(light, name)
    return settings if settings is not None and settings.use_file else None


def unload(self, context):
    """Another path names another file than the one that is embedded."""
    if self.text is not None:
        self.text = None
    tag_owner(self, context)


class EmbeddableSettings:
    """Mix-in of settings with a ``filepath``, whose ``update`` is `unload`."""

    text: PointerProperty(
        name="Embedded File",
        description="Text data-block with the content of the file; without one it is read from its path",
        type=bpy.types.Text,
        update=tag_owner,
    )
