"""Mutation check: faults fit the engine, are taken back, and are found; ``make mutations`` tries them all."""

import numpy as np
import pytest

from lumenray.engine.photometry import spectra, units
from lumenray.engine.scene.spectrum import Illuminant
from lumenray.validation.mutations import __main__ as command_line
from lumenray.validation.mutations import trials
from lumenray.validation.mutations.catalogue import MUTATIONS
from lumenray.validation.mutations.faults import Mutation, Replace, Rewrite, locate
from lumenray.validation.mutations.trials import BrokenOffError, Trial

BY_NAME = {mutation.name: mutation for mutation in MUTATIONS}

HARMLESS = Mutation(
    "harmless", "nothing", (Replace("photometry.units:BLENDER_EFFICACY", "1.0"),), ("C01.iso",)
)


def test_there_are_enough_faults_and_their_groups_are_quick():
    assert len(BY_NAME) == len(MUTATIONS) >= 12
    quick = trials.quick_groups()
    for mutation in MUTATIONS:
        assert mutation.likely and set(mutation.likely) <= set(quick), mutation.name


@pytest.mark.mitsuba
@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda mutation: mutation.name)
def test_a_fault_fits_the_engine_and_is_taken_back(mutation):
    before = [locate(change.target)[2] for change in mutation.changes]
    with mutation.injected():
        during = [locate(change.target)[2] for change in mutation.changes]
    after = [locate(change.target)[2] for change in mutation.changes]
    assert all(new is not old for new, old in zip(during, before, strict=True))
    assert all(new is old for new, old in zip(after, before, strict=True))


@pytest.mark.mitsuba
def test_a_fault_reaches_modules_that_import_by_name_and_leaves_no_trace():
    from lumenray.engine.transport.compiled import textures
    from lumenray.engine.transport.paths import wavelengths

    lamp = Illuminant("A")
    right = spectra.efficacy(lamp)
    with BY_NAME["K_m of 673"].injected():
        assert spectra.LUMINOUS_EFFICACY == wavelengths.LUMINOUS_EFFICACY == 673.0
        assert spectra.efficacy(lamp) == pytest.approx(right * 673.0 / 683.002, rel=1e-12)
    with BY_NAME["V by x-bar"].injected():
        np.testing.assert_array_equal(textures.luminous_efficiency(), spectra.observer()[:, 0])
    assert units.LUMINOUS_EFFICACY is spectra.LUMINOUS_EFFICACY is wavelengths.LUMINOUS_EFFICACY
    assert textures.luminous_efficiency is spectra.luminous_efficiency
    np.testing.assert_array_equal(spectra.luminous_efficiency(), spectra.observer()[:, 1])
    assert spectra.efficacy(lamp) == right


@pytest.mark.mitsuba
def test_a_fault_is_taken_back_after_an_error():
    with pytest.raises(ZeroDivisionError), BY_NAME["K_m of 673"].injected():
        raise ZeroDivisionError
    assert spectra.LUMINOUS_EFFICACY == 683.002


@pytest.mark.mitsuba
@pytest.mark.parametrize("old", ["np.cosh", "np."])
def test_a_fault_that_no_longer_fits_says_so(old):
    stale = Mutation("", "", (Rewrite("photometry.units:spread_axis_factor", old, ""),), ())
    with pytest.raises(ValueError, match="expected once: state the fault anew"), stale.injected():
        pass


@pytest.mark.mitsuba
@pytest.mark.validation
@pytest.mark.slow
def test_faults_are_caught():
    chosen = [BY_NAME[name] for name in ("receiver's cosine", "V by x-bar", "polarisation")]
    said = []
    outcomes = trials.run(chosen, False, said.append)
    assert said[0] == "without a fault 6 groups pass"
    for outcome in outcomes:
        assert outcome.is_caught and outcome.worst > 1.0, said
        assert outcome.found_by[0].group in outcome.mutation.likely


@pytest.mark.mitsuba
def test_a_process_that_breaks_off_says_where():
    broken = Mutation(
        "broken",
        "",
        (Rewrite("transport.paths.gather:response_of", "match kind:", "match what:"),),
        (),
    )
    with pytest.raises(BrokenOffError, match=r"C01\.iso: NameError"):
        trials.examine_apart(broken, ["C01.iso"])


# ---- the command, with answers made by hand ----


@pytest.fixture
def command(monkeypatch, capsys):
    """Run the command with mutations whose groups answer as told: by name ("" without a fault) the groups that fail."""

    def start(failing, *arguments, chosen=(HARMLESS,)):
        def answer(mutation, groups, stops=False):
            trials = []
            for key in groups:
                fails = key in failing.get("" if mutation is None else mutation.name, ())
                trials.append(Trial(key, not fails, 7.0 if fails else 0.1, 0.0))
                if fails and stops:
                    break
            return trials

        monkeypatch.setattr(command_line, "MUTATIONS", chosen)
        monkeypatch.setattr(trials, "quick_groups", lambda: ("C01.iso", "C01.tilt", "C05.axis"))
        monkeypatch.setattr(trials, "examine_apart", answer)
        return command_line.main(arguments), capsys.readouterr().err

    return start


def test_a_survivor_fails_the_check(command, tmp_path):
    code, told = command({}, "-o", str(tmp_path / "new"))
    assert code == 1 and "SURVIVES 3 groups" in told and "0 of 1 faults are caught" in told
    table = (tmp_path / "new" / "mutations.md").read_text(encoding="utf-8")
    assert "| harmless | nothing | **no** |  | 0 |" in table
    assert "`engine/photometry/units.py`, `BLENDER_EFFICACY`:" in table
    assert "- BLENDER_EFFICACY\n+ 1.0" in table


def test_groups_that_are_not_likely_are_asked_too(command, tmp_path):
    code, told = command({"harmless": ("C01.tilt", "C05.axis")}, "-o", str(tmp_path))
    assert code == 0 and "caught by C01.tilt: 7 of tolerance" in told
    code, told = command({"harmless": ("C01.tilt", "C05.axis")}, "--all", "-o", str(tmp_path))
    assert code == 0 and "caught by C01.tilt, C05.axis" in told
    assert "| harmless | nothing | yes | C01.tilt, C05.axis | 7 |" in (
        tmp_path / "mutations.md"
    ).read_text(encoding="utf-8")


def test_a_group_that_fails_anyway_proves_nothing(command, tmp_path):
    broken = {"": ("C01.tilt",), "harmless": ("C01.tilt",)}
    code, told = command(broken, "-o", str(tmp_path))
    assert code == 1 and "SURVIVES" in told
    broken["harmless"] = ("C01.tilt", "C05.axis")
    code, told = command(broken, "-o", str(tmp_path))
    assert code == 0 and "caught by C05.axis: 7 of" in told
    code, told = command({"": ("C01.iso",), "harmless": ("C01.iso",)}, "-o", str(tmp_path))
    assert code == 1 and "without a fault these fail already: C01.iso" in told


def test_one_fault_alone_does_not_replace_the_table(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, told = command({"harmless": ("C01.iso",)}, "--only", "harmless")
    assert code == 0 and "written" not in told and not list(tmp_path.iterdir())
    code, told = command({"harmless": ("C01.iso",)})
    assert code == 0 and (tmp_path / "docs" / "validation" / "mutations.md").exists()
