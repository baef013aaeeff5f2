"""Bakes without an engine: results whose light is known, laid out by hand, for tests of what Blender does with them."""

import os
import signal
import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from lumenray.engine.accuracy.extremes import Extreme
from lumenray.engine.accuracy.history import History, Mark
from lumenray.engine.accuracy.stopping import Progress
from lumenray.engine.baking.order import AtlasPage, BakeResult, Layout, LuxMap, Seams
from lumenray.engine.errors import Cancelled
from lumenray.engine.scene.provenance import Provenance
from lumenray.engine.scene.scene import Scene

SIZE = 16
"""Side of the pages. [lumel]"""

ERROR = 0.02
"""Relative standard error of every lumel."""


def illuminance_at(page: int, u, v):
    """Illuminance of the whole at a place of a page: two straight lines, which look-ups meet exactly. [lx]"""
    return 100.0 * (page + 1) + 300.0 * np.asarray(u) + 50.0 * np.asarray(v)


def share_of(number: int, count: int) -> float:
    """Share of a layer in the whole: 1, 2, 3 ... parts."""
    return (number + 1) / (count * (count + 1) / 2)


SHORT = "stopped at an error of 0.16 %; asked for: 0.1 %"
"""What is said of a bake that was stopped."""


class FakeSession:
    """Stands for the engine's session: takes scenes and orders, and bakes every object onto a page of its own."""

    def __init__(self, pages: int | None = None):
        self.scene = Scene()
        self.pages = pages
        self.order = None
        self.cancelled = self.stopped = False

    def apply(self, delta):
        self.scene.apply(delta)

    def cancel(self):
        self.cancelled = True

    def stop(self):
        self.stopped = True

    def close(self):
        pass

    def bake_objects(self, order, progress=None):
        if self.cancelled:
            raise Cancelled("cancelled")
        self.order = order
        known = [key for key in order.objects if key in self.scene.meshes]
        meshes = [self.scene.mesh(key) for key in known]
        pages = min(len(meshes), self.pages or len(meshes))
        names = [group.name for group in order.groups] + (["rest"] if order.groups else [])
        made = tuple(make_page(number, names, order.exitance) for number in range(pages))
        maps = tuple(
            make_map(mesh, number, number % pages, order) for number, mesh in enumerate(meshes)
        )
        own = Provenance("0", "llvm_ad_mono", self.scene.hash(), order.seed, 64, 1.5)
        return make_result((replace(each, provenance=own) for each in maps), made)


def lay_out(mesh, page: int) -> Layout:
    """Lay every polygon flat into a square of the page's grid, 0.1 from its edges."""
    polygon = mesh.polygon if mesh.polygon is not None else np.arange(len(mesh.triangles))
    corners = mesh.vertices[mesh.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(normal).argmax(axis=1)
    flat = np.stack([corners[..., 0], corners[..., 1]], axis=2)
    flat = np.where((axis == 0)[:, None, None], corners[..., 1:], flat)
    flat = np.where((axis == 1)[:, None, None], corners[..., ::2], flat)
    low = flat.min(axis=(0, 1))
    flat = (flat - low) / np.maximum(flat.max(axis=(0, 1)) - low, 1e-9)
    side = int(np.ceil(np.sqrt(polygon.max() + 1)))
    cell = np.stack([polygon % side, polygon // side], axis=1)[:, None]
    uv = ((cell + 0.1 + 0.8 * flat) / side).astype(np.float32)
    return Layout(
        uv, np.full(len(uv), page, np.int32), mesh.triangles, mesh.polygon, len(mesh.vertices)
    )


def make_page(number: int, layers=(), exitance: bool = False) -> AtlasPage:
    """Return a page that is computed all over."""
    places = (np.arange(SIZE) + 0.5) / SIZE
    values = illuminance_at(number, places[None, :], places[:, None]).astype(np.float32)
    whole = np.ones((SIZE, SIZE), bool)
    leaves = np.stack([0.9505 * values, values, 1.0891 * values], axis=2) if exitance else None
    return AtlasPage(
        number=number,
        width=SIZE,
        height=SIZE,
        illuminance=values,
        standard_error=ERROR * values,
        covered=whole,
        area=np.full((SIZE, SIZE), 0.01, np.float32),
        object=np.full((SIZE, SIZE), number, np.int32),
        chart=np.zeros((SIZE, SIZE), np.int32),
        layers={name: values * share_of(i, len(layers)) for i, name in enumerate(layers)},
        exitance=leaves,
        replicates=8,
        freedom=19.0,
    )


def make_map(mesh, number: int, page: int, order) -> LuxMap:
    """Return what is known of an object on a page of `make_page`."""
    values = make_page(page).illuminance
    return LuxMap(
        id=mesh.id,
        name=mesh.name,
        number=number,
        lumels=SIZE * SIZE,
        charts=1,
        mean=float(values.mean()),
        least=Extreme(float(values.min()), 0.9 * float(values.min()), 1.1 * float(values.min())),
        largest=Extreme(float(values.max()), 0.9 * float(values.max()), 1.1 * float(values.max())),
        relative_standard_error=ERROR,
        mean_standard_error=0.5,
        bias=0.1,
        bias_error=0.2,
        samples=64.0,
        density=order.densities.get(mesh.id, order.density),
        requested_density=order.density,
        area=2.56,
        invalid=3,
        provenance=Provenance("0", "llvm_ad_mono", "hash", order.seed, 64, 1.5),
        layout=lay_out(mesh, page),
    )


def make_result(maps, pages) -> BakeResult:
    """Return a finished bake that ran to 2 % in 12 s, as forecast to 4 %."""
    marks = (
        Mark(1.0, 16.0, 0.06, 11.5),
        Mark(4.0, 64.0, 0.035, 12.1),
        Mark(12.0, 192.0, ERROR, None),
    )
    return BakeResult(
        maps=tuple(maps),
        pages=tuple(pages),
        departures=(),
        files=(),
        history=History(marks, ERROR, 0.4),
        relative_standard_error=ERROR,
        quadratic_relative_error=0.019,
        mean=float(np.mean([page.illuminance for page in pages])) if pages else 0.0,
        shrink=0.8,
        seams=Seams(120, 3.0, 1.0, 1.2),
    )


def with_back(result: BakeResult) -> BakeResult:
    """Return the result with the first object baked from behind too, onto the last page."""
    first = result.maps[0]
    page = len(result.pages) - 1
    layout = replace(first.layout, page=np.full_like(first.layout.page, page))
    return replace(result, maps=(*result.maps, replace(first, layout=layout)))


class SlowSession(FakeSession):
    """Bakes until it is asked to end; a stop gives a result, a cancel none."""

    def __init__(self):
        super().__init__()
        self.is_working = threading.Event()

    def bake_objects(self, order, progress=None):
        while not (self.cancelled or self.stopped):
            self.is_working.set()
            progress(Progress(0.3, 64, 0.0016, 5.0, 20.0, "illuminance"))
            time.sleep(0.005)
        made = super().bake_objects(order, progress)
        return replace(made, shortfall=SHORT)


class Interrupted(FakeSession):
    """Presses Ctrl-C in its bake, so and so often."""

    def __init__(self, times):
        super().__init__()
        self.times = times

    def bake_objects(self, order, progress=None):
        for _ in range(self.times):
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.05)
        assert self.stopped
        if self.cancelled and order.checkpoint is not None:
            Path(order.checkpoint).write_bytes(b"state")
        return replace(super().bake_objects(order, progress), shortfall=SHORT)
