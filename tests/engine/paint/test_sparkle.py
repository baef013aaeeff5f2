"""Single flakes of a paint and its sphere: counted as by hand, a part of the table, and the colours of the reference."""

import json

import numpy as np
import pytest

from lumenray.engine.paint.reader import parse_paint
from lumenray.engine.paint.solution import solve
from lumenray.engine.paint.sparkle import find_sparkles
from lumenray.engine.paint.sphere import paint_sphere
from lumenray.engine.paint.tabulation import PREVIEW, tabulate
from lumenray.engine.scattering.data.flake_field import lay_out, parts_of
from lumenray.libraries import paints


def described(name, **flakes):
    content = json.loads(paints.presets()[name].read_text(encoding="utf-8"))
    for layer in content["layers"]:
        for each in layer.get("flakes", []):
            each.update(flakes)
    return parse_paint(content)


def test_flakes_are_as_many_as_the_recipe_says_and_a_part_of_the_table():
    # Alumina in titania, 7.3 % of the mass: 0.744 flakes on a vertical line, 17 um wide: 3279 to a square millimetre.
    paint = described("yellow_green_pearl", diameter={"median_um": 17, "log_spread": 0})
    solution = solve(paint, [450.0, 550.0, 650.0])
    table = tabulate(solution, PREVIEW)
    (sparkle,) = find_sparkles(solution, table)
    # They reflect 0.0309, 0.5358 and 0.1315 along the normal, so t is 2 x 0.744 x 0.2327 there and back.
    depth = 2.0 * 0.744 * 0.2327
    uneven = 0.5 * depth / np.tanh(0.5 * depth)
    assert sparkle.density == pytest.approx(3279e6 / uneven, rel=0.005)
    assert sparkle.slope == pytest.approx(np.radians(3.0), rel=1e-6)
    assert sparkle.blur == pytest.approx(0.21 * 0.55 / (1.45 * 17.0), rel=0.01)
    assert lay_out(sparkle).moment == pytest.approx(1.0)
    (part,) = parts_of((sparkle,), table)
    assert (part.values <= table.values * (1.0 + 1e-6)).all()
    # At the gloss nearly all light is that of single flakes; they are cut nowhere but by rounding.
    gloss = part.values[0, 0, 0, 0] / table.values[0, 0, 0, 0]
    assert (gloss > 0.8).all()
    lost = sparkle.first_order.values - part.values
    assert lost.max() < 0.01 * table.values.max()


def test_flakes_of_unknown_size_are_not_seen_one_by_one():
    paint = described("violet_pearl")
    for each in (flake for layer in paint.layers for flake in layer.flakes):
        object.__setattr__(each, "diameters", None)
    solution = solve(paint, [550.0])
    assert find_sparkles(solution, tabulate(solution, PREVIEW)) == ()


def test_the_sphere_is_violet_at_the_gloss_with_green_about_its_edge():
    picture = paint_sphere(described("violet_pearl"), 96)
    assert picture.shape == (96, 96, 4) and picture.dtype == np.float32
    assert (picture[0, 0] == 0.0).all() and (picture[..., :3] <= 1.0).all()
    brightest = np.unravel_index(picture[..., :3].sum(axis=2).argmax(), (96, 96))
    red, green, blue = picture[brightest][:3]
    assert blue > red > green
    # Left above, as the light is; the bottom row is first.
    assert brightest[0] > 48 > brightest[1]
    middle, edge = picture[48, 48], picture[48, 90]
    assert edge[1] > edge[2]
    assert edge[1] / edge[[0, 2]].sum() > 1.2 * middle[1] / middle[[0, 2]].sum()
