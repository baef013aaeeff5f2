"""What a feed sends to the engine, and what stays there of what others sent."""

import bpy
import pytest

from lumenray.blender_addon.foundation.identity import engine_id, ensure_ids
from lumenray.blender_addon.rendering.feed import SceneFeed
from lumenray.engine.scene.light import Output, Quantity
from lumenray.engine.scene.scene import Attachment, SceneDelta
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


def test_what_is_attached_to_an_item_survives_its_edits_and_goes_with_its_copies():
    source = lamp()
    ensure_ids()
    feed = SceneFeed(Session(witness=False))
    update(feed)
    key = light_key(source)
    bright = Output(Quantity.LUMINOUS_FLUX, 12345.0)
    feed.session.apply(SceneDelta(attached=(Attachment(key, {"output": bright}),)))
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
