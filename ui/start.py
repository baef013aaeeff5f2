"""Panel 'Start' of the sidebar: whether the engine is ready, scenes to begin with, and the first steps."""

import os

import bpy

from ..blender_addon import first_steps, readout
from ..blender_addon.first_steps import Step
from ..blender_addon.foundation import preferences
from ..libraries import luminaires
from .compatibility import ENGINE
from .parts import draw_choice, draw_text
from .sidebar import SidebarPanel, draw_engine

ICONS = {True: "CHECKMARK", False: "RADIOBUT_OFF"}
"""Icon of a step, by whether it is done."""

PHOTOMETRY = f"{luminaires.FOLDER / 'photometry'}{os.sep}"
"""Where the photometric files of the library lie."""


class LUMENRAY_PT_start(SidebarPanel, bpy.types.Panel):
    """What to do first; one line once that is done, or not wanted."""

    bl_label = "Start"

    def draw(self, context):
        layout = self.layout
        scene = context.scene
        first_steps.follow(scene)
        steps = first_steps.done(scene)
        if not first_steps.are_shown(scene):
            _draw_line(layout, sum(steps.values()), len(steps))
            return
        draw_engine(layout, context)
        column = layout.column(align=True)
        column.operator("lumenray.new_lit_room", icon="CUBE")
        column.operator("lumenray.open_office", icon="FILE_BLEND")
        for step, is_done in steps.items():
            layout.label(text=step.value, icon=ICONS[is_done])
            if not is_done:
                _NEXT[step](layout, context)
        own = preferences.own()
        if own is not None:
            layout.prop(own, "show_steps", text="Hide These Steps", icon="X", invert_checkbox=True)


def _draw_line(layout, count: int, most: int) -> None:
    """Draw all of the panel that is left when the steps are not shown."""
    row = layout.row(align=True)
    row.label(text=f"{count} of {most} steps done", icon=ICONS[count == most])
    row.operator("lumenray.new_lit_room", text="", icon="CUBE")
    row.operator("lumenray.open_office", text="", icon="FILE_BLEND")
    own = preferences.own()
    if own is not None and count < most:
        row.prop(own, "show_steps", text="", icon="DOWNARROW_HLT")


def _choose_engine(layout, context) -> None:
    draw_choice(layout, context.scene.render, "engine", ENGINE, "Render with Lumenray")


def _add_light(layout, context) -> None:
    # Blender's browser opens where our files are.
    layout.operator(
        "lumenray.add_luminaire", text="Add Luminaire…", icon="ADD"
    ).directory = PHOTOMETRY
    draw_text(layout, context, "Or a light with Physical Parameters")


def _state_reflectance(layout, context) -> None:
    draw_text(
        layout,
        context,
        "Give a surface a material with Physical Override, or one of ours from the Asset Browser",
    )


def _bake(layout, context) -> None:
    feedback = context.window_manager.lumenray
    if feedback.job.running:
        layout.label(text="Being baked, see below", icon="TIME")
        return
    count, text = readout.describe_selection(context)
    column = layout.column()
    column.enabled = count > 0 and (feedback.engine.usable or not feedback.engine.checked)
    column.operator("lumenray.bake_illuminance", icon="RENDER_STILL")
    layout.label(text=text)


def _show_lux(layout, context) -> None:
    layout.operator("lumenray.show_baked", text="Show Lux", icon="SHADING_TEXTURE").look = "FALSE"


_NEXT = {
    Step.ENGINE: _choose_engine,
    Step.LIGHT: _add_light,
    Step.SURFACE: _state_reflectance,
    Step.BAKE: _bake,
    Step.LUX: _show_lux,
}
"""What does a step, or says how."""


CLASSES = (LUMENRAY_PT_start,)
