"""Look-ups and samples a second: of kernels, of Mitsuba's own models, and one by one."""

import ctypes
import shutil
import subprocess
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...engine.scattering.data.evaluation import evaluate
from ...engine.scattering.data.resampling import resample
from ...engine.scattering.data.table import evaluate_table
from .kernels import make_plugin, start_backend, weigh_by_eye
from .models import RED, WAVELENGTHS, cosine_directions, paint

PAIRS = 1 << 20
"""Pairs of directions that are looked up in one go."""

SCALAR_PAIRS = 2000
"""Pairs that Python looks up one by one."""

REPEATS = 5
"""Of every timing; the fastest counts."""


def measure_speed(told) -> dict:
    """Look-ups and samples a second, of kernels, of Mitsuba's own models, and one by one."""
    table = resample(paint(0.2, RED), WAVELENGTHS, tolerance=0.02)
    rng = np.random.default_rng(3)
    wi, wo = (cosine_directions(rng.random((2, PAIRS))) for _ in range(2))
    nm = rng.uniform(400.0, 700.0, (PAIRS, 4))
    rows = {"table": list(table.values.shape), "pairs": PAIRS}
    rows["python"] = _time_python(table, wi, wo)
    told(f"one by one in Python: {rows['python']:.0f} a second")
    weighed = replace(
        table,
        wavelengths=table.wavelengths[:1],
        values=weigh_by_eye(table.values, table.wavelengths)[..., None].astype(np.float32),
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
            start_backend(spectral)
            import mitsuba as mi

            surfaces = {"table": make_plugin(table)}
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
