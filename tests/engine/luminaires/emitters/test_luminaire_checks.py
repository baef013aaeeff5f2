"""What cannot be a luminaire is refused in words; what goes and comes back shines as before."""

import gc
import re

import numpy as np
import pytest
from luminaires import OPENINGS, luminaire
from small_scenes import session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.distribution import Opening
from lumenray.engine.scene.scene import SceneDelta

pytestmark = [pytest.mark.mitsuba, pytest.mark.usefixtures("mono")]

WRONG_OPENINGS = {
    "no width": (Opening("rectangle", (0.0, 0.5, 0.0)), "size of 0 m along x"),
    "a flat body": (Opening("box", (0.3, 0.3, 0.0)), "size of 0 m along z"),
    "a flat ball": (Opening("ellipsoid", (0.3, 0.0, 0.3)), "size of 0 m along y"),
    "a cylinder of no length": (Opening("cylinder", (0.0, 0.3, 0.3), "x"), "size of 0 m along x"),
    "a thick disk": (Opening("ellipse", (0.3, 0.3, 0.1)), "expected 0 m"),
    "below nothing": (Opening("box", (0.3, -0.3, 0.3)), "size of -0.3 m along y"),
    "not a number": (Opening("ellipse", (np.nan, 0.3, 0.0)), "size of nan m along x"),
    "without end": (Opening("cylinder", (0.3, 0.3, np.inf)), "size of inf m along z"),
    "beyond the horizon": (Opening("rectangle", (5e4, 1.0, 0.0)), "to 10000 m"),
    "finer than light": (Opening("ellipsoid", (1e-6, 1e-6, 1e-6)), "1e-05 to"),
    "unheard of": (Opening("star", (1.0, 1.0, 1.0)), "shape 'star'"),
    "an axis too many": (Opening("cylinder", (1.0, 1.0, 1.0), "w"), "about 'w'"),
}


@pytest.mark.parametrize("name", WRONG_OPENINGS)
def test_what_is_no_opening_is_refused_in_words(name):
    opening, words = WRONG_OPENINGS[name]
    session = session_of(luminaire("lambertian", opening, key="kitchen"))
    said = f"(?=.*expected)luminaire 'kitchen' has an opening .*{re.escape(words)}"
    with pytest.raises(SceneError, match=said):
        session.measure([[0, 0, -1]], [[0, 0, 1]], StopRule(samples=16))


def test_a_scaled_frame_is_refused_in_words():
    light = luminaire("lambertian", OPENINGS["box"], rotation=2.0 * np.eye(3), key="hall")
    with pytest.raises(SceneError, match="'hall' is scaled or sheared"):
        session_of(light).measure([[0, 0, -1]], [[0, 0, 1]], StopRule(samples=16))


def test_luminaires_that_go_and_come_back_shine_as_before():
    place, up, rule = [[0.2, 0.1, -1.0]], [[0, 0, 1]], StopRule(samples=256)
    lights = [
        luminaire("batwing", OPENINGS["cylinder"], key="a"),
        luminaire("type B", place=(0.0, 0.5, 0.0), key="b"),
    ]
    session = session_of(*lights)
    first = session.measure(place, up, rule).illuminance
    for _ in range(3):
        session.apply(SceneDelta(removed=("a", "b")))
        gc.collect()
        assert session.measure(place, up, rule).illuminance == 0.0
        session.apply(SceneDelta(changed=tuple(lights)))
        gc.collect()
        np.testing.assert_array_equal(session.measure(place, up, rule).illuminance, first)
