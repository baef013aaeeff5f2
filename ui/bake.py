"""The bake: settings in the render tab; button, progress and results in the sidebar; light groups where lights are."""

import bpy

from ..blender_addon import readout
from ..blender_addon.bake.error_graph import graph
from ..blender_addon.luminaires.settings import is_luminaire
from ..imports import loaded_when_used
from .light import LightPanel
from .material import MaterialPanel
from .parts import PropertiesPanel, draw_choice, draw_icon, draw_lines, draw_text
from .presets import draw_presets
from .sidebar import SidebarPanel
from .world import WorldPanel

with loaded_when_used():
    from ..blender_addon.bake import folders as bake_folders
    from ..blender_addon.bake import images as baked_images
    from ..blender_addon.bake import job as bake

STOPS = (
    ("error", "error_percent", "Error"),
    ("absolute", "absolute", "Error [lx]"),
    ("time", "time", "Time"),
    ("samples", "samples", "Samples"),
)
"""Ends of a bake, of which the first that is met counts: switch, amount, and what they are called."""

PLAIN_VIEW = "Standard"
"""View transform under which false colours are what the scale shows."""


def draw_stop(layout, settings) -> None:
    """Draw what ends a bake; several ends may be on."""
    column = layout.column(align=True)
    for name, amount, label in STOPS:
        row = column.row(align=True, heading=label)
        row.prop(settings, f"use_{name}", text="")
        part = row.row(align=True)
        part.active = getattr(settings, f"use_{name}")
        part.prop(settings, amount, text="")
    if not any(getattr(settings, f"use_{name}") for name, *_ in STOPS):
        layout.label(text="Switch one on: it would never end", icon="ERROR")


def draw_buttons(layout, context, is_ready: bool) -> None:
    """Draw what starts a bake, and what goes on with an interrupted one."""
    column = layout.column()
    column.scale_y = 1.4
    column.enabled = is_ready
    column.operator("lumenray.bake_illuminance", icon="RENDER_STILL")
    settings = context.scene.lumenray.bake
    wanted = bake_folders.folder_of(settings)
    if bake_folders.find_interrupted(wanted, settings.overwrite) is None:
        return
    column = layout.column()
    column.enabled = is_ready
    column.label(text="The folder holds an unfinished bake", icon="INFO")
    column.operator("lumenray.bake_illuminance", text="Resume", icon="PLAY").resume = True


def draw_state(layout, context, baked) -> None:
    """Draw what makes baked light other than it should be: changes since, and an end short of its rule."""
    if baked.changed:
        draw_text(layout, context, f"Out of date. Changed since: {baked.changed}", "ERROR")
        layout.operator("lumenray.check_baked", text="Check for Changes", icon="FILE_REFRESH")
    if baked.shortfall:
        said = baked.shortfall
        said = f"Bake {said}" if said.startswith("stopped") else f"{said[:1].upper()}{said[1:]}"
        draw_text(layout, context, said, "INFO")


def draw_graph(layout, context) -> None:
    """Draw the graph of the error over time about as wide as the panel."""
    if graph.has_history:
        draw_icon(layout, context, graph.icon, "graph")


# ---- render tab ----


class BakePanel(PropertiesPanel):
    """Panel of the render tab."""

    bl_context = "render"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        self.draw_settings(layout, context, context.scene.lumenray.bake)


class LUMENRAY_PT_lux_bake(BakePanel, bpy.types.Panel):
    """Lux maps; the button is in the sidebar of the 3D view and here."""

    bl_label = "Lux Bake"

    def draw_settings(self, layout, context, settings):
        """Draw density, ends and the button."""
        layout.prop(settings, "density", text="Lumels per m")
        draw_stop(layout, settings)
        draw_buttons(layout, context, not context.window_manager.lumenray.job.running)


class LUMENRAY_PT_lux_bake_layout(BakePanel, bpy.types.Panel):
    """How surfaces lie on pages."""

    bl_label = "Layout"
    bl_parent_id = "LUMENRAY_PT_lux_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_settings(self, layout, context, settings):
        """Draw pages and charts."""
        layout.prop(settings, "from_textures", text="Match Textures")
        column = layout.column(align=True)
        column.prop(settings, "largest", text="Page Size [px]")
        column.prop(settings, "pages", text="Most Pages")
        column.prop(settings, "margin", text="Margin [px]")
        layout.prop(settings, "cone")
        layout.prop(settings, "detail", text="Detail")


class LUMENRAY_PT_lux_bake_light(BakePanel, bpy.types.Panel):
    """What of the light is computed, and how."""

    bl_label = "Light"
    bl_parent_id = "LUMENRAY_PT_lux_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_settings(self, layout, context, settings):
        """Draw layers, exitance and method."""
        layout.prop(settings, "layers")
        layout.prop(settings, "exitance")
        column = layout.column()
        column.active = settings.exitance
        column.prop(settings, "denoise")
        layout.prop(settings, "method")
        layout.prop(settings, "caustics")


class LUMENRAY_PT_lux_bake_output(BakePanel, bpy.types.Panel):
    """What is written where."""

    bl_label = "Files"
    bl_parent_id = "LUMENRAY_PT_lux_bake"

    def draw_settings(self, layout, context, settings):
        """Draw the folder and what else goes there."""
        layout.prop(settings, "folder")
        if not bpy.data.filepath:
            draw_text(
                layout, context, "Not saved: lux maps go with Blender's temporary folder", "INFO"
            )
        elif not settings.folder:
            draw_text(layout, context, f"Empty: {bake_folders.default_folder()}", "INFO")
        layout.prop(settings, "overwrite")
        layout.prop(settings, "use_checkpoint")
        layout.prop(settings, "isolux")
        layout.prop(settings, "use_gltf", text=f"glTF ({bake.GLTF})")
        column = layout.column(align=True)
        column.active = settings.use_gltf
        column.prop(settings, "gltf_textures")
        column.prop(settings, "gltf_size")


# ---- light groups ----


class LightGroupPanel:
    """Panel with the light group of something luminous: what of the context ``owner`` names."""

    bl_label = "Light Group"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(getattr(context, self.owner).lumenray, "light_group", text="Group")
        if context.scene.lumenray.bake.layers != "GROUPS":
            draw_choice(
                layout, context.scene.lumenray.bake, "layers", "GROUPS", "Bake Groups as Layers"
            )


class LUMENRAY_PT_light_group(LightGroupPanel, LightPanel, bpy.types.Panel):
    """Layer of a light."""

    owner = "light"


class LUMENRAY_PT_material_group(LightGroupPanel, MaterialPanel, bpy.types.Panel):
    """Layer of what glows with a material."""

    bl_context = "material"

    owner = "material"


class LUMENRAY_PT_world_group(LightGroupPanel, WorldPanel, bpy.types.Panel):
    """Layer of the surroundings."""

    owner = "world"


class LUMENRAY_PT_luminaire_group(LightGroupPanel, PropertiesPanel, bpy.types.Panel):
    """Layer of an empty that is a luminaire."""

    bl_context = "data"
    owner = "object"

    @classmethod
    def poll(cls, context):
        source = context.object
        is_empty = source is not None and source.type == "EMPTY" and is_luminaire(source)
        return is_empty and super().poll(context)


# ---- sidebar ----


class LUMENRAY_PT_bake(SidebarPanel, bpy.types.Panel):
    """Illuminance of the selected objects."""

    bl_label = "Bake Illuminance"

    def draw_header_preset(self, context):
        draw_presets(self.layout, context)

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        if context.window_manager.lumenray.job.running:
            self._draw_job(layout, context)
        else:
            self._draw_settings(layout, context)

    def _draw_job(self, layout, context):
        job = context.window_manager.lumenray.job
        # Rounded down, but for the last digit of what Blender keeps.
        layout.progress(factor=job.progress, text=f"{int(100.0 * job.progress + 1e-4)} %")
        draw_lines(layout, readout.describe_job(job), 0.35)
        draw_graph(layout, context)
        row = layout.row(align=True)
        row.enabled = not job.is_stopping
        row.operator("lumenray.stop_bake", icon="CHECKMARK")
        layout.operator("lumenray.cancel_bake", icon="X")
        text = "Ends with the results so far" if job.is_stopping else "Esc stops and keeps"
        layout.label(text=text, icon="INFO")

    def _draw_settings(self, layout, context):
        settings, engine = context.scene.lumenray.bake, context.window_manager.lumenray.engine
        count, text = readout.describe_selection(context)
        layout.label(text=text, icon="OBJECT_DATA" if count else "INFO")
        column = layout.column()
        column.prop(settings, "density", text="Lumels per m")
        if readout.is_bakeable(context.object):
            own = context.object.lumenray
            row = column.row(heading="Own Density")
            row.prop(own, "use_density", text="")
            part = row.row()
            part.active = own.use_density
            shown = (own, "density") if own.use_density else (settings, "density")
            part.prop(*shown, text="")
            column.prop(context.object.lumenray, "two_sided")
        column.prop(settings, "layers")
        draw_stop(layout, settings)
        draw_buttons(layout, context, bool(count) and (engine.usable or not engine.checked))
        if engine.checked and not engine.usable:
            draw_text(layout, context, "Not possible: the engine cannot run, see above", "INFO")


class LUMENRAY_UL_results(bpy.types.UIList):
    """Lux maps: name, mean."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        split = layout.split(factor=0.45)
        is_current = not item.id_data.lumenray.baked.changed
        split.label(text=item.name, icon="TEXTURE" if is_current else "ERROR")
        row = split.row()
        row.alignment = "RIGHT"
        row.label(text=readout.format_amount(item.mean, item.unit))


class LUMENRAY_PT_results(SidebarPanel, bpy.types.Panel):
    """What was baked last."""

    bl_label = "Lux Maps"

    @classmethod
    def poll(cls, context):
        return len(context.scene.lumenray.baked.rows) > 0

    def draw(self, context):
        layout = self.layout
        baked = context.scene.lumenray.baked
        draw_state(layout, context, baked)
        layout.template_list("LUMENRAY_UL_results", "", baked, "rows", baked, "row_index", rows=3)
        if baked.row_index < len(baked.rows):
            draw_lines(layout.box(), readout.describe_result(baked.rows[baked.row_index]))


class LUMENRAY_PT_results_whole(SidebarPanel, bpy.types.Panel):
    """The last bake as a whole, and how its error fell."""

    bl_label = "Whole Bake"
    bl_parent_id = "LUMENRAY_PT_results"

    def draw(self, context):
        layout = self.layout
        draw_lines(layout, readout.describe_bake(context.scene.lumenray.baked))
        if not context.window_manager.lumenray.job.running:
            draw_graph(layout, context)


class LUMENRAY_UL_layers(bpy.types.UIList):
    """Layers of baked light: name, strength, colour."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        split = layout.split(factor=0.4)
        split.label(text=item.name, icon="LIGHT")
        row = split.row(align=True)
        row.prop(item, "strength", text="", slider=True)
        colour = row.row(align=True)
        colour.scale_x = 0.5
        colour.prop(item, "colour", text="")


class LUMENRAY_PT_baked_light(SidebarPanel, bpy.types.Panel):
    """Baked light in EEVEE and material preview."""

    bl_label = "Baked Light"

    @classmethod
    def poll(cls, context):
        return baked_images.has_atlas() or bool(context.scene.lumenray.look.figure)

    def draw(self, context):
        layout = self.layout
        settings = context.scene.lumenray.look
        if context.scene.lumenray.baked.changed:
            layout.label(text="Out of date, see Lux Maps", icon="ERROR")
        if not settings.is_shown:
            layout.operator("lumenray.show_baked", icon="SHADING_TEXTURE")
            return
        layout.operator("lumenray.hide_baked", icon="LOOP_BACK")
        shading = context.space_data.shading
        if shading.type not in {"MATERIAL", "RENDERED"}:
            draw_choice(layout, shading, "type", "MATERIAL", "Show Material Preview")
        if not settings.figure:
            layout.row().prop(settings, "kind", expand=True)
        if settings.kind == "FALSE":
            self._draw_scale(layout, context)
        elif settings.layers and settings.kind == "LIGHT":
            layout.template_list(
                "LUMENRAY_UL_layers", "", settings, "layers", settings, "layer_index", rows=3
            )
            layout.operator("lumenray.write_mixed_maps", icon="FILE_TICK")

    def _draw_scale(self, layout, context):
        settings = context.scene.lumenray.look
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column(align=True)
        column.prop(settings, "low", text=f"From [{settings.unit}]")
        column.prop(settings, "high", text=f"To [{settings.unit}]")
        view = context.scene.view_settings
        if view.view_transform != PLAIN_VIEW:
            draw_text(
                layout, context, "Colours differ from the scale under this view transform", "ERROR"
            )
            layout.prop(view, "view_transform")


CLASSES = (
    LUMENRAY_UL_results,
    LUMENRAY_UL_layers,
    LUMENRAY_PT_lux_bake,
    LUMENRAY_PT_lux_bake_layout,
    LUMENRAY_PT_lux_bake_light,
    LUMENRAY_PT_lux_bake_output,
    LUMENRAY_PT_light_group,
    LUMENRAY_PT_material_group,
    LUMENRAY_PT_world_group,
    LUMENRAY_PT_luminaire_group,
    LUMENRAY_PT_bake,
    LUMENRAY_PT_baked_light,
    LUMENRAY_PT_results,
    LUMENRAY_PT_results_whole,
)
