"""What is built for pictures of the office, step by step, told as JSON.

That is ``python -m lumenray.benchmarks.kernels.builds WIDTH HEIGHT SAMPLES``, in a process of its own; ``DRJIT_CACHE_DIR``
names its cache of kernels.
"""

import json
import sys
import time
from dataclasses import replace

import numpy as np

from ..common.office import load_office

TINY = 8
"""Width and height of the picture by which the scene is taken in before anything counts. [pixel]"""

STEP = np.array([0.2, 0.1, 0.05])
"""By which a bulb is moved. [m]"""


def measure(width: int, height: int, samples: int) -> dict:
    """Render the office again and again, edited in between.

    Returns
    -------
    dict    By step: ``built``, kernels that were in no cache; ``seconds`` of the processor that all took, ``build_seconds``
        that LLVM took; ``largest``, lines of the largest that was built, and ``functions`` of it.
    """
    from ...engine.transport import backend

    backend.start(spectral=False)
    import drjit as dr

    from ...engine.accuracy.stopping import StopRule
    from ...engine.scene.light import AreaLight, PointLight
    from ...engine.scene.material import Material
    from ...engine.scene.scene import SceneDelta
    from ...engine.scene.spectrum import Rgb
    from ...engine.session import Session
    from ...engine.views import ViewSettings

    office = load_office()
    camera = replace(office.camera, width=width, height=height)
    kinds = {
        kind: [i for i in office.items if isinstance(i, kind)] for kind in (AreaLight, PointLight)
    }
    panel, bulb = (each[0] for each in kinds.values())
    paint = next(i for i in office.items if isinstance(i, Material) and i.name == "Wall Paint")
    dimmed = replace(panel, output=replace(panel.output, value=0.5 * panel.output.value))
    moved = replace(bulb, position=bulb.position + STEP)
    red = replace(paint, surface=replace(paint.surface, reflectance=Rgb(0.6, 0.2, 0.1)))
    session = Session(witness=False)

    def render(method: str, size=(width, height)) -> None:
        view = replace(camera, width=size[0], height=size[1])
        session.render(view, ViewSettings(StopRule(samples=samples), 1, method=method))

    def edit(*items):
        session.apply(SceneDelta(changed=items))
        render("cells")

    steps = {
        "taking the scene in, a picture of 8 x 8 pixels": lambda: (
            session.apply(SceneDelta(changed=office.items)),
            render("paths", (TINY, TINY)),
        ),
        "full paths": lambda: render("paths"),
        "cells": lambda: render("cells"),
        "cells again": lambda: render("cells"),
        "a panel dimmed": lambda: edit(dimmed),
        "a bulb moved": lambda: edit(moved),
        "the walls painted": lambda: edit(red),
    }
    told = {}
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        for name, step in steps.items():
            begin = time.process_time()
            step()
            told[name] = _tell(dr.kernel_history(), time.process_time() - begin)
    return told


def _tell(history: list[dict], seconds: float) -> dict:
    """Sum a step up, as `measure` tells it."""
    built = [
        each
        for each in history
        if "backend_time" in each and not each["cache_hit"] and not each["cache_disk"]
    ]
    texts = [each["ir"].getvalue() for each in built]
    largest = max(texts, key=len, default="")
    return {
        "built": len(built),
        "seconds": seconds,
        "build_seconds": sum(each["backend_time"] for each in built) / 1000.0,
        "largest": largest.count("\n"),
        "functions": largest.count("\ndefine "),
    }


if __name__ == "__main__":
    print(json.dumps(measure(*map(int, sys.argv[1:4]))))
