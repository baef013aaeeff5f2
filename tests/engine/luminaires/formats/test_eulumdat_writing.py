"""EULUMDAT as it is written."""

from dataclasses import replace

import numpy as np
import pytest
from eulumdat_files import DIRECTIONS, NAMES

from lumenray.engine.errors import LumenrayError
from lumenray.engine.luminaires.coordinates import FRAMES, directions
from lumenray.engine.luminaires.distribution import flux, intensity, mirrored, turned
from lumenray.engine.luminaires.formats.eulumdat.reader import parse_eulumdat
from lumenray.engine.luminaires.formats.eulumdat.writer import write_eulumdat
from lumenray.engine.luminaires.formats.record import LampSet, LuminaireFile, TiltTable
from lumenray.engine.scene.distribution import IntensityDistribution, Opening


def random_file(seed):
    """A luminaire with a random grid and symmetry, absolute or relative."""
    rng = np.random.default_rng(seed)
    symmetry = list(NAMES.values())[seed % 5]
    inner = np.sort(rng.choice(np.arange(5, 90, 2.5), rng.integers(1, 6), replace=False))
    quarter = np.concatenate([[0.0], inner, [90.0]])
    table = {}
    for azimuth in np.unique(
        np.concatenate([quarter, 180 - quarter, 180 + quarter, 360 - quarter])
    ):
        key = {
            "rotational": lambda _: 0.0,
            "quadrant": lambda c: round(min(c % 180, -c % 180), 6),
            "C0-C180": lambda c: round(min(c % 360, -c % 360), 6),
            "C90-C270": lambda c: round(min((c - 90) % 360, (90 - c) % 360), 6),
            "none": lambda c: round(c % 360, 6),
        }[symmetry](azimuth)
        table.setdefault(key, []).append(azimuth)
    polar = np.unique([0.0, *rng.choice(np.arange(1, 180, 0.5), 12, replace=False), 180.0])
    rows = {}
    peak = 10.0 ** rng.uniform(1, 6)
    for azimuths in table.values():
        row = peak * rng.random(len(polar)) ** 3
        row[[0, -1]] = 0.5 * peak
        rows.update(dict.fromkeys(azimuths, row))
    azimuth = np.array(sorted(rows))
    values = np.array([rows[a] for a in azimuth])
    if symmetry == "rotational":
        azimuth, values = azimuth[:1], values[:1]
    distribution = IntensityDistribution(np.deg2rad(azimuth), np.deg2rad(polar), values)
    absolute = bool(rng.integers(2))
    total = flux(distribution)
    return LuminaireFile(
        "made",
        "C",
        symmetry,
        distribution,
        Opening("rectangle", (0.1, 1.5, 0.0), "z"),
        azimuth,
        polar,
        absolute,
        stated_flux=None if absolute else total * rng.uniform(0.3, 3.0),
        watts=30.0,
        lamps=(LampSet(2, None, 30.0, 3000.0, "LED", "", "90"),),
        housing=(0.12, 1.6, 0.05),
        metadata={"MANUFAC": "Öst", "LUMINAIRE": "One\ntwo", "LUMCAT": "x" * 90},
    )


@pytest.mark.parametrize("seed", range(20))
def test_what_is_written_is_read_back(seed):
    file = random_file(seed)
    data, remarks = write_eulumdat(file)
    back = parse_eulumdat(data, "back.ldt")
    before, after = (intensity(f.distribution, DIRECTIONS) for f in (file, back))
    assert np.abs(after - before).max() < 1e-4 * before.max()
    assert back.symmetry == file.symmetry
    assert not back.remarks
    assert (back.opening, back.housing) == (file.opening, file.housing)
    assert back.is_absolute == file.is_absolute
    total = flux(file.distribution)
    assert back.stated_flux == pytest.approx(file.stated_flux or total, rel=1e-5)
    assert back.light_output_ratio == pytest.approx(total / (file.stated_flux or total), abs=1e-4)
    down = flux(file.distribution, 0.0, np.pi / 2) / total
    assert back.downward_fraction == pytest.approx(down, abs=1e-4)
    assert back.lamps[0].colour_temperature == 3000.0
    assert back.metadata["LUMINAIRE"] == "One two"
    assert [r.text for r in remarks] == [f"the text '{'x' * 20}...' is cut to 78 characters"]
    assert back.metadata["LUMCAT"] == "x" * 78


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(
    "change", [lambda d: turned(d, 0.7), mirrored, lambda d: turned(mirrored(d), -2.0)]
)
def test_a_turned_or_mirrored_luminaire_is_written_as_it_shines(seed, change):
    file = random_file(seed)
    file = replace(file, distribution=change(file.distribution))
    back = parse_eulumdat(write_eulumdat(file)[0], "back.ldt")
    before, after = (intensity(f.distribution, DIRECTIONS) for f in (file, back))
    assert np.abs(after - before).max() < 1e-4 * before.max()


@pytest.mark.parametrize("kind", ["A", "B"])
def test_other_coordinate_systems_are_brought_onto_c_planes_and_it_is_said(kind):
    azimuth = np.deg2rad(np.arange(-90.0, 91.0, 5.0))
    polar = np.deg2rad(np.arange(0.0, 181.0, 5.0))
    beam = directions(azimuth[:, None], polar, FRAMES[kind])
    values = 1000.0 * np.maximum(-beam[..., 2], 0.0) ** 2
    distribution = IntensityDistribution(azimuth, polar, values, FRAMES[kind])
    data, remarks = write_eulumdat(
        replace(random_file(0), distribution=distribution, photometric_type=kind)
    )
    back = parse_eulumdat(data, "back.ldt").distribution
    before, after = intensity(distribution, DIRECTIONS), intensity(back, DIRECTIONS)
    assert np.abs(after - before).max() < 0.006 * before.max()
    assert flux(back) == pytest.approx(flux(distribution), rel=2e-3)
    assert "brought onto C-planes every 5 and polar angles every 5 degrees" in remarks[0].text


def test_a_luminaire_without_light_is_not_written():
    file = random_file(0)
    dark = replace(file.distribution, intensity=0.0 * file.distribution.intensity)
    with pytest.raises(LumenrayError, match="emits nothing"):
        write_eulumdat(replace(file, distribution=dark))


@pytest.mark.parametrize(
    ("opening", "written"),
    [
        (Opening("ellipse", (0.3, 0.3, 0.0)), Opening("ellipse", (0.3, 0.3, 0.0))),
        (Opening("ellipsoid", (0.3, 0.3, 0.3)), Opening("cylinder", (0.3, 0.3, 0.3))),
        (Opening("cylinder", (1.2, 0.1, 0.1), "x"), Opening("box", (1.2, 0.1, 0.1))),
        (Opening("rectangle", (0.0, 0.4, 0.2), "x"), Opening("box", (0.001, 0.4, 0.2))),
        (Opening(), Opening()),
    ],
)
def test_openings_that_the_format_lacks_are_written_as_their_likes(opening, written):
    data, remarks = write_eulumdat(replace(random_file(0), opening=opening, metadata={}))
    assert parse_eulumdat(data, "back.ldt").opening == written
    assert bool(remarks) == (opening != written)


def test_what_has_no_place_in_the_format_is_named():
    tilt = TiltTable(3, np.array([0.0, 90.0]), np.array([1.0, 0.9]))
    spectrum = (np.array([400.0, 700.0]), np.array([1.0, 1.0]))
    file = replace(random_file(0), tilt=tilt, spectrum=spectrum, metadata={"MANUFAC": "日本"})
    texts = " ".join(r.text for r in write_eulumdat(file)[1])
    assert all(word in texts for word in ("tilt", "spectrum", "Latin-1"))
