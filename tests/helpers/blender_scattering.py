"""Materials that scatter light as a file says."""

import bpy
import numpy as np

from lumenray.engine.scene.scattering import ScatterTable

INCIDENCES = np.radians([0.0, 30.0, 60.0])


def matt(reflectance, wavelengths=(550.0,), rotations=(0.0,)):
    """A table of Lambert's law; ``reflectance`` a number or one for each wavelength."""
    shape = (len(rotations), 3, 2, 2, len(wavelengths))
    values = np.broadcast_to(np.asarray(reflectance, np.float32) / np.float32(np.pi), shape).copy()
    return ScatterTable(
        np.asarray(rotations, float),
        INCIDENCES,
        np.array([0.0, np.pi]),
        np.array([0.0, np.pi]),
        np.asarray(wavelengths, float),
        values,
    )


def add_paint(path="", name="Paint"):
    """Return a new material that is the active one of an object; with a path, a measured one."""
    material = bpy.data.materials.new(name)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0)], [], [(0, 1, 2)])
    mesh.materials.append(material)
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    if path:
        material.lumenray.use_override, material.lumenray.model = True, "MEASURED"
        material.lumenray.measured.filepath = path
    return material
