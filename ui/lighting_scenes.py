"""Lighting scenes: levels of the light groups under names, what they are judged by, and the verdicts."""

import bpy

from ..engine.errors import LumenrayError
from ..imports import loaded_when_used
from .compatibility import ENGINE
from .parts import PropertiesPanel, draw_lines, draw_text
from .sidebar import SidebarPanel

with loaded_when_used():
    from ..blender_addon.rendering import lighting_scenes
    from ..blender_addon.sensors import scene_verdicts

NO_GROUPS = "Keep light groups apart in the panel Light Mix; lighting scenes say how they shine"

NO_SCENES = "None yet: set the sliders of the light mix, then add what they show"


class LUMENRAY_UL_lighting_scenes(bpy.types.UIList):
    """Lighting scenes: name, and a button that sets the sliders."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index):
        is_now = lighting_scenes.is_applied(context.scene, item)
        row = layout.row(align=True)
        row.prop(
            item,
            "name",
            text="",
            icon="OUTLINER_OB_LIGHT" if is_now else "OUTLINER_DATA_LIGHT",
            emboss=False,
        )
        row.operator("lumenray.apply_lighting_scene", text="Apply").index = index


class LightingScenesPanel:
    """Panel of the lighting scenes."""

    bl_label = "Lighting Scenes"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, scene = self.layout, context.scene
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = scene.lumenray.light_mix
        if settings.groups == "NONE":
            draw_text(layout, context, NO_GROUPS, "INFO")
            return
        if not settings.scenes:
            draw_text(layout, context, NO_SCENES, "INFO")
        else:
            layout.template_list(
                "LUMENRAY_UL_lighting_scenes",
                "",
                settings,
                "scenes",
                settings,
                "scene_index",
                rows=3,
            )
        row = layout.row(align=True)
        row.operator("lumenray.add_lighting_scene", text="Add", icon="ADD")
        row.operator("lumenray.store_lighting_scene", text="Store", icon="FILE_TICK")
        row.operator("lumenray.remove_lighting_scene", text="Remove", icon="REMOVE")
        if settings.scene_index < len(settings.scenes):
            self._draw_scene(layout, context, settings.scenes[settings.scene_index])

    def _draw_scene(self, layout, context, row):
        chosen = lighting_scenes.choose(row)
        lines = [("levels", chosen.levels.text() or "all as in the scene")]
        try:
            lines += scene_verdicts.tell(scene_verdicts.judge_all(context.scene, chosen))
        except LumenrayError as error:
            lines.append(("verdicts", f"none: {error}"))
        draw_lines(layout.box(), lines)


class LUMENRAY_PT_lighting_scenes(LightingScenesPanel, PropertiesPanel, bpy.types.Panel):
    """Lighting scenes below the light mix."""

    bl_context = "view_layer"


class LUMENRAY_PT_lighting_scenes_sidebar(LightingScenesPanel, SidebarPanel, bpy.types.Panel):
    """Lighting scenes beside the rendered view."""

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE


CLASSES = (
    LUMENRAY_UL_lighting_scenes,
    LUMENRAY_PT_lighting_scenes,
    LUMENRAY_PT_lighting_scenes_sidebar,
)
"""For registration."""
