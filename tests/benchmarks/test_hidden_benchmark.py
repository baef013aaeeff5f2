"""The benchmark of light that is hard to find: closed forms against other ways to the same numbers, and verdicts."""

import json

import numpy as np
import pytest
from glass_scenes import fresnel
from panes import share, stack_share

from lumenray.benchmarks.hidden import run as hidden_light
from lumenray.benchmarks.hidden import truths
from lumenray.benchmarks.hidden.scenes import make_scenes

UP = np.array([0.0, 0.0, 1.0])


# ---- closed forms ----


@pytest.mark.parametrize("internal", [1.0, 0.96])
@pytest.mark.parametrize("degrees", [0.0, 35.0, 65.0, 82.0])
def test_two_panes_pass_what_a_sum_over_amplitudes_says(degrees, internal):
    found = truths.two_panes(np.cos(np.radians([degrees])), 1.52, internal)
    assert found == pytest.approx([stack_share(degrees, 1.52, internal, 2)], rel=1e-9)


def test_a_wide_sun_gives_the_mean_over_its_disk():
    rng = np.random.default_rng(1)
    tilt, radius, count = np.radians(82.0), np.radians(1.0), 400_000
    cosine = 1.0 - rng.random(count) * (1.0 - np.cos(radius))
    across = np.sqrt(1.0 - cosine**2) * np.cos(2.0 * np.pi * rng.random(count))
    height = np.cos(tilt) * cosine + np.sin(tilt) * across
    luminance = 1e4 / (np.pi * np.sin(radius) ** 2)
    parts = height * truths.two_panes(height, 1.52, 1.0)
    parts *= luminance * 2.0 * np.pi * (1.0 - np.cos(radius))
    found = truths.sun_through_panes(tilt, 1e4, 1.52, 1.0, 2.0 * radius)
    assert abs(found - parts.mean()) < 4.0 * parts.std() / np.sqrt(count)
    assert abs(found / truths.sun_through_panes(tilt, 1e4, 1.52, 1.0, 0.0) - 1.0) > 1e-4


def test_a_lamp_is_seen_in_a_pane_at_its_image():
    # From (1, 0, 0.5) the image of a lamp at 1 m is 1.5 m below and 1 m aside.
    degrees = np.degrees(np.arctan2(1.0, 1.5))
    expected = 1000.0 * share(degrees, 1.52, 0.96, True) * 1.5 / 3.25**1.5
    found = truths.lamp_in_pane((1.0, 0.0, 0.5), -UP, UP, 1000.0, 1.52, 0.96)
    assert found == pytest.approx(expected, rel=1e-9)


def test_a_body_in_a_bulb_takes_what_rays_bring_back_to_it():
    rng = np.random.default_rng(2)
    radius, bulb, index, count = 0.012, 0.03, 1.5, 200_000
    # Lambertian from the body; the sine at the glass is that at the body over the ratio of their radii.
    inside = np.arcsin(radius / bulb * np.sqrt(rng.random(count)))
    parts = fresnel(np.arcsin(index * np.sin(inside)), index)[0]
    back, absorbing = truths.body_in_bulb(radius, bulb, index)
    assert abs(back - parts.mean()) < 4.0 * parts.std() / np.sqrt(count) + 1e-9
    # Parallel light on the whole bulb: what is refracted to within the body's radius of the middle is met.
    aside = bulb * np.sqrt(rng.random(count))
    reflected, refracted = fresnel(np.arcsin(aside / bulb), index)
    parts = np.pi * bulb**2 * np.where(bulb * np.sin(refracted) < radius, 1.0 - reflected, 0.0)
    assert abs(absorbing - parts.mean()) < 4.0 * parts.std() / np.sqrt(count)
    assert truths.body_in_bulb(1e-6, bulb, index)[0] == pytest.approx(0.04, rel=1e-6)


def test_a_black_body_in_a_room_takes_by_its_surface():
    """A body without hollows shows a quarter of its surface, so 4 rho sigma is rho S."""
    expected = 9.0 / (0.5 * 4.0 + 0.5 * 2.0)
    assert truths.closed_room(9.0, 0.5, 4.0, 2.0 / 4.0) == pytest.approx(expected)


def test_the_wall_of_a_sphere_takes_all_the_light_in_it():
    rng = np.random.default_rng(3)
    places = rng.normal(size=(400_000, 3))
    places *= 2.0 / np.linalg.norm(places, axis=1, keepdims=True)
    found = truths.in_sphere(places, (0.5, 0.2, 0.6), 1000.0, 0.5, 2.0)
    expected = truths.closed_room(1000.0, 0.5, 16.0 * np.pi)
    assert abs(found.mean() - expected) < 4.0 * found.std() / np.sqrt(len(found))


def test_light_leaves_a_keyhole_as_paths_through_the_box_do():
    rng = np.random.default_rng(4)
    width, towards, count = 0.3, np.array([0.2, 0.1, -1.0]), 100_000
    place = np.column_stack([0.5 + width * (rng.random((count, 2)) - 0.5), np.ones(count)])
    direction = np.tile(towards, (count, 1))
    weight, sums = np.ones(count), np.zeros(count)
    for _ in range(30):
        with np.errstate(divide="ignore"):
            steps = np.where(direction > 0.0, (1.0 - place) / direction, -place / direction)
        axis = np.argmin(steps, axis=1)
        rows = np.arange(count)
        place = np.clip(place + steps[rows, axis, None] * direction, 0.0, 1.0)
        high = direction[rows, axis] > 0.0
        in_hole = (axis == 2) & high & (np.abs(place[:, :2] - 0.5) < 0.5 * width).all(axis=1)
        weight = np.where(in_hole, 0.0, weight)
        sums += weight
        weight = 0.7 * weight
        radius, angle = np.sqrt(rng.random(count)), 2.0 * np.pi * rng.random(count)
        aside = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
        direction = np.empty((count, 3))
        direction[rows, axis] = np.where(high, -1.0, 1.0) * np.sqrt(1.0 - radius**2)
        direction[rows, (axis + 1) % 3], direction[rows, (axis + 2) % 3] = aside.T
    found = truths.keyhole(width, 1e5, towards, 0.7) / (1e5 * width**2)
    # 4 % of the light leaves here; a hundredth of that and less from the holes that are measured.
    assert found == pytest.approx(sums.mean(), rel=3e-3)
    assert found < 0.96 / 0.3


@pytest.mark.parametrize("offset", [-0.9, -0.4, 0.0, 0.3, 0.8])
def test_a_disk_behind_an_edge_gives_what_its_free_points_give(offset):
    rng = np.random.default_rng(5)
    elevation, radius, count = np.radians(61.0), np.radians(2.0), 400_000
    tilt = elevation + offset * radius
    cosine = 1.0 - rng.random(count) * (1.0 - np.cos(radius))
    sine, angle = np.sqrt(1.0 - cosine**2), 2.0 * np.pi * rng.random(count)
    middle = np.array([np.cos(elevation), 0.0, np.sin(elevation)])
    up = np.array([-np.sin(elevation), 0.0, np.cos(elevation)])
    x, z = (
        cosine * middle[k] + sine * np.sin(angle) * up[k] for k in (0, 2)
    )  # the third lies along the edge
    parts = np.where(z * np.cos(tilt) < x * np.sin(tilt), z, 0.0)
    parts *= 1e5 / (np.pi * np.sin(radius) ** 2) * 2.0 * np.pi * (1.0 - np.cos(radius))
    found = truths.disk_behind_edge(elevation, 2.0 * radius, 1e5, tilt)
    assert abs(found - parts.mean()) < 4.0 * parts.std() / np.sqrt(count)


def test_a_disk_that_nothing_hides_is_whole():
    found = [truths.disk_behind_edge(1.0, 0.01, 1e5, 1.0 + side) for side in (0.02, -0.02)]
    assert found == pytest.approx([1e5 * np.sin(1.0), 0.0], abs=1e-6)


def test_the_faceted_ball_has_the_shadow_of_its_outline():
    scene = make_scenes()["facets-sun"]()
    ball = next(item for item in scene.items if item.id == "room")
    a, b, c = np.moveaxis(ball.vertices[ball.triangles], 1, 0)
    shadow = 0.5 * np.maximum(np.cross(b - a, c - a)[:, 2], 0.0).sum()
    assert scene.asked[0].true == pytest.approx(1000.0 * shadow, rel=1e-9)


# ---- scenes ----


def test_every_scene_can_be_made_and_every_value_has_its_true_one():
    for name, make in make_scenes().items():
        scene = make()
        assert len({item.id for item in scene.items}) == len(scene.items), name
        for asked in scene.asked:
            true = np.atleast_1d(asked.true)
            assert (np.isfinite(true) & (true > 0.0)).all(), name


@pytest.mark.mitsuba
@pytest.mark.slow
def test_a_run_gives_each_value_with_its_error_and_repeats_it():
    result = hidden_light.run(1, ["panes-65", "pane-lamp"], say=lambda text: None)
    rows = {(row["scene"], row["what"]): row for row in result["rows"]}
    assert set(rows) == {("panes-65", "sensor behind"), ("panes-65", "picture"), ("pane-lamp", "sensor near"),
                         ("pane-lamp", "sensor far"), ("pane-lamp", "picture")}  # fmt: skip
    # Two panes that did not throw light to each other would let 2820 lx pass, and a lamp alone gives no light there.
    assert rows["panes-65", "sensor behind"]["true"] == pytest.approx(2958.7, abs=0.1)
    for row in hidden_light.summarise(result):
        assert row["passed"], row
    again = hidden_light.run(1, ["panes-65", "pane-lamp"], jobs=2)
    assert [row["value"] for row in again["rows"]] == [row["value"] for row in result["rows"]]


# ---- verdicts and the document ----


def made_up(values, errors, what="mean of map", true=100.0):
    """Rows of one value of a scene, one for each seed; its margin is 0.2 %."""
    return [
        {"scene": "box", "seed": seed, "what": what, "value": value, "error": error, "true": true,
         "margin": 0.002, "unit": "lx", "seconds": 1.5}
        for seed, (value, error) in enumerate(zip(values, errors, strict=True), 1)
    ]  # fmt: skip


def result_of(*rows):
    machine = {"cpu": "Abacus", "cores": 2, "mitsuba": "3", "lumenray": "1"}
    scenes, rows = {"box": "lamp in a box"}, [row for part in rows for row in part]
    return {"machine": machine, "seeds": 2, "jobs": 1, "scenes": scenes, "rows": rows}


@pytest.mark.parametrize(
    ("values", "errors", "passes"),
    [
        ((100.5, 99.0), (0.4, 0.4), True),
        ((100.0, 101.5), (0.4, 0.4), False),  # one seed is farther off than it says
        ((97.0, 97.4), (2.0, 2.0), False),  # errors cover it, but the mean is off
        ((103.0, 97.0), (2.0, 2.0), True),
        ((100.1, 99.9), (0.0, 0.0), True),  # no noise: rounding alone
        ((100.5, 100.5), (0.0, 0.0), False),
        ((100.0, 100.1), (0.4, 100.0), False),  # what is stated once says nothing
        ((100.2, 99.8) * 6, (0.01,) * 12, True),  # within the margin
        (
            (101.0, 99.0) * 6,
            (0.4,) * 12,
            False,
        ),  # no seed is beyond, but all are off by twice what they say
        ((100.6, 99.4) * 6, (0.4,) * 12, True),
    ],
)
def test_a_row_passes_where_every_seed_and_the_mean_do(values, errors, passes):
    (row,) = hidden_light.summarise(result_of(made_up(values, errors)))
    assert row["passed"] is passes


def test_offs_are_told_in_stated_errors_and_in_per_cent():
    (row,) = hidden_light.summarise(result_of(made_up((101.0, 98.0), (0.5, 2.0))))
    assert (row["largest"], row["percent"], row["beyond"]) == (2.0, 2.0, 0)
    assert row["rms"] == pytest.approx(np.sqrt(2.5))
    assert (row["mean"], row["spread"]) == pytest.approx((99.5, 1.5))


def test_the_document_tells_what_is_not_met(tmp_path):
    good = made_up((100.0, 101.0), (0.5, 0.5))
    bad = made_up((100.0, 110.0), (0.5, 0.5), "sensor near")
    still = made_up((100.0, 100.0), (0.0, 0.0), "picture")
    result = result_of(good, bad, still)
    hidden_light.write_results(result, tmp_path / "docs", tmp_path / "data" / "all.json")
    text = (tmp_path / "docs" / "hidden.md").read_text(encoding="utf-8")
    assert "**2 of 3 rows pass**; 1 of 6 values are farther off" in text
    assert "- lamp in a box, sensor near: 1 seeds are off by more, the mean by +5.00 %" in text
    row = "| mean of map | 100 lx | 100.5 ± 0.5 | 0.5, 0.5 | 0.2 % | 1.00 % | 2.00 | 1.41 | 1.5 s | pass |"
    assert "| lamp in a box " + row in text
    assert "| 0.00 % | – | – | 1.5 s | pass |" in text
    assert json.loads((tmp_path / "data" / "all.json").read_text(encoding="utf-8")) == result


def test_the_command_ends_with_1_where_a_row_fails(tmp_path, monkeypatch, capsys):
    from lumenray.command_line.main import main

    asked = []
    good, bad = made_up((100.0, 101.0), (0.5, 0.5)), made_up((100.0, 110.0), (0.5, 0.5))

    def run(seeds, scenes, jobs, say):
        asked.append((seeds, scenes))
        return result_of(good if len(asked) == 1 else bad)

    monkeypatch.setattr(hidden_light, "run", run)
    command = ["benchmark", "hidden", "--scene", "a", "--scene", "b", "-o", str(tmp_path)]
    assert main(command) == 0
    assert main([*command, "--seeds", "3", "--force"]) == 1
    assert asked == [(20, ["a", "b"]), (3, ["a", "b"])]
    assert "hidden.md" in capsys.readouterr().out


def test_a_scene_that_is_not_there_is_told(tmp_path, capsys):
    from lumenray.command_line.main import main

    assert main(["benchmark", "hidden", "--scene", "cellar", "-o", str(tmp_path)]) == 1
    assert "there is no scene cellar; choose from panes-35, " in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
