"""IES LM-63 under damage, and random luminaires there and back."""

import os
import time

import numpy as np
import pytest
from mutations import mutate

from lumenray.engine.errors import FileFormatError
from lumenray.engine.luminaires.coordinates import FRAMES
from lumenray.engine.luminaires.distribution import flux, intensity, mirrored, turned
from lumenray.engine.luminaires.formats.lm63.reader import parse_lm63
from lumenray.engine.luminaires.formats.lm63.writer import write_lm63
from lumenray.engine.luminaires.formats.record import LampSet, LuminaireFile, TiltTable
from lumenray.engine.luminaires.formats.symmetry import expand_planes
from lumenray.engine.scene.distribution import SHAPES, IntensityDistribution, Opening

CHUNKS = 16
MUTATIONS = (8000 if os.environ.get("LUMENRAY_ALL_SEEDS") else 1600) // CHUNKS
"""Damaged files in each of the chunks; set LUMENRAY_ALL_SEEDS for the full number."""

LUMINAIRES = 300 if os.environ.get("LUMENRAY_ALL_SEEDS") else 40
"""Random luminaires that go there and back."""

TEXTS = [
    """IESNA:LM-63-2002
[TEST] 12
[TESTLAB] Hand made
[ISSUEDATE] 2024-01-01
[MANUFAC] Example
[LUMINAIRE] Downlight
[MORE] of two lines
TILT=NONE
2 1000 1.0 5 3 1 2 0.30 1.20 0
0.9 1 40
0 22.5 45 67.5 90
0 45 90
300 280 220 120 0
300 270 200 100 0
300 260 180 80 0
""",
    """IESNA91
[TEST] 3
TILT=INCLUDE
1
3
0 45 90
1.0 0.95 0.90
1 2000 1 3 1 1 1 -0.5 0 0
1 0.97 250
0 45 90
0
400 300 0
""",
    """LABEL OF 1986
TILT=NONE
1
2200
2.2
4
5
1
2
-.1
0
0
1
1
100
0,30,60,90
0,90,180,270,360
681.8,557.1,.5,0
681.8,400,.25,0
681.8,300,.125,0
681.8,400,.25,0
681.8,557.1,.5,0
END
""",
    """IES:LM-63-2019
[TEST] 4
[TESTLAB] x
[ISSUEDATE] y
[MANUFAC] z
TILT=NONE
1 -1 1.5 3 5 2 2 -0.4 0.2 -0.1
1 1.11000 90
-90 0 90
-90 -45 0 45 90
1 2 1
10 20 10
5 50 5
1 1 1
0 0 0
""",
    """IESNA:LM-63-1995
TILT=tilt.tlt
1 1000,0 1,0 3 3 3 2 0,1 0,1 0
1,0 1,0 12,5
-90 0 90
0 45 90
10,5 20,5 10,5
5,5 10,5 5,5
0,0 1,5 0,0
""",
]
"""Files of every edition and type; the last is written with decimal commas."""


def random_angles(rng, low, high, most):
    inner = rng.uniform(low + 0.01, high - 0.01, rng.integers(0, most))
    return np.unique(np.round([low, *inner, high], 2))


def random_distribution(rng, kind):
    if kind == "C":
        symmetry = ("rotational", "quadrant", "C0-C180", "C90-C270", "none")[rng.integers(5)]
        low, high = {
            "rotational": (0, 0),
            "quadrant": (0, 90),
            "C0-C180": (0, 180),
            "C90-C270": (90, 270),
            "none": (0, 360),
        }[symmetry]
        planes = random_angles(rng, low, high, 20) if high else np.zeros(1)
        low, high = ((0, 90), (0, 180), (90, 180))[rng.integers(3)]
        polar = random_angles(rng, low, high, 40)
        values = random_values(rng, len(planes), len(polar))
        azimuth, values = expand_planes(planes, values, symmetry)
    else:
        symmetry = "none"
        azimuth = random_angles(rng, -90, 90, 20)
        polar = random_angles(rng, 0, 180, 20)
        values = random_values(rng, len(azimuth), len(polar))
    if polar[0] == 0:
        values[:, 0] = values[0, 0]
    if polar[-1] == 180:
        values[:, -1] = values[0, -1]
    made = IntensityDistribution(np.radians(azimuth), np.radians(polar), values, FRAMES[kind])
    return symmetry, made


def random_values(rng, *shape):
    values = rng.uniform(0, 1, shape) * 10.0 ** rng.uniform(-3, 6)
    values[rng.uniform(size=shape) < 0.2] = 0.0
    values[0, 0] = values.max() or 1.0
    return values


def random_opening(rng):
    shape = SHAPES[rng.integers(len(SHAPES))]
    size = np.round(rng.uniform(0.01, 3.0, 3), 4)
    axis = "z"
    if shape in {"rectangle", "ellipse", "cylinder"}:
        axis = "xyz"[rng.integers(3)]
    if shape in {"rectangle", "ellipse"}:
        size["xyz".index(axis)] = 0.0
    if shape == "point":
        size[:] = 0.0
    return Opening(shape, tuple(map(float, size)), axis)


def random_file(rng) -> LuminaireFile:
    kind = "CCAB"[rng.integers(4)]
    symmetry, distribution = random_distribution(rng, kind)
    count = int(rng.integers(1, 200))
    lumens = float(np.round(rng.uniform(1, 1e5), 3)) if rng.integers(2) else None
    tilt = None
    if rng.integers(2):
        angles = random_angles(rng, 0, 90, 5)
        tilt = TiltTable(
            int(rng.integers(1, 4)), angles, np.round(rng.uniform(0, 2, len(angles)), 3)
        )
    keys = ["TEST", "TESTLAB", "ISSUEDATE", "MANUFAC", "LUMCAT", "_MINE", "OTHER"]
    letters = [*"abc 0189.,;:-[]()="]
    metadata = {
        key: "\n".join(
            " ".join("".join(rng.choice(letters, rng.integers(0, 90))).split())
            for _ in range(rng.integers(1, 4))
        )
        for key in rng.permutation(keys)
    }
    return LuminaireFile(
        format="LM-63-2002",
        photometric_type=kind,
        symmetry=symmetry,
        distribution=distribution,
        opening=random_opening(rng),
        stored_azimuths=np.degrees(distribution.azimuth),
        stored_polars=np.degrees(distribution.polar),
        is_absolute=lumens is None,
        stated_flux=lumens,
        watts=float(np.round(rng.uniform(1, 500), 2)),
        lamps=(LampSet(count, lumens),),
        tilt=tilt,
        metadata=metadata,
    )


def assert_sane(file):
    """Whatever was read must be usable: finite, not negative, and no brighter than its peak."""
    distribution = file.distribution
    values, total = distribution.intensity, flux(distribution)
    assert np.isfinite(values).all()
    assert values.min() >= 0.0
    assert 0.0 <= total <= 4.0 * np.pi * values.max() * (1.0 + 1e-9)
    assert (np.diff(distribution.azimuth) > 0.0).all()
    assert (np.diff(distribution.polar) > 0.0).all()
    assert distribution.polar[0] >= 0.0
    assert distribution.polar[-1] <= np.pi + 1e-12
    assert distribution.azimuth[-1] - distribution.azimuth[0] <= 2.0 * np.pi + 1e-9
    directions = np.random.default_rng(0).normal(size=(20, 3))
    found = intensity(distribution, directions)
    assert ((found >= 0.0) & (found <= values.max() * (1.0 + 1e-9))).all()
    assert np.isfinite(file.opening.size).all()
    assert min(file.opening.size) >= 0.0
    assert file.stated_flux is None or np.isfinite(file.stated_flux)


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_damaged_files_are_refused_or_read_sanely(chunk, tmp_path):
    rng = np.random.default_rng([63, chunk])
    seeds = [text.encode() for text in TEXTS]
    seeds += [write_lm63(random_file(rng)) for _ in range(4)]
    (tmp_path / "tilt.tlt").write_text("1\n2\n0 90\n1 0.5\n")
    for n in range(MUTATIONS):
        data = mutate(seeds[n % len(seeds)], rng)
        start = time.perf_counter()
        try:
            file = parse_lm63(data, "damaged.ies", tmp_path)
        except FileFormatError as error:
            assert "damaged.ies" in str(error), data
            assert "\n" not in str(error), data
        else:
            assert_sane(file)
            assert_sane(parse_lm63(write_lm63(file), "written again"))
        assert time.perf_counter() - start < 1.0, data


@pytest.mark.parametrize("seed", range(LUMINAIRES))
def test_random_luminaires_come_back_as_they_were(seed):
    rng = np.random.default_rng([64, seed])
    file = random_file(rng)
    data = write_lm63(file)
    assert max(map(len, data.split(b"\r\n"))) <= 132
    found = parse_lm63(data, "written.ies")
    directions = rng.normal(size=(3000, 3))
    expected = intensity(file.distribution, directions)
    peak = file.distribution.intensity.max()
    assert intensity(found.distribution, directions) == pytest.approx(
        expected, rel=1e-6, abs=1e-6 * peak
    )
    assert flux(found.distribution) == pytest.approx(flux(file.distribution), rel=1e-6)
    for name in ("photometric_type", "opening", "is_absolute", "watts", "metadata"):
        assert getattr(found, name) == getattr(file, name), name
    assert found.stated_flux == pytest.approx(file.stated_flux)
    assert found.lamps[0].count == file.lamps[0].count
    if file.tilt:
        assert found.tilt.geometry == file.tilt.geometry
        assert np.array_equal(found.tilt.angles, file.tilt.angles)
        assert np.array_equal(found.tilt.factors, file.tilt.factors)
    # What has been read once is written the same ever after.
    assert write_lm63(found) == data


@pytest.mark.parametrize("seed", range(LUMINAIRES // 2))
def test_random_turned_luminaires_shine_as_before(seed):
    rng = np.random.default_rng([65, seed])
    _, distribution = random_distribution(rng, "C")
    distribution = turned(distribution, rng.uniform(-7, 7))
    distribution = mirrored(distribution) if rng.integers(2) else distribution
    file = parse_lm63(TEXTS[0].encode(), "sample.ies")
    file = LuminaireFile(**{**vars(file), "distribution": distribution})
    found = parse_lm63(write_lm63(file), "written.ies").distribution
    directions = rng.normal(size=(3000, 3))
    expected = intensity(distribution, directions)
    # Planes are written to nine digits, which moves steep flanks by as much.
    assert intensity(found, directions) == pytest.approx(expected, abs=1e-5 * expected.max())


@pytest.mark.parametrize("seed", range(LUMINAIRES))
def test_numbers_may_be_laid_out_at_will(seed):
    """The same numbers, wrapped anywhere and separated by blanks, tabs or commas, give the same light."""
    rng = np.random.default_rng([66, seed])
    head, _, body = write_lm63(random_file(rng)).decode().partition("TILT=")
    tilt, _, body = body.partition("\r\n")
    ends = ["\r\n", "\n", "\r"][rng.integers(3)]
    gaps = [" ", "  ", "\t", ",", ", ", " ,", ends, " " + ends + " ", ends + ends]
    numbers = body.split()
    text = "".join(number + gaps[rng.integers(len(gaps))] for number in numbers)
    plain = parse_lm63(f"{head}TILT={tilt}\n{body}".encode(), "plain.ies")
    found = parse_lm63(f"{head}TILT={tilt}{ends}{text}".encode(), "laid out.ies")
    assert np.array_equal(found.distribution.intensity, plain.distribution.intensity)
    assert np.array_equal(found.distribution.azimuth, plain.distribution.azimuth)
    assert found.opening == plain.opening
