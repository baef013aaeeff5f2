"""Schedules: what is alike is counted together, and an unknown power makes sums unknown, not zero."""

import pytest

from lumenray.engine.judgement.schedule import Fitting, make_schedule

PANEL = Fitting("panel", 4000.0, 32.0)


def test_alike_luminaires_are_counted_and_powers_are_summed():
    dimmed = Fitting("panel", 2000.0, 32.0)
    made = make_schedule([PANEL, dimmed, PANEL, PANEL])
    assert [(each.luminous_flux, each.count) for each in made.fittings] == [
        (4000.0, 3),
        (2000.0, 1),
    ]
    assert made.luminous_flux == 14000.0
    assert made.watts == 128.0
    assert made.power_density(16.0) == pytest.approx(8.0)
    # 8 W/m2 for 400 lx.
    assert made.relative_power(16.0, 400.0) == pytest.approx(2.0)


def test_an_unknown_power_is_not_taken_as_none():
    made = make_schedule([PANEL, Fitting("old lamp", 900.0, None)])
    assert made.watts is None
    assert made.power_density(10.0) is None
    assert made.relative_power(10.0, 500.0) is None
    assert made.count == 2


def test_a_scene_without_luminaires_takes_no_power():
    made = make_schedule([])
    assert (made.count, made.luminous_flux, made.watts) == (0, 0.0, 0.0)
