"""Program of a process of its own that measures illuminances with Cycles, in Blender's Python module.

It imports nothing of ours: scenes come as plain data through a connection, illuminances go back. Every sensor is a tiny
white square that no ray can meet; Cycles bakes what falls on it. Units are lumens in place of Blender's watts.
"""

import os
import sys
from multiprocessing.connection import Listener

import bpy
import numpy as np
from mathutils import Matrix

LIMIT = 1024
"""Bounces of every kind, the most that Cycles allows."""

CURVE_STEPS = 1801
"""Values of a function of an angle: every 0.05 degrees."""

MAP_SIZE = 512
"""Width of the table by which directions to the sky are chosen. [pixel]"""


def serve(key: bytes, answer) -> None:
    """Say where to connect, then answer requests until the other side closes; an error is answered by its text.

    ``answer``: callable, request to answer.
    """
    with Listener(authkey=key) as listener:
        sys.stdout.write(f"{listener.address}\n")
        sys.stdout.flush()
        # Blender reports every bake and render there.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        link = listener.accept()
    with link:
        while True:
            try:
                request = link.recv()
            except EOFError:
                return
            try:
                found = answer(request)
            except Exception as error:
                found = f"{type(error).__name__}: {error}"
            link.send(found)


def measure(request: dict) -> np.ndarray:
    """Build the scene of a request and bake; see `cycles_scene.describe`. (n, k) illuminances of k patches of each sensor"""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    settle(request)
    for entry in request["meshes"]:
        add_mesh(entry)
    for entry in request["lights"]:
        add_light(entry)
    add_world(request["world"])
    return bake(request)


def settle(request: dict) -> None:
    """Set Cycles to the most accurate it has."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = request["samples"]
    cycles.seed = request["seed"]
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.use_auto_tile = False
    cycles.light_sampling_threshold = 0.0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.film_exposure = 1.0
    for name in ("max", "diffuse", "glossy", "transmission", "transparent_max"):
        setattr(cycles, f"{name}_bounces", LIMIT)


# ---- surfaces ----


def add_mesh(entry: dict) -> None:
    """Add triangles with one material."""
    mesh = bpy.data.meshes.new("mesh")
    triangles = entry["triangles"]
    mesh.vertices.add(len(entry["vertices"]))
    mesh.vertices.foreach_set("co", entry["vertices"].astype(np.float32).ravel())
    mesh.loops.add(triangles.size)
    mesh.loops.foreach_set("vertex_index", triangles.astype(np.int32).ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    # Faces are smooth unless told otherwise.
    mesh.shade_flat()
    mesh.materials.append(make_material(entry["material"]))
    add_object(bpy.data.objects.new("mesh", mesh))


def add_object(item) -> None:
    """Put an object into the scene."""
    bpy.context.scene.collection.objects.link(item)


def make_material(entry: dict):
    """Make a material of closures that are added up."""
    material = bpy.data.materials.new("material")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    closures = []
    match entry["kind"]:
        case "diffuse":
            closures.append(closure(tree, "ShaderNodeBsdfDiffuse", entry["reflectance"]))
            if entry["transmittance"] > 0.0:
                closures.append(closure(tree, "ShaderNodeBsdfTranslucent", entry["transmittance"]))
        case "mirror":
            closures.append(mirror(tree, entry["reflectance"]))
        case "glass":
            transmitted, reflected = glass(tree, entry["ior"], entry["transmittance"])
            closures += [
                closure(tree, "ShaderNodeBsdfTransparent", transmitted),
                mirror(tree, reflected),
            ]
        case "table":
            angle = incidence(tree).apply("ARCCOSINE") * (180.0 / np.pi)
            curves = [curve(angle, entry["angles"], entry[k]) for k in ("through", "back")]
            closures += [
                closure(tree, "ShaderNodeBsdfTransparent", curves[0]),
                mirror(tree, curves[1]),
            ]
    if entry["luminance"] > 0.0:
        glow = tree.nodes.new("ShaderNodeEmission")
        glow.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
        strength = Number(tree, entry["luminance"])
        if not entry["two_sided"]:
            geometry = tree.nodes.new("ShaderNodeNewGeometry")
            strength = strength * (1.0 - Number(tree, geometry.outputs["Backfacing"]))
        strength.into(glow.inputs["Strength"])
        closures.append(glow.outputs[0])
        material.cycles.emission_sampling = "FRONT_BACK" if entry["two_sided"] else "FRONT"
    else:
        material.cycles.emission_sampling = "NONE"
    total = closures[0]
    for other in closures[1:]:
        both = tree.nodes.new("ShaderNodeAddShader")
        tree.links.new(total, both.inputs[0])
        tree.links.new(other, both.inputs[1])
        total = both.outputs[0]
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(total, output.inputs["Surface"])
    return material


def closure(tree, kind: str, value):
    """Closure of a neutral colour, a number or a `Number`."""
    node = tree.nodes.new(kind)
    if isinstance(value, Number):
        value.into(node.inputs["Color"])
    else:
        node.inputs["Color"].default_value = (value, value, value, 1.0)
    return node.outputs[0]


def mirror(tree, value):
    """Ideal mirror."""
    output = closure(tree, "ShaderNodeBsdfAnisotropic", value)
    output.node.inputs["Roughness"].default_value = 0.0
    return output


class Number:
    """A socket or a constant of a node tree that can be calculated with."""

    def __init__(self, tree, value):
        self.tree, self.value = tree, value

    def into(self, socket) -> None:
        """Connect to an input."""
        if isinstance(self.value, float | int):
            socket.default_value = float(self.value)
        else:
            self.tree.links.new(self.value, socket)

    def apply(self, operation: str, *others) -> "Number":
        """Result of a Math node."""
        node = self.tree.nodes.new("ShaderNodeMath")
        node.operation = operation
        for socket, value in zip(node.inputs, (self, *others), strict=False):
            (value if isinstance(value, Number) else Number(self.tree, value)).into(socket)
        return Number(self.tree, node.outputs[0])

    def __add__(self, other):
        return self.apply("ADD", other)

    def __sub__(self, other):
        return self.apply("SUBTRACT", other)

    def __rsub__(self, other):
        return Number(self.tree, other) - self

    def __mul__(self, other):
        return self.apply("MULTIPLY", other)

    def __truediv__(self, other):
        return self.apply("DIVIDE", other)

    def __rtruediv__(self, other):
        return Number(self.tree, other) / self


def incidence(tree) -> Number:
    """Cosine of the angle of incidence."""
    geometry = tree.nodes.new("ShaderNodeNewGeometry")
    dot = tree.nodes.new("ShaderNodeVectorMath")
    dot.operation = "DOT_PRODUCT"
    tree.links.new(geometry.outputs["Normal"], dot.inputs[0])
    tree.links.new(geometry.outputs["Incoming"], dot.inputs[1])
    return Number(tree, dot.outputs["Value"]).apply("ABSOLUTE").apply("MINIMUM", 1.0)


def glass(tree, ior: float, body: float) -> tuple[Number, Number]:
    """Transmittance and reflectance of a pane: both polarisations through both faces (Airy's sums without phase)."""
    cosine = incidence(tree)
    inner = (1.0 - (1.0 - cosine * cosine) / ior**2).apply("SQRT")
    weakened = Number(tree, body).apply("POWER", 1.0 / inner)
    through, back = Number(tree, 0.0), Number(tree, 0.0)
    for one, two in ((cosine, inner * ior), (cosine * ior, inner)):
        ratio = (one - two) / (one + two)
        face = ratio * ratio
        lost = 1.0 - face
        passed = lost * lost * weakened / (1.0 - face * face * weakened * weakened)
        through = through + passed * 0.5
        back = back + (face + face * weakened * passed) * 0.5
    return through, back


def curve(angle: Number, angles, values) -> Number:
    """Piecewise linear function of an angle [deg], from a picture with one row."""
    places = np.linspace(0.0, 90.0, CURVE_STEPS)
    pixels = np.ones((CURVE_STEPS, 4), dtype=np.float32)
    pixels[:, :3] = np.interp(places, angles, values)[:, None]
    image = bpy.data.images.new("curve", CURVE_STEPS, 1, float_buffer=True, is_data=True)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    node = angle.tree.nodes.new("ShaderNodeTexImage")
    node.image, node.interpolation, node.extension = image, "Linear", "EXTEND"
    place = angle.tree.nodes.new("ShaderNodeCombineXYZ")
    # The first and the last value lie at the middle of their pixels.
    share = angle * ((CURVE_STEPS - 1) / (90.0 * CURVE_STEPS)) + 0.5 / CURVE_STEPS
    share.into(place.inputs["X"])
    place.inputs["Y"].default_value = 0.5
    angle.tree.links.new(place.outputs[0], node.inputs["Vector"])
    return Number(angle.tree, node.outputs["Color"])


# ---- lights ----


def add_light(entry: dict) -> None:
    """Add a lamp, or a portal."""
    kind = entry["kind"]
    data = bpy.data.lights.new("light", kind)
    data.energy = entry.get("power", 1.0)
    data.normalize = True
    match kind:
        case "POINT":
            data.shadow_soft_size = entry["radius"]
        case "SPOT":
            data.shadow_soft_size = entry["radius"]
            data.spot_size, data.spot_blend = entry["spot_size"], entry["spot_blend"]
        case "SUN":
            data.angle = entry["angle"]
        case "AREA":
            data.shape = entry["shape"]
            data.size, data.size_y = entry["size_x"], entry["size_y"]
            data.cycles.is_portal = entry["is_portal"]
    if "ies" in entry:
        add_photometry(data, entry["ies"])
    if hasattr(data, "use_soft_falloff"):
        data.use_soft_falloff = False
    lamp = bpy.data.objects.new("light", data)
    # A bare list would be taken by columns.
    lamp.matrix_world = Matrix(entry["frame"].tolist())
    add_object(lamp)


def add_photometry(data, text: str) -> None:
    """Let a lamp shine as a photometric file says."""
    file = bpy.data.texts.new("file")
    file.write(text)
    data.use_nodes = True
    tree = data.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNodeTexIES")
    node.mode, node.ies = "INTERNAL", file
    glow = tree.nodes.new("ShaderNodeEmission")
    glow.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    tree.links.new(node.outputs["Fac"], glow.inputs["Strength"])
    output = tree.nodes.new("ShaderNodeOutputLight")
    tree.links.new(glow.outputs[0], output.inputs["Surface"])


def add_world(entry: dict | None) -> None:
    """Set the surroundings: black, uniform, or a sky of the CIE over a ground."""
    world = bpy.data.worlds.new("world")
    bpy.context.scene.world = world
    world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    output = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    if entry is None:
        background.inputs["Strength"].default_value = 0.0
        return
    world.cycles.sampling_method = "MANUAL"
    world.cycles.sample_map_resolution = MAP_SIZE
    if entry["kind"] == "uniform":
        background.inputs["Strength"].default_value = entry["luminance"]
        return
    sky(tree, entry).into(background.inputs["Strength"])


def sky(tree, entry: dict) -> Number:
    """Luminance of a sky of the CIE (CIE S 011/E:2003) and of the ground below it."""
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    split = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(coordinates.outputs["Generated"], split.inputs[0])
    x, y, z = (Number(tree, split.outputs[k]) for k in range(3))
    height = z.apply("MAXIMUM", 1e-6)
    if entry["parameters"] is None:
        above = (height * 2.0 + 1.0) / 3.0
    else:
        a, b, c, d, e = entry["parameters"]
        sun = entry["towards_sun"]
        cosine = x * float(sun[0]) + y * float(sun[1]) + z * float(sun[2])
        cosine = cosine.apply("MINIMUM", 1.0).apply("MAXIMUM", -1.0)
        halo = (cosine.apply("ARCCOSINE") * d).apply("EXPONENT") - float(np.exp(d * np.pi / 2.0))
        above = (halo * c + cosine * cosine * e + 1.0) * (
            (Number(tree, b) / height).apply("EXPONENT") * a + 1.0
        )
    is_above = z.apply("GREATER_THAN", 0.0)
    return is_above * above * entry["scale"] + (1.0 - is_above) * entry["ground"]


# ---- measuring ----


def bake(request: dict) -> np.ndarray:
    """Illuminance of the sensors' patches, (n, k)."""
    side, count = request["side"], len(request["positions"])
    columns = int(np.ceil(np.sqrt(count)))
    rows = -(-count // columns)
    receiver = make_receivers(request, columns, rows)
    image = bpy.data.images.new(
        "image", columns * side, rows * side, float_buffer=True, is_data=True, alpha=True
    )
    tree = receiver.data.materials[0].node_tree
    target = tree.nodes.new("ShaderNodeTexImage")
    target.image = image
    tree.nodes.active = target
    add_object(receiver)
    bpy.context.view_layer.objects.active = receiver
    receiver.select_set(True)
    passes = {"DIRECT"} if request["direct"] else {"DIRECT", "INDIRECT"}
    bpy.ops.object.bake(type="DIFFUSE", pass_filter=passes, margin=0, use_clear=True)
    pixels = np.empty(4 * image.size[0] * image.size[1], dtype=np.float32)
    image.pixels.foreach_get(pixels)
    grid = pixels.reshape(rows, side, columns, side, 4)[..., 1].transpose(0, 2, 1, 3)
    # A bake without colour is the illuminance over pi.
    return np.pi * grid.reshape(rows * columns, side * side)[:count].astype(np.float64)


def make_receivers(request: dict, columns: int, rows: int):
    """Return an object of one white square for each sensor, each with its own pixels, which rays pass by."""
    positions, normals = request["positions"], request["normals"]
    count = len(positions)
    helper = np.where(np.abs(normals[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    u = np.cross(helper, normals)
    u *= 0.5 * request["receiver"] / np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(normals, u)
    corners = np.stack(
        [positions - u - v, positions + u - v, positions + u + v, positions - u + v], axis=1
    )
    mesh = bpy.data.meshes.new("receivers")
    mesh.vertices.add(4 * count)
    mesh.vertices.foreach_set("co", corners.astype(np.float32).ravel())
    mesh.loops.add(4 * count)
    mesh.loops.foreach_set("vertex_index", np.arange(4 * count, dtype=np.int32))
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 4 * count, 4, dtype=np.int32))
    place = np.stack([np.arange(count) % columns, np.arange(count) // columns], axis=1)
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    uv = (place[:, None] + square) / [columns, rows]
    mesh.uv_layers.new(name="uv").data.foreach_set("uv", uv.astype(np.float32).ravel())
    mesh.update(calc_edges=True)
    # So small squares have no accurate normals of their own.
    mesh.normals_split_custom_set(np.repeat(normals, 4, axis=0).astype(np.float32))
    mesh.materials.append(
        make_material(
            {"kind": "diffuse", "reflectance": 0.8, "transmittance": 0.0, "luminance": 0.0}
        )
    )
    receiver = bpy.data.objects.new("receivers", mesh)
    for name in ("diffuse", "glossy", "transmission", "volume_scatter", "shadow"):
        setattr(receiver, f"visible_{name}", False)
    return receiver


if __name__ == "__main__":
    serve(bytes.fromhex(sys.stdin.readline().strip()), measure)
