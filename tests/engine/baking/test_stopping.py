"""Ends of bakes."""

import numpy as np
import pytest

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import Cancelled


@pytest.mark.mitsuba
def test_a_bake_stops_at_the_wanted_error_and_can_be_cancelled():
    from small_scenes import box, paint, quad, session_of

    from lumenray.engine.baking.order import BakeOrder
    from lumenray.engine.scene.light import Output, PointLight, Quantity

    floor = quad("floor", (0.2, 0.2, 0.1), (1, 0, 0), (0, 1, 0), "paint")
    items = (
        box(2, 2, 2),
        floor,
        paint(0.5),
        PointLight("l", "l", Output(Quantity.LUMINOUS_FLUX, 100.0), np.ones(3), 0.1),
    )
    session = session_of(*items)

    def bake(progress=None, **rule):
        order = BakeOrder(("floor",), StopRule(**rule), density=16.0)
        return session.bake_objects(order, progress)

    seen = []
    made = bake(seen.append, error=0.01)
    assert made.relative_standard_error <= 0.01
    assert made.maps[0].relative_standard_error <= 0.01
    assert made.maps[0].samples > 4
    assert all(a.done <= b.done + 0.2 for a, b in zip(seen, seen[1:], strict=False))
    with pytest.raises(Cancelled):
        bake(lambda _: session.cancel(), samples=1 << 20)
    # The session goes on after a cancel.
    assert bake(samples=4).maps[0].samples == pytest.approx(4, abs=1)
