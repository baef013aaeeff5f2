"""The engine between edits: the same answers as from a fresh start, at the cost of what changed."""

from dataclasses import replace

import numpy as np
import pytest
from live_scenes import block, camera_at, frame_at, lamp
from small_scenes import paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.camera import Camera
from lumenray.engine.scene.light import (
    AreaLight,
    Output,
    PointLight,
    Quantity,
    SpotLight,
    SunLight,
    UniformWorld,
)
from lumenray.engine.scene.material import (
    Cauchy,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Emission,
    Material,
    ThinGlass,
)
from lumenray.engine.scene.mesh import Geometry, Mesh, Placement, place
from lumenray.engine.scene.modelling import Modelling, Switch
from lumenray.engine.scene.scene import Attachment, Scene, SceneDelta
from lumenray.engine.scene.sensor import SensorSet
from lumenray.engine.scene.spectrum import Blackbody, Constant, Illuminant, Rgb
from lumenray.engine.session import Session
from lumenray.engine.views import Display, LiveSettings, ViewSettings

pytestmark = pytest.mark.mitsuba

UP = np.array([[0.0, 0.0, 1.0]])

SURFACES = (
    lambda r: Diffuse(Rgb(*r.random(3))),
    lambda r: Coated(Rgb(*r.random(3)), roughness=float(r.random())),
    lambda r: Conductor("Al", float(0.1 + 0.5 * r.random())),
    lambda r: Dielectric(Cauchy(1.4 + 0.2 * float(r.random()))),
    lambda r: ThinGlass(1.5, Constant(float(r.random()))),
    lambda r: Diffuse(Constant(0.3), Constant(0.2)),
)


class Editor:
    """Seeded edits of a small room, as deltas, with the full list of items beside it."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)
        self.items = {}
        self.count = 0
        first = [
            *(replace(quad(name, *shape, "paint"), id=f"object:{name}") for name, shape in WALLS),
            paint(0.6),
            *(Material(f"m{k}", f"m{k}", SURFACES[k % 2](self.rng)) for k in range(4)),
            *(block(f"g{k}", k) for k in range(3)),
            lamp("lamp", 2, 2, 2.9),
            UniformWorld(10.0, Illuminant("D65")),
        ]
        self.delta = self._keep(first)
        for _ in range(5):
            self.delta = SceneDelta(self.delta.changed + self.add().changed)

    def _keep(self, changed, removed=()):
        for key in removed:
            self.items.pop(key)
        for item in changed:
            self.items[item.id] = item
        return SceneDelta(tuple(changed), tuple(removed))

    def _random_frame(self):
        x, y, z = self.rng.uniform(0.5, 3.5, 3)
        return frame_at(x, y, 0.5 * z, self.rng.uniform(0, 6), self.rng.uniform(0.2, 0.6))

    def _one(self, kind, prefix=""):
        keys = [k for k, v in self.items.items() if isinstance(v, kind) and k.startswith(prefix)]
        return self.items[keys[self.rng.integers(len(keys))]] if keys else None

    def _some_material(self):
        return f"m{self.rng.integers(4)}"

    def add(self):
        self.count += 1
        made = Placement(
            f"o{self.count}",
            f"o{self.count}",
            f"g{self.rng.integers(3)}",
            self._random_frame(),
            (self._some_material(), self._some_material()),
            index=self.count,
        )
        return self._keep([made])

    def move(self):
        item = self._one(Placement)
        return self._keep([replace(item, frame=self._random_frame())] if item else [])

    def delete(self):
        item = self._one(Placement)
        return self._keep([], [item.id] if item else [])

    def deform(self):
        item = self._one(Geometry)
        return self._keep([block(item.id, int(self.rng.integers(100)))])

    def reassign(self):
        item = self._one(Placement)
        slots = (self._some_material(), self._some_material())
        return self._keep([replace(item, materials=slots)] if item else [])

    def hide(self):
        item = self._one(Placement)
        return self._keep(
            [replace(item, visible_to_camera=not item.visible_to_camera)] if item else []
        )

    def recolour(self):
        item = self._one(Material, "m")
        make = SURFACES[self.rng.integers(len(SURFACES))]
        glow = Emission(Blackbody(4000.0), 300.0) if self.rng.random() < 0.3 else None
        return self._keep([replace(item, surface=make(self.rng), emission=glow)])

    def relight(self):
        item = self._one(AreaLight)
        lumens = 0.0 if self.rng.random() < 0.2 else self.rng.uniform(100, 2000)
        return self._keep(
            [lamp(item.id, *self.rng.uniform(1, 3, 2), 2.9, lumens, self.rng.uniform(2500, 6000))]
        )

    def light(self):
        self.count += 1
        place, key = self.rng.uniform(0.5, 3.5, 3), f"l{self.count}"
        out = Output(Quantity.LUMINOUS_FLUX, self.rng.uniform(10, 500), Blackbody(3500.0))
        down = np.array([0.0, 0.0, -1.0])
        made = [
            PointLight(key, key, out, place, 0.1),
            PointLight(key, key, out, place),
            SpotLight(key, key, out, place, down, 0.6, 0.3),
            SunLight(key, key, replace(out, quantity=Quantity.ILLUMINANCE), down, 0.01),
        ][self.rng.integers(4)]
        return self._keep([made])

    def darken(self):
        item = self._one(PointLight | SpotLight | SunLight)
        return self._keep([], [item.id] if item else [])

    def world(self):
        return self._keep([UniformWorld(self.rng.uniform(1, 100), Illuminant("D65"))])

    def edit(self):
        kinds = (
            self.add, self.move, self.move, self.delete, self.deform, self.reassign, self.hide,
            self.recolour, self.relight, self.light, self.darken, self.world,
        )  # fmt: skip
        return kinds[self.rng.integers(len(kinds))]()


WALLS = (
    ("floor", ((0, 0, 0), (4, 0, 0), (0, 4, 0))),
    ("wall", ((0, 4, 0), (4, 0, 0), (0, 0, 3))),
    ("side", ((0, 0, 0), (0, 4, 0), (0, 0, 3))),
)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.slow
def test_edits_end_at_the_picture_of_a_fresh_start(seed):
    editor = Editor(seed)
    kept = Session(witness=False)
    kept.apply(editor.delta)
    camera = camera_at(2, 2, 2.8)
    kept.watch(camera, LiveSettings(), Display())
    for number in range(60):
        kept.apply(editor.edit())
        if number % 3 == 0:
            kept.refine()
    fresh = Session(witness=False)
    # In another order and under other names: neither may count.
    items = list(editor.items.values())[::-1]
    fresh.apply(SceneDelta(changed=tuple(items)))
    settings = ViewSettings(StopRule(samples=8), seed=3)
    a, b = kept.render(camera, settings), fresh.render(camera, settings)
    assert a.provenance.scene_hash == b.provenance.scene_hash
    assert a.provenance.variant == b.provenance.variant
    same = np.isclose(a.tristimulus, b.tristimulus, rtol=1e-4, atol=1e-4).all(axis=2)
    assert same.mean() > 0.995
    np.testing.assert_array_equal(a.object_index, b.object_index)
    np.testing.assert_array_equal(a.material_index, b.material_index)


def test_an_object_that_is_gone_neither_shows_nor_shades():
    """Large enough that nothing is simply built anew: 40 screens, one after the other moved or removed."""
    light = PointLight("l", "l", Output(Quantity.LUMINOUS_INTENSITY, 100.0), np.array([0, 0, 2.0]))
    screens = [
        replace(quad(f"s{k}", (-1, -1, 0.5 + 0.02 * k), (2, 0, 0), (0, 2, 0), "black"), id=f"s{k}")
        for k in range(40)
    ]
    # Far marks keep the frame of the scene where it is.
    marks = [
        replace(quad(k, (x, 9, 0), (0.1, 0, 0), (0, 0.1, 0), "black"), id=k)
        for k, x in (("a", -9), ("b", 9))
    ]
    session = session_of(light, paint(0.0, "black"), *screens, *marks)
    rule = StopRule(samples=64)

    def lux(z):
        from lumenray.engine.transport.paths.illuminance import Receivers, compute

        compiled = session._prepare("auto", True)
        return compute(compiled, Receivers.at_points([[0.1, 0, z]], UP), rule, groups=4).mean[0]

    assert lux(0.0) == 0.0
    session.apply(SceneDelta(removed=tuple(f"s{k}" for k in range(39))))
    assert lux(0.0) == 0.0
    last = replace(screens[39], vertices=screens[39].vertices + np.array([5.0, 0, 0]))
    session.apply(SceneDelta(changed=(last,)))
    expected = 100.0 * 2.0 / (4.0 + 0.01) ** 1.5
    assert lux(0.0) == pytest.approx(expected, rel=1e-3)
    compiled = session._compiled
    assert not compiled.solid.is_settled
    compiled.settle()
    assert compiled.solid.is_settled
    assert lux(0.0) == pytest.approx(expected, rel=1e-3)
    session.apply(SceneDelta(changed=(screens[3],)))
    assert lux(0.0) == 0.0
    assert lux(1.0) == pytest.approx(100.0 * 1.0 / (1.0 + 0.01) ** 1.5, rel=1e-3)


def test_values_of_lights_materials_and_cameras_need_no_new_kernel():
    import drjit as dr

    editor = Editor(5)
    session = Session(witness=False)
    session.apply(editor.delta)
    camera = camera_at(2, 2, 2.8)
    session.watch(camera, LiveSettings(), Display())
    rng = np.random.default_rng(0)

    def edits(k):
        yield replace(
            editor.items["m0"], surface=Coated(Rgb(*rng.random(3)), roughness=0.2 + 0.1 * k)
        )
        yield replace(editor.items["m1"], surface=Dielectric(Cauchy(1.5 + 0.02 * k)))
        yield lamp("lamp", 2, 2, 2.9, 500.0 + k)
        yield lamp("lamp", 2, 2, 2.9, 500.0, 3000.0 + k)
        yield lamp("lamp", 2 + 0.1 * k, 2, 2.9)
        yield lamp("lamp", 2, 2, 2.9, size=0.3 + 0.1 * k)
        yield UniformWorld(10.0 + k, Illuminant("D65"))
        yield replace(editor.items["o1"], frame=frame_at(1 + 0.1 * k, 2, 1))
        yield camera_at(2, 2 + 0.1 * k, 2.7, 40 + 8 * k, 30, 1.0 + 0.1 * k)

    counts = []
    dr.set_flag(dr.JitFlag.KernelHistory, True)
    try:
        for k in range(4):
            dr.kernel_history_clear()
            for item in edits(k):
                if isinstance(item, Camera):
                    session.watch(item, LiveSettings(), Display())
                else:
                    session.apply(SceneDelta(changed=(item,)))
                for _ in range(3):
                    session.refine()
            kernels = [e for e in dr.kernel_history() if e["type"] == dr.KernelType.JIT]
            counts.append(len({e["hash"] for e in kernels}))
            if k >= 2:
                assert all(entry["cache_hit"] for entry in kernels)
    finally:
        dr.set_flag(dr.JitFlag.KernelHistory, False)
    assert counts[-1] > 0


def test_only_what_changed_is_built():
    editor = Editor(7)
    session = Session(witness=False)
    session.apply(editor.delta)
    session.watch(camera_at(2, 2, 2.8), LiveSettings(), Display())
    session.refine()
    assert session.commit.action == "everything built"
    for change, action in (
        (replace(editor.items["o1"], frame=frame_at(1, 1, 1)), "1 object built"),
        (replace(editor.items["m0"], surface=Diffuse(Rgb(0.1, 0.2, 0.3))), "1 surface changed"),
        (lamp("lamp", 2, 2, 2.9, 123.0), "1 light changed"),
        (UniformWorld(5.0), "surroundings changed"),
        (replace(editor.items["o1"], frame=frame_at(1, 1, 1), index=5), "nothing"),
    ):
        session.apply(SceneDelta(changed=(change,)))
        session.refine()
        assert session.commit.action == action
        assert session.commit.items == 1


def test_the_hash_does_not_know_ids_names_and_order():
    def scene(prefix, reverse):
        items = [
            Placement(prefix + "o", prefix, prefix + "g", frame_at(1, 2, 3), (prefix + "m",)),
            replace(block("g"), id=prefix + "g"),
            Material(prefix + "m", prefix, Diffuse(Constant(0.4))),
            lamp(prefix + "l", 0, 0, 1),
        ]
        made = Scene()
        made.apply(SceneDelta(changed=tuple(items[::-1] if reverse else items)))
        return made

    assert scene("a", False).hash() == scene("b", True).hash()
    other = scene("a", False)
    other.apply(SceneDelta(changed=(Material("am", "a", Diffuse(Constant(0.41))),)))
    assert other.hash() != scene("a", False).hash()


def test_a_placed_geometry_is_the_mesh_it_stands_for():
    geometry = block("g", 1)
    frame = frame_at(1, 2, 3, 0.7, 2.0)
    frame[:3, 0] *= -1.5
    mesh = place(geometry, Placement("o", "o", "g", frame, ("a", "b")))
    corners = geometry.vertices.astype(float) @ frame[:3, :3].T + frame[:3, 3]
    np.testing.assert_allclose(mesh.vertices, corners)
    # Mirrored: outside stays outside, and the normals point there.
    centre = mesh.vertices.mean(axis=0)
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    outwards = np.cross(b - a, c - a)
    assert ((outwards * (a - centre)).sum(axis=1) > 0.0).all()
    points = mesh.vertices[mesh.triangles]
    inverse = np.linalg.inv(frame[:3, :3])
    expected = geometry.corner_normals[:, ::-1].astype(float) @ inverse
    expected /= np.linalg.norm(expected, axis=2, keepdims=True)
    np.testing.assert_allclose(mesh.corner_normals, expected, atol=1e-5)
    assert ((mesh.corner_normals * (points - centre)).sum(axis=2) > 0.0).all()


def test_attachments_survive_what_the_host_sends():
    bright = Output(Quantity.LUMINOUS_FLUX, 5000.0)
    scene = Scene()
    scene.apply(SceneDelta(changed=(lamp("l", 0, 0, 1),)))
    scene.apply(SceneDelta(attached=(Attachment("l", {"output": bright}),)))
    assert scene.lights["l"].output == bright
    scene.apply(SceneDelta(changed=(lamp("l", 3, 0, 1),)))
    assert scene.lights["l"].output == bright
    assert scene.lights["l"].frame[0, 3] == 3.0
    # A copy has it too, and so has the light that was taken away and brought back.
    scene.apply(SceneDelta(changed=(lamp("copy", 1, 0, 1),), copies=(("copy", "l"),)))
    assert scene.lights["copy"].output == bright
    scene.apply(SceneDelta(removed=("l",)))
    scene.apply(SceneDelta(changed=(lamp("l", 4, 0, 1),)))
    assert scene.lights["l"].output == bright
    scene.apply(SceneDelta(attached=(Attachment("l", {}),)))
    assert scene.lights["l"].output.value == 1000.0
    before = scene.hash()
    with pytest.raises(SceneError, match="'colour' cannot be attached"):
        scene.apply(SceneDelta(removed=("copy",), attached=(Attachment("l", {"colour": 1}),)))
    assert scene.hash() == before


def test_sensors_of_the_engine_survive_edits():
    session = session_of(lamp("l", 0, 0, 1, 1000.0), paint(0.5))
    sensors = SensorSet("s", "desk", np.array([[0.0, 0.0, 0.0]]), UP)
    session.apply(SceneDelta(changed=(sensors,)))
    rule = StopRule(samples=1 << 12)
    first = session.measure_sensors("s", rule)
    session.apply(SceneDelta(changed=(lamp("l", 0, 0, 1, 2000.0),)))
    second = session.measure_sensors("s", rule)
    np.testing.assert_allclose(second.illuminance, 2.0 * first.illuminance, rtol=1e-5)
    with pytest.raises(SceneError, match="no sensors"):
        session.measure_sensors("t", rule)


def test_a_far_edit_moves_the_frame_and_stays_right():
    session = session_of(
        lamp("l", 0, 0, 1, 1000.0), paint(0.5), quad("f", (0, 0, -1), (1, 0, 0), (0, 1, 0), "paint")
    )
    rule = StopRule(samples=1 << 12)
    near = session.measure([[0, 0, 0]], UP, rule).illuminance
    session.apply(SceneDelta(changed=(lamp("l", 1000, 0, 1, 1000.0),)))
    far = session.measure([[1000, 0, 0]], UP, rule).illuminance
    np.testing.assert_allclose(far, near, rtol=2e-3)


def test_unused_is_forgotten():
    session = session_of(paint(0.5), lamp("l", 0, 0, 1))
    meshes = [
        replace(quad(f"q{k}", (k, 0, 0), (1, 0, 0), (0, 1, 0), f"m{k}"), id=f"q{k}")
        for k in range(3)
    ]
    materials = [Material(f"m{k}", f"m{k}", Conductor("Al", 0.2)) for k in range(3)]
    session.apply(SceneDelta(changed=(*meshes, *materials)))
    session.measure([[0, 0, 0]], UP, StopRule(samples=4))
    material_palette = session._compiled._material_palette
    assert material_palette.item("m1") is not None
    session.apply(SceneDelta(removed=("q1", "m1")))
    session.measure([[0, 0, 0]], UP, StopRule(samples=4))
    assert material_palette.item("m1") is None
    assert isinstance(meshes[0], Mesh)


def test_what_is_simplified_is_an_edit_like_others():
    """A view goes on from a switch that changes no model without being built anew."""
    light = PointLight("l", "l", Output(Quantity.LUMINOUS_INTENSITY, 100.0), np.array([1, 1, 1.8]))
    kept = session_of(block("b"), paint(0.5), light)
    kept.watch(camera_at(1, 1, 1.5, 8, 6), LiveSettings(samples=4), Display())
    kept.refine()
    plain = kept.scene.hash()
    kept.apply(SceneDelta(changed=(Modelling((("colours", Switch.FORCE),)),)))
    assert kept.has_view_work
    kept.refine()
    assert kept.commit.action != "everything built"
    kept.apply(SceneDelta(removed=("modelling",)))
    assert kept.scene.hash() == plain
