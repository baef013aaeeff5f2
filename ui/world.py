"""The world: its sky, or its background and what that one's numbers mean, and the sun of its place and time."""

import bpy

from ..blender_addon.foundation.node_trees import uses_nodes
from ..blender_addon.sky import depends_on_sun, find_sun_lamp, states_level, takes_lamp
from ..imports import loaded_when_used
from .compatibility import ENGINE
from .parts import PropertiesPanel, draw_description, draw_surface, draw_text, draw_wide

with loaded_when_used():
    from ..blender_addon.daylight import readout
    from ..blender_addon.environment import found


class WorldPanel(PropertiesPanel):
    """Panel of the world tab."""

    bl_context = "world"

    @classmethod
    def poll(cls, context):
        return context.world is not None and super().poll(context)


class BackgroundPanel(WorldPanel):
    """Panel about the world's nodes, which is there while they count."""

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.world.lumenray.source == "NODES"


class LUMENRAY_PT_world_preview(WorldPanel, bpy.types.Panel):
    """What the world looks like, which Blender has no panel of its own for."""

    bl_label = "Preview"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        self.layout.template_preview(context.world)


class LUMENRAY_PT_world_sky(WorldPanel, bpy.types.Panel):
    """Choice between nodes and a sky, and the latter's settings."""

    bl_label = "Sky"

    def draw(self, context):
        layout = self.layout
        world = context.world
        layout.row().prop(world.lumenray, "source", expand=True)
        if world.lumenray.source != "CIE":
            return
        settings = world.lumenray.sky
        layout.use_property_split = True
        layout.prop(settings, "kind", text="Kind")
        _draw_kind(layout, settings)
        column = layout.column()
        _draw_level(column, settings)
        column.prop(settings, "spectrum")
        if settings.spectrum == "CLEAR":
            column.prop(settings, "turbidity")
        if settings.spectrum != "CLEAR" or settings.kind == "CLOUDINESS":
            column.prop(settings, "colour_temperature", text="Daylight [K]")
        column.prop(settings, "ground_reflectance", text="Ground")
        lamp = _draw_sun_of_sky(layout, context, settings)
        draw_description(layout.box(), context, readout.describe_sky(world, lamp, context.scene))


def _draw_kind(layout, settings) -> None:
    """Draw what tells how the sky's light is distributed."""
    if settings.kind == "CIE":
        # Over the whole width: the names are long.
        row = layout.row()
        row.use_property_split = False
        row.prop(settings, "type", text="")
    elif settings.kind == "CLOUDINESS":
        layout.prop(settings, "cloudiness")
    elif settings.kind == "WEATHER":
        layout.prop(settings, "weather_file", text="File")
        layout.prop(settings, "weather_mean")
        if settings.weather_mean == "RANGE":
            column = layout.column(align=True)
            column.prop(settings, "mean_first_month")
            column.prop(settings, "mean_last_month")
            column = layout.column(align=True)
            column.prop(settings, "mean_start", text="Start [h]")
            column.prop(settings, "mean_end", text="End [h]")
            layout.prop(settings, "use_mean_sun")
    else:
        layout.prop(settings, "measured_text", text="Text")
        if settings.measured_text is None:
            layout.prop(settings, "measured_file", text="File")


def _draw_level(column, settings) -> None:
    """Draw what tells how bright the sky is."""
    if settings.kind in {"WEATHER", "MEASURED"}:
        column.prop(settings, "use_file_level")
    if not states_level(settings):
        return
    column.prop(settings, "level")
    if settings.level == "MODEL":
        return
    name, text = {
        "ILLUMINANCE": ("illuminance", "Illuminance [lx]"),
        "ZENITH": ("zenith_luminance", "Zenith [cd/m²]"),
        "TOTAL": ("total_illuminance", "Sky and Sun [lx]"),
    }[settings.level]
    draw_wide(column, settings, name, text)


def _draw_sun_of_sky(layout, context, settings):
    """Draw where the sky's sun stands, and return the Sun light that says it, None without one."""
    if not depends_on_sun(settings) or settings.kind == "WEATHER":
        return None
    column = layout.column(heading="Sun From")
    column.prop(settings, "use_place")
    if settings.use_place:
        return None
    column.prop(settings, "use_sun_lamp")
    lamp = find_sun_lamp(context.scene, context.view_layer) if takes_lamp(settings) else None
    if lamp is None:
        column.prop(settings, "elevation")
        column.prop(settings, "azimuth")
    return lamp


class LUMENRAY_PT_world_place(WorldPanel, bpy.types.Panel):
    """Place and time, and where the sun stands then."""

    bl_label = "Place and Time"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        world = context.world
        place, time = world.lumenray.place, world.lumenray.time
        column = layout.column()
        column.prop(place, "city")
        column.prop(place, "latitude")
        column.prop(place, "longitude")
        column.prop(place, "elevation", text="Height [m]")
        column.prop(place, "zone")
        column.prop(place, "north")
        odd = readout.describe_place(world)
        if odd:
            draw_text(column, context, odd[:1].upper() + odd[1:], "INFO")
        column = layout.column(align=True)
        column.prop(time, "year")
        column.prop(time, "month")
        column.prop(time, "day")
        column.prop(time, "hour", text="Clock [h]")
        column = layout.column()
        column.prop(time, "is_second")
        column.prop(time, "use_refraction")
        arc = world.lumenray.arc
        column.prop(arc, "is_shown")
        if arc.is_shown:
            column.prop(arc, "radius")
        draw_description(layout.box(), context, readout.describe_moment(world, context.scene))


class LUMENRAY_PT_world_sun(WorldPanel, bpy.types.Panel):
    """Sun light that follows place and time."""

    bl_label = "Sun"
    bl_parent_id = "LUMENRAY_PT_world_place"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        world = context.world
        settings = world.lumenray.sun
        if settings.lamp is None:
            layout.operator("lumenray.add_sun", icon="LIGHT_SUN")
            return
        layout.prop(settings, "lamp", text="Light")
        layout.prop(settings, "amount")
        if settings.amount == "GIVEN":
            draw_wide(layout, settings, "illuminance", "Facing the Sun [lx]")
        elif settings.amount == "HORIZONTAL":
            draw_wide(layout, settings, "horizontal_illuminance", "Horizontal [lx]")
        layout.prop(settings, "turbidity")
        draw_description(layout.box(), context, readout.describe_sun(world, context.scene))


class LUMENRAY_PT_world_study(WorldPanel, bpy.types.Panel):
    """Time along the frames, and the date in pictures."""

    bl_label = "Sun Study"
    bl_parent_id = "LUMENRAY_PT_world_place"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        time = context.world.lumenray.time
        layout.prop(time, "follows_frames")
        if time.follows_frames:
            column = layout.column()
            column.prop(time, "first_frame")
            column.prop(time, "minutes_per_frame", text="Per Frame [min]")
        layout.prop(time, "use_note")


class LUMENRAY_PT_world_surface(BackgroundPanel, bpy.types.Panel):
    """Background nodes."""

    bl_label = "Surface"

    def draw(self, context):
        layout = self.layout
        world = context.world
        if bpy.app.version < (5, 0, 0):
            layout.prop(world, "use_nodes", icon="NODETREE")
        layout.use_property_split = True
        if not uses_nodes(world):
            layout.prop(world, "color")
            return
        draw_surface(layout, world.node_tree)


class LUMENRAY_PT_world_unit(BackgroundPanel, bpy.types.Panel):
    """Unit of the background."""

    bl_label = "Unit of the Background"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        settings = context.world.lumenray
        layout.prop(settings, "unit")
        if settings.unit == "ILLUMINANCE":
            draw_wide(layout, settings, "illuminance", "Illuminance [lx]")
            column = layout.column(align=True)
            draw_wide(column, settings.environment, "meter_elevation", "Meter's Elevation")
            draw_wide(column, settings.environment, "meter_azimuth", "Meter's Azimuth")
        elif settings.unit == "WHITE":
            draw_wide(layout, settings, "white", "White [cd/m²]")
        elif settings.unit == "BLENDER":
            layout.prop(context.scene.lumenray, "efficacy", text="lm per Watt")


class LUMENRAY_PT_world_picture(BackgroundPanel, bpy.types.Panel):
    """Picture of the surroundings as light: what it holds, its bright sources as lights, its sun mended."""

    bl_label = "Picture as Light"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        world = context.world
        settings = world.lumenray.environment
        row = layout.row(align=True)
        row.operator("lumenray.load_environment", text="Load", icon="FILE_FOLDER")
        row.operator("lumenray.analyse_environment", text="Analyse", icon="VIEWZOOM")
        description, words = found.describe_found(world)
        if description.lines:
            box = layout.box()
            draw_description(box, context, description)
            for sentence in words:
                draw_text(box, context, sentence[:1].upper() + sentence[1:])
        row = layout.row()
        row.use_property_split = False
        row.prop(settings, "use_sources")
        if not settings.use_sources:
            return
        layout.prop(settings, "sun")
        if settings.sun == "NONE":
            return
        layout.prop(settings, "repair")
        if settings.repair == "RATIO":
            layout.prop(settings, "sun_ratio")
        elif settings.repair == "MODEL":
            layout.column().prop(settings, "sky_point", text="Sky at")
            layout.prop(world.lumenray.sun, "turbidity")
        column = layout.column()
        column.prop(settings, "half", text="Taken in")
        column.operator("lumenray.time_from_sun")


class LUMENRAY_PT_world_picture_limits(BackgroundPanel, bpy.types.Panel):
    """What makes a bright source of a picture."""

    bl_label = "Bright Sources"
    bl_parent_id = "LUMENRAY_PT_world_picture"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        settings = context.world.lumenray.environment
        layout.prop(settings, "source_factor", text="Source")
        layout.prop(settings, "edge_factor", text="Edge")
        layout.prop(settings, "radius", text="Radius")
        layout.prop(settings, "use_lower")


class LUMENRAY_PT_image_sky(bpy.types.Panel):
    """Place of the sky in the world's picture, in the sidebar of the Image Editor."""

    bl_label = "Sky of the World's Picture"
    bl_space_type = "IMAGE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Lumenray"

    @classmethod
    def poll(cls, context):
        world = context.scene.world
        return (
            context.engine == ENGINE
            and world is not None
            and world.lumenray.source == "NODES"
            and world.lumenray.environment.repair == "MODEL"
        )

    def draw(self, context):
        layout = self.layout
        layout.operator("lumenray.pick_sky", icon="EYEDROPPER")
        layout.prop(context.scene.world.lumenray.environment, "sky_point")


class LUMENRAY_PT_world_ground(WorldPanel, bpy.types.Panel):
    """Ground that the surroundings lie on, and the photo before them."""

    bl_label = "Ground and Photo"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        settings = context.world.lumenray.ground
        layout.prop(settings, "use_ground")
        column = layout.column()
        column.active = settings.use_ground
        column.prop(settings, "level")
        if settings.photo != "CAMERA":
            column.prop(settings, "camera_height")
            column.prop(settings, "centre")
        column.prop(settings, "radius")
        layout.prop(settings, "photo")
        if settings.photo == "NONE":
            return
        if settings.photo == "PLATE":
            layout.template_ID(settings, "plate", open="image.open")
            column = layout.column()
            column.prop(settings, "plate_azimuth")
            column.prop(settings, "plate_angle")
        draw_wide(layout, settings, "photo_luminance", "Photo's White [cd/m²]")
        if settings.photo == "CAMERA":
            layout.operator("lumenray.sun_from_shadow", icon="LIGHT_SUN")


CLASSES = (
    LUMENRAY_PT_world_preview,
    LUMENRAY_PT_world_sky,
    LUMENRAY_PT_world_ground,
    LUMENRAY_PT_world_place,
    LUMENRAY_PT_world_sun,
    LUMENRAY_PT_world_study,
    LUMENRAY_PT_world_surface,
    LUMENRAY_PT_world_unit,
    LUMENRAY_PT_world_picture,
    LUMENRAY_PT_world_picture_limits,
    LUMENRAY_PT_image_sky,
)
