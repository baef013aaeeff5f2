"""Parcels: what is packed comes out, and nothing else does."""

import numpy as np
import pytest
from workers import room

from lumenray.engine import VERSION
from lumenray.engine.cluster import workplace
from lumenray.engine.cluster.parcels import pack, unpack
from lumenray.engine.errors import CodecError
from lumenray.engine.scene.scene import Scene, SceneDelta


def test_values_come_out_as_they_were():
    value = {
        "few": np.arange(5),
        "many": np.linspace(0.0, 1.0, 1000).reshape(10, 100),
        "text": "lx",
    }
    value["some"] = (1, 2.5, None, [True])
    made = unpack(pack(value))
    assert made["some"] == value["some"]
    for name in ("few", "many"):
        np.testing.assert_array_equal(made[name], value[name])
        assert made[name].dtype == value[name].dtype


def test_scenes_come_out_as_they_were():
    scene, other = Scene(), Scene()
    scene.apply(SceneDelta(changed=room()))
    other.apply(unpack(pack(scene.snapshot())))
    assert other.hash() == scene.hash()
    assert list(other.meshes) == list(scene.meshes)


def test_a_snapshot_holds_attachments():
    from lumenray.engine.scene.scene import Attachment

    scene, other = Scene(), Scene()
    scene.apply(SceneDelta(changed=room(), attached=(Attachment("lamp", {"name": "renamed"}),)))
    other.apply(scene.snapshot())
    assert other.lights["lamp"].name == "renamed"
    # What is sent anew keeps what is attached to it.
    lamp = room()[-1]
    other.apply(SceneDelta(changed=(lamp,)))
    assert other.lights["lamp"].name == "renamed"


@pytest.mark.parametrize("damage", [b"", b"short", "cut", "longer", "mark"])
def test_damaged_parcels_are_refused(damage):
    whole = pack({"many": np.arange(1000)})
    made = {"cut": whole[:-1], "longer": whole + b"x", "mark": b"x" + whole[1:]}
    with pytest.raises(CodecError, match="parcel"):
        unpack(made.get(damage, damage))


def test_objects_that_run_are_not_sent():
    with pytest.raises(CodecError):
        pack({"run": print})


def test_workers_of_another_version_say_so():
    task = pack({"version": "0.0.1", "errand": "one"})
    told = unpack(workplace.work(b"", task))
    assert told["state"] == "failed"
    assert "expected 0.0.1" in told["text"]


def test_workers_do_nothing_that_they_are_not_there_for():
    scene = Scene()
    scene.apply(SceneDelta(changed=room()))
    news = {"name": "s", "base": None, "revision": 1, "deltas": (scene.snapshot(),)}
    order = {
        "version": VERSION, "errand": "two", "scene": "s", "revision": 1, "job": "j",
        "method": "apply", "arguments": (), "options": {},
    }  # fmt: skip
    told = unpack(workplace.work(pack(news), pack(order)))
    assert told["state"] == "refused"
    assert "there is no job called 'apply'" in told["fault"][1]
    assert unpack(workplace.work(b"", pack(order | {"revision": 2})))["state"] == "lacks"
    workplace.recall("two")
    assert unpack(workplace.work(b"", pack(order | {"method": "measure"})))["state"] == "left"


def test_an_unknown_scene_is_asked_for():
    order = {
        "version": VERSION,
        "errand": "three",
        "scene": "gone",
        "revision": 1,
        "method": "measure",
    }
    assert unpack(workplace.work(b"", pack(order)))["state"] == "lacks"
    # A change of what is not there helps nothing.
    news = {"name": "gone", "base": 4, "revision": 5, "deltas": ()}
    assert unpack(workplace.work(pack(news), pack(order | {"revision": 5})))["state"] == "lacks"
