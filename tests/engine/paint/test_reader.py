"""Compositions of paints: what their files mean, and what is refused."""

import copy
import json
import math

import numpy as np
import pytest

from lumenray.engine.errors import FileFormatError
from lumenray.engine.paint.composition import Diameters, face_densities, volume_fractions
from lumenray.engine.paint.reader import known_constituents, parse_paint, read_paint, settle_names
from lumenray.libraries import paints

PLAIN = {
    "lumenray_paint": 1,
    "name": "Plain",
    "layers": [
        {
            "thickness_um": 20,
            "binder": {"index": 1.45},
            "flakes": [
                {
                    "mirror": {"reflectance": 0.9},
                    "amount": {"area_per_volume_per_um": 0.1},
                    "tilt_deg": 3,
                }
            ],
        }
    ],
    "substrate": {"reflectance": 0.2},
}


def changed(**changes) -> dict:
    """The plain paint with other values at places such as ``layers__0__thickness_um``."""
    content = copy.deepcopy(PLAIN)
    for place, value in changes.items():
        *way, last = place.split("__")
        target = content
        for step in way:
            target = target[int(step) if step.isdigit() else step]
        target[last] = value
    return content


def flake(**own) -> dict:
    return {"mirror": {"reflectance": 0.9}, "density_g_per_cm3": 2.7} | own


@pytest.mark.parametrize("name", paints.presets())
def test_presets_are_paints(name):
    paint = read_paint(paints.presets()[name])
    assert paint.name
    assert all(np.isfinite(layer.binder.index.at([400.0, 700.0])).all() for layer in paint.layers)


def test_amounts_of_the_samples():
    """Concentrations of the dissertation's samples (A7)."""
    one = {
        "stack": {
            "core": {"index": 1.5, "thickness_nm": 448},
            "coatings": [{"index": 2.7, "thickness_nm": 12}],
        }
    }
    one |= {"amount": {"binder_mass_ratio": 0.24}, "density_g_per_cm3": 2.7}
    two = {
        "stack": {
            "core": {"index": 1.77, "thickness_nm": 230},
            "coatings": [{"index": 2.7, "thickness_nm": 165}],
        }
    }
    two |= {"amount": {"mass_fraction": 0.073}, "density_g_per_cm3": 3.7}
    for own, share, area in (
        (one, 0.08163265306122448, 0.17295053614666203),
        (two, 0.0208398755317023, 0.03721406344946839),
    ):
        layer = parse_paint(changed(layers__0__flakes=[own])).layers[0]
        assert volume_fractions(layer)[0] == pytest.approx(share, rel=1e-12)
        assert face_densities(layer)[0] == pytest.approx(area, rel=1e-12)


def test_amounts_agree():
    """The same layer, its amounts stated as ratios, as fractions of mass and as those of volume."""
    ratios = [
        flake(amount={"binder_mass_ratio": 0.2}),
        flake(amount={"binder_mass_ratio": 0.1}, density_g_per_cm3=4),
    ]
    masses = [
        flake(amount={"mass_fraction": 0.2 / 1.3}),
        flake(amount={"mass_fraction": 0.1 / 1.3}, density_g_per_cm3=4),
    ]
    mixed = [ratios[0], masses[1]]
    want = np.array([0.2 / 2.7, 0.1 / 4.0]) / (0.2 / 2.7 + 0.1 / 4.0 + 1.0)
    volumes = [flake(amount={"volume_fraction": share}) for share in want]
    for flakes in (ratios, masses, mixed, volumes):
        layer = parse_paint(changed(layers__0__flakes=flakes)).layers[0]
        assert volume_fractions(layer) == pytest.approx(list(want), rel=1e-12)


def test_tilts_and_diameters():
    for measure, times in (
        ("slope_per_axis", 1.0),
        ("mean", math.sqrt(math.pi / 2)),
        ("rms", math.sqrt(2)),
    ):
        own = flake(amount={"volume_fraction": 0.1}, tilt_deg=3 * times, tilt_measure=measure)
        made = parse_paint(changed(layers__0__flakes=[own])).layers[0].flakes[0]
        assert made.slope == pytest.approx(math.radians(3.0), rel=1e-12)
    sizes = Diameters.of_mass(7.9, 17.8, 35.8)
    assert sizes.log_spread == pytest.approx(0.5895529816878534, rel=1e-7)  # A13.size
    assert sizes.median_um == pytest.approx(8.882233279858587, rel=1e-7)
    assert sizes.face_um2 == pytest.approx(124.17439674666159, rel=1e-7)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"layers__0__thickness_um": -1}, ("layers[0].thickness_um is -1", "0.1 to 10000")),
        ({"layers__0__thickness_um": "20"}, ("layers[0].thickness_um is '20'", "a number")),
        ({"layers__0__thickness_um": math.nan}, ("layers[0].thickness_um is nan", "a number")),
        ({"layers__0__flakes__0__tilt_deg": 0.1}, ("flakes[0].tilt_deg is 0.1", "0.5 to 40")),
        ({"layers__0__flakes__0__tilt": 3}, ("flakes[0] has 'tilt'", "tilt_deg")),
        ({"layers__0__flakes__0__amount": {}}, ("amount has none of them", "'mass_fraction'")),
        ({"layers__0__flakes__0__amount": {"mass_fraction": 0.1, "volume_fraction": 0.1}}, ("'mass_fraction' and 'volume",)),
        ({"layers__0__flakes__0__stack": {"core": {"index": 1.5, "thickness_nm": 9}}}, ("needs one of mirror and stack",)),
        ({"layers__0__flakes__0__amount": {"area_per_volume_per_um": 10}}, ("leave no binder",)),
        ({"layers__0__flakes": [PLAIN["layers"][0]["flakes"][0]] * 9}, ("has 9 entries", "0 to 8")),
        ({"layers": []}, ("layers has 0 entries", "1 to 8")),
        ({"layers__0__binder": "treacle"}, ("layers[0].binder names 'treacle'", "binders of the library")),
        ({"layers__0__binder": {"index": "treacle"}}, ("names 'treacle'", "indices of the library", "aluminium")),
        ({"substrate": {"reflectance": 1.5}}, ("substrate.reflectance is 1.5", "1 at most")),
        ({"substrate": {"reflectance": {"wavelengths_nm": [400, 400], "values": [0, 1]}}}, ("do not ascend",)),
        ({"substrate": {"reflectance": {"wavelengths_nm": [400, 500], "values": [0, 1, 2]}}}, ("3 entries, expected 2",)),
        ({"lumenray_paint": 2}, ("lumenray_paint is 2", "expected 1")),
    ],
)  # fmt: skip
def test_faults_are_one_sentence(changes, words):
    with pytest.raises(FileFormatError) as caught:
        parse_paint(changed(**changes), path="my.json")
    text = str(caught.value)
    assert text.startswith("my.json: ") and "\n" not in text
    assert all(word in text for word in words), text


def test_users_constituents_go_before(tmp_path):
    own = {
        "lumenray_constituents": 1,
        "binders": {"treacle": {"index": 1.6, "density_g_per_cm3": 1.4}},
        "flakes": {
            "tin": {"mirror": {"reflectance": 0.7}, "density_g_per_cm3": 7.3, "tilt_deg": 12}
        },
    }
    file = tmp_path / "mine.json"
    file.write_text(json.dumps(own))
    content = changed(
        layers__0__binder="treacle",
        layers__0__flakes=[{"constituent": "tin", "amount": {"mass_fraction": 0.2}, "tilt_deg": 6}],
    )
    layer = parse_paint(content, known_constituents([file])).layers[0]
    assert layer.binder.density == 1.4
    flakes = layer.flakes[0]
    assert (flakes.name, flakes.density) == ("tin", 7.3)
    assert flakes.slope == pytest.approx(math.radians(6.0))
    with pytest.raises(FileFormatError, match="'tin', which is not among the flakes"):
        parse_paint(
            changed(layers__0__flakes=[{"constituent": "tin", "amount": {"mass_fraction": 0.2}}])
        )


def test_names_of_users_are_written_out_where_they_do_not_ship(tmp_path):
    own = {
        "lumenray_constituents": 1,
        "indices": {"glass": {"index": 1.52}, "pane": {"index": "glass"}},
        "binders": {"treacle": {"index": "pane"}},
        "flakes": {"sheet": {"stack": {"core": {"index": "pane", "thickness_nm": 300}}}},
    }
    file = tmp_path / "mine.json"
    file.write_text(json.dumps(own))
    content = changed(
        layers__0__binder="treacle",
        layers__0__flakes=[{"constituent": "sheet", "amount": {"mass_fraction": 0.2}}],
    )
    constituents = known_constituents([file])
    paint = parse_paint(content, constituents)
    alone = parse_paint(settle_names(paint.content, constituents)).layers[0]
    assert alone.binder.index.at([550.0]) == pytest.approx([1.52])
    assert alone.flakes[0].name == "sheet"
    assert alone.flakes[0].optics.core.index.at([550.0]) == pytest.approx([1.52])
    own["indices"]["glass"] = {"index": "pane"}
    file.write_text(json.dumps(own))
    with pytest.raises(FileFormatError, match=r"'(glass|pane)', which names itself"):
        parse_paint(content, known_constituents([file]))


def test_wide_files_are_refused(tmp_path):
    file = tmp_path / "paint.json"
    file.write_text('{"a":' * 100000)
    with pytest.raises(FileFormatError, match="cannot be read"):
        read_paint(file)
    file.write_text("[1]")
    with pytest.raises(FileFormatError, match="expected an object"):
        read_paint(file)
