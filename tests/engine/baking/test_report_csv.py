"""The table and the report of lux maps: ranges, what is not known, and what stands before the numbers."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from fake_bakes import ERROR, make_map, make_page, make_result

from lumenray.engine.accuracy.extremes import Extreme
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.files import absolute_error, find_shortfall, write_report
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.scene.mesh import Mesh

STOPPED = "stopped at an error of 2 % (6 lx); asked for: 1 %"

SQUARE = Mesh(
    id="floor",
    name="Floor",
    vertices=np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float),
    triangles=np.array([(0, 1, 2), (0, 2, 3)], np.int32),
    materials=("paint",),
    material_index=np.zeros(2, np.int32),
)

LOST = {
    "severity": "error",
    "object": "Sky",
    "node": "Picture",
    "message": "sky.png is lost",
    "instead": "uniform grey",
    "count": 2,
    "missing": True,
}


def ordered(**rule):
    return BakeOrder(("floor",), StopRule(**rule), file="room.blend")


def made_for(order, **changes):
    own = replace(make_map(SQUARE, 0, 0, order), **changes)
    return make_result([own], [make_page(0)])


def dark(result):
    """The result where no light arrives, and nothing is noisy."""
    page = result.pages[0]
    zero = np.zeros_like(page.illuminance)
    return replace(
        result,
        mean=0.0,
        relative_standard_error=float("inf"),
        pages=(replace(page, illuminance=zero, standard_error=zero),),
    )


def read_back(folder):
    """Lines before the table, its rows, and the report."""
    lines = (folder / "report.csv").read_text(encoding="utf-8").splitlines()
    heads = [line for line in lines if line.startswith("#")]
    assert lines[: len(heads)] == heads
    rows = list(csv.DictReader(lines[len(heads) :]))
    return heads, rows, json.loads((folder / "report.json").read_text(encoding="utf-8"))


def test_the_table_holds_the_ranges_of_the_report(tmp_path):
    order = ordered(error=0.05)
    write_report(tmp_path, order, made_for(order), ())
    heads, (row,), report = read_back(tmp_path)
    (quantity,) = report["quantities"]
    assert heads == []
    for name in ("minimum", "maximum", "uniformity"):
        low, high = quantity[f"{name}_range"]
        value = float(row[name])
        assert (float(row[f"{name}_low"]), float(row[f"{name}_high"])) == (low, high)
        assert value == quantity[name]
        assert low < value < high
    least = quantity["minimum"]
    assert quantity["minimum_range"] == pytest.approx([0.9 * least, 1.1 * least])
    share = least / quantity["mean"]
    assert quantity["uniformity"] == pytest.approx(share)
    assert quantity["uniformity_range"] == pytest.approx([0.9 * share, 1.1 * share], rel=1e-3)


def test_a_range_that_is_not_known_is_empty_in_the_table_and_null_in_the_report(tmp_path):
    order = ordered(error=0.05)
    unknown = Extreme(3.0, 0.0, float("inf"))
    write_report(tmp_path, order, made_for(order, least=unknown), ())
    _, (row,), report = read_back(tmp_path)
    assert (row["minimum"], row["minimum_low"], row["minimum_high"]) == ("3.0", "0.0", "")
    assert row["uniformity_high"] == ""
    assert report["quantities"][0]["minimum_range"] == [0.0, None]
    assert report["quantities"][0]["uniformity_range"][1] is None


def test_what_was_assumed_and_missed_stands_before_the_table(tmp_path):
    order = ordered(error=0.01, samples=64)
    result = made_for(order)
    own = replace(result.maps[0].provenance, notes=("the sun is small",))
    result = replace(result, maps=(replace(result.maps[0], provenance=own),))
    shortfall = find_shortfall(order.rule, result)
    rows = [
        {**LOST, "severity": "info", "message": "of little weight"},
        {**LOST, "severity": "warning", "object": "all maps", "node": "", "message": shortfall},
        {**LOST, "severity": "warning", "object": "a\nb", "node": "", "count": 1},
        LOST,
    ]
    write_report(tmp_path, order, result, rows)
    heads, (row,), _ = read_back(tmp_path)
    assert heads == [
        "# goal: the wanted relative standard error of 1 % was not reached, it is 2 %: the 64 samples ended before",
        "# error: Sky / Picture: sky.png is lost; uniform grey (2 times)",
        "# warning: a b: sky.png is lost; uniform grey",
        "# note: the sun is small",
    ]
    assert row["name"] == "Floor"


def test_a_bake_that_was_stopped_has_not_reached_its_goal(tmp_path):
    """Whatever its error is: it may have been asked for samples."""
    for order in (ordered(error=0.05), ordered(samples=1000)):
        result = replace(made_for(order), shortfall=STOPPED)
        write_report(tmp_path, order, result, ())
        heads, _, report = read_back(tmp_path)
        assert report["goal"] == {"reached": False, "shortfall": STOPPED}
        assert heads == [f"# goal: {STOPPED}"]


def test_an_error_in_lux_is_known_without_light(tmp_path):
    order = ordered(absolute=0.5)
    bright = made_for(order)
    assert absolute_error(bright) == pytest.approx(ERROR * bright.mean)
    result = dark(bright)
    assert absolute_error(result) == 0.0
    write_report(tmp_path, order, result, ())
    assert read_back(tmp_path)[2]["goal"] == {"reached": True, "shortfall": ""}
    # Noise that all falls on zeros counts all the same.
    page = result.pages[0]
    noisy = replace(page, standard_error=np.full_like(page.illuminance, 0.75))
    missed = find_shortfall(order.rule, replace(result, pages=(noisy,)))
    assert "wanted standard error of 0.5 lx was not reached, it is 0.75 lx" in missed
    # A share of nothing is not known.
    assert "more samples do not lower it" in find_shortfall(StopRule(error=0.01), result)
    assert "not known" in find_shortfall(StopRule(error=0.01), result)
