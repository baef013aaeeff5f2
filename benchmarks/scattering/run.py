"""Measured materials: storage over error, sampling, speed against others, pictures, and a back-light, in one run."""

import ctypes
import shutil
import subprocess
import tempfile
import time
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from ...engine.scattering.data.evaluation import albedo, evaluate, measure_reciprocity
from ...engine.scattering.data.record import ScatteringFile
from ...engine.scattering.data.resampling import resample
from ...engine.scattering.data.store import pack
from ...engine.scattering.data.table import direction_of, evaluate_table, place_on
from ..common.machine import OtherLoad, describe_machine
from ..common.output import write_numbers
from .models import MATERIALS, RED, WAVELENGTHS, mirror, paint

TOLERANCES = (0.05, 0.02, 0.01)
"""Errors that tables are made with."""

ANGLES = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0)
"""Of incidence, of the table that sampling is measured on. [deg]"""

PAIRS = 1 << 20
"""Pairs of directions that are looked up in one go."""

SCALAR_PAIRS = 2000
"""Pairs that Python looks up one by one."""

REPEATS = 5
"""Of every timing; the fastest counts."""

DRAWN = 1 << 18
"""Directions that are drawn at each incidence."""

PICTURE, GROUPS, SAMPLES = 96, 8, 64
"""Side of pictures in pixels, independent ones of each, samples of a pixel in each."""

BLOCK = 8
"""Pixels along the side of the blocks whose means are compared."""

ERRORS = (-0.05, 0.05)
"""That are made on purpose in the reflectance of the back-light's reflector."""


def run(say=None) -> dict:
    """Measure everything. ``say``: told in one line what was done. The result is plain data for JSON."""
    told = say or (lambda line: None)
    parts = {
        "storage": lambda: measure_storage(told),
        "sampling": lambda: measure_sampling(told),
        "speed": lambda: measure_speed(told),
        "pictures": lambda: measure_pictures(told),
        "backlight": lambda: measure_backlight(told),
    }
    result: dict = {"machine": describe_machine(), "other_load": {}}
    for name, measure in parts.items():
        load = OtherLoad()
        result[name] = measure()
        result["other_load"][name] = load.share()
    return result


# ---- tables ----


def measure_storage(told) -> list[dict]:
    """Size and error of tables made of materials that are known exactly."""
    rows = []
    for name, (exact, wavelengths, _) in MATERIALS.items():
        for tolerance in TOLERANCES:
            start = time.perf_counter()
            table = _table(name, tolerance)
            seconds = time.perf_counter() - start
            content = pack(ScatteringFile(Path(name), "", {"front_reflection": table}))
            rows.append(
                {
                    "material": name,
                    "tolerance": tolerance,
                    "shape": list(table.values.shape),
                    "bytes": len(content),
                    "stated": table.error,
                    "measured": _error_of(table, exact, wavelengths),
                    "albedo": _albedo_error(table, exact, wavelengths),
                    "reciprocity": measure_reciprocity(table).residual,
                    "seconds": seconds,
                }
            )
            told(f"{name}, {100 * tolerance:g} %: {len(content)} bytes")
    return rows


@cache
def _table(name: str, tolerance: float):
    exact, wavelengths, more = MATERIALS[name]
    return resample(exact, wavelengths, tolerance=tolerance, **more)


def _error_of(table, exact, wavelengths) -> float:
    """Error of a table over other pairs of directions than those that its stated error is of."""
    rng = np.random.default_rng(99)
    wi, spread = (_cosine_directions(rng.random((2, 20_000))) for _ in range(2))
    wi = wi[wi[:, 2] > np.cos(np.radians(80.0))]
    spread = spread[: len(wi)]
    near = wi * [-1.0, -1.0, 1.0] + 0.2 * rng.normal(size=wi.shape) * rng.random((len(wi), 1))
    near /= np.linalg.norm(near, axis=1, keepdims=True)
    wo = np.where(np.arange(len(wi))[:, None] % 2 == 0, near, spread)
    above = wo[:, 2] > 0.05
    wi, wo = wi[above], wo[above]
    true = exact(wi, wo)
    floor = 0.05 * max(albedo(table, s).max() for s in table.incidences) / np.pi
    made = evaluate(table, wi, wo)
    if made.shape[1] > 1:
        below, share = place_on(table.wavelengths, wavelengths)
        made = made[:, below] * (1.0 - share) + made[:, below + 1] * share
    relative = (made - true) / (true + floor)
    return float(np.sqrt((relative**2).mean()))


def _at_bands(values, wavelengths, bands):
    """Values at those of the wavelengths that a table kept."""
    if values.shape[1] == 1:
        return values
    return values[:, np.searchsorted(wavelengths, bands)]


def _albedo_error(table, exact, wavelengths) -> float:
    """Largest relative error of the reflectance at the angles of `ANGLES`, by quadrature over 600 x 400 directions."""
    radial = (np.arange(600) + 0.5) / 600
    worst = 0.0
    for angle in ANGLES:
        s = np.radians(angle)
        # Points crowd about the mirror direction, where lobes are.
        polar = 0.5 * np.pi * radial**2
        turn = (np.arange(400) + 0.5) / 400 * 2.0 * np.pi
        t, a = (m.ravel() for m in np.meshgrid(polar * 2.0, turn, indexing="ij"))
        weight = np.sin(t) * 2.0 * np.pi * radial.repeat(400) / 600 * (2.0 * np.pi / 400)
        wo = direction_of(np.full_like(t, s), t, a)
        above = wo[:, 2] > 0.0
        wi = np.broadcast_to([np.sin(s), 0.0, np.cos(s)], wo.shape)
        f = _at_bands(exact(wi[above], wo[above]), wavelengths, table.wavelengths)
        true = ((weight * wo[:, 2])[above]) @ f
        worst = max(worst, float(np.abs(albedo(table, s) / true - 1.0).max()))
    return worst


def _cosine_directions(draw) -> np.ndarray:
    sine, turn = np.sqrt(draw[0]), 2.0 * np.pi * draw[1]
    return np.stack([sine * np.cos(turn), sine * np.sin(turn), np.sqrt(1.0 - draw[0])], axis=1)


# ---- sampling ----


def _start(spectral: bool):
    from ...engine.scattering.kernels import plugin
    from ...engine.transport import backend

    backend.start(spectral=spectral)
    plugin.register()


def _plugin(*tables, transmission=None):
    from ...engine.scene.material import Measured
    from ...engine.transport.compiled.surfaces import bsdf
    from ...engine.transport.compiled.textures import TextureMaker

    front, back = tables if len(tables) == 2 else (tables[0], tables[0])
    return bsdf(Measured(front, back, transmission, transmission), TextureMaker(np.ones(471)))


def measure_sampling(told) -> list[dict]:
    """Weights of directions that are drawn: their mean against the albedo, their spread, the largest."""
    _start(spectral=False)
    import drjit as dr
    import mitsuba as mi

    rows = []
    for name in MATERIALS:
        table = _table(name, 0.02)
        bsdf = _plugin(table)
        for angle in ANGLES:
            si = dr.zeros(mi.SurfaceInteraction3f, DRAWN)
            si.wi = mi.Vector3f(
                float(np.sin(np.radians(angle))), 0.0, float(np.cos(np.radians(angle)))
            )
            stream = mi.PCG32(DRAWN, 11)
            numbers = mi.Point2f(stream.next_float32(), stream.next_float32())
            _, weight = bsdf.sample(mi.BSDFContext(), si, stream.next_float32(), numbers)
            weight = np.array(weight[0], dtype=float)
            rows.append(
                {
                    "material": name,
                    "incidence": angle,
                    "mean": float(weight.mean()),
                    "error": float(weight.std() / np.sqrt(DRAWN)),
                    "albedo": float(
                        _photometric(albedo(table, np.radians(angle)), table.wavelengths)
                    ),
                    "spread": float(weight.std() / weight.mean()),
                    "largest": float(weight.max() / weight.mean()),
                }
            )
        told(f"sampling, {name}")
    return rows


def _photometric(values, wavelengths):
    """Sum over the bands by the eye at equal energy, as photometric kernels take them here."""
    from ...engine.transport.compiled.textures import TextureMaker

    return TextureMaker(np.ones(471)).weigh(values, wavelengths)[..., 0]


# ---- speed ----


def measure_speed(told) -> dict:
    """Look-ups and samples a second, of kernels, of Mitsuba's own models, and one by one."""
    table = resample(paint(0.2, RED), WAVELENGTHS, tolerance=0.02)
    rng = np.random.default_rng(3)
    wi, wo = (_cosine_directions(rng.random((2, PAIRS))) for _ in range(2))
    nm = rng.uniform(400.0, 700.0, (PAIRS, 4))
    rows = {"table": list(table.values.shape), "pairs": PAIRS}
    rows["python"] = _time_python(table, wi, wo)
    told(f"one by one in Python: {rows['python']:.0f} a second")
    weighed = replace(
        table,
        wavelengths=table.wavelengths[:1],
        values=_photometric(table.values, table.wavelengths)[..., None].astype(np.float32),
    )
    rows["compiled"] = _time_compiled(table, wi, wo, nm)
    rows["compiled photometric"] = _time_compiled(weighed, wi, wo, nm[:, :1])
    told(f"one by one, compiled: {rows['compiled']} and {rows['compiled photometric']}")
    start = time.perf_counter()
    evaluate_table(table, wi[: PAIRS // 8], wo[: PAIRS // 8])
    rows["numpy"] = PAIRS / 8 / (time.perf_counter() - start)
    rows["kernels"] = _time_kernels(table, wi, wo, nm, told)
    return rows


def _time_python(table, wi, wo) -> float:
    start = time.perf_counter()
    for k in range(SCALAR_PAIRS):
        evaluate_table(table, wi[k : k + 1], wo[k : k + 1])
    return SCALAR_PAIRS / (time.perf_counter() - start)


def _time_compiled(table, wi, wo, nm) -> float | None:
    """Look-ups a second of a scalar program on one processor; None without a compiler."""
    compiler = shutil.which("cc")
    if compiler is None:
        return None
    source = Path(__file__).with_name("scalar.c")
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "scalar.so"
        options = ["-O2", "-fno-tree-vectorize", "-shared", "-fPIC", "-o", str(library)]
        subprocess.run([compiler, *options, str(source), "-lm"], check=True)
        program = ctypes.CDLL(str(library))
        pointer = ctypes.POINTER(ctypes.c_float)

        class Axis(ctypes.Structure):
            _fields_ = [("count", ctypes.c_int), ("values", pointer)]

        kept = [np.ascontiguousarray(a, dtype=np.float32) for a in (wi, wo, nm, table.values)]
        axes = [
            np.ascontiguousarray(a, dtype=np.float32)
            for a in (table.incidences, table.radials, table.azimuths, table.wavelengths)
        ]
        asked = nm.shape[1]
        result = np.zeros((PAIRS, asked), dtype=np.float32)

        def at(array):
            return array.ctypes.data_as(pointer)

        best = np.inf
        for _ in range(REPEATS):
            start = time.perf_counter()
            program.evaluate(
                PAIRS, at(kept[0]), at(kept[1]), asked, at(kept[2]),
                *(Axis(len(a), at(a)) for a in axes), at(kept[3]), at(result),
            )  # fmt: skip
            best = min(best, time.perf_counter() - start)
        expected = evaluate_table(table, wi[:200], wo[:200])
        wanted = [
            np.interp(n, table.wavelengths, row) for row, n in zip(expected, nm[:200], strict=True)
        ]
        if not np.allclose(result[:200], np.array(wanted) * wo[:200, 2:], rtol=1e-3, atol=1e-5):
            raise RuntimeError("the scalar program looks up something else")
    return PAIRS / best


def _time_kernels(table, wi, wo, nm, told) -> list[dict]:
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for spectral in (True, False):
            _start(spectral)
            import mitsuba as mi

            surfaces = {"table": _plugin(table)}
            if spectral:
                surfaces["Mitsuba's measured"] = mi.load_dict(_rgl(table, Path(folder)))
            surfaces["Mitsuba's principled"] = mi.load_dict(
                {"type": "principled", "roughness": 0.45}
            )
            for name, bsdf in surfaces.items():
                speeds = _time_surface(bsdf, wi, wo, nm)
                rows.append({"surface": name, "spectral": spectral, **speeds})
                told(
                    f"{name}: "
                    + ", ".join(f"{speed / 1e6:.1f}" for speed in speeds.values())
                    + " M/s"
                )
    return rows


def _time_surface(bsdf, wi, wo, nm) -> dict[str, float]:
    """Values, values with the density of sampling, and samples with theirs, a second."""
    import drjit as dr
    import mitsuba as mi

    si = dr.zeros(mi.SurfaceInteraction3f, PAIRS)
    si.wi = _vectors(wi)
    if mi.is_spectral:
        si.wavelengths = mi.Spectrum(*(mi.Float(n.astype(np.float32)) for n in nm.T))
    out = _vectors(wo)
    stream = mi.PCG32(PAIRS, 1)
    first = stream.next_float32()
    second = mi.Point2f(stream.next_float32(), stream.next_float32())
    dr.eval(si, out, first, second)
    context = mi.BSDFContext()
    return {
        "values": PAIRS / _fastest(lambda: bsdf.eval(context, si, out)),
        "evaluations": PAIRS / _fastest(lambda: bsdf.eval_pdf(context, si, out)),
        "samples": PAIRS / _fastest(lambda: bsdf.sample(context, si, first, second)),
    }


def _fastest(work) -> float:
    import drjit as dr

    best = np.inf
    for _ in range(REPEATS + 1):
        dr.sync_thread()
        start = time.perf_counter()
        dr.eval(work())
        dr.sync_thread()
        best = min(best, time.perf_counter() - start)
    return best


def _vectors(v):
    import mitsuba as mi

    return mi.Vector3f(*(mi.Float(np.ascontiguousarray(c, dtype=np.float32)) for c in v.T))


def _rgl(table, folder: Path) -> dict:
    """An RGL file of a table, as Mitsuba reads it."""
    from ...engine.scattering.readers.tensor_file import write_tensor_file

    path = folder / "material.bsdf"
    angles = np.radians(np.concatenate([np.arange(0.0, 81.0, 5.0), [84.0, 87.0, 89.0]]))
    write_tensor_file(path, lambda wi, wo: evaluate(table, wi, wo), angles, table.wavelengths, 64)
    return {"type": "measured", "filename": str(path)}


# ---- pictures ----


def measure_pictures(told) -> list[dict]:
    """Differences of pictures by tables and by Mitsuba's own models, with those of chance."""
    _start(spectral=True)
    import mitsuba as mi

    rows = []
    with tempfile.TemporaryDirectory() as folder:
        exact = paint(0.2, RED)
        path = Path(folder) / "red.bsdf"
        from ...engine.scattering.readers.reader import Wish, read_scattering
        from ...engine.scattering.readers.tensor_file import write_tensor_file

        angles = np.radians(np.concatenate([np.arange(0.0, 81.0, 4.0), [83.0, 86.0, 89.0]]))
        write_tensor_file(path, exact, angles, WAVELENGTHS, 64)
        ours = read_scattering(path, Wish(0.02)).sides["front_reflection"]
        matt = resample(MATERIALS["matt"][0], [550.0])
        rough = resample(mirror(0.3, is_joint=False), [550.0], tolerance=0.01)
        cases = {
            "RGL file, Mitsuba's measured": (ours, {"type": "measured", "filename": str(path)}),
            "Lambert, Mitsuba's diffuse": (
                matt,
                {"type": "diffuse", "reflectance": {"type": "uniform", "value": 0.8}},
            ),
            "GGX metal, Mitsuba's roughconductor": (
                rough,
                {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": 0.3},
            ),
        }
        for name, (table, other) in cases.items():
            theirs = mi.load_dict({"type": "twosided", "nested": other})
            both = [
                np.stack([_render(bsdf, seed + offset) for seed in range(GROUPS)])
                for offset, bsdf in ((0, _plugin(table)), (100, theirs))
            ]
            rows.append({"case": name, "stated": table.error} | _compare(*both))
            told(f"{name}: {100 * rows[-1]['difference']:.2f} %")
    return rows


def _compare(ours, theirs) -> dict:
    """Difference of block means relative to the mean of a block, and how much of it is chance."""

    def blocks(p):
        shape = (len(p), PICTURE // BLOCK, BLOCK, PICTURE // BLOCK, BLOCK, p.shape[-1])
        return p.reshape(shape).mean(axis=(2, 4))

    a, b = blocks(ours), blocks(theirs)
    mean = np.maximum(b.mean(axis=0), 0.02 * b.mean())
    chance = np.sqrt((a.var(axis=0, ddof=1) + b.var(axis=0, ddof=1)) / GROUPS) / mean
    apart = (a.mean(axis=0) - b.mean(axis=0)) / mean
    squared = max(float((apart**2).mean() - (chance**2).mean()), 0.0)
    return {
        "difference": float(np.sqrt((apart**2).mean())),
        "chance": float(np.sqrt((chance**2).mean())),
        "without_chance": float(np.sqrt(squared)),
        "whole": float(a.mean() / b.mean() - 1.0),
        "pictures": [a_.tolist() for a_ in (ours.mean(axis=0), theirs.mean(axis=0))],
    }


def _render(bsdf, seed: int) -> np.ndarray:
    """A ball on a floor of the same stuff, a lamp and a grey sky. (h, w, 3)"""
    import mitsuba as mi

    look = mi.ScalarTransform4f().look_at
    scene = mi.load_dict(
        {
            "type": "scene",
            "sky": {"type": "constant", "radiance": 0.3},
            "lamp": {
                "type": "rectangle",
                "to_world": look([2, -2, 3], [0, 0, 0], [0, 0, 1]),
                "emitter": {"type": "area", "radiance": 6.0},
            },
            "ball": {"type": "sphere", "bsdf": bsdf},
            "floor": {
                "type": "rectangle",
                "to_world": mi.ScalarTransform4f().translate([0, 0, -1]).scale(4.0),
                "bsdf": bsdf,
            },
            "sensor": {
                "type": "perspective",
                "fov": 40.0,
                "to_world": look([0, -6, 1.5], [0, 0, 0], [0, 0, 1]),
                "film": {
                    "type": "hdrfilm",
                    "width": PICTURE,
                    "height": PICTURE,
                    "rfilter": {"type": "box"},
                },
            },
            "integrator": {"type": "path", "max_depth": 4},
        }
    )
    return np.array(mi.render(scene, spp=SAMPLES, seed=seed))


# ---- back-light ----


def measure_backlight(told) -> dict:
    """A light box: how much its luminance changes with an error of its reflector, foretold and computed."""
    from dataclasses import replace

    from ...engine.accuracy.stopping import StopRule
    from ...engine.scene.material import Measured
    from ...engine.scene.scene import SceneDelta
    from ...engine.sensitivity import measure_sensitivities
    from .box import light_box, sensors_above

    reflector = resample(paint(0.25, np.array([0.93])), [550.0], tolerance=0.03)
    back, through = (
        resample(lambda wi, wo, s=s: np.full((len(wi), 1), s / np.pi), [550.0]) for s in (0.55, 0.4)
    )
    session, walls = light_box(
        Measured(reflector, reflector), Measured(back, back, through, through)
    )
    places, normals = sensors_above()
    figures = measure_sensitivities(session, places, normals, StopRule(samples=4096), 1)
    rule = StopRule(samples=1 << 17)
    right = session.measure(places, normals, rule, 7)
    rows = []
    wanted = next(f for f in figures if f.material == walls.id)
    for error in ERRORS:
        values = reflector.values * np.float32(1.0 + error)
        wrong = replace(reflector, values=values)
        session.apply(SceneDelta((replace(walls, surface=Measured(wrong, wrong)),)))
        off = session.measure(places, normals, rule, 7)
        change = off.illuminance.mean() / right.illuminance.mean() - 1.0
        rows.append(
            {
                "error": error,
                "computed": float(change),
                "foretold": float((1.0 + error) ** wanted.mean - 1.0),
            }
        )
    told(f"back-light: {wanted.mean:.2f} % per 1 %")
    return {
        "luminance": float(right.illuminance.mean() / np.pi),
        "figures": [{"material": f.name, "mean": f.mean, "error": f.mean_error} for f in figures],
        "rows": rows,
    }


def write_results(result: dict, folder: Path, json_path: Path | None) -> None:
    """Write the document and its picture, and all numbers as JSON if wanted."""
    from .chart import draw_pictures, draw_storage
    from .document import write_document

    folder.mkdir(parents=True, exist_ok=True)
    draw_storage(result["storage"]).save(folder / "scattering_storage.png")
    draw_pictures(result["pictures"]).save(folder / "scattering_pictures.png")
    write_document(result, folder / "scattering.md")
    plain = [{k: v for k, v in row.items() if k != "pictures"} for row in result["pictures"]]
    write_numbers(result | {"pictures": plain}, json_path)
