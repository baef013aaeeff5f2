"""The report, written of runs made by hand."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from lumenray.engine.scene.light import CieSky, Output, Quantity, SunLight
from lumenray.engine.scene.material import Diffuse, Glossy, ThinGlass
from lumenray.engine.scene.spectrum import Constant
from lumenray.validation.bench import Finding, Setup
from lumenray.validation.cases import Case
from lumenray.validation.cells import cut_percent, tell_number
from lumenray.validation.charts import draw_errors, family_of
from lumenray.validation.determinism import SeedCheck
from lumenray.validation.drawing import SIZE, draw_setup
from lumenray.validation.published import load_published
from lumenray.validation.reference import load_groups
from lumenray.validation.report import write_report
from lumenray.validation.runner import Answer, Run
from lumenray.validation.stage import BLACK, box, candela, glowing, material, matt, quad, sphere
from lumenray.validation.texts import TEXTS
from lumenray.validation.verdict import judge

CASES = {
    "C05": ("Area", "direct"),
    "C09": ("Obstruction", "interreflection"),
    "C12": ("Roof", "daylight"),
    "C36": ("Glare", "glare"),
}

BROKEN, MISSING = "C05.near", "C36.ugr"

EMITTER = (
    glowing("emitter", 1000.0),
    BLACK,
    quad("emitter_plane", (1.5, 1.5, 3.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), "emitter"),
)


def answer(name, groups, factor=0.2, missing=()):
    made = Answer(name)
    noise = np.random.default_rng(7)
    for key, group in groups.items():
        if key in missing:
            made.missing[key] = f"{name} cannot be asked: it has no eyes"
            continue
        errors = factor * group.allowed
        values = group.values + errors * noise.uniform(-1.0, 1.0, errors.size)
        if name == "Lumenray" and key == BROKEN:
            values = 1.02 * group.values
        made.findings[key] = Finding(group, values, errors, seconds=1.5)
        made.verdicts[key] = judge(made.findings[key])
    made.seconds = 12.0
    return made


@pytest.fixture(scope="module")
def run():
    groups = {k: g for k, g in load_groups().items() if g.case in CASES}
    cases = {k: Case(k, *words, lambda bench: iter(())) for k, words in CASES.items()}
    cie = groups["C05.cie53"]
    return Run(
        cases=cases,
        groups=groups,
        engine=answer("Lumenray", groups, missing=(MISSING,)),
        peers={"Radiance": answer("Radiance", groups, 0.8, missing=(MISSING, "C12.1x1.sky3"))},
        setups={"C05": Setup(EMITTER, cie.positions, cie.normals, cie.labels)},
        determinism=(
            SeedCheck("C05.cie53", True, 1.1, 56),
            SeedCheck("C12.1x1.sky1", False, 2.4, 56),
        ),
        machine={
            "cpu": "Abacus",
            "cores": 1,
            "memory_gib": 0.1,
            "system": "Wood",
            "python": "3.11",
            "mitsuba": "3.9",
            "lumenray": "0.1.0",
        },
        version="0.1.0",
        seed=3,
        error=None,
        is_quick=False,
        seconds=75.0,
    )


@pytest.fixture(scope="module")
def written(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    return folder, write_report(run, folder)


def page(written, name):
    return (written[0] / name).read_text(encoding="utf-8")


def test_everything_told_is_written(written):
    folder, paths = written
    assert sorted(paths) == sorted(p for p in folder.rglob("*") if p.is_file())
    assert {f"{case}.md" for case in CASES} < {path.name for path in paths}
    assert len(set(paths)) == len(paths)


def test_links_lead_to_files(written):
    folder, paths = written
    for path in paths:
        if path.suffix != ".md":
            continue
        text = path.read_text(encoding="utf-8")
        for target in re.findall(r"\]\(([^)#]+)\)|(?:href|src)=\"([^\"]+)\"", text):
            link = target[0] or target[1]
            assert (folder / link).exists(), f"{path.name}: {link}"


def test_a_failing_group_is_marked_in_summary_and_page(run, written):
    summary = page(written, "README.md")
    assert f"**2 of {len(run.groups)} groups FAIL**" in summary
    assert BROKEN in summary
    assert MISSING in summary
    assert "**1 FAIL**" in summary
    section = page(written, "C05.md").partition(f"## `{BROKEN}`")[2].partition("## `")[0]
    assert "**FAIL.**" in section
    assert section.count("**OUTSIDE**") == len(run.groups[BROKEN].labels)
    assert run.engine.verdicts[BROKEN].faults[0] in section
    assert "No values: Lumenray cannot be asked: it has no eyes." in page(written, "C36.md")


def test_a_passing_case_says_so(written):
    assert "All 32 scored groups pass." in page(written, "C12.md")
    assert "FAIL" not in page(written, "C12.md")
    assert "**The group passes.**" in page(written, "C09.md")


def test_a_run_without_failures_says_that_all_pass(run, tmp_path):
    groups = {k: g for k, g in run.groups.items() if g.case == "C09"}
    good = replace(
        run,
        cases={"C09": run.cases["C09"]},
        groups=groups,
        engine=answer("Lumenray", groups),
        peers={},
        setups={},
        determinism=(),
    )
    write_report(good, tmp_path)
    summary = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert "**Every scored group passes.**" in summary
    assert "FAIL" not in summary
    assert "`lumenray validate --family C09 --seed 3`" in summary
    assert "does not replace the whole" in summary


def test_every_value_is_on_its_page(run, written):
    for key, found in run.engine.findings.items():
        text = page(written, f"{found.group.case}.md")
        section = text.partition(f"## `{family_of(key)}`")[2].partition("\n## ")[0]
        digits = 5 if family_of(key) == key else 4
        cells = [cell.strip(" *") for cell in section.split("|")]
        for value, reference in zip(found.values, found.group.values, strict=True):
            assert tell_number(value, digits) in cells, key
            assert tell_number(reference, digits) in cells, key


def test_every_value_is_in_the_outcome(run, written):
    outcome = json.loads(page(written, "validation.json"))
    detail = {entry["id"]: entry for entry in outcome["detail"]}
    assert set(detail) == set(run.groups)
    for key, found in run.engine.findings.items():
        values = [row[2] for row in detail[key]["points"]]
        np.testing.assert_allclose(values, found.values, rtol=1e-8)


def test_peers_stand_beside_ours_with_what_they_cannot_state(written):
    summary = page(written, "README.md")
    assert "What Radiance could not be asked for:" in summary
    assert "it has no eyes" in summary
    assert "| verdict | CIE printed | Radiance |" in page(written, "C05.md")


def test_seeds_are_told(written):
    summary = page(written, "README.md")
    assert "1 of 2 groups pass" in summary
    assert "| `C12.1x1.sky1` | **NO** | 2.40 | 56 | **FAIL** |" in summary


def test_published_figures_are_told(written):
    summary = page(written, "README.md")
    assert "| reference system, 227 values of the CIE list | 52.00 % | 72.00 % |" in summary
    for result in load_published().results:
        assert result.program in summary


def test_numbers_are_cut_not_rounded_up_to_all():
    assert cut_percent(1.0) == "100.00 %"
    assert cut_percent(0.99999) == "99.99 %"
    assert cut_percent(0.57) == "57.00 %"


def test_every_case_has_words():
    assert list(TEXTS) == list(dict.fromkeys(group.case for group in load_groups().values()))
    assert all(text.about.endswith(".") and text.basis.endswith(".") for text in TEXTS.values())


def test_skies_belong_together():
    assert family_of("C12.1x1.sky13") == "C12.1x1.sky*"
    assert family_of("C11.lum4") == "C11.lum*"
    assert family_of("C05.scale1000") == "C05.scale1000"


def test_sensors_and_glowing_surfaces_are_drawn():
    cie = load_groups()["C05.cie53"]
    picture = np.asarray(draw_setup(Setup(EMITTER, cie.positions, cie.normals, cie.labels)), int)
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    red, green, blue = np.moveaxis(picture, -1, 0)
    assert ((red > 180) & (green < 80) & (blue < 80)).sum() > 100
    assert ((red > 220) & (green > 180) & (blue < 120)).sum() > 500
    assert (picture[[0, -1]] == 255).all()


@pytest.mark.parametrize(
    "items",
    [
        (),
        (candela("far", (1e5, -2e5, 3e4), 1000.0),),
        (
            BLACK,
            box("room", (0, 0, 0), (4, 4, 3), "black", inwards=True),
            CieSky(12, (0, 1, 2), 1.0),
        ),
        (matt("ball", 0.5), sphere("ball", (0, 0, 1), 2.0, "ball")),
        (
            matt("ground", 0.3),
            quad("ground", (-500, -500, 0), (1000, 0, 0), (0, 1000, 0), "ground"),
            material("mirror", Glossy(Constant(0.9), 0.0)),
            quad("mirror", (0, -3, 0), (0, 6, 0), (0, 0, 2), "mirror"),
            material("pane", ThinGlass()),
            quad("pane", (1, 0, 0), (0, 1, 0), (0, 0, 1), "pane"),
            SunLight(
                "sun", "sun", Output(Quantity.ILLUMINANCE, 1e5), np.array((0.0, 0.0, -1.0)), 0.01
            ),
        ),
        (material("paint", Diffuse(Constant(0.2))), box("thing", (0, 0, 0), (1, 1, 1), "paint")),
    ],
)
@pytest.mark.parametrize("sensors", [0, 1, 40])
def test_any_set_up_can_be_drawn(items, sensors):
    places = np.stack([np.arange(sensors) * 0.1] * 2 + [np.zeros(sensors)], axis=-1)
    places[5:7] = np.nan
    normals = np.tile((0.0, 0.0, 1.0), (sensors, 1))
    labels = tuple(f"point {i}" for i in range(sensors))
    picture = draw_setup(Setup(items, places, normals, labels), (320, 210))
    assert picture.size == (320, 210)


def test_errors_that_are_no_numbers_are_drawn():
    group = load_groups()["C09.form"]
    values = group.values * np.where(np.arange(group.values.size) == 2, np.nan, 40.0)
    finding = Finding(group, values, np.zeros_like(values))
    assert draw_errors([(finding, judge(finding))]).size[0] == 900
