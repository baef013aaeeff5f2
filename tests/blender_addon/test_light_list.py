"""The list of lights: what each gives as the engine gets it, what is left out and why, and when it is not current."""

import math
import time
import types

import bpy
import numpy as np
import pytest
from panels import context, draw, interface

from lumenray.blender_addon import light_list, shown_lights
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.lights.lights import convert_light
from lumenray.engine.errors import SceneError
from lumenray.engine.photometry import units
from lumenray.engine.scene.light import Output, PointLight, Quantity, SunLight
from lumenray.engine.transport.compiled.emission import (
    area_luminance,
    line_luminance,
    luminaire_flux,
    point_intensity,
    spot_intensity,
    sun_illuminance,
)
from lumenray.libraries import luminaires

FLUX = {
    "PointLight": lambda light: point_intensity(light).amount * 4.0 * math.pi,
    "SpotLight": lambda light: (
        spot_intensity(light).amount * units.spot_solid_angle(light.half_angle, light.blend)
    ),
    "AreaLight": lambda light: (
        area_luminance(light).amount * math.pi * light.area / units.spread_axis_factor(light.spread)
    ),
    "LineLight": lambda light: line_luminance(light).amount * math.pi * light.area,
    "SunLight": lambda light: sun_illuminance(light).amount,
    "Luminaire": lambda light: luminaire_flux(light).amount,
}
"""From what the engine makes of each kind. [lm, lx of suns]"""


@pytest.fixture(autouse=True)
def _registered(registered):
    with interface():
        bpy.context.scene.render.engine = "LUMENRAY"
        yield


def add(kind, name=None, **settings):
    """A new light in the scene, with physical parameters if a quantity is among the settings."""
    light = bpy.data.lights.new(name or kind.title(), kind)
    source = bpy.data.objects.new(name or kind.title(), light)
    bpy.context.scene.collection.objects.link(source)
    light.lumenray.use_physical = "quantity" in settings
    for key, value in settings.items():
        owner = light.lumenray if hasattr(light.lumenray, key) else light
        setattr(owner, key, value)
    return source


def find():
    bpy.context.view_layer.update()
    return light_list.find_lights(bpy.context.evaluated_depsgraph_get())


def refresh():
    bpy.context.view_layer.update()
    return shown_lights.refresh(bpy.context.scene, bpy.context.view_layer)


def emitted(source):
    """What the engine emits of an object."""
    efficacy = bpy.context.scene.lumenray.efficacy
    made = convert_light(source, "x", "x", source.matrix_world, 1.0, efficacy, ConversionReport())
    return FLUX[type(made).__name__](made)


def is_current():
    bpy.context.view_layer.update()
    return shown_lights.is_current(bpy.context.scene, bpy.context.view_layer)


@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        ("POINT", {"energy": 10.0, "color": (1.0, 0.5, 0.2)}),
        ("POINT", {"energy": 10.0, "tube_length": 1.5, "shadow_soft_size": 0.02}),
        ("POINT", {"quantity": "LUMINOUS_INTENSITY", "value": 100.0}),
        ("POINT", {"quantity": "LUMINANCE", "value": 1e4, "shadow_soft_size": 0.1}),
        ("POINT", {"quantity": "RADIANT_FLUX", "value": 9.0, "spectrum": "BLACKBODY"}),
        ("POINT", {"quantity": "LUMINANCE", "value": 1e4, "tube_length": 1.5, "shadow_soft_size": 0.02}),
        ("SPOT", {"quantity": "ILLUMINANCE", "value": 900.0, "spot_blend": 0.3}),
        ("SPOT", {"energy": 30.0}),
        ("AREA", {"quantity": "LUMINANCE", "value": 5000.0, "shape": "ELLIPSE", "size_y": 0.2}),
        ("AREA", {"quantity": "ILLUMINANCE", "value": 800.0, "spread": 1.0}),
        ("AREA", {"energy": 30.0, "spread": 1.0}),
        ("SUN", {"quantity": "LUMINANCE", "value": 1e9, "angle": 0.01}),
        ("SUN", {"quantity": "RADIANT_FLUX", "value": 1000.0, "spectrum": "DAYLIGHT"}),
        ("SUN", {"energy": 3.0}),
    ],
)  # fmt: skip
def test_every_light_gives_what_the_engine_emits(kind, settings):
    source = add(kind, **settings)
    source.scale = (2.0, 3.0, 3.0) if kind == "AREA" else (2.0, 2.0, 2.0)
    (row,) = find().rows
    assert row.amount == pytest.approx(emitted(source), rel=1e-5)
    assert row.unit == ("lx" if kind == "SUN" else "lm")
    assert row.icon == f"LIGHT_{kind}"


def test_a_luminaire_gives_the_lumens_that_its_factors_leave():
    bpy.ops.lumenray.add_luminaire(
        filepath=str(luminaires.FOLDER / "photometry" / "downlight_60.ies")
    )
    source = bpy.context.object
    whole = find().flux
    settings = source.lumenray.luminaire
    settings.dimming, settings.maintenance_factor = 0.5, 0.8
    (row,) = find().rows
    assert row.amount == pytest.approx(0.4 * whole, rel=1e-5)
    assert row.amount == pytest.approx(emitted(source), rel=1e-5)


def test_the_brightest_is_first_and_suns_are_not_in_the_total():
    for name, value in (("Dim", 10.0), ("Bright", 1000.0), ("Fair", 200.0)):
        add("POINT", name, quantity="LUMINOUS_FLUX", value=value)
    add("SUN", "Sun", quantity="ILLUMINANCE", value=5e4)
    held = find()
    assert [row.name for row in held.rows] == ["Sun", "Bright", "Fair", "Dim"]
    assert held.flux == pytest.approx(1210.0)
    lines = dict(light_list.describe(held))
    assert lines["Total"] == "1\u2009210 lm"
    assert lines["Lights"] == "4"
    assert lines["Suns"] == "1, not in the total"


def test_what_is_off_or_hidden_is_left_out_and_said():
    for name in ("On", "Hidden", "Off", "Dark", "Eye"):
        add("POINT", name, quantity="LUMINOUS_FLUX", value=0.0 if name == "Off" else 100.0)
    bpy.data.objects["Hidden"].hide_render = True
    dark = bpy.data.objects["Dark"]
    dark.visible_diffuse = dark.visible_glossy = dark.visible_transmission = False
    bpy.data.objects["Eye"].hide_set(True)
    both = add("POINT", "Both", energy=5.0)
    both.hide_viewport = both.hide_render = True
    group = bpy.data.collections.new("Stored")
    bpy.context.scene.collection.children.link(group)
    group.objects.link(add("POINT", "Stored", energy=5.0))
    bpy.context.scene.collection.objects.unlink(bpy.data.objects["Stored"])
    group.hide_render = True
    held = find()
    assert [row.name for row in held.rows] == ["On"]
    assert (held.off, held.hidden) == (5, 1)
    lines = dict(light_list.describe(held))
    assert lines["Off or hidden in renders"] == "5, left out"
    assert lines["Hidden in the viewport"] == "1, not listed"


def test_what_cannot_be_computed_is_said_with_its_reason():
    add("POINT", "Good", energy=10.0)
    add("SPOT", "Bad", quantity="LUMINANCE", value=10.0)
    add("POINT", "Point", quantity="LUMINANCE", value=10.0, shadow_soft_size=0.0)
    # Off, whatever else is said of it.
    add("POINT", "Off", energy=0.0).data.use_shadow = False
    held = find()
    assert [row.name for row in held.rows] == ["Good"]
    assert held.off == 1
    words = light_list.describe_problems(held)
    assert "Bad: luminance is not defined for a spot light" in words
    assert "(and 1 more)" in words


def test_a_light_without_a_size_has_no_luminance():
    output = Output(Quantity.LUMINANCE, 1.0)
    for light in (
        PointLight("a", "a", output, np.zeros(3)),
        SunLight("a", "a", output, np.array([0.0, 0.0, -1.0])),
    ):
        with pytest.raises(SceneError, match="no size"):
            light_list.amount_of(light)


def test_an_instancer_is_one_row_with_all_its_lights():
    store = bpy.data.collections.new("Store")
    for name in ("A", "B"):
        source = add("POINT", name, quantity="LUMINOUS_FLUX", value=100.0)
        store.objects.link(source)
        bpy.context.scene.collection.objects.unlink(source)
    for k in range(3):
        room = bpy.data.objects.new(f"Room {k}", None)
        room.instance_type, room.instance_collection = "COLLECTION", store
        bpy.context.scene.collection.objects.link(room)
    held = find()
    assert [light_list.name_row(row) for row in held.rows] == [f"Room {k} (×2)" for k in range(3)]
    assert [row.amount for row in held.rows] == pytest.approx([200.0] * 3)
    assert held.count == 6


# ---- the list that is shown ----


def test_choosing_a_row_selects_its_object_and_the_active_object_is_the_active_row():
    for name, value in (("Dim", 10.0), ("Bright", 1000.0)):
        add("POINT", name, quantity="LUMINOUS_FLUX", value=value)
    refresh()
    rows = bpy.context.window_manager.lumenray_lights
    assert [row.name for row in rows.rows] == ["Bright", "Dim"]
    assert [row.amount for row in rows.rows] == ["1\u2009000 lm", "10.0 lm"]
    assert rows.row_index == -1
    rows.row_index = 1
    assert bpy.context.view_layer.objects.active.name == "Dim"
    assert [each.name for each in bpy.context.selected_objects] == ["Dim"]
    bpy.context.view_layer.objects.active = bpy.data.objects["Bright"]
    assert rows.row_index == 0
    # A selection changes no light.
    assert is_current()


def test_a_row_of_an_object_that_is_gone_selects_nothing():
    add("POINT", "Gone", energy=10.0)
    kept = add("POINT", "Kept", energy=5.0)
    refresh()
    bpy.data.objects.remove(bpy.data.objects["Gone"])
    bpy.context.view_layer.objects.active = kept
    bpy.context.window_manager.lumenray_lights.row_index = 0
    assert bpy.context.view_layer.objects.active == kept
    assert not is_current()


@pytest.mark.parametrize(
    "change",
    [
        lambda source: setattr(source.data.lumenray, "value", 7.0),
        lambda source: setattr(source.data, "energy", 3.0),
        lambda source: setattr(source, "hide_render", True),
        lambda source: source.hide_set(True),
        lambda source: setattr(source, "scale", (2.0, 2.0, 2.0)),
        lambda source: bpy.data.objects.remove(source, do_unlink=True),
        lambda _: add("SUN"),
        lambda _: setattr(bpy.context.scene.lumenray, "efficacy", 100.0),
        lambda _: setattr(bpy.context.scene.unit_settings, "scale_length", 0.01),
    ],
)
def test_a_list_that_is_not_current_says_so_until_it_is_found_anew(change):
    source = add("POINT", energy=10.0)
    refresh()
    assert is_current()
    change(source)
    assert not is_current()
    refresh()
    assert is_current()


def test_undo_makes_the_list_old_and_another_file_forgets_it():
    add("POINT", energy=10.0)
    refresh()
    for handler in bpy.app.handlers.undo_post:
        if handler.__module__.endswith("shown_lights"):
            handler(bpy.context.scene)
    assert not is_current()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert shown_lights.held() is None
    assert not bpy.context.window_manager.lumenray_lights.rows


class Timers:
    """Takes what is to be called later."""

    def __init__(self):
        self.waiting = []

    def register(self, function, first_interval):
        assert first_interval > 0.0
        self.waiting.append(function)

    def is_registered(self, function):
        return function in self.waiting


@pytest.fixture
def timers(monkeypatch):
    """What is to be called later in Blender with a window."""
    made = Timers()
    window = types.SimpleNamespace(
        app=types.SimpleNamespace(background=False, timers=made),
        context=bpy.context,
        data=bpy.data,
    )
    monkeypatch.setattr(shown_lights, "bpy", window)
    return made


def test_the_list_that_is_found_by_itself_is_that_of_the_view_layer_in_the_window(timers):
    scene, source = bpy.context.scene, add("POINT", energy=10.0)
    source.hide_set(True)
    other = scene.view_layers.new("Other")
    shown_lights.follow(scene, other)
    (find_soon,) = timers.waiting
    shown_lights._state.changed = 0.0
    assert find_soon() is None
    assert shown_lights.is_current(scene, other)
    assert [row.name for row in shown_lights.held().rows] == ["Point"]


def test_a_panel_shows_no_other_scenes_lights():
    add("POINT", energy=10.0)
    refresh()
    assert "Total" in draw("LUMENRAY_PT_lights", context(scene=bpy.context.scene))
    other = bpy.data.scenes.new("Other")
    where = context(scene=other, view_layer=other.view_layers[0])
    assert draw("LUMENRAY_PT_lights", where) == ["lumenray.list_lights"]


def test_a_list_of_a_view_layer_that_is_gone_is_not_looked_for(timers):
    scene = bpy.context.scene
    other = scene.view_layers.new("Other")
    shown_lights.follow(scene, other)
    scene.view_layers.remove(other)
    (find_soon,) = timers.waiting
    shown_lights._state.changed = 0.0
    assert find_soon() is None
    assert shown_lights.held() is None


def test_a_list_that_is_quickly_found_follows_the_scene_once_that_is_left_alone(
    monkeypatch, timers
):
    clock = types.SimpleNamespace(now=time.monotonic() + 1.0)
    monkeypatch.setattr(shown_lights.time, "monotonic", lambda: clock.now)
    source, where = add("POINT", energy=10.0), context(scene=bpy.context.scene)
    for _ in range(3):
        draw("LUMENRAY_PT_lights", where)
    (find_soon,) = timers.waiting
    assert find_soon() is None
    assert is_current()
    timers.waiting.clear()
    draw("LUMENRAY_PT_lights", where)
    assert not timers.waiting
    source.data.energy = 20.0
    assert not is_current()
    draw("LUMENRAY_PT_lights", where)
    # Dragging goes on.
    assert find_soon() == pytest.approx(shown_lights.QUIET)
    assert not is_current()
    clock.now += 1.0
    assert find_soon() is None
    assert is_current()
    # What takes long is left to the button.
    monkeypatch.setattr(shown_lights, "QUICK", 0.0)
    timers.waiting.clear()
    source.data.energy = 30.0
    assert not is_current()
    draw("LUMENRAY_PT_lights", where)
    assert not timers.waiting


def test_the_panel_shows_the_list_and_what_is_wrong_with_it():
    where = context(engine=bpy.context.scene.render.engine, scene=bpy.context.scene)
    assert draw("LUMENRAY_PT_lights", where) == ["lumenray.list_lights"]
    source = add("POINT", energy=10.0)
    add("SPOT", "Bad", quantity="LUMINANCE", value=10.0)
    bpy.context.view_layer.update()
    assert bpy.ops.lumenray.list_lights() == {"FINISHED"}
    seen = draw("LUMENRAY_PT_lights", where)
    assert "LUMENRAY_UL_lights" in seen
    assert "Total" in seen
    said = " ".join(seen)
    assert "Left out: Bad:" in said
    assert "Glowing materials and the world" in said
    assert "has changed" not in said
    source.data.energy = 20.0
    bpy.context.view_layer.update()
    assert "has changed" in " ".join(draw("LUMENRAY_PT_lights", where))
    assert draw("LUMENRAY_PT_lights", context(engine="CYCLES")) is None


def test_drawing_two_thousand_lights_asks_none_of_them(monkeypatch):
    for k in range(2000):
        add("POINT", f"Lamp {k}", energy=k + 1.0)
    refresh()
    where = context(scene=bpy.context.scene)

    def fail(*_, **__):
        raise AssertionError("a panel that is drawn converts lights")

    monkeypatch.setattr(light_list, "convert_light", fail)
    start = time.perf_counter()
    for _ in range(20):
        draw("LUMENRAY_PT_lights", where)
    # Some milliseconds each where nothing else runs; converting the lights takes seconds.
    assert (time.perf_counter() - start) / 20 < 0.2
