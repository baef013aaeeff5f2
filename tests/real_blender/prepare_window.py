"""Turn a newly opened window into one worth a picture: ``--python prepare_window.py -- VIEW``.

The bundled office is built anew. ``light`` makes
a luminaire active, ``material`` an object with a physical override, ``render`` starts F12, ``bake``
runs the bake as a user would and writes into the log how long the window ever waited, ``bake_graph``
shows one half-way; ``baked`` and ``baked_lux`` bake the whole office and show its light and its
illuminance in material preview; ``viewport`` moves an object in the rendered view, ``viewport_lux``
shows the illuminance there. ``luminaire`` has a scene of its own: luminaires from the library before
a wall, with their polar solids and one's panel; so has ``rayset``: ray sets of the library on a board,
with their points and rays; so has ``measured``: balls of measured materials in the rendered view, and
one's panel. ``library`` shows the luminaires in the Asset
Browser. ``world`` shows houses under a clear sky of the CIE and its sun, ``sun_arc`` the same with the sun of a place and
time, its arc and the panel. ``first_hour_1`` is Blender as
it starts, with the Start panel before any step, ``first_hour_2`` the same after *New Lit Room*, and
``first_hour_3`` after its bake, with lux in false colours and all steps done. In the others the sidebar
shows the tab of Lumenray.
"""

import importlib
import math
import sys
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))

from checkout import PACKAGE, tool

VIEW = sys.argv[sys.argv.index("--") + 1] if "--" in sys.argv else "light"

IS_FIRST_HOUR = VIEW.startswith("first_hour")

ACTIVE = {
    "light": "LED Panel 1",
    "material": "Window Panes",
    "bake": "Floor",
    "bake_graph": "Floor",
    "baked": "Floor",
    "baked_lux": "Floor",
}
"""Object that is made active for each view."""

LUMINAIRES = (
    ("flood_asymmetric.ldt", (-1.1, 0.0, 2.4), 90.0),
    ("batwing_office.ldt", (0.0, 0.0, 2.4), 0.0),
    ("downlight_40.ies", (1.1, 0.0, 2.4), 0.0),
)
"""File, place [m] and turn about the vertical [degree] of the luminaires, the active one in the middle."""

RAYSETS = (
    ("led_dome", (-0.017, 0.0, 0.006)),
    ("led_collimator", (0.0, 0.0, 0.016)),
    ("filament", (0.017, 0.0, 0.008)),
)
"""Ray sets of the library and their places [m], the active one in the middle."""

BALLS = (
    ("lacquer_red_gloss", (-0.115, 0.02, 0.05)),
    ("aluminium_brushed", (0.0, 0.0, 0.05)),
    ("car_blue", (0.115, 0.02, 0.05)),
)
"""Measured materials of the library and places of their balls [m], the active one in the middle."""

CONTEXT = {
    "measured": "MATERIAL",
    "light": "DATA",
    "luminaire": "DATA",
    "rayset": "DATA",
    "material": "MATERIAL",
    "world": "WORLD",
    "sun_arc": "WORLD",
}
"""Tab of the properties editor; elsewhere that of the render settings."""

LARGE_PROPERTIES = {"luminaire", "measured", "rayset", "sun_arc", "world"}
"""Pictures of a panel: the properties editor takes the whole height, and there is no sidebar."""

SOLID = {"render", "bake", "bake_graph", "baked", "baked_lux", "luminaire", "rayset", "sun_arc"}
"""Pictures in which the view is not rendered."""

ZOOM = {
    "viewport": 20.0,
    "viewport_lux": 20.0,
    "baked": 20.0,
    "baked_lux": 20.0,
    "luminaire": 29.0,
    "measured": 29.0,
    "rayset": 29.0,
    "sun_arc": 29.0,
    "world": 29.0,
}
"""Blender's zoom of the camera's frame in the view; 0 leaves room around it."""

CATEGORY = "Lumenray"

HOUSES = (
    (10.0, 6.0, 6.0, -9.0, 4.0),
    (6.0, 6.0, 16.0, 2.0, 9.0),
    (9.0, 7.0, 9.0, 13.0, 3.0),
    (5.0, 5.0, 4.0, 1.0, -4.0),
)
"""Length, width and height of boxes, and x and y of their centres. [m]"""

SUN = (-55.0, 0.0, -220.0)
"""Rotation of the Sun light: 35 degrees high, in the south-west. [degree]"""

ATTEMPTS = 20
"""How often the sidebar is asked for its tab; it has none before it was drawn."""


def prepare_spaces(window):
    """Choose what the window's editors show."""
    context = CONTEXT.get(VIEW, "RENDER")
    for area in window.screen.areas:
        for space in area.spaces:
            if space.type == "VIEW_3D":
                # A rendered view would take its share of the processor from F12 and the bake, and its noise fills files.
                space.shading.type = "SOLID" if VIEW in SOLID else "RENDERED"
                space.region_3d.view_perspective = "CAMERA"
                space.region_3d.view_camera_zoom = ZOOM.get(VIEW, 0.0)
                space.show_region_ui = VIEW not in LARGE_PROPERTIES
                # Lines below every lamp.
                space.overlay.show_extras = not VIEW.startswith(("viewport", "baked"))
            elif space.type == "PROPERTIES":
                space.context = context


def sidebars(window):
    """Return area and sidebar of every viewport."""
    return [
        (area, region)
        for area in window.screen.areas
        if area.type == "VIEW_3D"
        for region in area.regions
        if region.type == "UI"
    ]


def choose_tab():
    """Return a timer function that brings the tab to the front as soon as there is one."""
    left = ATTEMPTS

    def choose():
        nonlocal left
        left -= 1
        done = True
        for window in bpy.context.window_manager.windows:
            for area, region in sidebars(window):
                try:
                    region.active_panel_category = CATEGORY
                except (AttributeError, TypeError):
                    # Read-only while there are no tabs.
                    done = False
                area.tag_redraw()
                done = done and region.active_panel_category == CATEGORY
        return None if done or left == 0 else 0.3

    return choose


def build():
    """Build the office in the open file and make one object active."""
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    tool("libraries.scenes.office").build_office()
    for item in bpy.context.view_layer.objects:
        item.select_set(False)
    wanted = ACTIVE.get(VIEW, "")
    found = [o for o in bpy.context.view_layer.objects if wanted and o.name.startswith(wanted[:8])]
    item = bpy.data.objects.get(wanted) or next(iter(found), None)
    if item is not None:
        item.select_set(True)
        bpy.context.view_layer.objects.active = item


def build_luminaires():
    """Hang luminaires before a wall, the second one active."""
    staging, shapes = tool("libraries.scenes.staging"), tool("libraries.scenes.shapes")
    assembly = tool("libraries.scenes.assembly").Assembly
    folder = Path(importlib.import_module(f"{PACKAGE}.libraries.luminaires").__file__).parent
    collection = staging.new_collection("Room")
    paint = staging.new_material(
        "Paint", "ShaderNodeBsdfPrincipled", {"Base Color": (0.6, 0.6, 0.6), "Roughness": 1.0}
    )
    floor = shapes.quad((-3.0, -2.0, 0.0), (6.0, 0.0, 0.0), (0.0, 3.0, 0.0))
    wall = shapes.quad((-3.0, 1.0, 0.0), (6.0, 0.0, 0.0), (0.0, 0.0, 3.2))
    assembly().add(paint, floor).build("Floor", collection)
    assembly().add(paint, wall).build("Wall", collection)
    made = []
    for name, place, turn in LUMINAIRES:
        bpy.context.scene.cursor.location = place
        bpy.ops.lumenray.add_luminaire(filepath=str(folder / "photometry" / name))
        made.append(bpy.context.object)
        made[-1].rotation_euler.z = math.radians(turn)
    for item in made:
        item.select_set(item is made[1])
    bpy.context.view_layer.objects.active = made[1]
    bpy.context.scene.cursor.location = (0.0, 0.0, -10.0)
    made[1].lumenray.luminaire.dimming = 0.8
    made[1].lumenray.luminaire.maintenance_factor = 0.9
    staging.new_camera((1.0, -2.7, 2.35), (88.0, 0.0, 19.0), lens=32.0)
    staging.set_render(1248, 940, 500.0)


def build_raysets():
    """Put ray sets above a board, shining down on it, the second one active."""
    staging, shapes = tool("libraries.scenes.staging"), tool("libraries.scenes.shapes")
    assembly = tool("libraries.scenes.assembly").Assembly
    collection = staging.new_collection("Bench")
    paint = staging.new_material(
        "Paint", "ShaderNodeBsdfPrincipled", {"Base Color": (0.4, 0.4, 0.4), "Roughness": 1.0}
    )
    board = shapes.quad((-0.05, -0.03, 0.0), (0.1, 0.0, 0.0), (0.0, 0.06, 0.0))
    assembly().add(paint, board).build("Board", collection)
    made = []
    for name, place in RAYSETS:
        bpy.context.scene.cursor.location = place
        bpy.ops.lumenray.add_rayset(entry=name)
        made.append(bpy.context.object)
    for item in made:
        item.select_set(item is made[1])
    bpy.context.view_layer.objects.active = made[1]
    bpy.context.scene.cursor.location = (0.0, 0.0, -1.0)
    camera = staging.new_camera((0.012, -0.075, 0.034), (72.0, 0.0, 9.0), lens=32.0)
    camera.data.clip_start = 0.001
    staging.set_render(1248, 940, 500.0)


def build_balls():
    """Put balls of measured materials on a floor below a lamp, under a grey sky."""
    staging, shapes = tool("libraries.scenes.staging"), tool("libraries.scenes.shapes")
    assembly = tool("libraries.scenes.assembly").Assembly
    collection = staging.new_collection("Samples")
    ground = staging.new_material("Ground", "ShaderNodeBsdfDiffuse", {"Color": (0.3, 0.3, 0.3)})
    plain = shapes.quad((-2.0, -2.0, 0.0), (4.0, 0.0, 0.0), (0.0, 4.0, 0.0))
    assembly().add(ground, plain).build("Floor", collection)
    balls = []
    for name, place in BALLS:
        bpy.ops.mesh.primitive_uv_sphere_add(
            segments=96, ring_count=48, radius=0.05, location=place
        )
        bpy.ops.object.shade_smooth()
        ball = bpy.context.object
        material = bpy.data.materials.new(name.replace("_", " ").title())
        material.use_nodes = True
        ball.data.materials.append(material)
        settings = material.lumenray
        settings.use_override, settings.model = True, "MEASURED"
        settings.measured.filepath = f"library:{name}"
        balls.append(ball)
    for ball in balls:
        ball.select_set(False)
    bpy.context.view_layer.objects.active = balls[1]
    lamp = staging.new_light("Lamp", "AREA", collection, (0.35, -0.3, 0.6), "LUMINOUS_FLUX", 700.0)
    lamp.data.size = 0.25
    lamp.rotation_euler = [math.radians(angle) for angle in (35.0, 0.0, 45.0)]
    staging.set_sky((1.0, 1.0, 1.0), 100.0)
    staging.new_camera((0.0, -0.42, 0.16), (76.0, 0.0, 0.0), lens=45.0)
    staging.set_render(1248, 940, 300.0)


def build_houses():
    """Put boxes on a plain under a clear sky with its sun."""
    staging, shapes = tool("libraries.scenes.staging"), tool("libraries.scenes.shapes")
    assembly = tool("libraries.scenes.assembly").Assembly
    collection = staging.new_collection("Street")
    paint = staging.new_material("Render", "ShaderNodeBsdfDiffuse", {"Color": (0.6, 0.57, 0.52)})
    ground = staging.new_material("Ground", "ShaderNodeBsdfDiffuse", {"Color": (0.2, 0.2, 0.2)})
    plain = shapes.quad((-400.0, -400.0, 0.0), (800.0, 0.0, 0.0), (0.0, 800.0, 0.0))
    assembly().add(ground, plain).build("Plain", collection)
    for number, (*size, x, y) in enumerate(HOUSES, start=1):
        house = shapes.box(size, (x, y, 0.5 * size[2]))
        assembly().add(paint, house).build(f"House {number}", collection)
    sun = staging.new_light("Sun", "SUN", collection, (0.0, 0.0, 30.0), "ILLUMINANCE", 60000.0)
    sun.data.angle = math.radians(0.53)
    sun.rotation_euler = [math.radians(angle) for angle in SUN]
    staging.set_sky((1.0, 1.0, 1.0), 1.0)
    world = bpy.context.scene.world.lumenray
    world.source, world.sky.type = "CIE", "12"
    staging.new_camera((-14.0, -38.0, 12.0), (83.0, 0.0, -20.0), lens=32.0)
    staging.set_render(1248, 940, 15000.0)


def build_study():
    """Let houses have the sun of a morning of May in Lisbon, and show its arc."""
    build_houses()
    bpy.data.objects.remove(bpy.data.objects["Sun"])
    scene = bpy.context.scene
    world = scene.world.lumenray
    world.sky.use_place = True
    world.place.city = "Lisbon, Portugal"
    world.time.month, world.time.day, world.time.hour = 5, 10, 16.5
    world.place.north = math.radians(20.0)
    world.arc.is_shown, world.arc.radius = True, 26.0
    bpy.ops.lumenray.add_sun()
    staging = tool("libraries.scenes.staging")
    staging.new_camera((-24.0, -66.0, 30.0), (70.0, 0.0, -20.0), lens=32.0)
    staging.set_render(1248, 940, 15000.0)
    open_panels()


def open_panels():
    """Have all panels of the world open, in their order; nodes and preview aside."""
    kinds = importlib.import_module(f"{PACKAGE}.ui.world").CLASSES
    for kind in reversed(kinds):
        bpy.utils.unregister_class(kind)
    for kind in kinds:
        if kind.__name__ in {"LUMENRAY_PT_world_place", "LUMENRAY_PT_world_study"}:
            kind.bl_options = kind.bl_options - {"DEFAULT_CLOSED"}
        bpy.utils.register_class(kind)


def enlarge_properties():
    """Return a timer function that gives the properties editor the whole right side of the window, in a good width."""

    def close():
        window = bpy.context.window_manager.windows[0]
        for kind in ("OUTLINER", "DOPESHEET_EDITOR", "PROPERTIES"):
            area = next(a for a in window.screen.areas if a.type == kind)
            with bpy.context.temp_override(window=window, area=area):
                bpy.ops.screen.area_close()
        view = next(a for a in window.screen.areas if a.type == "VIEW_3D")
        with bpy.context.temp_override(window=window, area=view):
            bpy.ops.screen.area_split(direction="VERTICAL", factor=0.78)

    def change():
        # Where areas lie is known after they were drawn.
        areas = bpy.context.window_manager.windows[0].screen.areas
        views = [area for area in areas if area.type == "VIEW_3D"]
        max(views, key=lambda area: area.x).type = "PROPERTIES"

    def choose():
        # So are the tabs of the properties editor.
        prepare_spaces(bpy.context.window_manager.windows[0])

    steps = iter((close, change, choose))

    def step():
        done = next(steps, None)
        if done is None:
            return None
        done()
        return 0.5

    return step


def browse_library():
    """Turn the 3D view into an Asset Browser of our luminaires."""
    areas = bpy.context.window_manager.windows[0].screen.areas
    area = max(areas, key=lambda a: a.width * a.height)
    area.ui_type = "ASSETS"

    def choose():
        # The editor has its parameters after it was drawn.
        area.spaces.active.params.asset_library_reference = "Lumenray"

    bpy.app.timers.register(choose, first_interval=2.0)


class Pulse:
    """Timer that notes the longest time for which the window did not answer."""

    def __init__(self):
        self.last = time.monotonic()
        self.longest = 0.0
        self.was_running = False

    def __call__(self):
        now = time.monotonic()
        running = bpy.context.window_manager.lumenray.job.running
        if running:
            self.longest = max(self.longest, now - self.last)
        elif self.was_running:
            print(f"longest wait of the window during the bake: {self.longest:.2f} s", flush=True)
        self.was_running = running
        self.last = now
        return 0.05


LITTLE = "Floor,Wall South,Desk Top A,Ceiling"
"""Objects of a short bake."""


def press_button(operator, **options):
    """Press a button of the sidebar, as it were."""
    window = bpy.context.window_manager.windows[0]
    area = next(a for a in window.screen.areas if a.type == "VIEW_3D")
    region = next(r for r in area.regions if r.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region):
        print(operator("INVOKE_DEFAULT", **options), flush=True)


def start_bake():
    """Bake a little."""
    press_button(
        bpy.ops.lumenray.bake_illuminance, objects=LITTLE, samples=64, folder="/out/window-bake"
    )


def start_long_bake():
    """Begin a bake that is still under way when the picture is taken."""
    names = [o.name for o in bpy.data.collections["Bake"].objects]
    press_button(
        bpy.ops.lumenray.bake_illuminance,
        objects=",".join(names),
        error=0.02,
        density=8.0,
        folder="/out/window-graph",
    )


def start_whole_bake():
    """Bake the room and all that is in it, and show it when it is done; its light in layers."""
    settings = bpy.context.scene.lumenray
    settings.bake.layers = "GROUPS" if VIEW == "baked" else "NONE"
    for source in bpy.data.objects:
        if source.type == "LIGHT":
            source.data.lumenray.light_group = source.name.rstrip(" 0123456789.")
    outside = set(bpy.data.collections["Exterior"].objects)
    names = [
        o.name for o in bpy.context.view_layer.objects if o.type == "MESH" and o not in outside
    ]
    press_button(
        bpy.ops.lumenray.bake_illuminance,
        objects=",".join(names),
        samples=24,
        density=4.0,
        folder="/out/window-baked",
    )
    bpy.app.timers.register(show_when_done, first_interval=1.0)


def show_when_done():
    """Show baked light as soon as there is some; time until the next look. [s]"""
    feedback = bpy.context.window_manager.lumenray
    if feedback.job.running:
        return 0.5
    press_button(bpy.ops.lumenray.show_baked)
    if VIEW == "baked_lux":
        bpy.context.scene.lumenray.look.kind = "FALSE"
        bpy.context.scene.view_settings.view_transform = "Standard"
    return None


def follow_first_steps():
    """Do what the Start panel offers, as far as the picture is to show it."""
    if VIEW == "first_hour_1":
        return
    press_button(bpy.ops.lumenray.new_lit_room)
    if VIEW == "first_hour_3":
        press_button(bpy.ops.lumenray.bake_illuminance, folder="/out/window-room")
        bpy.app.timers.register(show_lux_when_done, first_interval=1.0)


def show_lux_when_done():
    """Press the last button of the Start panel as soon as it can be pressed; time until the next look. [s]"""
    if bpy.context.window_manager.lumenray.job.running:
        return 0.5
    press_button(bpy.ops.lumenray.show_baked, look="FALSE")
    return None


def turn_evening():
    """Leave the light to the lamps: daylight through panes would take many minutes to become smooth."""
    tree = bpy.context.scene.world.node_tree
    tree.nodes["Background"].inputs["Strength"].default_value = 0.0


def move_basket():
    """Move something, as it were by hand."""
    bpy.data.objects["Waste Basket"].location.x += 0.15


def start_render():
    """Press F12, as it were."""
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window):
        print(bpy.ops.render.render("INVOKE_DEFAULT"), flush=True)


bpy.context.preferences.view.show_splash = False
if IS_FIRST_HOUR:
    # Blender as it starts.
    for area, _ in sidebars(bpy.context.window_manager.windows[0]):
        area.spaces.active.show_region_ui = True
    bpy.app.timers.register(follow_first_steps, first_interval=4.0)
elif VIEW in LARGE_PROPERTIES:
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    {
        "luminaire": build_luminaires,
        "measured": build_balls,
        "rayset": build_raysets,
        "sun_arc": build_study,
        "world": build_houses,
    }[VIEW]()
    bpy.app.timers.register(enlarge_properties(), first_interval=0.5)
elif VIEW == "library":
    bpy.app.timers.register(browse_library, first_interval=2.0)
else:
    build()
if not IS_FIRST_HOUR:
    bpy.context.scene.render.engine = "LUMENRAY"
    for shown in bpy.context.window_manager.windows:
        prepare_spaces(shown)
bpy.app.timers.register(choose_tab(), first_interval=1.0)
if VIEW == "render":
    bpy.context.scene.lumenray.render.samples = 16
    bpy.app.timers.register(start_render, first_interval=4.0)
if VIEW == "bake":
    bpy.app.timers.register(Pulse(), first_interval=3.0)
    bpy.app.timers.register(start_bake, first_interval=4.0)
if VIEW == "bake_graph":
    bpy.app.timers.register(start_long_bake, first_interval=4.0)
if VIEW.startswith("baked"):
    bpy.app.timers.register(start_whole_bake, first_interval=4.0)
if VIEW.startswith(("viewport", "baked")):
    turn_evening()
if VIEW == "viewport":
    bpy.app.timers.register(move_basket, first_interval=15.0)
if VIEW == "viewport_lux":
    bpy.context.scene.lumenray.viewport.display = "FALSE_ILLUMINANCE"
    bpy.context.scene.lumenray.viewport.automatic = False
