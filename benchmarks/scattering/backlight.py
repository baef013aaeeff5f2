"""A light box whose reflector is wrong: what changes, foretold and computed."""

from dataclasses import replace

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.scattering.data.resampling import resample
from ...engine.scene.material import Measured
from ...engine.scene.scene import SceneDelta
from ...engine.sensitivity import measure_sensitivities
from .box import light_box, sensors_above
from .models import paint

ERRORS = (-0.05, 0.05)
"""That are made on purpose in the reflectance of the back-light's reflector."""


def measure_backlight(told) -> dict:
    """A light box: how much its luminance changes with an error of its reflector, foretold and computed."""
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
