"""Take a picture of every panel of ours at the widths that Blender gives its editors at first.

Run by ``run_panels.sh`` in a window that is high enough for whole tabs; pictures go to ``/out/panels``. They are for
reading: what is cut off, what has no unit, what a designer does not need.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import subprocess

import bpy
import numpy as np
from window import PACKAGE, module, override, region_of, show_tab, start, wait_for, window

FOLDER = Path("/out/panels")

TALL = {
    "LUMENRAY_PT_world_preview",
    "LUMENRAY_PT_world_place",
    "LUMENRAY_PT_world_sun",
    "LUMENRAY_PT_world_study",
}
"""Panels of the world that are left out of the pictures of its picture."""

DRAWN = 1.5
"""How long drawing may take, twice where texts follow from a file. [s]"""

PHOTOMETRY = "libraries/luminaires/photometry"


def area_of(kind):
    """Return the largest area of a kind."""
    return max(
        (area for area in window().screen.areas if area.type == kind),
        key=lambda area: area.width * area.height,
    )


def picture(name, region):
    """Take a picture of a region."""
    top = window().height - region.y - region.height
    crop = f"{region.width}x{region.height}+{region.x}+{top}"
    command = ["import", "-silent", "-window", "root", "-crop", crop, "+repage"]
    subprocess.run([*command, str(FOLDER / f"{name}.png")], check=True)
    print(f"{name}: {region.width} pixels wide", flush=True)


def tab(name, context):
    """Take a picture of a tab of the properties editor."""
    area = area_of("PROPERTIES")
    area.tag_redraw()
    # Which tabs there are is known after drawing.
    yield DRAWN
    area.spaces.active.context = context
    area.tag_redraw()
    yield DRAWN
    area.tag_redraw()
    yield DRAWN
    picture(name, region_of(area))


def sidebar(name):
    """Take a picture of the sidebar."""
    area = area_of("VIEW_3D")
    area.tag_redraw()
    yield DRAWN
    area.tag_redraw()
    yield DRAWN
    picture(name, region_of(area, "UI"))


def activate(item):
    """Select an object alone and make it active."""
    for other in bpy.context.view_layer.objects:
        other.select_set(other == item)
    bpy.context.view_layer.objects.active = item


def open_panels():
    """Have all panels open: their classes say what is folded at first."""
    for kind in module("ui").CLASSES:
        if "DEFAULT_CLOSED" in getattr(kind, "bl_options", ()):
            bpy.utils.unregister_class(kind)
            kind.bl_options = kind.bl_options - {"DEFAULT_CLOSED"}
            bpy.utils.register_class(kind)


def prepare():
    """Show our tab and choose our engine."""
    bpy.context.scene.render.engine = "LUMENRAY"
    open_panels()
    yield from show_tab()
    yield DRAWN


def first_steps():
    """The Start panel before its first step, after the room was added, after its bake, and when all is done."""
    scene, view = bpy.context.scene, area_of("VIEW_3D").spaces.active
    camera = scene.camera
    scene.render.engine = "BLENDER_WORKBENCH"
    yield from sidebar("sidebar_start")
    with override(area_of("VIEW_3D")):
        bpy.ops.lumenray.new_lit_room()
    yield from sidebar("sidebar_start_room")
    with override(area_of("VIEW_3D")):
        bpy.ops.lumenray.bake_illuminance("INVOKE_DEFAULT", error=0.05, folder="/out/panels/room")
    job = bpy.context.window_manager.lumenray.job
    yield from wait_for(lambda: not job.running, "the bake", 240.0)
    yield from sidebar("sidebar_start_baked")
    with override(area_of("VIEW_3D")):
        bpy.ops.lumenray.show_baked("INVOKE_DEFAULT", look="FALSE")
    yield from sidebar("sidebar_start_done")
    with override(area_of("VIEW_3D")):
        bpy.ops.lumenray.hide_baked()
    for item in list(bpy.data.collections["Lit Room"].objects):
        bpy.data.objects.remove(item)
    # The other pictures are of Blender as it starts.
    scene.camera, view.shading.type, view.region_3d.view_perspective = camera, "SOLID", "PERSP"
    scene.lumenray.property_unset("baked")


def lights():
    """Lights of all kinds, with Blender's watts and in photometric units."""
    for kind in ("POINT", "SPOT", "SUN", "AREA"):
        bpy.ops.object.light_add(type=kind, location=(0.0, 0.0, 3.0))
        item = bpy.context.object
        yield from tab(f"light_{kind.lower()}", "DATA")
        yield from sidebar(f"sidebar_{kind.lower()}")
        item.data.lumenray.use_physical = True
        item.data.lumenray.spectrum = "DAYLIGHT"
        yield from tab(f"light_{kind.lower()}_physical", "DATA")
        yield from sidebar(f"sidebar_{kind.lower()}_physical")
        bpy.data.objects.remove(item)


def tubes():
    """A point light that is a tube, in the 3D view and in its panels."""
    bpy.ops.object.light_add(type="POINT", location=(0.0, 0.0, 2.0), rotation=(0.0, 0.3, 0.4))
    light = bpy.context.object.data
    light.shadow_soft_size, light.lumenray.tube_length = 0.1, 3.0
    light.lumenray.use_physical = True
    yield from tab("tube", "DATA")
    yield from sidebar("sidebar_tube")
    area = area_of("VIEW_3D")
    picture("view_tube", next(each for each in area.regions if each.type == "WINDOW"))


def light_list():
    """The list of lights, some of them left out, and with a change that it does not hold yet."""
    made = []
    for number, kind in enumerate(("POINT", "SPOT", "SUN", "AREA", "POINT")):
        bpy.ops.object.light_add(type=kind, location=(number, 0.0, 3.0))
        made.append(bpy.context.object)
    made[-1].hide_render = True
    # Found by itself once the scene is left alone.
    yield DRAWN
    yield from sidebar("sidebar_lights")
    made[0].data.energy *= 2.0
    area = area_of("VIEW_3D")
    area.tag_redraw()
    yield 0.2
    picture("sidebar_lights_changed", region_of(area, "UI"))
    for item in made:
        bpy.data.objects.remove(item)


def luminaires():
    """A luminaire on an empty, and a ray set."""
    folder = Path(sys.modules[PACKAGE].__file__).parent / PHOTOMETRY
    bpy.ops.lumenray.add_luminaire(filepath=str(folder / "batwing_office.ldt"))
    yield 3.0
    yield from tab("luminaire", "DATA")
    yield from sidebar("sidebar_luminaire")
    bpy.ops.lumenray.add_rayset(entry="led_collimator")
    yield 12.0
    yield from tab("rayset", "DATA")
    yield from sidebar("sidebar_rayset")


def sensors():
    """Sensors over the floor of the lit room: before they are measured, measured, and out of date."""
    with override(area_of("VIEW_3D")):
        bpy.ops.lumenray.new_lit_room()
    activate(
        next(o for o in bpy.data.collections["Lit Room"].objects if o.name.startswith("Floor"))
    )
    bpy.ops.lumenray.add_sensors(layout="FLOOR")
    area = area_of("VIEW_3D")
    area.spaces.active.region_3d.view_perspective = "CAMERA"
    yield from sidebar("sidebar_sensors")
    with override(area):
        bpy.ops.lumenray.measure_sensors("INVOKE_DEFAULT")
    running = module("blender_addon.sensors.running")
    yield from wait_for(lambda: not running.is_running(), "the sensors", 240.0)
    yield from sidebar("sidebar_sensors_measured")
    bpy.context.scene.lumenray.sensors.requirement = "office.writing"
    yield from sidebar("sidebar_sensors_judged")
    seen = next(each for each in area.regions if each.type == "WINDOW")
    picture("view_sensors", seen)
    lamp = next(o for o in bpy.data.collections["Lit Room"].objects if o.type in {"EMPTY", "LIGHT"})
    lamp.location.x += 0.5
    yield from sidebar("sidebar_sensors_outdated")
    picture("view_sensors_outdated", seen)
    for item in list(bpy.data.collections["Lit Room"].objects):
        bpy.data.objects.remove(item)


def goniometers():
    """A goniometer about a lamp of the lit room, with its curves in the view; and the room by tone operators."""
    with override(area_of("VIEW_3D")):
        bpy.ops.lumenray.new_lit_room()
    objects = bpy.data.collections["Lit Room"].objects
    activate(next(o for o in objects if o.type in {"EMPTY", "LIGHT"}))
    bpy.ops.lumenray.add_sensors(layout="SPHERE")
    area = area_of("VIEW_3D")
    area.spaces.active.region_3d.view_perspective = "CAMERA"
    with override(area):
        bpy.ops.lumenray.measure_sensors("INVOKE_DEFAULT")
    running = module("blender_addon.sensors.running")
    yield from wait_for(lambda: not running.is_running(), "the goniometer", 240.0)
    yield from sidebar("sidebar_goniometer")
    picture("view_goniometer", region_of(area))
    shading, settings = area.spaces.active.shading, bpy.context.scene.lumenray.viewport
    settings.samples, shading.type = 32, "RENDERED"
    for display in ("PHOTOGRAPHIC", "VISUAL"):
        settings.display = display
        yield 40.0
        picture(f"view_{display.lower()}", region_of(area))
    shading.type, settings.display = "SOLID", "PICTURE"
    for item in list(objects):
        bpy.data.objects.remove(item)


def materials():
    """All models of a material."""
    cube = bpy.data.objects["Cube"]
    activate(cube)
    material = cube.active_material
    yield from tab("material_nodes", "MATERIAL")
    settings = material.lumenray
    settings.use_override = True
    for item in settings.bl_rna.properties["model"].enum_items:
        settings.model = item.identifier
        yield from tab(f"material_{item.identifier.lower()}", "MATERIAL")
    with override(area_of("VIEW_3D")):
        bpy.ops.lumenray.load_scattering_file(filepath="library:aluminium_brushed")
    yield 15.0
    yield from tab("material_measured_file", "MATERIAL")
    settings.use_override = False


def hang_curtain():
    """Return a curtain in folds, its warp hanging along V of its UV map."""
    columns, rows = 121, 41
    x, z = np.meshgrid(np.linspace(-1.0, 1.0, columns), np.linspace(0.0, 2.0, rows))
    y = 0.07 * np.sin(22.0 * x) * (1.3 - 0.4 * z)
    number = np.arange(rows * columns).reshape(rows, columns)
    corners = (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    faces = np.stack(corners, axis=-1).reshape(-1, 4)
    mesh = bpy.data.meshes.new("Curtain")
    mesh.from_pydata(np.stack([x, y, z], axis=-1).reshape(-1, 3).tolist(), [], faces.tolist())
    layer = mesh.uv_layers.new(name="Drape")
    uv = np.stack([0.5 * (x + 1.0), 0.5 * z], axis=-1).reshape(-1, 2)[faces.ravel()]
    layer.data.foreach_set("uv", uv.ravel().astype(np.float32))
    mesh.shade_smooth()
    item = bpy.data.objects.new("Curtain", mesh)
    bpy.context.scene.collection.objects.link(item)
    item.data.materials.append(bpy.data.materials.new("Curtain"))
    return item


def cloths():
    """A curtain of voile before a cube: its panels while it is computed and after, and its picture in the view."""
    item = hang_curtain()
    item.rotation_euler, item.location = (0.0, 0.0, 0.8), (1.3, -1.2, -0.8)
    activate(item)
    settings = item.active_material.lumenray
    settings.use_override, settings.model = True, "CLOTH"
    with override(area_of("VIEW_3D")):
        bpy.ops.lumenray.set_cloth_preset(preset="voile")
    tables = module("blender_addon.cloths.tables").cloth_tables
    yield from tab("cloth_computing", "MATERIAL")
    # No picture of the material is drawn meanwhile.
    area_of("PROPERTIES").spaces.active.context = "SCENE"
    yield from wait_for(
        lambda: tables.state_of(settings.cloth).reading is not None, "the cloth", 900.0
    )
    area = area_of("VIEW_3D")
    area.spaces.active.region_3d.view_perspective = "CAMERA"
    bpy.context.scene.lumenray.viewport.samples = 16
    area.spaces.active.shading.type = "RENDERED"
    viewport = module("blender_addon.rendering.viewport")

    def is_shown():
        status = viewport.newest_status()
        return status is not None and status.samples >= 16

    yield from wait_for(is_shown, "the view", 600.0)
    yield DRAWN
    picture("view_cloth", next(each for each in area.regions if each.type == "WINDOW"))
    area.spaces.active.shading.type = "SOLID"
    yield from tab("cloth", "MATERIAL")
    # The picture takes its place only when it is drawn.
    yield 10.0
    yield from tab("cloth", "MATERIAL")
    bpy.data.objects.remove(item)


def inks():
    """A pigment layer while it is computed, cancelled, and done; and its particles in the view."""
    cube, view = bpy.data.objects["Cube"], area_of("VIEW_3D")
    activate(cube)
    material = cube.active_material
    settings = material.lumenray
    settings.use_override, settings.model = True, "INK"
    tables = module("blender_addon.inks.tables").ink_tables
    yield from tab("ink_computing", "MATERIAL")
    with bpy.context.temp_override(window=window(), material=material):
        bpy.ops.lumenray.cancel_ink()
    yield from wait_for(lambda: tables.state_of(settings.ink).is_stopped, "the stop", 60.0)
    yield from tab("ink_cancelled", "MATERIAL")
    view.spaces.active.shading.color_type = "MATERIAL"
    cube.hide_set(True)
    with override(view), bpy.context.temp_override(material=material):
        # What scripts set is in no step by itself.
        bpy.ops.ed.undo_push(message="Pigment layer")
        bpy.ops.lumenray.show_ink_particles("EXEC_DEFAULT", True)
        box = next(each for each in bpy.data.objects if "magnification" in each)
        name = box.name
        activate(box)
        bpy.ops.view3d.view_selected()
    yield from sidebar("sidebar_ink_particles")
    picture("view_ink_particles", region_of(view))
    with override(view):
        bpy.ops.ed.undo()
    yield DRAWN
    log.check(name not in bpy.data.objects, "one step back takes the particles away")
    log.check("Cube" in bpy.data.objects, "and leaves the rest")
    cube = bpy.data.objects["Cube"]
    cube.hide_set(False)
    activate(cube)
    settings = cube.active_material.lumenray
    with bpy.context.temp_override(window=window(), material=cube.active_material):
        bpy.ops.lumenray.compute_ink()
    yield from wait_for(lambda: tables.state_of(settings.ink).reading, "the pigment layer", 400.0)
    yield from tab("ink", "MATERIAL")
    settings.use_override = False


def show_sunny_picture(world):
    """Let a world show an even sky with a clipped sun over a dark ground."""
    image = bpy.data.images.new("street.hdr", 256, 128, float_buffer=True)
    pixels = np.ones((128, 256, 4), np.float32)
    pixels[:64, :, :3] = 0.2
    pixels[92:94, 150:152, :3] = 300.0
    image.pixels.foreach_set(pixels.ravel())
    tree = world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])


def worlds():
    """The world's nodes, and a sky."""
    settings = bpy.context.scene.world.lumenray
    yield from tab("world_nodes", "WORLD")
    settings.unit = "ILLUMINANCE"
    yield from tab("world_lux", "WORLD")
    show_sunny_picture(bpy.context.scene.world)
    settings.environment.use_sources, settings.environment.repair = True, "RATIO"
    bpy.ops.lumenray.analyse_environment()
    # The window is not high enough for all panels at once.
    hidden = [kind for kind in module("ui").CLASSES if kind.__name__ in TALL]
    for kind in reversed(hidden):
        bpy.utils.unregister_class(kind)
    yield from tab("world_picture", "WORLD")
    settings.environment.repair = "MODEL"
    yield from tab("world_picture_model", "WORLD")
    settings.environment.use_sources, settings.environment.repair = False, "NONE"
    for kind in hidden:
        bpy.utils.register_class(kind)
    settings.source, settings.sky.type = "CIE", "12"
    yield from tab("world_sky", "WORLD")
    for kind in ("CLOUDINESS", "WEATHER", "MEASURED"):
        settings.sky.kind = kind
        yield from tab(f"world_{kind.lower()}", "WORLD")
    settings.sky.kind, settings.sky.weather_mean = "WEATHER", "RANGE"
    yield from tab("world_hours", "WORLD")
    settings.sky.kind, settings.sky.spectrum, settings.sky.level = "CIE", "CLEAR", "MODEL"
    settings.sky.use_place = True
    yield from tab("world_clear_sky", "WORLD")
    settings.sky.spectrum, settings.sky.level = "TEMPERATURE", "ILLUMINANCE"
    settings.sky.use_place = False
    year = bpy.context.scene.lumenray.year
    year.blinds = year.maps = bpy.data.collections[0]
    for rule in ("TIMES", "FACADE"):
        year.blinds_rule = rule
        yield from tab(f"year_{rule.lower()}", "WORLD")
    year.blinds = year.maps = None
    bpy.ops.lumenray.add_sun()
    settings.time.follows_frames = True
    yield from tab("world_place", "WORLD")
    settings.time.follows_frames = False
    settings.sun.lamp = None
    settings.source = "NODES"
    settings.ground.use_ground, settings.ground.photo = True, "PLATE"
    settings.ground.radius = 6.0
    yield from tab("world_ground", "WORLD")
    settings.ground.photo = "CAMERA"
    yield from tab("world_photo", "WORLD")
    picture("ground_view", region_of(area_of("VIEW_3D")))
    settings.ground.use_ground, settings.ground.photo = False, "NONE"


def renders():
    """The render tab with all ways to stop and to expose."""
    settings = bpy.context.scene.lumenray
    for stop, exposure in (("SAMPLES", "LUMINANCE"), ("ERROR", "EV100"), ("TIME", "AUTO")):
        settings.render.stop, settings.exposure = stop, exposure
        settings.bake.use_absolute = settings.bake.use_time = settings.bake.use_samples = True
        yield from tab(f"render_{stop.lower()}", "RENDER")
    settings.render.stop, settings.exposure = "SAMPLES", "LUMINANCE"
    settings.bake.use_absolute = settings.bake.use_time = settings.bake.use_samples = False


def clusters():
    """The cluster's panel: no address, nobody there, and two workers; the tab has nothing else meanwhile."""
    ui, settings = module("ui"), bpy.context.scene.lumenray
    others = (*ui.render.CLASSES, *ui.bake.CLASSES, *ui.modelling.CLASSES)
    others = [kind for kind in others if getattr(kind, "bl_context", "") == "render"]
    for kind in reversed(others):
        bpy.utils.unregister_class(kind)
    own = bpy.context.preferences.addons[PACKAGE].preferences
    yield from tab("cluster_unnamed", "RENDER")
    jobs = module("blender_addon.foundation.background_job")

    def find_workers():
        with override(area_of("VIEW_3D")):
            bpy.ops.lumenray.find_workers("INVOKE_DEFAULT")
        yield from wait_for(lambda: not jobs.is_running("cluster"), "the workers", 60.0)

    settings.use_cluster = True
    with module("engine.cluster.hosts").LocalCluster(0, threads=1) as cluster:
        own.cluster_address = str(cluster.address)
        yield from find_workers()
        yield from tab("cluster_empty", "RENDER")
        cluster.add_worker()
        cluster.add_worker()
        yield from find_workers()
        yield from tab("cluster_panel", "RENDER")
    settings.use_cluster, own.cluster_address = False, ""
    for kind in others:
        bpy.utils.register_class(kind)


def find_out():
    """Have decisions made."""
    with override(area_of("VIEW_3D")):
        bpy.ops.lumenray.explain_modelling("INVOKE_DEFAULT")
    jobs = module("blender_addon.foundation.background_job")
    name = module("blender_addon.modelling.job").NAME
    yield from wait_for(lambda: not jobs.is_running(name), "the decisions", 60.0)


def modelling():
    """What will be computed, before and after it was found out, and out of date; the tab has nothing else meanwhile."""
    ui, settings = module("ui"), bpy.context.scene.lumenray
    others = (*ui.render.CLASSES, *ui.bake.CLASSES)
    others = [kind for kind in others if getattr(kind, "bl_context", "") == "render"]
    for kind in reversed(others):
        bpy.utils.unregister_class(kind)
    # Off-white paint can do without wavelengths within the error of lux maps.
    shader = bpy.data.objects["Cube"].active_material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0.8, 0.795, 0.79, 1.0)
    settings.modelling.purpose, settings.bake.error = "LUX_MAPS", 0.02
    yield from tab("modelling_unknown", "RENDER")
    yield from find_out()
    yield from tab("modelling_bounded", "RENDER")
    bpy.data.objects["Cube"].location.x += 0.5
    yield from tab("modelling_outdated", "RENDER")
    settings.render.stop, settings.render.error = "ERROR", 0.01
    settings.modelling.purpose, settings.modelling.colours = "PICTURE", "OFF"
    yield from find_out()
    yield from tab("modelling_overruled", "RENDER")
    settings.property_unset("modelling")
    for kind in others:
        bpy.utils.register_class(kind)
    settings.render.stop = "SAMPLES"


def bakes():
    """A bake before it starts, under way, and done."""
    cube = bpy.data.objects["Cube"]
    activate(cube)
    yield from sidebar("sidebar_bake")
    with override(area_of("VIEW_3D")):
        bpy.ops.lumenray.bake_illuminance(
            "INVOKE_DEFAULT", objects="Cube", error=0.01, folder="/out/panels/lux"
        )
    yield 2.0
    yield from sidebar("sidebar_job")
    job = bpy.context.window_manager.lumenray.job
    yield from wait_for(lambda: not job.running, "the bake", 120.0)
    yield 3.0
    yield from sidebar("sidebar_results")
    with override(area_of("VIEW_3D")):
        bpy.ops.lumenray.show_baked()
    bpy.context.scene.lumenray.look.kind = "FALSE"
    yield from sidebar("sidebar_baked")
    with override(area_of("VIEW_3D")):
        bpy.ops.lumenray.hide_baked()


def views():
    """The rendered view, its status, and the conversion report."""
    shading = area_of("VIEW_3D").spaces.active.shading
    settings = bpy.context.scene.lumenray
    settings.viewport.display, settings.viewport.automatic = "FALSE_ILLUMINANCE", False
    settings.viewport.samples = 16
    shading.type = "RENDERED"
    yield 20.0
    yield from sidebar("sidebar_view")
    shading.type = "SOLID"
    settings.viewport.display = "PICTURE"
    settings.render.samples = 8
    bpy.context.scene.render.resolution_percentage = 25
    with bpy.context.temp_override(window=window()):
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield 15.0
    subprocess.run(["import", "-silent", "-window", "root", str(FOLDER / "render.png")], check=True)


def mixes():
    """The light mix of a render by single lights: one is dimmed and one is off, without another render."""
    settings = bpy.context.scene.lumenray
    settings.light_mix.groups = "EACH"
    settings.render.samples, settings.render.use_pass_illuminance = 8, True
    bpy.context.scene.render.resolution_percentage = 25
    bpy.ops.object.light_add(type="AREA", location=(2.0, -2.0, 3.0))
    lamp = bpy.context.object
    with bpy.context.temp_override(window=window()):
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield from wait_for(lambda: len(settings.light_mix.rows) > 1, "the render", 60.0)
    yield 3.0
    settings.light_mix.rows[0].factor = 0.5
    settings.light_mix.rows[1].is_on = False
    # The sidebar's panel is the same; the render stands in the place of its view.
    yield from tab("view_layer_mix", "VIEW_LAYER")
    bpy.data.objects.remove(lamp)


def end():
    """Close Blender."""
    (FOLDER / "done").touch()
    bpy.ops.wm.quit_blender()


class Log:
    """Takes what `start` tells of failures."""

    def check(self, holds, text):
        """Print a failure."""
        print(f"{'ok' if holds else 'FAILED'}: {text}", flush=True)

    def write(self, is_complete):
        """Nothing is kept."""


CASES = {
    f.__name__: f
    for f in (
        first_steps,
        lights,
        tubes,
        light_list,
        luminaires,
        sensors,
        goniometers,
        materials,
        cloths,
        inks,
        worlds,
        renders,
        clusters,
        modelling,
        bakes,
        views,
        mixes,
    )
}
wanted = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
FOLDER.mkdir(exist_ok=True)
bpy.context.preferences.view.show_splash = False
# In the same window, of which pictures are taken.
bpy.context.preferences.view.render_display_type = "AREA"
bpy.context.preferences.system.use_region_overlap = False
log = Log()
start([prepare, *(CASES[name] for name in wanted or CASES)], log, end)
