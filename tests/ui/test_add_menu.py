"""Blender's own menu of what can be added."""

import bpy


def test_luminaires_are_added_from_blenders_own_menu():
    from lumenray import ui

    draws = bpy.types.VIEW3D_MT_light_add._dyn_ui_initialize()
    ui.attach()
    assert ui.add_menu.draw_luminaire in draws
    ui.detach()
    assert ui.add_menu.draw_luminaire not in draws
