"""What the benchmark of the atlas measures: scenes, lumels, and programs that agree on both."""

import numpy as np
import pytest

from lumenray.engine.accuracy.extremes import Extreme
from lumenray.engine.accuracy.history import History
from lumenray.engine.baking.order import AtlasPage, BakeResult, Layout, LuxMap, Seams
from lumenray.engine.scene.provenance import Provenance

pytestmark = pytest.mark.mitsuba

PROVENANCE = Provenance("", "", "", 0, 0, 0.0, (), ())


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
    from lumenray.benchmarks.atlas.stage import Stage
    from lumenray.benchmarks.common.pieces import box, make_mesh, quad
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
    from lumenray.benchmarks.atlas.stage import Stage
    from lumenray.benchmarks.atlas.variants import make_plain
    from lumenray.benchmarks.common.pieces import rigid_frame
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
