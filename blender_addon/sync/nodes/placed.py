"""Evaluation of a material's nodes for one object: its own values, and the places of texels on its surface."""

from dataclasses import dataclass, field

import numpy as np

from ....engine.scene.memo import recall
from ....engine.scene.mesh import CHART_MAP
from . import fields, needs
from .fields import Field, Layout, constant
from .graph import node_key
from .rays import RayContext

USUAL = 256
"""Texels along a side where nothing asks for more: seams and edges of faces are blurred over one. [texel]"""

SHARP = 1024
"""Texels along a side where a texture has edges. [texel]"""

FINEST = 2048
"""Side up to which a picture of texels goes. [texel]"""

WAVE = 16
"""Texels for the finest wave or cell that counts, where so many are affordable."""

COARSEST = 4
"""Texels for a wave or cell with which it is still to be recognised."""

AFFORDABLE = 1e7
"""Noises in three dimensions that one picture may take, about three seconds' worth."""

TWO_SIDES = (
    "The normal of a face points at whoever looks at it",
    "that of the front is used for both sides",
)
"""What is noted of normals."""

MOST = 0.9
"""Share of neighbouring texels whose difference counts as the usual one at most; the rest may lie at seams. [-]"""


@dataclass(frozen=True, eq=False)
class TexelLayout(Layout):
    """How values lie that are known at texels: (1, n, c). ``texels``: `engine.atlas.texels.Texels`."""

    texels: object = None

    def picture(self, values: np.ndarray) -> np.ndarray:
        """Return the picture of values."""
        return recall(values, "picture", lambda v: self.texels.lay(v[0]))


@dataclass(frozen=True, eq=False)
class Subject:
    """What of an object its materials ask for.

    Parameters
    ----------
    matrix : (4, 4) float64 array    To the world, in Blender units.
    values : dict    What its needs (`needs`) come to, as tuples of numbers; of other objects the matrix from the world.
    """

    matrix: np.ndarray = field(default_factory=lambda: np.eye(4))
    values: dict[tuple, tuple] = field(default_factory=dict)


@dataclass
class Fineness:
    """How fine a picture is to be.

    Parameters
    ----------
    wanted : float    Factor on the texels along a side with which nothing would be lost. [-]
    works : dict    What is calculated at every texel, in noises in three dimensions, by node.
    """

    wanted: float = 1.0
    works: dict[tuple, float] = field(default_factory=dict)


class PlacedContext(RayContext):
    """The conversion of a material for one object.

    Parameters
    ----------
    datablock, report, images    As of `RayContext`.
    subject : Subject
    surface : sync.surfaces.Surface or None    None: its pictures lie by UV maps as ever.
    texels : engine.atlas.texels.Texels or None    Of the slot's triangles.
    rows : (t,) array or None    Triangles of the surface that the texels count.
    """

    def __init__(self, datablock, report, images, subject, surface=None, texels=None, rows=None):
        super().__init__(datablock, report, images)
        self.subject, self.surface, self.texels = subject, surface, texels
        self.rows, self.has_texels, self.is_material = rows, texels is not None, True
        self._fineness = Fineness()
        if texels is not None:
            self.want(USUAL)

    @property
    def wanted(self) -> float:
        """Factor on the texels along a side with which nothing would be lost, in all branches. [-]"""
        return self._fineness.wanted

    @property
    def work(self) -> float:
        """What is calculated at every texel, in noises in three dimensions; branches share what nodes give."""
        return sum(self._fineness.works.values())

    def take_output(self, at) -> Field | None:
        """Return what a node gives for the object; None: it gives the same as for all."""
        made, found = super().take_output(at), _SOURCES.get(at.node.bl_idname)
        return found(at, self) if made is None and found is not None else made

    def coordinates(self) -> Field | None:
        """Return what textures go by where nothing is linked."""
        return self.at_texels("generated", lambda s: s.generated) if self.has_texels else None

    def value(self, need: tuple) -> tuple | None:
        """Return what one of the needs comes to; None: it is not known."""
        return self.subject.values.get(need)

    # ---- at texels ----

    def at_texels(self, name, corners, change=None) -> Field:
        """Return the field of what corners of triangles have.

        Parameters
        ----------
        name : hashable    By which the values are kept; it stands for the other parameters.
        corners : callable    Given the surface; (t, 3, c).
        change : callable or None    Applied to the values at texels.
        """

        def make():
            values = self.texels.interpolate(corners(self.surface)[self.rows])
            return np.array(values if change is None else change(values), np.float32)[None]

        values = self.texels.keep(name, make)
        if (values == values[:, :1]).all():
            return constant(*values[0, 0])
        return Field(values, self.layout())

    def layout(self, interpolation: str = "linear") -> TexelLayout:
        """Return how values at texels lie."""
        return TexelLayout(
            CHART_MAP, np.eye(3), interpolation, "extend", self.datablock, texels=self.texels
        )

    def uv(self, name: str = "") -> Field:
        """Return a UV map as coordinates; those that are not there are 0."""
        if self.surface.uv_map(name) is None:
            return constant(0.0, 0.0, 0.0)
        return self.at_texels(("uv", name), lambda s: _padded(s.uv_map(name)))

    def turned(self, name: str, corners) -> Field:
        """Return directions across the surface in the world, of unit length."""
        matrix = np.linalg.inv(self.subject.matrix[:3, :3]).T if self.is_regular() else np.eye(3)
        return self.at_texels(
            (name, "world", matrix.tobytes()), corners, lambda v: _unit(_unit(v) @ matrix.T)
        )

    def normals(self) -> Field:
        """Return directions across the surface in the object's own frame, of unit length."""
        return self.at_texels("normal", lambda s: s.normals(), _unit)

    def tangents(self, uv_map: str) -> Field | None:
        """Return where U grows in the object's own frame, and 1 or -1 by the side of V; None: there is no such map."""
        if self.surface.uv_map(uv_map) is None:
            return None
        return self.at_texels(("tangents", uv_map), lambda s: s.tangents(uv_map))

    def moved(self, matrix: np.ndarray | None = None) -> Field:
        """Return places in the world, or as a matrix (4, 4) takes those of the world."""
        whole = self.subject.matrix if matrix is None else matrix @ self.subject.matrix
        return self.at_texels(
            ("position", whole.tobytes()),
            lambda s: s.positions(),
            lambda v: v @ whole[:3, :3].T + whole[:3, 3],
        )

    def is_regular(self) -> bool:
        """Whether the object has a size in all directions."""
        return abs(np.linalg.det(self.subject.matrix[:3, :3])) > 1e-30

    def weigh(self, at, places: Field, waves: float, work: float = 1.0, is_sharp=False) -> None:
        """Note how fine a texture is.

        Parameters
        ----------
        at : Inputs    Of the texture.
        places : Field    Coordinates.
        waves : float    Waves or cells per unit of the coordinates.
        work : float    What it costs at one place, in noises in three dimensions.
        is_sharp : bool    Whether it has edges.
        """
        self._fineness.works[(*node_key(at.node, at.groups), at.output.identifier)] = work
        if places.is_constant or len(self.texels) < 2:
            return
        usual = waves * self.step_of(places)
        if not np.isfinite(usual):
            return
        self._want_factor(usual * WAVE)
        if is_sharp:
            self.want(SHARP)
        if usual * COARSEST > 1.0:
            at.note(
                "Details of the texture are finer than the texels of the object's picture",
                f"it is drawn on {self.texels.width} x {self.texels.height} texels, on which they are lost",
            )

    def step_of(self, places: Field) -> float:
        """Difference of coordinates between texels beside each other that few exceed."""
        if places.is_constant or len(self.texels) < 2:
            return 0.0
        return recall(places.values, "usual step", self._usual_step)

    def _usual_step(self, values: np.ndarray) -> float:
        first, second = self.texels.keep("neighbours", lambda: np.stack(self.texels.neighbours()))
        steps = np.abs(values[0, first] - values[0, second]).max(axis=1)
        return float(np.quantile(steps, MOST)) if len(steps) else 0.0

    def want(self, side: float) -> None:
        """Note how many texels along a side are wanted."""
        self._want_factor(side / max(self.texels.width, self.texels.height))

    def _want_factor(self, factor: float) -> None:
        self._fineness.wanted = max(self._fineness.wanted, factor)


def _padded(uv: np.ndarray) -> np.ndarray:
    return np.concatenate([uv, np.zeros_like(uv[..., :1])], axis=-1)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-30)


# ---- nodes ----


def _coordinates(at, context) -> Field | None:
    name, node = at.output.identifier, at.node
    if node.from_instancer and name in {"Generated", "UV"}:
        return _known(context, (needs.VALUE, f"instance {name.lower()}"))
    if not context.has_texels:
        return None
    if name == "Generated":
        return context.coordinates()
    if name == "UV":
        return context.uv()
    if name == "Normal":
        at.remark(*TWO_SIDES)
        return context.normals()
    if name != "Object":
        return None
    if node.object is None:
        return context.at_texels("position", lambda s: s.positions())
    matrix = context.value((needs.FRAME, node.object.original.session_uid))
    return None if matrix is None else context.moved(np.reshape(matrix, (4, 4)))


def _geometry(at, context) -> Field | None:
    name = at.output.identifier
    if not context.has_texels:
        return None
    if name == "Position":
        return context.moved()
    if name in {"Normal", "True Normal"}:
        at.remark(*TWO_SIDES)
    if name == "Normal":
        return context.turned("normal", lambda s: s.normals())
    if name == "True Normal":
        return _fine(context, context.turned("flat", lambda s: s.flat_normals()), WAVE)
    if name == "Random Per Island":
        return _fine(context, context.at_texels("islands", lambda s: s.islands()))
    if name == "Pointiness":
        return _fine(context, context.at_texels("pointiness", lambda s: s.pointiness()))
    return None


def _fine(context, made: Field, texels: float = COARSEST) -> Field:
    """Ask for texels enough along the sides of triangles."""
    context.want(texels * np.sqrt(len(context.rows)))
    return made


def _uv_map(at, context) -> Field | None:
    if at.node.from_instancer:
        return _known(context, (needs.VALUE, "instance uv"))
    return context.uv(at.node.uv_map) if context.has_texels else None


def _object_info(at, context) -> Field | None:
    name = at.output.identifier
    if name == "Location":
        return constant(*context.subject.matrix[:3, 3])
    (need,) = needs.needs_of_node(at.node, at.output) or (None,)
    return None if need is None else _known(context, need)


def _known(context, need) -> Field | None:
    value = context.value(need)
    return None if value is None else constant(*value)


def _attribute(at, context) -> Field | None:
    node, name = at.node, at.node.attribute_name
    if node.attribute_type != "GEOMETRY":
        value = context.value((needs.ATTRIBUTE, node.attribute_type, name))
        return None if value is None else _shown(at, constant(*value))
    return _of_mesh(at, context, name) if context.has_texels else None


def _vertex_colour(at, context) -> Field | None:
    if not context.has_texels:
        return None
    return _of_mesh(at, context, at.node.layer_name or context.surface.colour)


def _of_mesh(at, context, name: str) -> Field:
    """Return an output of an attribute of the mesh; black if there is none, as in Cycles."""
    values = context.surface.attributes.get(name)
    if values is None:
        return _shown(at, constant(0.0))
    made = context.at_texels(("attribute", name), lambda s: s.attributes[name])
    return _fine(context, _shown(at, made))


def _shown(at, made: Field) -> Field:
    """Return an output of an attribute of one, two, three or four channels."""
    channels, output = made.values.shape[-1], at.output.identifier
    if output == "Alpha":
        return (
            fields.map_fields(lambda v: v[..., 3:], made, note=at.note)
            if channels == 4
            else constant(1.0)
        )
    if output == "Fac":
        if channels < 3:
            return fields.map_fields(lambda v: v[..., :1], made, note=at.note)
        return fields.map_fields(lambda v: v[..., :3].mean(-1, keepdims=True), made, note=at.note)
    if channels == 2:
        return fields.map_fields(_padded, made, note=at.note)
    if channels == 1:
        return fields.map_fields(lambda v: np.repeat(v, 3, axis=-1), made, note=at.note)
    return fields.map_fields(lambda v: v[..., :3], made, note=at.note)


def _transform(at, context) -> Field | None:
    """Return a vector of the world in the object's frame, or the other way round."""
    node = at.node
    spaces = (node.convert_from, node.convert_to)
    if spaces[0] == spaces[1]:
        return at("Vector")
    if "CAMERA" in spaces or not context.is_regular():
        return None
    matrix, kind = context.subject.matrix, node.vector_type
    matrix = matrix if spaces[1] == "WORLD" else np.linalg.inv(matrix)
    linear = np.linalg.inv(matrix[:3, :3]).T if kind == "NORMAL" else matrix[:3, :3]
    shift = matrix[:3, 3] if kind == "POINT" else np.zeros(3)

    def move(vector, linear, shift):
        made = fields.rgb(vector) @ linear.reshape(3, 3).T + shift
        return _unit(made) if kind == "NORMAL" else made

    return at.map(move, at("Vector"), constant(*linear.ravel()), constant(*shift))


def _wireframe(at, context) -> Field | None:
    """Return where a triangle's own edges are near, as Cycles draws them."""
    if not context.has_texels or at.node.use_pixel_size:
        return None
    half = 0.5 * at.plain("Size")
    matrix = context.subject.matrix
    corners = context.surface.positions()[context.rows].astype(np.float64)
    corners = corners @ matrix[:3, :3].T + matrix[:3, 3]
    texels = context.texels
    own = corners[texels.triangle]
    place = np.einsum("tcx,tc->tx", own, texels.weights)
    near = np.zeros(len(texels), bool)
    for first in range(3):
        along = _unit(own[:, first] - own[:, first - 1])
        across = np.cross(along, own[:, first] - place)
        near |= (across**2).sum(axis=1) < half**2
    places = context.moved()
    if half > 0.0:
        context.weigh(at, places, 0.25 / half, is_sharp=True)
    return Field(near.astype(np.float32)[None, :, None], context.layout())


_SOURCES = {
    "ShaderNodeTexCoord": _coordinates,
    "ShaderNodeNewGeometry": _geometry,
    "ShaderNodeUVMap": _uv_map,
    "ShaderNodeObjectInfo": _object_info,
    "ShaderNodeAttribute": _attribute,
    "ShaderNodeVertexColor": _vertex_colour,
    "ShaderNodeWireframe": _wireframe,
    "ShaderNodeVectorTransform": _transform,
}
"""What nodes give that know the object, by their ``bl_idname``."""
