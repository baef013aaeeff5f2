"""Small scenes of Blender, made by script: what all features have in common."""

import bpy
import numpy as np

SIDE = 48
"""Width and height of the pictures. [pixel]"""


class Stage:
    """A scene that is empty at first.

    Attributes
    ----------
    scene : bpy.types.Scene
    """

    def __init__(self):
        # Without the preferences: reading those too takes five times as long.
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        if "cycles" not in bpy.context.preferences.addons:
            bpy.ops.preferences.addon_enable(module="cycles")
        self.scene = bpy.context.scene
        render = self.scene.render
        render.resolution_x = render.resolution_y = SIDE
        render.resolution_percentage = 100

    def link(self, name, data, **settings):
        """Add an object."""
        item = bpy.data.objects.new(name, data)
        for key, value in settings.items():
            setattr(item, key, value)
        self.scene.collection.objects.link(item)
        return item

    def mesh(self, name, vertices, faces, material=None, **settings):
        """Add a mesh."""
        data = bpy.data.meshes.new(name)
        data.from_pydata(vertices, [], faces)
        if material is not None:
            data.materials.append(material)
        return self.link(name, data, **settings)

    def tile(self, material, **settings):
        """Add a square of two units with a UV map, which faces up."""
        corners = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
        item = self.mesh("Tile", corners, [(0, 1, 2, 3)], material, **settings)
        layer = item.data.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float).ravel())
        return item

    def grid(self, material, is_smooth=True, count=40):
        """Add a square of two units of many faces with a UV map."""
        step = np.linspace(-1.0, 1.0, count + 1)
        corners = [(x, y, 0.0) for y in step for x in step]
        first = [row * (count + 1) + column for row in range(count) for column in range(count)]
        faces = [(n, n + 1, n + count + 2, n + count + 1) for n in first]
        item = self.mesh("Grid", corners, faces, material)
        layer = item.data.uv_layers.new(name="UVMap")
        places = np.array([corners[n][:2] for face in faces for n in face])
        layer.data.foreach_set("uv", (0.5 + 0.5 * places).ravel())
        item.data.polygons.foreach_set("use_smooth", [is_smooth] * len(faces))
        return item

    def ball(self, material, radius=0.8, location=(0.0, 0.0, 0.8), name="Ball", is_smooth=True):
        """Add a sphere with a UV map."""
        bpy.ops.mesh.primitive_uv_sphere_add(
            radius=radius, location=location, segments=48, ring_count=24
        )
        item = bpy.context.object
        item.name = name
        item.data.materials.append(material)
        item.data.polygons.foreach_set("use_smooth", [is_smooth] * len(item.data.polygons))
        return item

    def light(self, kind, location=(0.0, 0.0, 3.0), energy=100.0, turn=(0.0, 0.0, 0.0), **settings):
        """Add a light."""
        data = bpy.data.lights.new("Light", kind)
        data.energy = energy
        for key, value in settings.items():
            setattr(data, key, value)
        return self.link("Light", data, location=location, rotation_euler=turn)

    def world(self, colour=(1.0, 1.0, 1.0), strength=1.0) -> "Tree":
        """Give the scene a world; returns its nodes."""
        world = self.scene.world = bpy.data.worlds.new("World")
        tree = Tree(world, "ShaderNodeOutputWorld")
        tree.show(tree.add("Background", Color=(*colour, 1.0), Strength=strength))
        return tree

    def camera(self, location=(0.0, -5.0, 2.2), turn=(1.25, 0.0, 0.0), **settings):
        """Add the camera."""
        data = bpy.data.cameras.new("Camera")
        for key, value in settings.items():
            setattr(data, key, value)
        item = self.link("Camera", data, location=location, rotation_euler=turn)
        self.scene.camera = item
        return item

    def above(self):
        """Look down on a tile, a little inside its edges."""
        return self.camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), type="ORTHO", ortho_scale=1.9)

    def studio(self, material=None, floor=None):
        """Put a ball on a floor under an area light and a dim world, before a camera; returns the ball."""
        self.world((0.5, 0.6, 0.8), 0.4)
        self.light("AREA", (1.5, -1.5, 3.5), 150.0, (0.5, 0.35, 0.0), size=1.5)
        self.tile(floor or self.paint(), scale=(3.0, 3.0, 3.0))
        self.camera()
        return self.ball(material or self.paint((0.7, 0.3, 0.2)))

    def paint(self, colour=(0.6, 0.6, 0.6)):
        """Return a matt material."""
        tree = self.material()
        tree.show(tree.add("BsdfDiffuse", Color=(*colour, 1.0)))
        return tree.owner

    def material(self) -> "Tree":
        """Return the nodes of a new material."""
        return Tree(bpy.data.materials.new("Material"), "ShaderNodeOutputMaterial")


class Tree:
    """A node tree under construction; ``owner``: the material or world."""

    def __init__(self, owner, output):
        self.owner = owner
        if bpy.app.version < (5, 0, 0):
            owner.use_nodes = True
        self.nodes, self.links = owner.node_tree.nodes, owner.node_tree.links
        self.nodes.clear()
        self.output = self.nodes.new(output)

    def add(self, kind, attributes=None, out=0, **values):
        """Add a node and return one of its outputs; ``values``: inputs by name, ``_0`` by number, numbers or outputs."""
        node = self.nodes.new(f"ShaderNode{kind}")
        for name, value in (attributes or {}).items():
            setattr(node, name, value)
        for name, value in values.items():
            key = int(name[1:]) if name[0] == "_" else name.replace("_", " ")
            self.set(node.inputs[key], value)
        return node.outputs[out]

    def set(self, socket, value):
        """Set an input, or link it."""
        if isinstance(value, bpy.types.NodeSocket):
            self.links.new(value, socket)
        else:
            socket.default_value = value

    def show(self, output, to="Surface"):
        """Link an output to the end of the tree, and return whose tree it is."""
        self.links.new(output, self.output.inputs[to])
        return self.owner


def image(name="Picture", size=8, is_float=True, is_smooth=True):
    """Make a picture of soft colours, or of noise."""
    x, y = np.meshgrid(np.arange(size) / size, np.arange(size) / size)
    pixels = np.ones((size, size, 4), np.float32)
    pixels[..., 0] = 0.5 + 0.4 * np.sin(2 * np.pi * x)
    pixels[..., 1] = 0.5 + 0.4 * np.cos(2 * np.pi * y)
    pixels[..., 2] = 0.4
    if not is_smooth:
        pixels[..., :3] = np.random.default_rng(1).random((size, size, 3))
    made = bpy.data.images.new(name, size, size, float_buffer=is_float)
    made.pixels.foreach_set(pixels.ravel())
    made.update()
    return made


def panorama():
    """Make a picture of surroundings, brighter above."""
    made = bpy.data.images.new("Sky", 32, 16, float_buffer=True)
    x, y = np.meshgrid(np.arange(32) / 32, np.arange(16) / 16)
    pixels = np.ones((16, 32, 4), np.float32)
    pixels[..., 0] = 0.5 + 0.3 * np.sin(2 * np.pi * x) + y
    pixels[..., 1] = 0.5 + y
    pixels[..., 2] = 0.6 + y
    made.pixels.foreach_set(pixels.ravel())
    made.update()
    return made
