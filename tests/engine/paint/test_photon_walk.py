"""Monte Carlo in paints: a continuum against the solution, discs in their places against wide flakes' closed form."""

import numpy as np
import pytest
from paints import interference, make_paint, mirrors, one_layer

from lumenray.benchmarks.paint import reference
from lumenray.engine.errors import SceneError
from lumenray.engine.paint.explicit_flakes import walk_among_discs
from lumenray.engine.paint.photon_walk import walk
from lumenray.engine.paint.solution import solve

GRAIN = {"medium": {"extinction_per_um": 0.02, "albedo": 0.8, "asymmetry": 0.7}}

PAINTS = {
    "opaque": one_layer([mirrors(0.9, 5)]),
    "clear": one_layer([interference(448, 1.5, 40, 0.1, 5)], 0.5),
    "two indices": make_paint(
        [(30, [], [GRAIN], 1.6), (20, [mirrors(0.8, 8, 0.05)], [], 1.45)], 0.4
    ),
}


@pytest.mark.parametrize("name", PAINTS)
def test_continuum_agrees_with_the_solution(name):
    walked = walk(PAINTS[name], 550.0, np.radians(30.0), 20_000, seed=1)
    albedo = solve(PAINTS[name], [550.0], is_polarised=False).albedo([0.5])[0, 0]
    assert abs(walked.albedo - albedo) < 4.0 * walked.error
    assert walked.error < 0.01
    # T1: what comes in is scattered, absorbed or mirrored.
    assert walked.albedo + walked.absorbed + walked.mirrored == pytest.approx(1.0, abs=1e-12)


def test_opaque_flakes_of_the_reference():
    found = walk(PAINTS["opaque"], 550.0, 0.0, 20_000, seed=3)
    want, error = (
        reference.entries()["A9.MC.opaque r.9 s5 aH2 black"][name][0] for name in ("value", "error")
    )
    assert abs(found.albedo - want) < 4.0 * np.hypot(found.error, error)


def test_wide_flakes_reflect_as_piles():
    """Nearly parallel wide mirrors below a face: R = r (1 - exp(-a H)) and the face's own reflections."""
    paint = one_layer([mirrors(0.9, 0.5, area=0.05, diameter={"median_um": 400})])
    found = walk_among_discs(paint, 550.0, 0.0, 6_400, seed=3)
    inside, face = 0.9 * (1.0 - np.exp(-1.0)), (0.45 / 2.45) ** 2
    want = (1.0 - face) ** 2 * inside / (1.0 - face * inside)
    assert abs(found.albedo - want) < 4.0 * found.error
    # A continuum of the same area reflects a fifth less.
    assert found.albedo > 1.1 * solve(paint_of_tilt(2.0), [550.0]).albedo([0.0])[0, 0]


def paint_of_tilt(tilt):
    return one_layer([mirrors(0.9, tilt, area=0.05)])


@pytest.mark.slow
@pytest.mark.parametrize("diameter", [6, 17, 50])
def test_discs_of_the_reference(diameter):
    """A10, at 45 degrees, where the surface holds much of the light."""
    paint = one_layer([mirrors(0.9, 5, diameter={"median_um": diameter})])
    found = walk_among_discs(paint, 550.0, np.radians(45.0), 24_000, seed=3)
    entry = reference.entries()[f"A10.explicit.D{diameter}.0.45"]
    assert abs(found.albedo - entry["value"]) < 4.0 * np.hypot(found.error, entry["error"])


def test_what_is_not_followed_is_said():
    with pytest.raises(SceneError, match="smooth paints"):
        walk(
            make_paint([(20, [], [], 1.5)], 0.5, surface={"orange_peel_slope_deg": 2}),
            550.0,
            0.0,
            10,
        )
    with pytest.raises(SceneError, match="need a 'diameter'"):
        walk_among_discs(PAINTS["opaque"], 550.0, 0.0, 10)
    crowded = one_layer([mirrors(0.9, 5, area=8, diameter={"median_um": 5})], thickness=200)
    with pytest.raises(SceneError, match="discs, expected 40000 at most"):
        walk_among_discs(crowded, 550.0, 0.0, 10)
