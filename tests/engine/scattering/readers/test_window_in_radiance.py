"""Real WINDOW XML files, and their values and totals in Radiance."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from folders import WILD
from scattering_models import directions
from window_files import HALF_TURN, evaluate_window, read_window, row_towards, shares_sent

from lumenray.engine.errors import FileFormatError
from lumenray.engine.scattering.data.patches import check_patches
from lumenray.engine.scattering.data.tree import albedo_of_tree, check_tree
from lumenray.engine.scattering.readers.window_xml import SIDES, is_window_xml, read_window_xml
from lumenray.engine.scene.scattering import PatchMatrix

DATA = WILD / "bsdf" / "lbnl_xml"

RADIANCE = """
import json, sys
import pyradiance.bsdf as bsdf
kept, found = [], []
for path, pairs, incidents in json.load(sys.stdin):
    # Radiance ends the process where one of several is given back.
    data = bsdf.load_file(path)
    kept.append(data)
    values = [float(bsdf.query(data, *pair)[1]) for pair in pairs]
    # Diffuse and other, reflected or transmitted.
    totals = [bsdf.direct_hemi(data, *way, flags) for *way, flags in incidents]
    found.append([values, totals])
json.dump(found, sys.stdout)
"""
"""Values and hemispherical totals; angles in degrees, of wi and wo."""


def real_files() -> list[Path]:
    if not DATA.is_dir():
        pytest.skip(f"no real files in {DATA}")
    return sorted(DATA.glob("*.xml"))


def test_real_files_are_read_or_refused():
    for path in real_files():
        data = path.read_bytes()
        assert is_window_xml(data)
        stated = set(re.findall(rb"<WavelengthDataDirection>(.*?)<", data))
        if not stated:
            with pytest.raises(FileFormatError, match="template without data"):
                read_window_xml(data, path)
            continue
        file = read_window_xml(data, path)
        sides = {SIDES[name.decode().lower()] for name in stated}
        for name in ("front_transmission", "back_transmission"):
            if name in sides:
                sides |= {"front_transmission", "back_transmission"}
        assert set(file.sides) == sides
        for side in file.sides.values():
            (check_patches if isinstance(side, PatchMatrix) else check_tree)(side)


def test_files_of_known_reflectance():
    real_files()
    for name, expected in (
        ("simple_tensor_refl", (0.8, 0.8)),
        ("simple_tensor_front_refl", (0.8, 0.0)),
    ):
        sides = read_window((DATA / f"{name}.xml").read_bytes()).sides
        for side, value in zip(("front_reflection", "back_reflection"), expected, strict=True):
            assert albedo_of_tree(sides[side], 0.5)[0] == pytest.approx(value, rel=1e-6)


def degrees_of(w) -> tuple[float, float]:
    return (
        float(np.degrees(np.arccos(np.clip(w[2], -1.0, 1.0)))),
        float(np.degrees(np.arctan2(w[1], w[0]))),
    )


def in_radiance(w, is_front: bool) -> tuple[float, float]:
    """Polar angle and azimuth of a direction that lies on our front or back, in Radiance's frame: its z points indoors."""
    return degrees_of((-w[0], w[1], -w[2] if is_front else w[2]))


def test_values_and_totals_are_those_of_radiance():
    """By its own evaluation of the same files: fronts, backs, incident and outgoing directions are where it has them."""
    pytest.importorskip("pyradiance")
    count, asked, ours = 150, [], []
    wi, wo = directions(count, 20, 0.0), directions(count, 21, 0.0)
    # Straight and mirrored light is met in a third of the pairs.
    near = wi[::3] * HALF_TURN + np.random.default_rng(22).normal(size=(50, 3)) * 0.02
    wo[::3] = near / np.linalg.norm(near, axis=1, keepdims=True) * np.sign(near[:, 2:])
    incidents = np.concatenate(
        [row_towards(*way) for way in ((3, 20), (38, 110), (62, 200), (80, 310))]
    )
    for path in real_files():
        if path.name == "WINDOW6BSDFt_template.xml":
            continue
        for name, scatter in read_window_xml(path.read_bytes(), path).sides.items():
            if not scatter.values.any():
                # Radiance takes what is not seen as not told, and tells it by reciprocity.
                continue
            side, kind = name.split("_")
            front, leaves = side == "front", (side == "front") == (kind == "reflection")
            pairs = [
                (*in_radiance(a, front), *in_radiance(b, leaves))
                for a, b in zip(wi, wo, strict=True)
            ]
            flags = 12 + (1 if kind == "reflection" else 2)
            asked.append((str(path), pairs, [(*in_radiance(w, front), flags) for w in incidents]))
            ours.append((path.name, name, scatter))
    found = subprocess.run(
        [sys.executable, "-c", RADIANCE],
        input=json.dumps(asked),
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    compared = 0
    for (file, name, scatter), (values, totals) in zip(ours, json.loads(found.stdout), strict=True):
        label = f"{file} {name}"
        # Radiance keeps the even part of a distribution apart, with a colour of four digits.
        assert evaluate_window(scatter, wi, wo) == pytest.approx(values, rel=1e-3, abs=1e-5), label
        assert shares_sent(scatter, incidents) == pytest.approx(totals, rel=5e-3, abs=1e-6), label
        compared += np.count_nonzero(values)
    assert compared > 2000
