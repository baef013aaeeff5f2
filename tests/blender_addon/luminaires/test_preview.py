"""Diagrams of luminaires as icons."""

import threading

import bpy
import numpy as np
import pytest
from panels import finish_pictures
from photometric_files import write_peaks

from lumenray.blender_addon.file_assets.pictures import Pictures
from lumenray.blender_addon.luminaires import preview as luminaire_pictures
from lumenray.blender_addon.luminaires.files import photometric_files


def test_diagram_is_drawn_once_for_every_content(new_luminaire, monkeypatch):
    drawn, allowed = [], threading.Event()

    def diagram(file, size, dark):
        allowed.wait(30.0)
        drawn.append((file, dark))
        pixels = np.zeros((*size[::-1], 4), np.float32)
        pixels[0, 0] = (1.0, 0.5, 0.0, 1.0)
        return pixels

    monkeypatch.setattr("lumenray.engine.analysis.polar_diagram.diagram_pixels", diagram)
    made = Pictures("diagram", luminaire_pictures.draw_diagram)
    _, settings = new_luminaire(write_peaks())
    reading = photometric_files.obtain(settings)
    # Blender goes on while the picture is drawn.
    assert made.icon(reading, 256, True) == 0
    assert bpy.app.timers.is_registered(made.timer)
    assert made.timer() is not None
    assert drawn == []
    allowed.set()
    for _ in range(3):
        made.icon(reading, 256, True)
        finish_pictures(made)
    assert drawn == [(reading.file, True)]
    _, other = new_luminaire(write_peaks(peaks=(2, 1, 1, 1, 2)), name="other.ies")
    made.icon(photometric_files.obtain(other), 256, True)
    made.icon(reading, 256, False)
    finish_pictures(made)
    assert drawn[1:] == [(photometric_files.obtain(other).file, True), (reading.file, False)]
    icon = next(iter(made._icons.values()))
    assert tuple(icon.image_size) == (256, 256)
    first = int(icon.image_pixels[0]) & 0xFFFFFFFF
    # Red in the lowest byte, of the bottom left pixel.
    assert first & 0xFF == 255
    assert (first >> 8) & 0xFF == pytest.approx(127, abs=1)
    made.close()
    assert not bpy.app.timers.is_registered(made.timer)


def test_diagram_of_a_real_file_becomes_an_icon(new_luminaire):
    made = Pictures("diagram", luminaire_pictures.draw_diagram)
    _, settings = new_luminaire(write_peaks())
    made.icon(photometric_files.obtain(settings), 256, False)
    finish_pictures(made)
    (icon,) = made._icons.values()
    pixels = np.empty(256 * 256 * 4, np.float32)
    icon.image_pixels_float.foreach_get(pixels)
    # White paper with something on it.
    assert pixels.max() == 1.0
    assert 0.01 < (pixels < 0.7).mean() < 0.5
    made.close()
