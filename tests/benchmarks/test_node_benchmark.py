"""The benchmark of graphs of nodes: what is painted, and how it judges."""

import bpy
import pytest

from lumenray.benchmarks.nodes import run as nodes

pytestmark = pytest.mark.usefixtures("extension")


def test_both_offices_have_as_many_paints_and_an_edit_changes_one():
    from lumenray.benchmarks.nodes.dressing import COUNT, dress, turn
    from lumenray.blender_addon.sync.scene_sync import SceneSync

    names = {}
    for kind in nodes.KINDS:
        materials = dress(kind)
        names[kind] = [each.name for each in materials]
        assert len(materials) == COUNT
        for item in bpy.data.objects:
            item.hide_viewport = item.name != "Pen"
        graph = bpy.context.evaluated_depsgraph_get()
        graph.update()
        sync = SceneSync()
        rows = sync.walk(graph).report.rows
        assert not [row.text() for row, _ in rows if row.severity.name == "ERROR"]
        pen = next(each for each in materials if each.name == "Book Red")
        turn(pen, 3)
        changed = sync.walk(graph).delta.changed
        assert {item.name for item in changed if hasattr(item, "surface")} == {"Book Red"}
    assert names["pictures"] == names["graphs"]


def test_the_page_tells_what_is_slower(tmp_path):
    def seconds(picture, edit):
        return {"sync": [3.0], "picture": [picture], "edit": [edit] * 3, "shown": [0.5]}

    result = {
        "machine": {"cpu": "A processor", "cores": 2},
        "count": 39,
        "side": 512,
        "seconds": {"pictures": seconds(2.0, 0.1), "graphs": seconds(2.2, 0.2)},
    }
    nodes.write_results(result, tmp_path, None)
    text = (tmp_path / "nodes.md").read_text(encoding="utf-8")
    assert "| a picture | 2.000 s | 2.200 s | 110% |" in text
    assert "Not met: an edit of a node's value, of that with pictures: 200%." in text
