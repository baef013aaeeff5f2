"""Ray sets: error over the size of the file, convergence beyond it, lux maps close by, speed and memory, in one run."""

import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...engine.raysets.cloud import make_cloud
from ...engine.raysets.emission import make_emission, prepare_light
from ...engine.raysets.record import LUMINOUS, Rays
from ...engine.raysets.writers import write_tm25
from ..common.machine import OtherLoad, describe_machine
from ..common.output import write_numbers
from ..common.ray_sources import RADIUS, SOURCES, disk, even_numbers, landed_shares, numbers
from .sizes import DISTANCES, DRAWN, MAP_SAMPLES, MAP_SIDE, PIECE, REPLICATES, SERIES_RAYS

SIZE = 2.0 * RADIUS
"""Of the sources. [m]"""

COUNTS = (1_000, 10_000, 100_000, 1_000_000)
"""Rays of the files."""


CELLS = 10
"""Along each side of a plane."""

KINDS = {"even": even_numbers, "random": numbers}
"""How the numbers of a file are chosen."""

SETS = {1_000: 4, 10_000: 4}
"""Independent files of a size over which squares of errors are averaged; one of others."""


SERIES = (1, 2, 4, 8, 16, 32, 64, 128, 256)
"""Generated rays over those of the file, for convergence."""


FLUX = 100.0
"""Of every source. [lm]"""


def run(say=None) -> dict:
    """Measure everything. ``say``: told in one line what was done. The result is plain data for JSON."""
    told = say or (lambda line: None)
    parts = {
        "errors": lambda: measure_errors(told),
        "convergence": lambda: measure_convergence(told),
        "maps": lambda: measure_maps(told),
        "speed": lambda: measure_speed(told),
    }
    result: dict = {"machine": describe_machine(), "other_load": {}}
    for name, measure in parts.items():
        load = OtherLoad()
        result[name] = measure()
        result["other_load"][name] = load.share()
    return result


def measure_errors(told) -> list[dict]:
    """Errors of illuminance on planes, of the file's rays and of generated ones."""
    rows = []
    for name, (source, exact) in SOURCES.items():
        truths = {d: exact(height_of(d), CELLS) for d in DISTANCES}
        for kind, choose in KINDS.items():
            for count in COUNTS:
                squares = {d: [] for d in DISTANCES}
                raws = {d: [] for d in DISTANCES}
                stated = []
                for seed in range(1, SETS.get(count, 1) + 1):
                    position, direction = source(choose(count, seed))
                    cloud = make_cloud(
                        Rays(position, direction, np.ones(count, np.float32)), FLUX, seed=seed
                    )
                    stated.append(cloud.information_error)
                    made = _land(cloud)
                    for distance, truth in truths.items():
                        mean = truth.mean()
                        raw = landed_shares(position, direction, height_of(distance), CELLS)
                        raws[distance].append(((raw - truth) ** 2).mean() / mean**2)
                        square = ((made[distance] - truth) ** 2).mean() / mean**2
                        # What is due to the number of generated rays.
                        squares[distance].append(square - 1.0 / (DRAWN * mean))
                rows += [
                    {
                        "source": name,
                        "numbers": kind,
                        "rays": count,
                        "distance": distance,
                        "repeated": float(np.sqrt(np.mean(raws[distance]))),
                        "generated": float(np.sqrt(max(np.mean(squares[distance]), 0.0))),
                        "stated": float(np.mean(stated)),
                    }
                    for distance in DISTANCES
                ]
                told(f"{name}, {kind}, {count} rays: {rows[-3]['generated']:.4f} at two sizes")
    return rows


def height_of(distance: float) -> float:
    """Height of a plane over the source's middle. ``distance``: of its surface, in sizes. [m]"""
    return SIZE * distance + RADIUS


def _land(cloud) -> dict[float, np.ndarray]:
    """Shares of generated light in the cells of all planes."""
    rng = np.random.default_rng(7)
    made = {distance: np.zeros(CELLS**2) for distance in DISTANCES}
    for _ in range(DRAWN // PIECE):
        drawn = cloud.draw(PIECE, rng)
        for distance in DISTANCES:
            made[distance] += landed_shares(
                drawn.position, drawn.direction, height_of(distance), CELLS, drawn.flux
            )
    return {distance: cells * (PIECE / DRAWN) for distance, cells in made.items()}


def measure_convergence(told) -> dict:
    """Variance and error of generated and repeated rays, as their number grows beyond that of the file."""
    source, exact = SOURCES["sphere"]
    height = height_of(2.0)
    truth = exact(height, CELLS)
    position, direction = source(even_numbers(SERIES_RAYS, 1))
    cloud = make_cloud(Rays(position, direction, np.ones(SERIES_RAYS, np.float32)), FLUX)
    rows = []
    for factor in SERIES:
        count = factor * SERIES_RAYS
        generated, repeated = [], []
        for seed in range(REPLICATES):
            rng = np.random.default_rng(seed)
            drawn = cloud.draw(count, rng)
            generated.append(
                landed_shares(drawn.position, drawn.direction, height, CELLS, drawn.flux)
            )
            chosen = rng.integers(0, SERIES_RAYS, count)
            repeated.append(landed_shares(position[chosen], direction[chosen], height, CELLS))
        row = {"rays": count, "factor": factor}
        for name, cells in (("generated", generated), ("repeated", repeated)):
            found = np.array(cells)
            row[f"{name}_variance"] = float(found.var(axis=0, ddof=1).mean() / truth.mean() ** 2)
            row[f"{name}_error"] = float(np.sqrt(((found - truth) ** 2).mean()) / truth.mean())
        rows.append(row)
    told("convergence")
    return {"rows": rows, "stated": cloud.information_error, "rays": SERIES_RAYS}


def measure_maps(told) -> list[dict]:
    """Errors of lux maps under a disk, with its rays traced and as a point."""
    from ...engine.accuracy.stopping import StopRule
    from ...engine.baking.order import BakeOrder
    from ...engine.scene.light import Luminaire, Output, Quantity
    from ...engine.scene.material import Diffuse, Material
    from ...engine.scene.mesh import Mesh
    from ...engine.scene.scene import SceneDelta
    from ...engine.scene.spectrum import Constant
    from ...engine.session import Session

    position, direction = disk(even_numbers(10_000, 1))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "disk.tm25ray"
        flux = np.full(len(position), FLUX / len(position), np.float32)
        write_tm25(path, [Rays(position, direction, flux)], LUMINOUS)
        light = prepare_light(path)
    # Errors of lumels are to be those of chance, which are taken off.
    emission = replace(light.emission, information_error=0.0)
    rows = []
    for distance in DISTANCES:
        height, half = SIZE * distance, 0.75 * SIZE * distance
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float) * half
        sheet = Mesh(
            "sheet",
            "sheet",
            corners,
            np.array([[0, 1, 2], [0, 2, 3]], np.int32),
            ("black",),
            np.zeros(2, np.int32),
        )
        frame = np.eye(4)
        frame[2, 3] = height
        lamp = Luminaire(
            "led",
            "led",
            Output(Quantity.LUMINOUS_FLUX, FLUX),
            frame,
            light.distribution,
            rays=emission,
        )
        row = {"distance": distance}
        for name, caustics in (("rays", "auto"), ("point", "off")):
            session = Session(witness=False)
            black = Material("black", "black", Diffuse(Constant(0.0)))
            session.apply(SceneDelta(changed=(sheet, black, lamp)))
            order = BakeOrder(
                ("sheet",),
                StopRule(samples=MAP_SAMPLES),
                density=MAP_SIDE / (2.0 * half),
                margin=1,
                caustics=caustics,
                transport="mono",
            )
            start = time.perf_counter()
            made = session.bake_objects(order)
            row[f"{name}_seconds"] = time.perf_counter() - start
            row[f"{name}_error"] = _map_error(made, height, half)
        rows.append(row)
        told(f"lux map at {distance:g} sizes: {row['rays_error']:.4f}, {row['point_error']:.4f}")
    return rows


def _map_error(made, height: float, half: float) -> float:
    """Root mean square error of a map of the sheet under the disk, over its mean, without the part of chance."""
    page, facts = made.pages[0], made.maps[0]
    row, column = np.nonzero(page.covered & (page.object == facts.number))
    values = made.lumels(facts.number)
    corner = facts.layout.uv.reshape(-1, 2)
    low, high = corner.min(axis=0), corner.max(axis=0)
    # The chart may lie turned on its page; the light under the middle of a disk does not care.
    place = np.stack([(column + 0.5) / page.width, (row + 0.5) / page.height], axis=1)
    across = (2.0 * (place - low) / (high - low) - 1.0) * half
    inside = (np.abs(across) < half).all(axis=1)
    square = (across**2).sum(axis=1)[inside]
    total = square + height**2 + RADIUS**2
    factor = 0.5 * (1.0 - (total - 2.0 * RADIUS**2) / np.sqrt(total**2 - 4.0 * RADIUS**2 * square))
    true = FLUX / (np.pi * RADIUS**2) * factor
    light = values.illuminance.astype(float)[inside]
    noise = values.standard_error.astype(float)[inside]
    found = ((light - true) ** 2 - noise**2).mean()
    return float(np.sqrt(max(found, 0.0)) / true.mean())


def measure_speed(told) -> dict:
    """Rays generated in a second, seconds of preparation, and bytes that are held."""
    from ...engine.transport import backend

    backend.start(spectral=False)
    import drjit as dr
    import mitsuba as mi

    from ...engine.transport.light_tracing.ray_source import RaySource

    rows = []
    for name, (source, _) in SOURCES.items():
        position, direction = source(even_numbers(100_000, 1))
        rays = Rays(position, direction, np.ones(100_000, np.float32))
        start = time.perf_counter()
        cloud = make_cloud(rays, FLUX)
        prepared = time.perf_counter() - start
        rng = np.random.default_rng(1)
        host = _best(lambda cloud=cloud, rng=rng: cloud.draw(PIECE, rng), 3)
        drawer = RaySource(make_emission(cloud, np.zeros(3), np.zeros(0), np.zeros(0)))

        def draw(drawer=drawer):
            made = drawer.draw(mi.PCG32(size=4 * PIECE, initstate=dr.opaque(mi.UInt64, 3)))
            dr.eval(*made[:3])
            dr.sync_thread()

        draw()
        kernel = _best(draw, 5)
        rows.append(
            {
                "source": name,
                "body": cloud.body.describe(),
                "prepare_seconds": prepared,
                "host_rays_per_second": PIECE / host,
                "kernel_rays_per_second": 4 * PIECE / kernel,
                "bytes_per_ray": cloud.bytes_per_ray,
            }
        )
        told(f"{name}: {4e-6 * PIECE / kernel:.1f} million rays a second in kernels")
    return {"rows": rows, "rays": 100_000}


def _best(work, rounds: int) -> float:
    """Shortest time of some rounds. [s]"""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document and its pictures to a folder, and all numbers to a JSON file if one is named."""
    from .chart import draw_convergence, draw_errors
    from .document import write_document

    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    draw_errors(result["errors"], folder / "raysets_errors.png")
    draw_convergence(result["convergence"], folder / "raysets_convergence.png")
    write_document(result, folder / "raysets.md")
