"""What a feed sends to the engine besides Blender's own scene."""

import bpy
import numpy as np
import pytest
from lumenray.blender_addon.foundation.identity import engine_id, ensure_ids
from lumenray.blender_addon.rendering import feed as feed_module
from lumenray.blender_addon.rendering.feed import SceneFeed, add_to_engine
from lumenray.engine.scene.light import Output, Quantity
from lumenray.engine.scene.scene import Attachment
from lumenray.engine.scene.sensor import SensorSet
from lumenray.engine.session import Session

pytestmark = pytest.mark.blender


def lamp(name="Lamp"):
    made = bpy.data.objects.new(name, bpy.data.lights.new(name, "POINT"))
    bpy.context.scene.collection.objects.link(made)
    made.data.energy = 10.0
    return made


def update(feed):
    bpy.context.view_layer.update()
    return feed.update(bpy.context.evaluated_depsgraph_get())


def light_key(source):
    return engine_id(source).replace("object:", "light:")


def test_additions_survive_edits_copies_and_a_new_engine():
    source = lamp()
    ensure_ids()
    feed = SceneFeed(Session(witness=False))
    update(feed)
    key = light_key(source)
    assert key in feed.session.scene.lights
    bright = Output(Quantity.LUMINOUS_FLUX, 12345.0)
    add_to_engine(Attachment(key, {"output": bright}))
    add_to_engine(SensorSet("sensors:desk", "desk", np.zeros((1, 3)), np.array([[0.0, 0, 1]])))
    assert feed.session.scene.lights[key].output == bright
    source.data.energy = 20.0
    source.location.x = 2.0
    update(feed)
    light = feed.session.scene.lights[key]
    assert (light.output, light.position[0]) == (bright, 2.0)

    copy = source.copy()
    copy.data = source.data.copy()
    bpy.context.scene.collection.objects.link(copy)
    update(feed)
    other = light_key(copy)
    assert other != key
    assert feed.session.scene.lights[other].output == bright

    again = SceneFeed(Session(witness=False))
    update(again)
    assert again.session.scene.lights[key].output == bright
    assert again.session.scene.lights[other].output == bright
    assert "sensors:desk" in again.session.scene.sensors


def test_nothing_is_sent_for_nothing():
    lamp()
    feed = SceneFeed(Session(witness=False))
    assert update(feed).stats.sent["light"] == 1
    assert update(feed) is None
    bpy.data.objects["Lamp"].name = "Other"
    bpy.data.objects["Other"].select_set(True)
    assert update(feed) is None
    bpy.data.objects["Other"].data.energy = 5.0
    edit = update(feed)
    assert sum(edit.stats.sent.values()) == 1
    assert edit.revision == feed.session.revision


def test_additions_end_with_the_file():
    add_to_engine(SensorSet("sensors:desk", "desk", np.zeros((1, 3)), np.array([[0.0, 0, 1]])))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert not feed_module._additions
