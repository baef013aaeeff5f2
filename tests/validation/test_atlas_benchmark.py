"""The benchmark of the atlas: what it measures is right, and it tells what it measured."""

import json
from dataclasses import replace

import numpy as np
import pytest
from lumenray.engine.accuracy.extremes import Extreme
from lumenray.engine.accuracy.history import History, Mark
from lumenray.engine.baking.order import AtlasPage, BakeResult, Layout, LuxMap, Seams
from lumenray.engine.scene.provenance import Provenance

pytestmark = pytest.mark.mitsuba

PROVENANCE = Provenance("", "", "", 0, 0, 0.0, (), ())


@pytest.fixture(scope="module", autouse=True)
def _started():
    """Settle where LLVM lies before Dr.Jit is loaded."""
    from lumenray.engine.transport import backend

    backend.start(spectral=False)


def lay_out_quads(mesh, density: float, side: int, start: int):
    """Rectangles of a mesh of quads side by side in rows from a row of the page on. (t, 3, 2) uv, and the next free row."""
    uv = np.zeros((len(mesh.triangles), 3, 2), dtype=np.float32)
    x, y, height = 2.0, float(start), 0.0
    for first in range(0, len(mesh.triangles), 2):
        corners = mesh.vertices[mesh.triangles[first : first + 2]]
        origin = corners[0, 0]
        u, v = corners[0, 1] - origin, corners[1, 2] - origin
        size = np.linalg.norm(u) * density, np.linalg.norm(v) * density
        if x + size[0] + 4 > side:
            x, y, height = 2.0, y + height + 4, 0.0
        flat = np.stack(
            [(corners - origin) @ (w / (w @ w)) * s for w, s in zip((u, v), size, strict=True)],
            axis=-1,
        )
        uv[first : first + 2] = (flat + np.array([x, y])) / side
        x, height = x + size[0] + 4, max(height, size[1])
    return uv, int(np.ceil(y + height)) + 4


def made_up_bake(scene, side: int = 256, density: float = 4.0) -> BakeResult:
    """Result of a scene of quads whose pages hold nothing yet but where things lie."""
    from lumenray.engine.scene.scene import Scene, SceneDelta

    held = Scene()
    held.apply(SceneDelta(changed=scene.items))
    maps, row = [], 2
    for number, key in enumerate(scene.objects):
        mesh = held.mesh(key)
        uv, row = lay_out_quads(mesh, density, side, row)
        page = np.zeros(len(mesh.triangles), dtype=np.int32)
        layout = Layout(uv, page, mesh.triangles, None, len(mesh.vertices))
        figures = dict.fromkeys(("lumels", "charts", "mean", "relative_standard_error"), 1)
        figures |= dict.fromkeys(
            ("mean_standard_error", "bias", "bias_error", "samples", "density", "area"), 1
        )
        maps.append(
            LuxMap(
                id=key,
                name=key,
                number=number,
                requested_density=density,
                invalid=0,
                smoothed=False,
                provenance=PROVENANCE,
                layout=layout,
                least=Extreme(1.0, 0.9, 1.1),
                largest=Extreme(1.0, 0.9, 1.1),
                **figures,
            )
        )
    assert row <= side
    shape = (side, side)
    page = AtlasPage(
        0,
        side,
        side,
        np.zeros(shape, np.float32),
        np.zeros(shape, np.float32),
        np.ones(shape, bool),
        np.zeros(shape, np.float32),
        _owners(maps, side),
        np.zeros(shape, np.int32),
        {},
        None,
        8,
        19.0,
    )
    seams = Seams(0, 0.0, 0.0, 0.0)
    return BakeResult(tuple(maps), (page,), (), (), History(), 0.0, 0.0, 0.0, 1.0, seams)


def _owners(maps, side: int) -> np.ndarray:
    """Object number by lumel: charts lie in rows of their own."""
    made = np.full((side, side), -1, dtype=np.int32)
    for lux_map in maps:
        v = lux_map.layout.uv[..., 1] * side
        made[int(v.min()) - 1 : int(np.ceil(v.max())) + 1] = lux_map.number
    return made


@pytest.fixture(scope="module")
def cornell():
    """Return the plain box with its made-up bake and the places of its lumels."""
    from lumenray.benchmarks.atlas.lumels import find_places
    from lumenray.benchmarks.atlas.scenes import build
    from lumenray.benchmarks.atlas.stage import Stage
    from lumenray.benchmarks.atlas.variants import make_plain

    scene = make_plain(build("cornell"))
    result = made_up_bake(scene)
    stage = Stage(scene)
    meshes = {key: stage.scene.mesh(key) for key in scene.objects}
    return scene, result, stage, find_places(result, meshes)


def test_places_of_lumels_cover_the_surface(cornell):
    scene, _, stage, places = cornell
    surface = sum(stage.scene.mesh(key).areas().sum() for key in scene.objects)
    # What is left out are rims of less than a quarter of a lumel.
    assert places.area.sum() == pytest.approx(surface, rel=0.02)
    # Places of a lumel lie within its diagonal of a quarter of a metre's.
    first = places.positions[places.start]
    last = places.positions[places.start + places.count - 1]
    assert np.linalg.norm(first - last, axis=1).max() <= 0.25 * np.sqrt(2.0) + 1e-6


def test_scenes_are_closed_and_seen_from_inside(cornell):
    _, _, stage, places = cornell
    assert not stage.are_inside(places.positions[::7], places.geometric_normals[::7]).any()


@pytest.mark.parametrize("key", ["cornell", "cabin", "window", "hall", "lamp"])
def test_rooms_face_inwards(key):
    from lumenray.benchmarks.atlas.scenes import build
    from lumenray.engine.scene.mesh import Mesh

    scene = build(key)
    assert len({item.id for item in scene.items}) == len(scene.items)
    shells = [
        item
        for item in scene.items
        if isinstance(item, Mesh) and item.id.split()[0] in {"wall", "side", "ceiling", "floor"}
    ]
    points = np.concatenate([mesh.vertices for mesh in shells])
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    for mesh in shells:
        corners = mesh.vertices[mesh.triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        inwards = np.einsum("ti,ti->t", normal, middle - corners.mean(axis=1))
        assert (inwards > 0.0).all(), mesh.id


def test_places_below_a_lid_are_inside():
    from lumenray.benchmarks.atlas.scenes import AtlasScene
    from lumenray.benchmarks.atlas.shapes import box, make_mesh, quad
    from lumenray.benchmarks.atlas.stage import Stage
    from lumenray.engine.scene.material import Diffuse, Material

    floor = make_mesh("floor", [quad((-1, -1, 0), (2, 0, 0), (0, 2, 0))], "grey")
    block = make_mesh("block", [box((-0.2, -0.2, -0.1), (0.2, 0.2, 0.3))], "grey")
    items = (Material("grey", "grey", Diffuse()), floor, block)
    stage = Stage(AtlasScene("", "", items, ("floor",), 1.0, 1))
    places, up = np.array([[0.0, 0.0, 0.0], [0.7, 0.7, 0.0]]), np.array([[0.0, 0.0, 1.0]] * 2)
    assert stage.are_inside(places, up).tolist() == [True, False]


def test_plain_gathering_and_the_reference_agree(cornell, tmp_path):
    """Two estimators with random numbers of their own; within what their errors allow."""
    from lumenray.benchmarks.atlas.gather import PlainGather
    from lumenray.benchmarks.atlas.lumels import draw_rows
    from lumenray.benchmarks.atlas.references import find_reference

    _, _, stage, places = cornell
    chosen = places.take(draw_rows(places, places.is_inner, 64, 1))
    said = []
    reference = find_reference(stage, chosen, 0.01, 60.0, said.append, tmp_path)
    gather = PlainGather(stage, chosen)
    values = np.array([gather.run(1024, seed)[0] for seed in range(4)])
    mean, spread = values.mean(axis=0), values.std(axis=0, ddof=1) / 2.0
    total = np.sqrt(spread**2 + reference.errors**2)
    # The mean of 64 squares of about unit variance, with few degrees of freedom.
    assert 0.3 < np.median(((mean - reference.values) / total) ** 2) / 0.5 < 2.5
    assert np.average(mean - reference.values) == pytest.approx(
        0.0, abs=4.0 * np.sqrt(np.mean(total**2) / len(chosen))
    )
    # A second time it comes from the folder.
    again = find_reference(stage, chosen, 0.01, 60.0, said.append, tmp_path)
    assert len(said) == 1
    assert np.array_equal(again.values, reference.values)


def test_the_plain_variant_has_the_flux_of_the_scene():
    """Illuminance straight below a small Lambertian square: flux / (pi d^2) (inverse square and cosine law)."""
    from lumenray.benchmarks.atlas.scenes import AtlasScene
    from lumenray.benchmarks.atlas.shapes import rigid_frame
    from lumenray.benchmarks.atlas.stage import Stage
    from lumenray.benchmarks.atlas.variants import make_plain
    from lumenray.engine.accuracy.stopping import StopRule
    from lumenray.engine.scene.light import AreaLight, Output, Quantity
    from lumenray.engine.transport.paths.illuminance import Receivers, compute

    output = Output(Quantity.LUMINOUS_FLUX, 1000.0)
    frame = rigid_frame((0.0, 0.0, 4.0), (0.0, 0.0, -1.0))
    lamp = AreaLight("lamp", "lamp", output, frame, 0.02, 0.02)
    stage = Stage(make_plain(AtlasScene("", "", (lamp,), (), 1.0, 1)))
    receivers = Receivers.at_points([[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]])
    made = compute(stage.compiled, receivers, StopRule(samples=1 << 12))
    assert made.mean[0] == pytest.approx(1000.0 / (np.pi * 16.0), rel=1e-3)


@pytest.mark.blender
@pytest.mark.slow
def test_cycles_bakes_the_same_page(cornell, tmp_path):
    pytest.importorskip("bpy")
    from lumenray.benchmarks.atlas.cycles import CyclesBake
    from lumenray.benchmarks.atlas.lumels import draw_rows
    from lumenray.benchmarks.atlas.references import find_reference

    scene, result, stage, places = cornell
    chosen = places.take(draw_rows(places, places.is_inner, 96, 1))
    reference = find_reference(stage, chosen, 0.01, 60.0, lambda _: None, tmp_path)
    cycles = CyclesBake(scene, result)
    try:
        page, seconds = cycles.run(256)
    finally:
        cycles.close()
    values = page[chosen.y, chosen.x]
    assert seconds > 0.0
    # A wrong place would be off by much more than the noise of 256 paths.
    assert reference.error_of(values) < 0.2
    assert reference.ratio(values)[0] == pytest.approx(1.0, abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["exact", "cached"])
def test_radiance_reads_the_same_lumels(cornell, tmp_path, kind):
    pytest.importorskip("pyradiance")
    from lumenray.benchmarks.atlas.lumels import draw_rows
    from lumenray.benchmarks.atlas.radiance import CACHED, EXACT, RadianceRace
    from lumenray.benchmarks.atlas.references import find_reference

    scene, _, stage, places = cornell
    chosen = places.take(draw_rows(places, places.is_inner, 48, 1))
    reference = find_reference(stage, chosen, 0.01, 60.0, lambda _: None, tmp_path)
    radiance = RadianceRace(scene, chosen)
    try:
        values, seconds = radiance.run(EXACT[3] if kind == "exact" else CACHED[0], 250.0)
    finally:
        radiance.close()
    assert seconds > 0.0
    assert reference.ratio(values)[0] == pytest.approx(1.0, abs=0.05)


# ---- statistics ----


@pytest.mark.parametrize(
    ("freedom", "expected"), [(1, 12.7062), (2, 4.30265), (3, 3.18245), (7, 2.36462), (30, 2.04227)]
)
def test_student_quantiles_are_those_of_tables(freedom, expected):
    """Table of Student's t for two-sided 95 % intervals (any textbook of statistics)."""
    from lumenray.benchmarks.atlas.statistics import student_quantile

    assert student_quantile(0.975, freedom) == pytest.approx(expected, rel=1e-5)


def test_times_to_an_error_follow_the_runs():
    from lumenray.benchmarks.atlas.statistics import seconds_to

    # error = 0.1 / sqrt(seconds)
    points = [(seconds, 0.1 / np.sqrt(seconds)) for seconds in (1.0, 4.0, 16.0, 64.0)]
    within = seconds_to(points, 0.02)
    assert (within.seconds, within.is_thought_on) == (pytest.approx(25.0), False)
    beyond = seconds_to(points, 0.005)
    assert (beyond.seconds, beyond.is_thought_on) == (pytest.approx(400.0), True)
    assert seconds_to(points, 0.5).bound == "<"
    # A biased program comes to an end.
    flat = [(1.0, 0.05), (4.0, 0.031), (16.0, 0.0301), (64.0, 0.03)]
    assert seconds_to(flat, 0.01).bound == ">"


def made_up_reference(values, errors):
    """Reference with lumels of 1 m2."""
    from lumenray.benchmarks.atlas.references import Reference

    return Reference(values, errors, np.ones(len(values)), 1, 1.0)


@pytest.mark.parametrize("honesty", [0.5, 1.0, 2.0])
def test_calibration_finds_how_honest_an_error_is(honesty):
    """Stated errors are the true ones over ``honesty``; the reference has noise of its own."""
    from lumenray.benchmarks.atlas.calibration import covered_share
    from lumenray.benchmarks.atlas.statistics import student_quantile

    rng = np.random.default_rng(5)
    count, replicates = 20_000, 8
    truth = rng.uniform(50.0, 150.0, count)
    reference = made_up_reference(truth + 0.4 * rng.standard_normal(count), np.full(count, 0.4))
    samples = truth[:, None] + 2.0 * np.sqrt(replicates) * rng.standard_normal((count, replicates))
    values = samples.mean(axis=1)
    errors = samples.std(axis=1, ddof=1) / np.sqrt(replicates) / honesty
    ratio = reference.error_of(values) / reference.stated(errors)
    assert ratio == pytest.approx(honesty, rel=0.03)
    held = covered_share(values - reference.values, errors, reference.errors, replicates - 1)
    if honesty == 1.0:
        assert held == pytest.approx(0.95, abs=0.01)
        assert student_quantile(0.975, replicates - 1) > 1.96
    else:
        assert (held > 0.97) == (honesty < 1.0)
        assert (held < 0.93) == (honesty > 1.0)


def test_forecasts_are_taken_after_a_twentieth_of_the_time_and_after_two_passes():
    from lumenray.benchmarks.atlas.calibration import judge_forecast

    marks = (
        Mark(0.4, 0.0, 0.1, 8.0),
        Mark(0.9, 3.0, 0.07, 11.0),
        Mark(2.0, 6.0, 0.05, 9.7),
        Mark(10.0, 30.0, 0.02, 10.0),
    )
    row = judge_forecast(replace(empty_result(), history=History(marks)), 0.02)
    assert row["rough"] == pytest.approx({"at": 0.09, "forecast": 11.0, "share": 1.1})
    assert row["settled"] == pytest.approx({"at": 0.2, "forecast": 9.7, "share": 0.97})


def empty_result() -> BakeResult:
    """Return a result of nothing."""
    return BakeResult((), (), (), (), History(), 0.0, 0.0, 0.0, 1.0, Seams(0, 0.0, 0.0, 0.0))


def race_of(factor: float) -> dict:
    """Race in which another program takes ``factor`` times as long as ours."""

    def row(scale):
        points = [(scale * s, 0.05 / np.sqrt(s)) for s in (0.5, 2.0, 8.0, 32.0)]
        return {"points": points, "work": ["-"] * 4, "scaled": 1.0, "mean": 1.0}

    slow = {"ways": {"exact": row(3 * factor), "cached": row(factor)}}
    return {
        "key": "cornell",
        "title": "Box",
        "lumels": 100,
        "judged": 50,
        "reference_error": 0.002,
        "first_seconds": 9.0,
        "programs": {
            "Lumenray": row(1.0),
            "plain_gather": row(factor),
            "cycles": {"refusal": "no Blender"},
            "radiance": slow,
        },
        "switches": {name: row(factor) for name in ("qmc", "direct_apart", "adaptive")},
    }


def made_up_result() -> dict:
    """Whole result with every part."""
    from lumenray.benchmarks.atlas.summary import summarise

    run = {"level": 0.02, "seed": 1, "seconds": 1.0, "stated": 0.02, "stated_here": 0.02}
    run |= {"true": 0.021, "ratio": 1.05, "covered": 0.948, "mean": 1.0, "replicates": 8}
    own = {"at": 0.06, "forecast": 9.8, "share": 0.98}
    forecast = {"target": 0.01, "seconds": 10.0, "rough": own, "settled": own}
    scene = {"key": "cornell", "title": "Box", "lumels": 100, "judged": 50, "cut": 0}
    scene |= {
        "reference_error": 0.002,
        "runs": [run, run | {"level": 0.01}],
        "forecasts": [forecast],
    }
    size = {"triangles": 1_000_000, "charts": 10_000, "pages": 6, "density": 20.0, "setup": 1.0}
    size |= {"tracing": 8.0, "finishing": 1.0, "memory": 3.0, "memory_before": 1.0, "not_finite": 0}
    runs = [size | {"lumels": n, "seconds": n / 1e6} for n in (10_000_000, 40_000_000)]
    leak = {"case": "box", "lit": 100.0, "dark": 1e-5, "largest": 1e-4, "lumels": 9}
    seam = {"error": 0.02, "places": 9, "step": 1.0, "noise": 2.0, "mean": 900.0, "charts": 5}
    hard = {"case": "T-vertices", "triangles": 9, "lumels": 9, "charts": 1, "not_finite": 0}
    races = [race_of(4.0), race_of(9.0)]
    machine = dict.fromkeys(
        ("cpu", "cores", "memory_gib", "system", "python", "mitsuba", "lumenray"), "-"
    )
    return {
        **summarise([scene], races),
        "machine": machine,
        "is_quick": True,
        "scenes": [scene],
        "races": races,
        "geometry": {
            "leaks": [leak],
            "seams": [seam | {"before": 3.0, "after": 1.0, "told_noise": 2.0}],
            "hard": [
                hard | {"area": 1.0, "low": 0.99, "high": 1.01, "reported": ["a; b"]},
                {"case": "slivers", "triangles": 3, "failure": "no lumel"},
            ],
        },
        "scale": {"samples": 4, "runs": runs},
        "seconds": 9.0,
        "unsteadiness": 0.04,
        "other_load": 0.5,
    }


def test_the_summary_is_of_all_runs():
    result = made_up_result()
    assert result["calibration"] == pytest.approx(1.05)
    assert result["coverage_95"] == pytest.approx(0.948)
    assert result["forecast_median_error"] == pytest.approx(0.02)
    # The better way of a program counts; the geometric mean of 4 and 9 is 6.
    assert result["speedup"]["plain_gather"] == pytest.approx(6.0)
    assert result["speedup"]["radiance"] == pytest.approx(6.0)
    assert result["speedup"]["qmc"] == pytest.approx(6.0)
    assert result["speedup"]["cycles"] is None


def test_the_bars_tell_what_is_met_and_what_is_not():
    from lumenray.benchmarks.atlas.bars import check_bars, compare_results

    result = made_up_result()
    bars = {bar.demand: bar.passed for bar in check_bars(result)}
    assert bars["true over stated error, mean"] is True
    assert bars["time of Plain gathering over ours"] is False
    assert bars["time of Cycles over ours"] is None
    assert bars["dark side over lit side"] is True
    assert bars["hard geometry without a number that is none"] is False
    assert bars["exponent of time in lumels"] is True
    # One scene that states too little is told, whatever the mean of all is.
    (scene,) = result["scenes"]
    poor = {**scene, "key": "poor", "runs": [{**run, "ratio": 1.2} for run in scene["runs"]]}
    (bar,) = (
        bar
        for bar in check_bars({**result, "scenes": [scene] * 9 + [poor]})
        if bar.demand == "true over stated error, every scene"
    )
    assert bar.passed is False
    assert bar.measured.startswith("1.20 at worst (poor")
    assert bars[bar.demand] is True
    other = {**result, "calibration": 1.2}
    assert [bar.passed for bar in compare_results(other, result)].count(False) == 1


def test_the_document_and_its_pictures_are_written(tmp_path):
    from lumenray.benchmarks.atlas import run as atlas

    result = made_up_result()
    atlas.write_results(result, tmp_path, tmp_path / "all.json")
    text = (tmp_path / "atlas.md").read_text(encoding="utf-8")
    for name in ("atlas_races.png", "atlas_calibration.png", "atlas_scale.png"):
        assert f"({name})" in text
        assert (tmp_path / name).stat().st_size > 1000
    assert "This was a quick run" in text
    assert "fails: no lumel" in text
    read = atlas.read_results(tmp_path / "all.json")
    assert read["speedup"] == json.loads(json.dumps(result["speedup"]))


def test_a_building_has_as_many_triangles_and_rooms_as_asked():
    from lumenray.benchmarks.atlas.building import build_building, count_triangles
    from lumenray.engine.scene.light import AreaLight

    scene = build_building(20_000, 360, 10.0)
    assert count_triangles(scene) == pytest.approx(20_000, rel=0.2)
    assert sum(isinstance(item, AreaLight) for item in scene.items) == 10


def test_a_smooth_cylinder_has_every_edge_once():
    from lumenray.benchmarks.atlas.geometry import _cylinder, _shared_edges

    mesh = _cylinder()
    first, second = _shared_edges(mesh.triangles)
    # Three edges for each triangle; all are shared by two but those of the rims.
    assert len(first) == (3 * len(mesh.triangles) - 2 * 48) // 2
    for column in (1, 2):
        ends = [mesh.triangles[rows[:, 0], rows[:, column]] for rows in (first, second)]
        assert np.array_equal(*ends)


def test_large_bakes_that_were_ended_are_gone_on_with(tmp_path, monkeypatch):
    from lumenray.benchmarks.atlas import scale as atlas_scale
    from lumenray.engine.errors import LumenrayError

    asked, said = [], []

    def bake(run):
        asked.append(run.pages)
        if len(asked) == 2:
            raise LumenrayError("ended")
        names = ("triangles", "charts", "lumels", "pages", "seconds", "memory")
        return dict.fromkeys(names, 1.0) | {"pages": run.pages}

    monkeypatch.setattr(atlas_scale, "_in_child", bake)
    runs = tuple(atlas_scale.Specification(100, 6, pages) for pages in (1, 2, 3))
    cache = tmp_path / "scale.json"
    with pytest.raises(LumenrayError):
        atlas_scale.measure_scale(said.append, runs, cache)
    made = atlas_scale.measure_scale(said.append, runs, cache)
    assert asked == [1, 2, 2, 3]
    assert [row["pages"] for row in made["runs"]] == [1, 2, 3]
    # A whole one begins anew.
    atlas_scale.measure_scale(said.append, runs, cache)
    assert asked[4:] == [1, 2, 3]


def test_steady_work_is_foretold_and_work_that_slows_down_is_not():
    from lumenray.benchmarks.common.machine import foretell

    even = np.arange(400) * 0.1
    assert foretell(even.tolist(), 0.1) == pytest.approx(0.0, abs=1e-9)
    # Twice as slow in every second stretch of 25 pieces: the first tenth of 200 sees but one kind.
    steps = np.where(np.arange(400) // 25 % 2 == 0, 0.1, 0.2)
    assert 0.1 < foretell(np.cumsum(steps).tolist(), 0.1) < 0.4
