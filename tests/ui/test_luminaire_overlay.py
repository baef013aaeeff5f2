"""Curves and openings of luminaires drawn into the view."""

import bpy
import numpy as np
import pytest
from blender_luminaires import shown_places
from mathutils import Matrix
from photometric_files import write_peaks

from lumenray.ui import luminaire_overlay


def test_lines_are_curves_as_long_as_the_solid_and_the_opening_in_its_own_size(new_luminaire):
    new_luminaire(write_peaks(size=(0.3, 0.6, 0.0)), matrix=Matrix.Translation((10, 20, 30)))
    metres, radius = 0.01, 50.0
    places = shown_places(scale=metres)
    view = luminaire_overlay._Shown(places, np.zeros((1, 3)), radius)
    points, colours = luminaire_overlay._lines(view, metres)
    assert len(points) % 2 == 0
    assert colours.shape == (len(points), 4)
    parts = {
        name: points[np.isclose(colours, colour).all(axis=1)] - (10, 20, 30)
        for name, colour in zip(
            ("C0", "C90", "opening"),
            (*luminaire_overlay.CURVE_COLOURS, luminaire_overlay.OPENING_COLOUR),
            strict=True,
        )
    }
    # 0.6 m along x and 0.3 m along y, in units of 1 cm.
    assert np.ptp(parts["opening"], axis=0) == pytest.approx((60.0, 30.0, 0.0), abs=1e-4)
    assert np.linalg.norm(parts["C0"], axis=1).max() == pytest.approx(radius, rel=1e-3)
    assert np.abs(parts["C0"][:, 1]).max() < 1e-4
    assert np.abs(parts["C90"][:, 0]).max() < 1e-4
    # In C90 and C270, 1 of the peak's 9 cd at 0 and at 45 degrees.
    assert np.linalg.norm(parts["C90"], axis=1).max() == pytest.approx(radius / 9.0, rel=1e-3)


def test_views_are_looked_through_anew_only_after_changes_that_can_matter(new_luminaire):
    source, settings = new_luminaire(write_peaks())
    mesh = bpy.data.objects.new("Floor", bpy.data.meshes.new("Floor"))
    bpy.context.scene.collection.objects.link(mesh)
    bpy.context.view_layer.update()
    views = luminaire_overlay._cache.views
    bpy.app.handlers.depsgraph_update_post.append(luminaire_overlay.note_update)

    def is_noted(change):
        views["view"] = None
        change()
        bpy.context.view_layer.update()
        return not views

    def turn():
        settings.rotation = 1.0

    try:
        assert not is_noted(lambda: setattr(mesh, "location", (1, 0, 0)))
        assert is_noted(lambda: setattr(source, "location", (1, 0, 0)))
        assert is_noted(turn)
        assert is_noted(lambda: source.select_set(True))
        assert is_noted(lambda: source.hide_set(True))
        assert is_noted(lambda: bpy.data.objects.remove(source))
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(luminaire_overlay.note_update)
        views.clear()
