"""Light straight from surfaces that shine: shapes, nearness, size, grazing incidence, thin sources, occluders."""

import numpy as np

from lumenray.engine.scene.light import AreaLight, Output, PointLight, Quantity, SunLight

from ..bench import Bench, Finding, Findings
from ..stage import BLACK, EVEN, candela, glowing, mesh, quad
from .registry import case

LUMINANCE = 1000.0
"""Of emitters unless stated otherwise. [cd/m2]"""


def area_light(luminance: float, size_x: float, size_y: float, shape="rectangle") -> AreaLight:
    """Area light about the origin that shines down."""
    output = Output(Quantity.LUMINANCE, luminance, EVEN)
    return AreaLight("lamp", "lamp", output, np.eye(4), size_x, size_y, shape)


def panel(centre, side: float, paint: str, faces_up: bool = False):
    """Horizontal square that shines on one side."""
    corner = np.asarray(centre, dtype=np.float64) - (0.5 * side, 0.5 * side, 0.0)
    x, y = (side, 0.0, 0.0), (0.0, side, 0.0)
    return quad("panel", corner, x, y, paint) if faces_up else quad("panel", corner, y, x, paint)


def join(group, parts) -> Finding:
    """Put the readings of a group's points together.

    Parameters
    ----------
    group : Group
    parts : iterable of (points, Readings)    Indices of the points, and what was read there.
    """
    values, errors = np.full(len(group.values), np.nan), np.full(len(group.values), np.nan)
    for points, made in parts:
        values[points], errors[points] = made.values, made.errors
    return Finding(group, values, errors)


def measure_points(bench: Bench, items, group, points):
    """Measure some of a group's points. Returns them with their readings."""
    made = bench.measure(
        items, group.positions[points], group.normals[points], group.allowed[points]
    )
    bench.show(group, items)
    return points, made


@case(
    "C05",
    "Diffuse area sources",
    "direct",
    quick=("C05.cie53", "C05.axis", "C05.horizon", "C05.triangle", "C05.disk", "C05.sphere"),
)
def run_areas(bench: Bench) -> Findings:
    """Rectangles, a triangle, a disk and spheres of one luminance."""
    groups = bench.groups("C05")
    shine = glowing("shine", LUMINANCE)
    for key, scale in (("C05.cie53", 1.0), ("C05.scale0.001", 0.001), ("C05.scale1000", 1000.0)):
        if key in groups:
            items = [shine, panel(scale * np.array([2.0, 2.0, 3.0]), scale, shine.id)]
            yield bench.measure_group(items, groups[key])
    square = area_light(LUMINANCE, 1.0, 1.0)
    for key in ("C05.axis", "C05.near"):
        if key in groups:
            yield bench.measure_group([square], groups[key])
    if group := groups.get("C05.perp"):
        wall = quad("wall", (0.0, -0.5, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), shine.id)
        yield bench.measure_group([shine, wall], group)
    if group := groups.get("C05.horizon"):
        yield bench.measure_group([shine, panel((0.0, 0.0, 1.0), 2.0, shine.id)], group)
    if group := groups.get("C05.triangle"):
        corners = [(0.0, 0.0, 2.0), (0.0, 1.0, 2.0), (1.5, 0.0, 2.0)]
        yield bench.measure_group([shine, mesh("triangle", corners, [[0, 1, 2]], shine.id)], group)
    if group := groups.get("C05.disk"):
        yield bench.measure_group([area_light(LUMINANCE, 1.0, 1.0, "ellipse")], group)
    if group := groups.get("C05.sphere"):
        yield _measure_spheres(bench, group)


def _measure_spheres(bench: Bench, group) -> Finding:
    """Spheres, each with its points."""
    spheres = {}
    for i, extra in enumerate(group.extras):
        spheres.setdefault((*extra["sphere_centre"], extra["sphere_radius"]), []).append(i)
    output = Output(Quantity.LUMINANCE, LUMINANCE, EVEN)
    return join(
        group,
        [
            measure_points(
                bench, [PointLight("lamp", "lamp", output, np.array(centre), radius)], group, points
            )
            for (*centre, radius), points in spheres.items()
        ],
    )


@case("C21", "Grazing incidence", "direct", quick=("C21.point", "C21.beam", "C21.area"))
def run_grazing(bench: Bench) -> Findings:
    """Point, beam and surface that are seen from a plane at up to 89.99 degrees."""
    groups = bench.groups("C21")
    if group := groups.get("C21.point"):
        yield join(
            group,
            [
                measure_points(bench, [candela("lamp", extra["source"], 1000.0)], group, [i])
                for i, extra in enumerate(group.extras)
            ],
        )
    if group := groups.get("C21.beam"):
        output = Output(Quantity.ILLUMINANCE, 1e5, EVEN)
        sun = SunLight("sun", "sun", output, np.array([0.0, 0.0, -1.0]))
        tilt = np.radians([float(label.split()[0]) for label in group.labels])
        normals = np.stack([np.sin(tilt), np.zeros(len(tilt)), np.cos(tilt)], axis=1)
        places = np.zeros((len(tilt), 3))
        made = bench.measure([sun], places, normals, group.allowed)
        bench.show(group, [sun], places, normals)
        yield Finding(group, made.values, made.errors)
    if group := groups.get("C21.area"):
        shine = glowing("shine", LUMINANCE)
        yield bench.measure_group([shine, panel((0.0, 0.0, 0.05), 1.0, shine.id)], group)


@case("C22", "Tiny sources and huge distances", "direct", quick=("C22.size", "C22.far"))
def run_sizes(bench: Bench) -> Findings:
    """Emitters of 0.1 mm to 100 m and sensors 0.1 mm to 1000 km away."""
    groups = bench.groups("C22")
    if group := groups.get("C22.size"):
        # Labels say "side 0.0001 at 0.01 m"; sensors of one emitter are measured together.
        sides = {}
        for i, label in enumerate(group.labels):
            sides.setdefault(float(label.split()[1]), []).append(i)
        yield join(
            group,
            [
                measure_points(bench, [area_light(1e6, side, side)], group, points)
                for side, points in sides.items()
            ],
        )
    if group := groups.get("C22.far"):
        yield bench.measure_group([candela("lamp", (0.0, 0.0, 0.0), 1e9)], group)


@case("C24", "Coplanar source and receiver", "direct", quick=("C24.coplanar", "C24.edge"))
def run_coplanar(bench: Bench) -> Findings:
    """Sensors in the plane of an emitter that faces up, behind it, and just above its plane."""
    groups = bench.groups("C24")
    shine = glowing("shine", LUMINANCE)
    items = [shine, panel((0.0, 0.0, 0.0), 1.0, shine.id, faces_up=True)]
    for key in ("C24.coplanar", "C24.edge"):
        if key in groups:
            yield bench.measure_group(items, groups[key])


@case("C27", "Long thin source", "direct", quick=("C27.strip",))
def run_strips(bench: Bench) -> Findings:
    """Strip 10 m long and 1 mm wide, and one so thin that it is a line."""
    groups = bench.groups("C27")
    length, width, luminance = 10.0, 1e-3, 1e5
    # The line has the strip's luminance times width; at a width of 0.01 mm it differs from a line by less than 1e-9.
    for key, share in (("C27.strip", 1.0), ("C27.line", 0.01)):
        if key in groups:
            items = [area_light(luminance / share, length, width * share)]
            yield bench.measure_group(items, groups[key])


@case("C30", "Occluder and area source", "direct", quick=("C30.half",))
def run_occluder(bench: Bench) -> Findings:
    """A black half-plane between floor and emitter."""
    groups = bench.groups("C30")
    if group := groups.get("C30.half"):
        shine = glowing("shine", LUMINANCE)
        # The half-plane ends so far out that no line from a sensor to the emitter passes its other edges.
        half = quad("half-plane", (-50.0, -50.0, 1.5), (50.0, 0.0, 0.0), (0.0, 100.0, 0.0), "black")
        items = [shine, BLACK, panel((0.0, 0.0, 3.0), 1.0, shine.id), half]
        yield bench.measure_group(items, group)
