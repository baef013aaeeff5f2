"""The graph of errors as an icon."""

from fake_bakes import make_page, make_result
from panels import finish_pictures

from lumenray.blender_addon.bake.error_graph import ErrorGraph


def test_the_graph_is_drawn_once_for_a_history():
    made = ErrorGraph()
    result = make_result([], [make_page(0)])
    assert made.icon(200, True) == 0
    made.note(result.history)
    assert made.icon(200, True) == 0
    finish_pictures(made)
    (icon,) = made._icons.values()
    assert tuple(icon.image_size) == (200, 150)
    made.icon(200, True)
    assert made.timer() is None
    made.note(None)
    assert not made.has_history
    made.close()
