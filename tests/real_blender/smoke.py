"""Use Lumenray the way a user does, and write down what it measured.

In a real Blender into which the extension was installed::

    blender -b --python-exit-code 1 --python smoke.py -- use FOLDER
    blender -b FOLDER/box.blend -E LUMENRAY -o FOLDER/line_ -F OPEN_EXR -f 1
    blender -b --python-exit-code 1 --python smoke.py -- read FOLDER

and with the bpy wheel, in which the package is called ``lumenray``::

    python smoke.py use FOLDER

``use`` registers, appends every asset of the libraries, opens the bundled scenes, renders and bakes the closed box, renders
it by a worker of a cluster too, bakes it with a luminaire that is dropped as a file, registers anew and renders again, and
writes ``FOLDER/smoke.json``;
``read`` adds what the render from the command line shows.
"""

import importlib
import json
import sys
from pathlib import Path

import bpy
import numpy as np

SIZE = 64
"""Width and height of the render. [pixel]"""

LUMINAIRE = "downlight_60.ies"
"""Luminaire of the library that is dropped."""

BAKE_DENSITY = 12.0
"""Lumels per metre of the bundled scenes, which is not the default."""

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Weights of linear Rec. 709 red, green and blue in the relative luminance (ITU-R BT.709)."""

IS_WHEEL = not bpy.app.binary_path
"""Whether this is the bpy wheel; a real Blender tells where its program lies."""

INSTALLED = "bl_ext.user_default.lumenray"
"""Name of the package where Blender has installed it from a zip."""


class SmokeError(Exception):
    """Something that a user would see go wrong."""


def require(condition, message):
    """Raise :class:`SmokeError` unless the condition holds."""
    if not condition:
        raise SmokeError(message)


def load_package():
    """Return the registered package: the installed extension, or the wheel's ``lumenray``."""
    if IS_WHEEL:
        package = importlib.import_module("lumenray")
        package.register()
        return package
    import addon_utils

    loaded = addon_utils.check(INSTALLED)
    require(loaded == (True, True), f"{INSTALLED} is not enabled: (default, loaded) is {loaded}")
    return sys.modules[INSTALLED]


def open_box(package):
    """Open the bundled closed box and set up its render."""
    scenes = importlib.import_module(f"{package.__name__}.libraries.scenes")
    bpy.ops.wm.open_mainfile(filepath=str(scenes.scene_path("closed_box")))
    scene = bpy.context.scene
    require("Floor" in bpy.data.objects, "the closed box has no object 'Floor'")
    require(scene.camera is not None, "the closed box has no camera")
    scene.render.engine = "LUMENRAY"
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"


def read_luminance(path):
    """Return the mean of a picture and its standard error.

    The noise of a pixel is taken from the differences of neighbours, which the picture's own
    contrast only makes larger.

    Returns
    -------
    dict    ``mean`` and ``standard_error`` of the relative luminance. [-]
    """
    require(path.exists(), f"the render did not write {path.name}")
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    require((width, height) == (SIZE, SIZE), f"{path.name} has {width} x {height} pixels")
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    luminance = pixels.reshape(height, width, -1)[..., :3].astype(float) @ LUMINANCE
    require(np.isfinite(luminance).all(), f"{path.name} has pixels that are no numbers")
    require(luminance.mean() > 0.0, f"{path.name} is black")
    # The lamp itself is in view and would hide all other differences.
    luminance = np.minimum(luminance, 4.0 * np.median(luminance))
    variance = np.mean(np.diff(luminance, axis=1) ** 2) / 2.0
    return {"mean": luminance.mean(), "standard_error": np.sqrt(variance / luminance.size)}


def render(folder, name):
    """Render the scene into a file and return what :func:`read_luminance` finds there."""
    path = folder / f"{name}.exr"
    path.unlink(missing_ok=True)
    bpy.context.scene.render.filepath = str(path)
    result = bpy.ops.render.render(write_still=True)
    require(result == {"FINISHED"}, f"the render ended with {result}")
    return read_luminance(path)


def check_regions(folder):
    """Render a part of the frame, cropped and not: it is as large as Blender cuts it, and not black."""
    settings = bpy.context.scene.render
    settings.use_border = True
    settings.border_min_x, settings.border_max_x = 0.21, 0.63
    settings.border_min_y, settings.border_max_y = 0.13, 0.71
    part = int(0.63 * SIZE) - int(0.21 * SIZE), int(0.71 * SIZE) - int(0.13 * SIZE)
    for is_cropped, size in ((True, part), (False, (SIZE, SIZE))):
        settings.use_crop_to_border = is_cropped
        settings.filepath = str(folder / f"region_{is_cropped}.exr")
        result = bpy.ops.render.render(write_still=True)
        require(result == {"FINISHED"}, f"the render of a region ended with {result}")
        image = bpy.data.images.load(settings.filepath)
        require(tuple(image.size) == size, f"a region has {tuple(image.size)} pixels, not {size}")
        pixels = np.empty(size[0] * size[1] * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
        lit = (pixels.reshape(-1, image.channels)[:, :3].max(axis=1) > 0.0).sum()
        bpy.data.images.remove(image)
        require(0.9 < lit / (part[0] * part[1]) < 1.01, f"{lit} pixels of a region are lit")
    settings.use_border = False


def render_on_cluster(package, folder):
    """Render by a worker of a cluster, which comes with the cluster pack, and return what :func:`read_luminance` finds."""
    hosts = importlib.import_module(f"{package.__name__}.engine.cluster.hosts")
    scene, manager = bpy.context.scene, bpy.context.window_manager
    preferences = bpy.context.preferences.addons[INSTALLED].preferences
    scene.lumenray.use_cluster = True
    with hosts.LocalCluster(1, threads=1) as cluster:
        preferences.cluster_address = str(cluster.address)
        result = bpy.ops.lumenray.find_workers()
        require(result == {"FINISHED"}, f"looking for workers ended with {result}")
        found = [row.name for row in manager.lumenray.cluster.workers]
        require(found == [cluster.workers[0].address], f"the workers are {found}")
        made = render(folder, "cluster")
    scene.lumenray.use_cluster = False
    preferences.cluster_address = ""
    return made


def bake(folder):
    """Bake the floor's illuminance and return its row of the report."""
    # 2 m of floor at 32 lumels a metre make a map of 64 x 64.
    result = bpy.ops.lumenray.bake_illuminance(
        objects="Floor", density=32.0, samples=64, folder=str(folder)
    )
    require(result == {"FINISHED"}, f"the bake ended with {result}")
    report = folder / "report.json"
    require(report.exists(), "the bake wrote no report.json")
    rows = json.loads(report.read_text(encoding="utf-8"))["quantities"]
    row = next((row for row in rows if row["quantity"] == "illuminance"), None)
    require(row is not None, f"report.json tells no illuminance: {rows}")
    require(row["unit"] == "lx", f"the illuminance is in {row['unit']}, not lx")
    require(row["mean"] > 0.0, "the floor is dark")
    return {"mean": row["mean"], "standard_error": row["mean_standard_error"]}


def bake_luminaire(package, folder):
    """Put a luminaire of the library where the lamp is, as a file dropped onto the window does, and bake."""
    lamp = next(o for o in bpy.data.objects if o.type == "LIGHT")
    bpy.context.scene.cursor.location = lamp.location
    bpy.data.objects.remove(lamp)
    file = Path(package.__file__).parent / "libraries" / "luminaires" / "photometry" / LUMINAIRE
    result = bpy.ops.lumenray.drop_luminaire(filepath=str(file))
    require(result == {"FINISHED"}, f"dropping {LUMINAIRE} ended with {result}")
    require(any(o.type == "EMPTY" for o in bpy.data.objects), "no luminaire was made")
    return bake(folder)


def check_libraries(package):
    """Require that every asset is offered in the Asset Browser and can be appended, with what makes it what it is."""
    shipped = importlib.import_module(f"{package.__name__}.libraries.materials")
    luminaires = importlib.import_module(f"{package.__name__}.libraries.luminaires")
    models = luminaires.read_library(luminaires.FOLDER).models
    titles = {
        "Lumenray": ("luminaires.blend", {model.title for model in models}),
        "Lumenray: materials": ("materials.blend", {entry.title for entry in shipped.entries()}),
    }
    for name, (file, wanted) in titles.items():
        libraries = bpy.context.preferences.filepaths.asset_libraries
        found = next((entry for entry in libraries if entry.name == name), None)
        require(found is not None, f"there is no asset library '{name}'")
        path = Path(found.path) / file
        with bpy.data.libraries.load(str(path), link=False, assets_only=True) as (offered, taken):
            taken.objects, taken.collections = offered.objects, offered.collections
            taken.materials = offered.materials
        appended = [*taken.objects, *taken.collections, *taken.materials]
        left = wanted - {item.name for item in appended}
        require(not left, f"{file} does not offer {', '.join(sorted(left))} to this Blender")
        lamps = [item for item in taken.objects if item.type == "LIGHT"]
        lamps += [item for group in taken.collections for item in group.objects]
        for lamp in lamps:
            settings = lamp.data.lumenray.luminaire
            has_file = settings.use_file and settings.text is not None
            require(has_file, f"{lamp.name} comes without its photometric file")
        for material in taken.materials:
            require(material.lumenray.use_override, f"{material.name} comes without its override")


def check_scenes(package):
    """Require that this Blender opens the bundled scenes."""
    scenes = importlib.import_module(f"{package.__name__}.libraries.scenes")
    for name in scenes.NAMES:
        bpy.ops.wm.open_mainfile(filepath=str(scenes.scene_path(name)))
        scene = bpy.context.scene
        require(scene.camera is not None, f"the scene {name} opens without its camera")
        require(scene.render.engine == "LUMENRAY", f"{name} opens with {scene.render.engine}")
        meshes = [item for item in scene.objects if item.type == "MESH" and item.data.polygons]
        require(meshes, f"the scene {name} opens without its surfaces")
        # They were saved before there were groups of settings.
        density = scene.lumenray.bake.density
        require(density == BAKE_DENSITY, f"{name} opens with {density} lumels per metre")


def register_again(package):
    """Unregister and register, and check that nothing stays behind or goes missing."""
    package.unregister()
    left = [name for name in dir(bpy.types) if name.startswith("LUMENRAY_")]
    require(not left, f"unregistering leaves {', '.join(left)}")
    require(not hasattr(bpy.types.Scene, "lumenray"), "unregistering leaves Scene.lumenray")
    package.register()
    require(hasattr(bpy.types.Scene, "lumenray"), "registering again brings no Scene.lumenray")


def use(folder):
    """Go through everything and write ``smoke.json`` and ``box.blend``."""
    folder.mkdir(parents=True, exist_ok=True)
    package = load_package()
    check_libraries(package)
    check_scenes(package)
    open_box(package)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "box.blend"))
    measured = {"luminance": render(folder, "first"), "illuminance": bake(folder / "bake")}
    if not IS_WHEEL:
        measured["luminance by a cluster"] = render_on_cluster(package, folder)
    check_regions(folder)
    measured["illuminance by a luminaire"] = bake_luminaire(package, folder / "luminaire")
    register_again(package)
    open_box(package)
    measured["luminance after registering again"] = render(folder, "second")
    write(folder, {"blender": bpy.app.version_string, "measured": measured})
    if IS_WHEEL:
        package.unregister()


def read(folder):
    """Add the picture that the command line rendered to ``smoke.json``."""
    record = json.loads((folder / "smoke.json").read_text(encoding="utf-8"))
    measured = read_luminance(folder / "line_0001.exr")
    record["measured"]["luminance from the command line"] = measured
    write(folder, record)


def write(folder, record):
    """Write ``smoke.json`` and show it."""
    text = json.dumps(record, indent=2)
    (folder / "smoke.json").write_text(text + "\n", encoding="utf-8")
    print(text)


def main():
    """Do what the arguments (after ``--``, inside Blender) ask for."""
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    verb, folder = arguments
    {"use": use, "read": read}[verb](Path(folder).resolve())


main()
