"""Panels. They show and name things; whatever has to be found out is found out in `blender_addon`."""

from . import compatibility, light, material, render, sidebar, world

CLASSES = (
    *light.CLASSES,
    *material.CLASSES,
    *world.CLASSES,
    *render.CLASSES,
    *sidebar.CLASSES,
)


def attach():
    """Let Blender's own panels appear for our engine."""
    compatibility.attach()


def detach():
    """Take our engine off Blender's own panels."""
    compatibility.detach()
