"""What every scene needs around its geometry: collections, materials, lights, sky, camera."""

import math

import bpy

ENGINE = "LUMENRAY"
"""Identifier of our render engine."""


def new_collection(name):
    """Return a new collection of the current scene."""
    collection = bpy.data.collections.new(name)
    bpy.context.scene.collection.children.link(collection)
    return collection


def new_material(name, shader, inputs, image=None):
    """Return a material of one shader node.

    Parameters
    ----------
    name : str
    shader : str    Node type, such as ``ShaderNodeBsdfPrincipled``.
    inputs : dict    Values by socket name; colours as (3,) linear.
    image : bpy.types.Image or None    Drives the first colour socket by the mesh's UV map.
    """
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        # Only before Blender 5.0, where materials have nodes at all times.
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    node = tree.nodes.new(shader)
    node.location = (-300.0, 0.0)
    for socket, value in inputs.items():
        is_colour = node.inputs[socket].type == "RGBA"
        node.inputs[socket].default_value = (*value, 1.0) if is_colour else value
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    if "Base Color" in inputs or "Color" in inputs:
        material.diffuse_color = (*inputs.get("Base Color", inputs.get("Color")), 1.0)
    if image is not None:
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.location = (-600.0, 0.0)
        texture.image = image
        tree.links.new(texture.outputs["Color"], node.inputs[0])
    return material


def override(material, model, **values):
    """Switch a material's physical override on, set ``model`` and its values, and return it."""
    settings = material.lumenray
    settings.use_override = True
    settings.model = model
    for key, value in values.items():
        setattr(settings, key, value)
    return material


def new_light(name, kind, collection, location, quantity, value, spectrum="RGB", **settings):
    """Return a light object stated in photometric units.

    Parameters
    ----------
    name, kind : str    ``kind`` is Blender's ``POINT``, ``AREA``, ``SUN`` or ``SPOT``.
    collection : bpy.types.Collection
    location : (3,) sequence    [m]
    quantity : str    One of our light quantities.
    value : float    In the unit of the quantity. [lm, cd, lx, cd/m2 or W]
    spectrum : str    One of our spectra.
    **settings    Further values of our light settings.
    """
    light = bpy.data.lights.new(name, kind)
    physical = light.lumenray
    physical.use_physical = True
    physical.quantity = quantity
    physical.value = value
    physical.spectrum = spectrum
    for key, setting in settings.items():
        setattr(physical, key, setting)
    # Blender's own watts agree, so that other engines show the same balance of lights.
    light.energy = value / bpy.context.scene.lumenray.efficacy
    item = bpy.data.objects.new(name, light)
    item.location = location
    # Blender hides lights from the camera at first; lamps are there to be seen.
    item.visible_camera = True
    collection.objects.link(item)
    return item


def new_camera(location, rotation, lens, shift_y=0.0):
    """Make the scene's camera.

    Parameters
    ----------
    location : (3,) sequence    [m]
    rotation : (3,) sequence    Euler angles. [degrees]
    lens : float    Focal length for a sensor 36 mm wide. [mm]
    shift_y : float    Vertical shift, which keeps verticals upright where a tilt would not. [-]
    """
    camera = bpy.data.cameras.new("Camera")
    camera.lens = lens
    camera.shift_y = shift_y
    camera.clip_start = 0.01
    camera.clip_end = 500.0
    item = bpy.data.objects.new("Camera", camera)
    item.location = location
    item.rotation_euler = [math.radians(angle) for angle in rotation]
    bpy.context.scene.collection.objects.link(item)
    bpy.context.scene.camera = item
    return item


def set_sky(colour, luminance):
    """Give the scene a uniform background.

    Parameters
    ----------
    colour : (3,) sequence    Linear colour.
    luminance : float    Of a white pixel. [cd/m2]
    """
    world = bpy.data.worlds.new("World")
    if world.node_tree is None:
        world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (*colour, 1.0)
    background.inputs["Strength"].default_value = luminance
    output = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    world.color = colour
    world.lumenray.unit = "LUMINANCE"
    bpy.context.scene.world = world


def set_render(width, height, white_luminance, samples=64, view_transform="Standard"):
    """Set the picture size, our render settings and the engine if it is there.

    Parameters
    ----------
    width, height : int    [px]
    white_luminance : float    Luminance that becomes 1.0. [cd/m2]
    samples : int    Paths per pixel.
    view_transform : str    Blender's view transform.
    """
    scene = bpy.context.scene
    scene.render.resolution_x = width
    scene.render.resolution_y = height
    scene.view_settings.view_transform = view_transform
    scene.lumenray.white_luminance = white_luminance
    scene.lumenray.render.samples = samples
    scene.lumenray.bake.density = 12.0
    scene.lumenray.bake.samples = 256
    if any(getattr(t, "bl_idname", "") == ENGINE for t in bpy.types.RenderEngine.__subclasses__()):
        scene.render.engine = ENGINE
