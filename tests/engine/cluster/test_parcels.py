"""Parcels: what is packed comes out, and nothing else does."""

import numpy as np
import pytest
from workers import room

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
