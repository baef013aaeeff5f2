"""What was tried to make the kernels of pictures faster, told as JSON.

That is ``python -m lumenray.benchmarks.kernels.trials TRIAL WIDTH HEIGHT SAMPLES``, in a process of its own: what is tried
holds for all kernels of a process.
"""

import ctypes
import json
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...engine import llvm
from ...engine.errors import LumenrayError
from ..common.office import load_office

TRIALS: dict[str, dict] = {
    "as it is": {},
    "8 lanes": {"lanes": 8},
    "16 lanes": {"lanes": 16},
    "functions of equal code not merged": {"flag": "MergeFunctions"},
    "calls not optimised": {"flag": "OptimizeCalls"},
}
"""By name: lanes of a packet, or a flag of Dr.Jit that is taken away."""

ORDERS = ("as they come", "by what they meet", "by chance")
"""Orders in which rays that surfaces have scattered are followed."""

ROUNDS = 3
"""How often everything is measured; the fastest counts."""

SEED = 11


def measure(trial: str, width: int, height: int, samples: int) -> dict:
    """Render the office by full paths.

    Returns
    -------
    dict    ``lanes`` of a packet; ``seconds`` of the processor for a picture whose kernels are there; ``beside``, the share
        of its time that passes outside of kernels [-]; ``functions`` of the largest kernel, and ``build_seconds`` of all;
        ``orders``, processor seconds by `ORDERS`, and ``sorting``, those that it takes to order them, for the first trial.

    Raises
    ------
    LumenrayError    Dr.Jit does not let the number of lanes be chosen here.
    """
    from ...engine.transport import backend

    wanted = TRIALS[trial]
    # Before any kernel: parts of those that there are would be used on.
    lanes = _set_lanes(wanted.get("lanes"))
    backend.start(spectral=False)
    import drjit as dr

    from ...engine.accuracy.stopping import StopRule
    from ...engine.scene.scene import SceneDelta
    from ...engine.session import Session
    from ...engine.views import ViewSettings

    if "flag" in wanted:
        dr.set_flag(getattr(dr.JitFlag, wanted["flag"]), False)
    office = load_office()
    camera = replace(office.camera, width=width, height=height)
    session = Session(witness=False)
    session.apply(SceneDelta(changed=office.items))
    settings = ViewSettings(StopRule(samples=samples), 1, method="paths")
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        session.render(camera, settings)
        built = [each for each in dr.kernel_history() if "backend_time" in each]
        runs = [_time(lambda: session.render(camera, settings)) for _ in range(ROUNDS)]
    texts = [each["ir"].getvalue() for each in built]
    made = {
        "lanes": lanes,
        "seconds": min(seconds for seconds, _ in runs),
        "beside": min(beside for _, beside in runs),
        "functions": max(texts, key=len, default="").count("\ndefine "),
        "build_seconds": sum(each["backend_time"] for each in built) / 1000.0,
    }
    if not wanted:
        made |= _measure_orders(session, camera, samples)
    return made


def _time(work) -> tuple[float, float]:
    """Processor seconds of work, and the share of its time that no kernel took."""
    import drjit as dr

    dr.kernel_history_clear()
    begin, begin_wall = time.process_time(), time.perf_counter()
    work()
    wall = time.perf_counter() - begin_wall
    seconds = time.process_time() - begin
    launched = sum(each["execution_time"] for each in dr.kernel_history()) / 1000.0
    return seconds, max(1.0 - launched / wall, 0.0)


def _set_lanes(lanes: int | None) -> int:
    """Choose how many lanes a packet has, None: those of Dr.Jit; returns how many there are."""
    llvm.settle()
    import drjit.llvm

    libraries = sorted(Path(drjit.__file__).parent.glob("*drjit-core*"))
    try:
        core = ctypes.CDLL(str(libraries[0]))
        count, choose = core._Z21jit_llvm_vector_widthv, core._Z19jit_llvm_set_targetPKcS0_j
        kind = core._Z19jit_llvm_target_cpuv, core._Z24jit_llvm_target_featuresv
    except (IndexError, OSError, AttributeError) as error:
        raise LumenrayError(f"Dr.Jit does not tell its lanes here ({error})") from None
    if lanes is not None:
        for each in kind:
            each.restype = ctypes.c_char_p
        # Copies: the library frees what it has told.
        processor, features = (bytes(each() or b"") for each in kind)
        choose(processor, features, lanes)
    return int(count())


def _measure_orders(session, camera, samples: int) -> dict:
    """Follow the rays that first surfaces scatter, in several orders; returns ``orders`` and ``sorting``."""
    with session._engine("auto") as scene:
        rays, met = _scatter_rays(scene, camera, samples)
        begin = time.process_time()
        by_shape = np.argsort(met, kind="stable")
        sorting = time.process_time() - begin
        drawn = np.random.default_rng(SEED).permutation(len(met))
        orders = dict(zip(ORDERS, (np.arange(len(met)), by_shape, drawn), strict=True))
        _follow(scene, rays, drawn)
        seconds = {
            name: min(_follow(scene, rays, order) for _ in range(ROUNDS))
            for name, order in orders.items()
        }
    return {"orders": seconds, "sorting": sorting}


def _scatter_rays(scene, camera, samples: int) -> tuple[dict, np.ndarray]:
    """Rays of a picture once the first surfaces have scattered them, as `trace` wants them, and which shapes they meet."""
    import drjit as dr
    import mitsuba as mi

    from ...engine.transport.compiled.textures import is_spectral
    from ...engine.transport.paths import gather
    from ...engine.transport.paths.channels import picture_sampler
    from ...engine.transport.paths.film import Film, learn_lights, sees
    from ...engine.transport.paths.sampler import hash_words, random_stream
    from ...engine.transport.paths.visibility import closest_hit
    from ...engine.transport.rays import spawn_ray

    film = Film(camera, scene.origin)
    learn_lights(scene, film)
    lane = dr.arange(mi.UInt32, camera.width * camera.height * samples)
    many = dr.opaque(mi.UInt32, samples)
    sample, own = lane % many, hash_words(lane // many, dr.opaque(mi.UInt32, SEED))
    wavelengths = gather.draw_wavelengths(picture_sampler(scene, 0), sample, own)
    ray, stream = film.ray_of(lane // many, sample, own), random_stream(sample, own)
    if is_spectral():
        ray.wavelengths = wavelengths
    si = closest_hit(scene, ray, sees(ray))
    choice = stream.next_float32()
    point = mi.Point2f(stream.next_float32(), stream.next_float32())
    bsdf = scene.bsdf(si, si.is_valid())
    bs, weight = bsdf.sample(mi.BSDFContext(), si, choice, point, si.is_valid())
    rays = {
        "ray": spawn_ray(scene, si, si.to_world(bs.wo)),
        "wavelengths": wavelengths,
        "scatter_pdf": bs.pdf,
        "reference": si.p,
        "active": si.is_valid() & dr.any(weight != 0.0),
    }
    met = closest_hit(scene, rays["ray"], rays["active"])
    shape = dr.select(met.is_valid(), dr.reinterpret_array(mi.UInt32, met.shape), 0)
    dr.eval(rays, shape)
    return rays, np.array(shape)


def _follow(scene, rays: dict, order: np.ndarray) -> float:
    """Processor seconds for rays in an order."""
    import drjit as dr
    import mitsuba as mi

    from ...engine.transport.paths.path_loop import trace
    from ...engine.transport.paths.sampler import random_stream

    index = mi.UInt32(order.astype(np.uint32))
    taken = {
        name: None if each is None else dr.gather(type(each), each, index)
        for name, each in rays.items()
    }
    taken["stream"] = random_stream(index, dr.opaque(mi.UInt32, SEED))
    dr.eval(taken)
    dr.sync_thread()
    begin = time.process_time()
    dr.eval(trace(scene, depth=1, **taken))
    dr.sync_thread()
    return time.process_time() - begin


if __name__ == "__main__":
    try:
        print(json.dumps(measure(sys.argv[1], *map(int, sys.argv[2:5]))))
    except LumenrayError as refusal:
        print(json.dumps({"refusal": str(refusal)}))
