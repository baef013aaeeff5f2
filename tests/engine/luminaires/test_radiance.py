"""Direct illuminance from photometric files against Radiance, an independent program, where it is installed."""

import numpy as np
import pytest

from lumenray.benchmarks.common import radiance
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.luminaires.distribution import flux
from lumenray.engine.luminaires.formats.reader import read_luminaire
from lumenray.engine.scene.light import Luminaire, Output, Quantity
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.session import Session

pytestmark = [
    pytest.mark.mitsuba,
    pytest.mark.validation,
    pytest.mark.skipif(
        not radiance.is_installed(), reason="pyradiance is not installed (run 'make setup')"
    ),
]

ROTATIONAL = """IESNA:LM-63-2002
[TEST] made for this test
[TESTLAB] none
[ISSUEDATE] 2025-01-01
[MANUFAC] none
TILT=NONE
1 -1 1 10 1 1 2 0 0 0
1 1 0
0 5 10 20 30 40 50 60 75 90
0
2000 1900 1700 1200 700 400 250 150 40 0
"""
"""Uneven angles, the same all around."""

STREET = """IESNA91
[TEST] made for this test
[TESTLAB] none
[MANUFAC] none
TILT=NONE
1 5000 2.5 7 5 1 1 0 0 0
0.9 1 0
0 15 30 45 60 75 90
0 45 90 135 180
120 180 260 340 300 90 0
120 170 230 290 240 60 0
120 150 180 200 150 40 0
120 130 140 120 80 20 0
120 110 90 60 30 10 0
"""
"""Half a turn, with a multiplier, a ballast factor and sizes in feet."""

UPLIGHT = """IESNA:LM-63-1995
[TEST] made for this test
TILT=NONE
1 1000 1 9 9 1 2 0 0 0
1 1 0
0 22.5 45 67.5 90 112.5 135 157.5 180
0 30 80 120 170 210 280 330 360
60 70 80 60 40 90 150 130 110
60 50 90 70 50 80 140 120 110
60 80 60 90 70 70 160 150 110
60 90 70 50 60 60 120 140 110
60 60 80 80 30 95 130 110 110
60 55 75 85 45 85 170 125 110
60 65 95 65 55 75 155 135 110
60 75 85 75 65 65 145 115 110
60 70 80 60 40 90 150 130 110
"""
"""All around, without any symmetry, in uneven planes, up and down."""

FLOOD = """IESNA:LM-63-2002
[TEST] made for this test
[TESTLAB] none
[ISSUEDATE] 2025-01-01
[MANUFAC] none
TILT=NONE
1 -1 1 5 5 2 2 0 0 0
1 1 0
-40 -20 0 20 40
-60 -30 0 30 60
0 200 400 150 0
0 600 900 500 0
0 800 2000 700 0
0 500 1100 400 0
0 100 300 50 0
"""
"""Type B, unlike on all sides."""

PLACE = np.array([0.4, -0.3, 3.0])


@pytest.fixture(scope="module")
def session():
    """Return one session for all files, so that kernels are made once."""
    return Session(witness=False)


def turned(about_x: float, about_z: float) -> np.ndarray:
    """Rotation about z, then about x. [degree]"""
    c, s = np.cos(np.deg2rad(about_z)), np.sin(np.deg2rad(about_z))
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    c, s = np.cos(np.deg2rad(about_x)), np.sin(np.deg2rad(about_x))
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]) @ turn


def illuminance(session, file, rotation, positions, normals):
    """Illuminance by our engine. [lx]"""
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = rotation, PLACE
    output = Output(Quantity.LUMINOUS_FLUX, flux(file.distribution))
    light = Luminaire("light:one", "one", output, frame, file.distribution)
    session.apply(SceneDelta(changed=(light,)))
    return session.measure(positions, normals, StopRule(samples=64), transport="mono").illuminance


def grid(side: float) -> tuple[np.ndarray, np.ndarray]:
    """20 points on the floor, 10 on a wall and 10 on the ceiling."""
    across = np.linspace(-side, side, 5)
    x, y = (values.ravel() for values in np.meshgrid(across, across[:4]))
    floor = np.stack([x, y, np.zeros(20)], axis=1)
    wall = np.stack([np.full(10, -3.0), x[:10], 0.3 + 0.5 * np.arange(10)], axis=1)
    ceiling = np.stack([x[10:], y[10:] - 0.7, np.full(10, 5.0)], axis=1)
    normals = np.repeat([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]], [20, 10, 10], axis=0)
    return np.concatenate([floor, wall, ceiling]), normals


@pytest.mark.parametrize(
    "text", [ROTATIONAL, STREET, UPLIGHT], ids=["rotational", "street", "uplight"]
)
def test_illuminance_is_that_of_radiance(session, tmp_path, text):
    path = tmp_path / "luminaire.ies"
    path.write_text(text, encoding="ascii")
    file, rotation = read_luminaire(path), turned(20.0, 35.0)
    positions, normals = grid(2.5)
    ours = illuminance(session, file, rotation, positions, normals)
    theirs = radiance.measure(path, rotation, PLACE, positions, normals).illuminance
    polar = np.rad2deg(
        np.arccos(
            -((positions - PLACE) @ rotation)[:, 2] / np.linalg.norm(positions - PLACE, axis=1)
        )
    )
    # Beyond the last angle of a table Radiance goes on for a while.
    inside = polar <= file.stored_polars[-1]
    bright = inside & (ours > 0.01 * ours.max())
    assert bright.sum() > 20
    assert np.abs(ours / np.where(bright, theirs, 1.0) - 1.0)[bright].max() < 0.005, (ours, theirs)


def test_type_b_is_that_of_radiance_in_the_two_planes_where_angles_agree(session, tmp_path):
    # Radiance takes both angles of type B from projections: they are those of LM-75 where one of them is 0.
    path = tmp_path / "flood.ies"
    path.write_text(FLOOD, encoding="ascii")
    file, rotation = read_luminaire(path), turned(0.0, 0.0)
    reach = 3.0 * np.tan(np.deg2rad(np.array([-35.0, -25.0, -10.0, 5.0, 15.0, 28.0, 38.0])))
    zero = np.zeros(7)
    offsets = np.concatenate(
        [np.stack([reach, zero, zero], axis=1), np.stack([zero, reach, zero], axis=1)]
    )
    positions = offsets + np.array([PLACE[0], PLACE[1], 0.0])
    normals = np.tile([0.0, 0.0, 1.0], (14, 1))
    ours = illuminance(session, file, rotation, positions, normals)
    # Its axes of type B: up is x, right is -y.
    axes = rotation @ turned(0.0, 90.0)
    theirs = radiance.measure(path, axes, PLACE, positions, normals).illuminance
    assert ours.min() > 0.0
    assert np.abs(ours / theirs - 1.0).max() < 0.005, (ours, theirs)
