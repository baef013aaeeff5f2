"""Particles of a pigment layer as objects: points on which nodes put one particle each, in a box of the binder.

What Blender keeps of a particle is a point with its diameter and its rotation; its shape is made once for each pigment.
"""

import bpy
import numpy as np

from ...engine.errors import SceneError
from ...engine.ink.composition import Ink
from ...engine.ink.packing import Packing, count_spheres
from ...engine.ink.particles import Chain, chain_of
from ...engine.ink.plan import FIRST, LAST, make_plan
from ...engine.ink.reader import parse_ink
from ...engine.ink.realisation import face_of, pack_ink, thickness_of
from ..foundation.units import metres_per_unit
from .description import describe
from .readout import shown_colour

MICROMETRE = 1e-6
"""[m]"""

MOST_SPHERES = 20_000
"""Spheres that are shown: packing them takes some seconds, in which Blender waits, and each has `FACES` by itself."""

FACES = ((2_000, 3), (MOST_SPHERES, 2))
"""Subdivisions of a sphere, 320 and 80 triangles, up to so many spheres."""

BANDS = np.linspace(FIRST, LAST, 33)
"""By which colours are found. [nm]"""

DEPTH = 0.5
"""How much of a pigment light crosses that shows its colour: about as much as there is in a printed layer. [um]"""

CLEAR = 0.08
"""Opacity of the box."""

MOST_HILLS = 64
"""Steps of a rough upper face, each way."""

WORDS = {"rice": "grains", "cylinder": "rods", "sphere": "balls"}
"""What people call particles, by their shapes."""


def add_structure(context, settings, realisation: int, magnification: float) -> bpy.types.Object:
    """Put the particles of a realisation, as waves meet them, at the 3D cursor.

    Parameters
    ----------
    context : bpy.types.Context
    settings : LumenrayInkSettings
    realisation : int    As of `engine.ink.realisation`; those that are solved begin at 0.
    magnification : float    Of lengths. [-]

    Returns
    -------
    bpy.types.Object    The box, which the objects of the pigments are children of; its custom properties tell the scale.

    Raises
    ------
    FileFormatError    The composition says what cannot be.
    SceneError    There are too many particles, or they do not fit.
    """
    ink = parse_ink(describe(settings))
    plan = make_plan(ink, draft=settings.quality == "DRAFT")
    thickness = thickness_of(ink, realisation)
    count = count_spheres([each.population for each in ink.particles], plan.width, thickness)
    if count > MOST_SPHERES:
        raise SceneError(
            f"about {count:,} spheres are too many to show, expected {MOST_SPHERES:,} at most; choose Draft, or state a "
            "narrower cell in the description ('cell_um' of 'solution')"
        )
    packing = pack_ink(ink, plan.width, plan.seed, realisation) if ink.particles else None
    # Lengths of Blender's to the micrometre.
    scale = magnification * MICROMETRE / metres_per_unit(context.scene)
    box = _make_box(ink, plan.width, thickness, face_of(ink, plan, realisation), scale)
    box.name = f"{ink.name or 'Pigment layer'}, 1 µm = {100.0 * MICROMETRE * magnification:.3g} cm"
    box.location = context.scene.cursor.location
    told = {
        "magnification": magnification,
        "width_um": plan.width,
        "thickness_um": thickness,
        "realisation": realisation,
        "seed": plan.seed,
    }
    for name, value in told.items():
        box[name] = value
    made = [box]
    if packing is not None:
        faces = next(level for most, level in FACES if len(packing.spheres()[1]) <= most)
        for number, pigment in enumerate(ink.particles):
            name, population = pigment.name or f"pigment {number + 1}", pigment.population
            item = _make_points(packing, packing.kinds == number, scale)
            words = WORDS[population.shape]
            item.name = item.data.name = f"{len(item.data.vertices):,} {words} of {name}"
            paint = _make_material(name, _tint(pigment.index.at(BANDS), DEPTH))
            nodes = _make_nodes(
                f"{words.capitalize()} of {name}", chain_of(population.shape), faces, paint
            )
            item.modifiers.new("Particles", "NODES").node_group = nodes
            item["volume_fraction"] = population.share
            item.parent = box
            made.append(item)
    for item in made:
        context.collection.objects.link(item)
    return box


def _tint(index, depth: float) -> tuple[float, float, float]:
    """Linear colour of light that has crossed matter without being scattered. (w,) complex, [um]"""
    passed = np.exp(-4.0 * np.pi * np.imag(index) * depth / (1e-3 * BANDS))
    return shown_colour(passed, BANDS)


def _make_box(ink: Ink, width, thickness, heights, scale) -> bpy.types.Object:
    """Make the layer: its lower face at 0, its upper one as the heights have it."""
    step = max(1, -(-len(heights) // MOST_HILLS))
    hills = heights[::step, ::step] if heights.size else np.zeros((1, 1))
    count = len(hills)
    # The cell repeats, so that the last row is the first one.
    top = thickness + np.pad(hills, (0, 1), mode="wrap")
    y, x = (width * (each / count - 0.5) for each in np.mgrid[: count + 1, : count + 1])
    corners = 0.5 * width * np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    points = np.concatenate([np.stack([x, y, top], axis=-1).reshape(-1, 3), corners])
    rows = np.arange((count + 1) ** 2).reshape(count + 1, count + 1)
    quads = np.stack([rows[:-1, :-1], rows[:-1, 1:], rows[1:, 1:], rows[1:, :-1]], axis=-1)
    low = rows.size + np.arange(4)
    edges = (rows[0, ::-1], rows[::-1, -1], rows[-1], rows[:, 0])
    sides = [(low[k], low[(k + 1) % 4], *edge) for k, edge in enumerate(edges)]
    faces = [*quads.reshape(-1, 4).tolist(), *sides, low[::-1]]
    mesh = bpy.data.meshes.new("Layer")
    mesh.from_pydata((scale * points).tolist(), [], [list(map(int, face)) for face in faces])
    matrix = np.sqrt(np.array([ink.matrix(nm) for nm in BANDS]))
    mesh.materials.append(_make_material("Binder", _tint(matrix, ink.thickness), CLEAR))
    return bpy.data.objects.new("Layer", mesh)


def _make_points(packing: Packing, own, scale: float) -> bpy.types.Object:
    """Make the points of a pigment; ``own``: which particles are of it."""
    centres = packing.centres[own] - np.array([0.5, 0.5, 0.0]) * packing.width
    centres[:, 2] = packing.thickness - centres[:, 2]
    axes = packing.axes[own] * np.array([1.0, 1.0, -1.0])
    # Rods are the same either way, so the nearer end is turned to the axis.
    axes = np.where(axes[:, 2:] < 0.0, -axes, axes)
    rotations = np.stack([1.0 + axes[:, 2], -axes[:, 1], axes[:, 0], np.zeros(len(axes))], axis=1)
    rotations /= np.linalg.norm(rotations, axis=1, keepdims=True)
    mesh = bpy.data.meshes.new("Particles")
    mesh.vertices.add(len(centres))
    mesh.vertices.foreach_set("co", (scale * centres).astype(np.float32).ravel())
    for key, kind, values in (
        ("diameter", "FLOAT", scale * packing.diameters[own]),
        ("rotation", "QUATERNION", rotations),
    ):
        attribute = mesh.attributes.new(key, kind, "POINT")
        attribute.data.foreach_set("value", values.astype(np.float32).ravel())
    return bpy.data.objects.new("Particles", mesh)


def _make_nodes(name: str, chain: Chain, faces: int, material) -> bpy.types.GeometryNodeTree:
    """Make the nodes that put a chain of spheres on each point, turned and as large as the point says."""
    tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
    tree.is_modifier = True
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    nodes, links = tree.nodes, tree.links

    def node(kind: str, place: float, height: float = 0.0):
        made = nodes.new(kind)
        made.location = 200.0 * place, height
        return made

    ball, join = node("GeometryNodeMeshIcoSphere", -5), node("GeometryNodeJoinGeometry", -3)
    ball.inputs["Radius"].default_value, ball.inputs["Subdivisions"].default_value = 1.0, faces
    for number, (place, radius) in enumerate(zip(chain.places, chain.radii, strict=True)):
        member = node("GeometryNodeTransform", -4, -320.0 * number)
        member.inputs["Translation"].default_value = 0.0, 0.0, float(place)
        member.inputs["Scale"].default_value = (float(radius),) * 3
        links.new(ball.outputs["Mesh"], member.inputs["Geometry"])
        links.new(member.outputs["Geometry"], join.inputs["Geometry"])
    smooth, paint = node("GeometryNodeSetShadeSmooth", -2), node("GeometryNodeSetMaterial", -1)
    paint.inputs["Material"].default_value = material
    points, put = node("NodeGroupInput", -1, 200.0), node("GeometryNodeInstanceOnPoints", 0)
    end = node("NodeGroupOutput", 3)
    links.new(join.outputs["Geometry"], smooth.inputs["Geometry"])
    links.new(smooth.outputs["Geometry"], paint.inputs["Geometry"])
    links.new(paint.outputs["Geometry"], put.inputs["Instance"])
    links.new(points.outputs["Geometry"], put.inputs["Points"])
    for number, (key, kind, socket) in enumerate(
        (("rotation", "QUATERNION", "Rotation"), ("diameter", "FLOAT", "Scale"))
    ):
        value = node("GeometryNodeInputNamedAttribute", -1, -200.0 * (number + 1))
        value.data_type, value.inputs["Name"].default_value = kind, key
        links.new(value.outputs["Attribute"], put.inputs[socket])
    # Renders have one mesh for all: engines that know thousands of objects by themselves take long to take them over.
    seen, choice = node("GeometryNodeIsViewport", 0, 200.0), node("GeometryNodeSwitch", 2)
    joined = node("GeometryNodeRealizeInstances", 1, -200.0)
    choice.input_type = "GEOMETRY"
    links.new(put.outputs["Instances"], joined.inputs["Geometry"])
    links.new(seen.outputs["Is Viewport"], choice.inputs["Switch"])
    links.new(joined.outputs["Geometry"], choice.inputs["False"])
    links.new(put.outputs["Instances"], choice.inputs["True"])
    links.new(choice.outputs["Output"], end.inputs["Geometry"])
    return tree


def _make_material(name: str, colour, opacity: float = 1.0) -> bpy.types.Material:
    """Make a material that all engines show alike."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        # Before Blender 5.0, where materials have nodes at all times.
        material.use_nodes = True
    shader = next(each for each in material.node_tree.nodes if each.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = *colour, 1.0
    shader.inputs["Alpha"].default_value = opacity
    material.diffuse_color = *colour, opacity
    return material
