"""Random edits of a small Blender scene, and the comparison of a scene kept current with one exported afresh.

Data-blocks are looked up anew for every edit, because undo makes all references invalid.
"""

import random
from pathlib import Path

import bpy


class RandomEdits:
    """A scene of about twenty objects and a seeded stream of edits.

    Parameters
    ----------
    seed : int
    folder : Path    Where the file is saved and opened again.
    only : collection of str or None    Names of the edits to choose from; None: all.
    """

    def __init__(self, seed: int, folder: Path, only=None):
        self.random = random.Random(seed)  # noqa: S311 - nothing secret
        self.path = Path(folder) / f"edits_{seed}.blend"
        self.count = 0
        self.names = sorted(only or EDITS)
        self.weights = [EDITS[name][1] for name in self.names]
        bpy.context.preferences.edit.use_global_undo = True
        self._build()
        remember("start")

    def edit(self) -> str:
        """Make one edit, bring the dependency graph up to date and return the edit's name."""
        name = self.random.choices(self.names, self.weights)[0]
        EDITS[name][0](self)
        bpy.context.view_layer.update()
        if name not in {"undo", "redo", "reopen"}:
            remember(name)
        elif name == "reopen":
            remember("opened")
        return name

    # ---- choosing ----

    def pick(self, blocks):
        """Return one of them, None if there is none."""
        blocks = sorted(blocks, key=lambda block: block.name)
        return self.random.choice(blocks) if blocks else None

    def pick_object(self, *types):
        """Return a random object of the scene."""
        scene = bpy.context.scene
        return self.pick(o for o in scene.objects if not types or o.type in types)

    def name(self, word) -> str:
        """Return a name that sorts anywhere."""
        self.count += 1
        return f"{self.random.choice('ABCXYZ')} {word} {self.count}"

    def vector(self, low=-3.0, high=3.0):
        """Return three random numbers."""
        return tuple(self.random.uniform(low, high) for _ in range(3))

    # ---- making ----

    def add_mesh(self, is_linked=True):
        """Make a mesh object of a few faces."""
        mesh = bpy.data.meshes.new(self.name("mesh"))
        corners = [self.vector(-1, 1) for _ in range(5)]
        mesh.from_pydata(corners, [], [(0, 1, 2), (0, 2, 3), (0, 1, 4, 3)])
        mesh.uv_layers.new(name="UV")
        if self.random.random() < 0.7:
            mesh.materials.append(self.pick(bpy.data.materials))
        made = bpy.data.objects.new(self.name("object"), mesh)
        made.location = self.vector()
        if is_linked:
            self.collection().objects.link(made)
        return made

    def add_light(self):
        """Make a lamp."""
        kind = self.random.choice(("POINT", "SPOT", "SUN", "AREA"))
        data = bpy.data.lights.new(self.name("lamp"), kind)
        made = bpy.data.objects.new(self.name("light"), data)
        made.location = self.vector()
        self.collection().objects.link(made)
        return made

    def add_material(self):
        """Make a material."""
        made = bpy.data.materials.new(self.name("paint"))
        if bpy.app.version < (5, 0, 0):
            made.use_nodes = True
        made.node_tree.nodes["Principled BSDF"].inputs[0].default_value = (*self.vector(0, 1), 1)
        return made

    def add_text(self):
        """Make a text object."""
        data = bpy.data.curves.new(self.name("text"), "FONT")
        data.body = "ab"
        made = bpy.data.objects.new(self.name("sign"), data)
        made.location = self.vector()
        self.collection().objects.link(made)
        return made

    def add_instance(self):
        """Make an empty that shows the collection of props."""
        made = bpy.data.objects.new(self.name("instance"), None)
        made.instance_type = "COLLECTION"
        made.instance_collection = bpy.data.collections["Props"]
        made.location = self.vector()
        bpy.context.scene.collection.objects.link(made)
        return made

    def collection(self):
        """Return one of the scene's collections."""
        scene = bpy.context.scene
        return self.random.choice([scene.collection, bpy.data.collections["Room"]])

    def _build(self):
        scene = bpy.context.scene
        scene.collection.children.link(bpy.data.collections.new("Room"))
        props = bpy.data.collections.new("Props")
        props.use_fake_user = True
        for _ in range(4):
            self.add_material()
        for _ in range(9):
            self.add_mesh()
        for _ in range(2):
            props.objects.link(self.add_mesh(is_linked=False))
        scatter_group()
        lamp = self.add_light()
        props.objects.link(lamp)
        for _ in range(3):
            self.add_light()
        self.add_text()
        for _ in range(2):
            self.add_instance()
        world = bpy.data.worlds.new("Sky")
        if bpy.app.version < (5, 0, 0):
            world.use_nodes = True
        scene.world = world
        bpy.context.view_layer.update()


def scatter_group():
    """Make geometry nodes that put a cone on each vertex, beside the mesh itself."""
    group = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    group.use_fake_user = True
    for way in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    begin, end, join, cone, scatter = (
        group.nodes.new(kind)
        for kind in (
            "NodeGroupInput",
            "NodeGroupOutput",
            "GeometryNodeJoinGeometry",
            "GeometryNodeMeshCone",
            "GeometryNodeInstanceOnPoints",
        )
    )
    group.links.new(begin.outputs[0], scatter.inputs["Points"])
    group.links.new(cone.outputs[0], scatter.inputs["Instance"])
    group.links.new(scatter.outputs[0], join.inputs[0])
    group.links.new(begin.outputs[0], join.inputs[0])
    group.links.new(join.outputs[0], end.inputs[0])
    return group


def _edit_scatter(edits):
    nodes = bpy.data.node_groups["Scatter"].nodes
    cone = next(n for n in nodes if n.bl_idname == "GeometryNodeMeshCone")
    cone.inputs["Depth"].default_value = edits.random.uniform(0.1, 1)
    cone.inputs["Vertices"].default_value = edits.random.randrange(3, 6)


def remember(message: str) -> None:
    """Make an undo step, as every operator in the window does."""
    bpy.ops.ed.undo_push(message=message)


# ---- the edits ----


def _move(edits):
    edits.pick_object().location = edits.vector()


def _turn(edits):
    edits.pick_object().rotation_euler = edits.vector()


def _resize(edits):
    edits.pick_object().scale = edits.vector(-2, 2)


def _deform(edits):
    found = edits.pick_object("MESH")
    if found and len(found.data.vertices):
        edits.random.choice(list(found.data.vertices)).co = edits.vector(-1, 1)
        found.data.update()


def _empty_mesh(edits):
    found = edits.pick_object("MESH")
    if found:
        found.data.clear_geometry()


def _delete(edits):
    found = edits.pick_object()
    if found and len(bpy.context.scene.objects) > 15:
        bpy.data.objects.remove(found)


def _delete_data(edits):
    found = edits.pick_object("MESH", "FONT")
    if found and len(bpy.context.scene.objects) > 15:
        data = found.data
        (bpy.data.meshes if found.type == "MESH" else bpy.data.curves).remove(data)


def _purge(edits):
    bpy.data.orphans_purge()


def _duplicate(edits, is_full):
    found = edits.pick_object()
    if found is None or len(bpy.context.scene.objects) > 40:
        return
    made = found.copy()
    if is_full and found.data is not None:
        made.data = found.data.copy()
    made.location = edits.vector()
    edits.collection().objects.link(made)


def _duplicate_by_operator(edits):
    found = edits.pick_object()
    if found is None or not found.visible_get() or len(bpy.context.scene.objects) > 40:
        return
    for other in bpy.context.scene.objects:
        other.select_set(False)
    found.select_set(True)
    bpy.context.view_layer.objects.active = found
    bpy.ops.object.duplicate(linked=edits.random.random() < 0.5)


def _rename(edits):
    kinds = (bpy.data.objects, bpy.data.materials, bpy.data.meshes, bpy.data.lights)
    found = edits.pick(edits.random.choice((*kinds, bpy.data.worlds)))
    if found:
        found.name = edits.name("renamed")


def _select(edits):
    found = edits.pick(bpy.context.view_layer.objects)
    if found:
        found.select_set(not found.select_get())


def _hide(edits):
    found = _one_to_hide(edits, lambda o: o.hide_get())
    if found.name in bpy.context.view_layer.objects:
        found.hide_set(not found.hide_get())


def _hide_viewport(edits):
    found = _one_to_hide(edits, lambda o: o.hide_viewport)
    found.hide_viewport = not found.hide_viewport


def _hide_render(edits):
    found = _one_to_hide(edits, lambda o: o.hide_render)
    found.hide_render = not found.hide_render


def _one_to_hide(edits, is_hidden):
    """Return a hidden object more often than not, so that the scene does not vanish."""
    hidden = [o for o in bpy.context.scene.objects if is_hidden(o)]
    return edits.pick(hidden) if hidden and edits.random.random() < 0.7 else edits.pick_object()


def _hide_collection(edits):
    room = bpy.data.collections["Room"]
    if edits.random.random() < 0.5:
        room.hide_viewport = not room.hide_viewport
    else:
        layer = bpy.context.view_layer.layer_collection.children["Room"]
        layer.exclude = not layer.exclude


def _move_in_outliner(edits):
    room, scene = bpy.data.collections["Room"], bpy.context.scene.collection
    found = edits.pick(scene.objects)
    if found and found.name not in room.objects:
        room.objects.link(found)
        scene.objects.unlink(found)


def _paint(edits):
    found = edits.pick(bpy.data.materials)
    node = found.node_tree.nodes.get("Principled BSDF") if found else None
    if node:
        node.inputs[0].default_value = (*edits.vector(0, 1), 1)


def _change_shader(edits):
    found = edits.pick(bpy.data.materials)
    if found is None:
        return
    tree = found.node_tree
    output = tree.get_output_node("CYCLES")
    kind = edits.random.choice(("BsdfDiffuse", "BsdfGlossy", "Emission", "BsdfTransparent"))
    tree.links.new(tree.nodes.new(f"ShaderNode{kind}").outputs[0], output.inputs["Surface"])


def _lay_by_object(edits):
    """Let a material ask the objects that show it."""
    found = edits.pick(bpy.data.materials)
    if found is None:
        return
    tree = found.node_tree
    kind, output = edits.random.choice(
        (
            ("TexCoord", "Generated"),
            ("TexCoord", "Object"),
            ("NewGeometry", "Position"),
            ("ObjectInfo", "Color"),
            ("ObjectInfo", "Random"),
            ("VertexColor", "Color"),
        )
    )
    node, shader = tree.nodes.new(f"ShaderNode{kind}"), tree.nodes.new("ShaderNodeBsdfDiffuse")
    if output == "Object" and edits.random.random() < 0.5:
        node.object = edits.pick_object()
    tree.links.new(node.outputs[output], shader.inputs["Color"])
    tree.links.new(shader.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])


def _object_colour(edits):
    found = edits.pick_object("MESH", "FONT")
    if found:
        found.color = (*edits.vector(0, 1), 1)


def _vertex_colours(edits):
    found = edits.pick_object("MESH")
    if found and len(found.data.vertices):
        layers = found.data.color_attributes
        layer = layers.get("Tint") or layers.new("Tint", "FLOAT_COLOR", "POINT")
        for each in layer.data:
            each.color = (*edits.vector(0, 1), 1)
        found.data.update()


def _use_group(edits):
    found = edits.pick(bpy.data.materials)
    if found is None:
        return
    group = bpy.data.node_groups.get("Tint")
    if group is None:
        group = bpy.data.node_groups.new("Tint", "ShaderNodeTree")
        group.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
        colour = group.nodes.new("ShaderNodeRGB")
        end = group.nodes.new("NodeGroupOutput")
        group.links.new(colour.outputs[0], end.inputs[0])
    tree = found.node_tree
    node, shader = tree.nodes.new("ShaderNodeGroup"), tree.nodes.new("ShaderNodeBsdfDiffuse")
    node.node_tree = group
    tree.links.new(node.outputs[0], shader.inputs["Color"])
    tree.links.new(shader.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])


def _edit_group(edits):
    group = bpy.data.node_groups.get("Tint")
    if group:
        node = next(n for n in group.nodes if n.bl_idname == "ShaderNodeRGB")
        node.outputs[0].default_value = (*edits.vector(0, 1), 1)


def _override_material(edits):
    found = edits.pick(bpy.data.materials)
    if found:
        found.lumenray.use_override = True
        found.lumenray.reflectance = edits.random.random()


def _fill_slot(edits):
    found = edits.pick_object("MESH", "FONT")
    if not found:
        return
    if not found.material_slots:
        found.data.materials.append(None)
    slot = edits.random.choice(list(found.material_slots))
    slot.link = edits.random.choice(("DATA", "OBJECT"))
    material = edits.add_material() if edits.random.random() < 0.3 else None
    slot.material = material or edits.pick(bpy.data.materials)


def _change_slots(edits):
    found = edits.pick_object("MESH")
    if not found:
        return
    if len(found.data.materials) and edits.random.random() < 0.3:
        found.data.materials.pop()
    else:
        found.data.materials.append(edits.pick(bpy.data.materials))
    for face in found.data.polygons:
        face.material_index = edits.random.randrange(3)


def _delete_material(edits):
    if len(bpy.data.materials) > 3:
        bpy.data.materials.remove(edits.pick(bpy.data.materials))


def _power(edits):
    found = edits.pick(bpy.data.lights)
    if found:
        found.energy = edits.random.choice((0.0, edits.random.uniform(1, 100)))


def _light_colour(edits):
    found = edits.pick(bpy.data.lights)
    if found:
        found.color = edits.vector(0.1, 1)


def _light_type(edits):
    found = edits.pick(bpy.data.lights)
    if found:
        found.type = edits.random.choice(("POINT", "SPOT", "SUN", "AREA"))


def _light_parameters(edits):
    found = edits.pick(bpy.data.lights)
    if found:
        found.lumenray.use_physical = True
        found.lumenray.value = edits.random.uniform(1, 1000)
        found.lumenray.quantity = edits.random.choice(("LUMINOUS_FLUX", "ILLUMINANCE"))


def _world_colour(edits):
    world = bpy.context.scene.world
    if world:
        node = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
        node.inputs[0].default_value = (*edits.vector(0, 1), 1)


def _change_world(edits):
    scene = bpy.context.scene
    scene.world = edits.random.choice((None, edits.pick(bpy.data.worlds)))
    if scene.world is None and edits.random.random() < 0.5:
        scene.world = bpy.data.worlds.new(edits.name("sky"))
        if bpy.app.version < (5, 0, 0):
            scene.world.use_nodes = True


def _parent(edits):
    # An instance's own members must not hang on it: Blender calls that a cycle.
    child, parent = edits.pick_object(), edits.pick_object("MESH", "LIGHT", "FONT")
    above = parent
    while above is not None:
        if above == child:
            return
        above = above.parent
    child.parent = parent


def _unparent(edits):
    edits.pick_object().parent = None


def _modify(edits):
    found = edits.pick_object("MESH")
    if not found:
        return
    if found.modifiers and edits.random.random() < 0.6:
        modifier = found.modifiers[0]
        if edits.random.random() < 0.5:
            found.modifiers.remove(modifier)
        else:
            modifier.show_viewport = not modifier.show_viewport
        return
    kind = edits.random.choice(("ARRAY", "SOLIDIFY", "NODES"))
    modifier = found.modifiers.new("Modifier", kind)
    if kind == "NODES":
        modifier.node_group = bpy.data.node_groups["Scatter"]


def _instance(edits):
    if len(bpy.context.scene.objects) < 40:
        edits.add_instance()


def _fill_props(edits):
    props = bpy.data.collections["Props"]
    found = edits.pick(props.objects) if edits.random.random() < 0.5 else None
    if found and len(props.objects) > 1:
        props.objects.unlink(found)
        return
    found = edits.pick_object("MESH", "LIGHT", "FONT")
    if found and found.name not in props.objects:
        props.objects.link(found)


def _edit_prop(edits):
    found = edits.pick(bpy.data.collections["Props"].objects)
    if found:
        found.location = edits.vector()


def _object_settings(edits):
    found = edits.pick_object("MESH", "LIGHT")
    if found:
        found.visible_camera = edits.random.random() < 0.5
        found.pass_index = edits.random.randrange(9)


def _units(edits):
    settings = bpy.context.scene.unit_settings
    settings.system = "METRIC"
    settings.scale_length = edits.random.choice((1.0, 0.01, 0.3))


def _efficacy(edits):
    bpy.context.scene.lumenray.efficacy = edits.random.uniform(100, 600)


def _animate(edits):
    found = edits.pick_object()
    found.keyframe_insert("location", frame=1)
    found.location = edits.vector()
    found.keyframe_insert("location", frame=20)


def _go_to_frame(edits):
    bpy.context.scene.frame_set(edits.random.randrange(1, 20))


def _undo(edits):
    for _ in range(edits.random.randrange(1, 4)):
        if not bpy.ops.ed.undo.poll():
            return
        try:
            bpy.ops.ed.undo()
        except RuntimeError:
            # There is nothing left to undo.
            return
        if edits.random.random() < 0.5:
            bpy.context.view_layer.update()


def _redo(_edits):
    if not bpy.ops.ed.redo.poll():
        return
    try:
        bpy.ops.ed.redo()
    except RuntimeError:
        # There is nothing to redo.
        return


def _reopen(edits):
    bpy.ops.wm.save_as_mainfile(filepath=str(edits.path), check_existing=False)
    bpy.ops.wm.open_mainfile(filepath=str(edits.path))


EDITS = {
    "move": (_move, 4),
    "turn": (_turn, 2),
    "resize": (_resize, 2),
    "deform": (_deform, 4),
    "empty mesh": (_empty_mesh, 0.3),
    "add mesh": (lambda edits: edits.add_mesh(), 1.5),
    "add light": (lambda edits: edits.add_light(), 1),
    "add text": (lambda edits: edits.add_text(), 0.5),
    "delete": (_delete, 3),
    "delete data": (_delete_data, 0.4),
    "purge": (_purge, 0.4),
    "duplicate linked": (lambda edits: _duplicate(edits, False), 1.5),
    "duplicate full": (lambda edits: _duplicate(edits, True), 1),
    "duplicate by operator": (_duplicate_by_operator, 1),
    "rename": (_rename, 2),
    "select": (_select, 1),
    "hide": (_hide, 2),
    "hide in viewports": (_hide_viewport, 2),
    "hide in renders": (_hide_render, 2),
    "hide collection": (_hide_collection, 1),
    "move in outliner": (_move_in_outliner, 1),
    "material colour": (_paint, 3),
    "material type": (_change_shader, 2),
    "material by object": (_lay_by_object, 2),
    "object colour": (_object_colour, 1),
    "vertex colours": (_vertex_colours, 1),
    "material group": (_use_group, 1),
    "group colour": (_edit_group, 2),
    "material override": (_override_material, 1),
    "slot": (_fill_slot, 2),
    "slots": (_change_slots, 1),
    "delete material": (_delete_material, 0.3),
    "light power": (_power, 3),
    "light colour": (_light_colour, 2),
    "light type": (_light_type, 2),
    "light parameters": (_light_parameters, 2),
    "world colour": (_world_colour, 2),
    "world": (_change_world, 1),
    "parent": (_parent, 2),
    "unparent": (_unparent, 1),
    "modifier": (_modify, 2),
    "scatter": (_edit_scatter, 1),
    "collection instance": (_instance, 0.7),
    "collection": (_fill_props, 1.5),
    "move in collection": (_edit_prop, 2),
    "object settings": (_object_settings, 2),
    "units": (_units, 0.5),
    "efficacy": (_efficacy, 0.5),
    "animate": (_animate, 0.7),
    "frame": (_go_to_frame, 1),
    "undo": (_undo, 7),
    "redo": (_redo, 4),
    "reopen": (_reopen, 0.7),
}
"""Function and weight of each edit by name."""
