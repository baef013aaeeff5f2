"""Runner, outcome and command, with cases made by hand instead of the engine's."""

import json
import sys
import types

import numpy as np
import pytest

from lumenray import validation as suite
from lumenray.command_line import validate as validate_command
from lumenray.command_line.main import main
from lumenray.validation import outcome, runner
from lumenray.validation.bench import Bench, CannotStateError, Finding
from lumenray.validation.cases import Case
from lumenray.validation.reference import groups_of, load_groups


class Stranger:
    """Instrument that is not ours."""

    name = "Stranger"

    def measure(self, items, query, seed):
        raise CannotStateError("nothing can be asked")


def give_right_values(bench):
    """Case C01 with the reference's own values and noise of the wanted size on one group."""
    for key, group in bench.groups("C01").items():
        if key == "C01.iso":
            spread = group.allowed / 4.0
            noise = np.random.default_rng(bench.seed).normal(size=spread.size)
            yield Finding(group, group.values + 0.3 * spread * noise, spread)
        else:
            yield Finding(group, group.values.copy(), np.zeros_like(group.values))


def give_low_values(bench):
    """Case C20, 0.9 % low."""
    for group in bench.groups("C20").values():
        yield Finding(group, 0.991 * group.values, np.zeros_like(group.values))


def give_part(bench):
    """Case C05: one group, then more than the instrument can do."""
    group = bench.groups("C05")["C05.cie53"]
    yield Finding(group, group.values.copy(), np.zeros_like(group.values))
    assert bench.engine
    raise ZeroDivisionError("a slip")


RIGHT = Case("C01", "right", "direct", give_right_values, ("C01.iso", "C01.flux"))
LOW = Case("C20", "low", "daylight", give_low_values, ("C20.black",))
PART = Case("C05", "part", "direct", give_part, ("C05.cie53",))


def test_a_run_judges_every_group():
    lines = []
    made = runner.run({"C01": RIGHT, "C20": LOW}, seed=5, say=lines.append)
    assert list(made.groups) == [*groups_of("C01"), *groups_of("C20")]
    assert list(made.engine.findings) == list(made.engine.verdicts) == list(made.groups)
    assert made.failed == ("C20.black",)
    assert made.seed == 5 and made.version and made.machine["cores"] and not made.peers
    assert any("C20.black" in line and "FAILS" in line and "bias" in line for line in lines)
    assert any("C01.tilt" in line and "passes" in line for line in lines)
    assert all(finding.seconds >= 0.0 for finding in made.engine.findings.values())


def test_seeds_of_the_run_are_checked():
    """The noise is a third of what is stated, so chi-square must tell."""
    made = runner.run({"C01": RIGHT})
    (check,) = made.determinism
    assert check.group == "C01.iso" and check.is_identical and check.degrees == 50
    assert check.chi_square == pytest.approx(0.09, abs=0.05) and not check.passes


def test_a_case_that_breaks_off_keeps_what_it_found_and_fails_the_rest(caplog):
    made = runner.run({"C05": PART, "C20": LOW}, is_quick=False)
    assert list(made.engine.findings) == ["C05.cie53", "C20.black", "C20.diffuse"]
    assert made.engine.missing["C05.axis"] == "broke off with ZeroDivisionError: a slip"
    assert set(made.failed) == {*groups_of("C05"), "C20.black"} - {"C05.cie53"}
    assert "a slip" in caplog.text


def test_a_peer_that_cannot_state_a_case_is_told():
    made = runner.run({"C05": PART}, peers=[Stranger])
    stranger = made.peers["Stranger"]
    assert list(stranger.findings) == ["C05.cie53"]
    assert "more than illuminances" in stranger.missing["C05.axis"]
    assert outcome.summarise_peer(made.groups, stranger).groups == 1


def test_a_peer_that_is_not_installed_is_told():
    class Absent:
        def __init__(self):
            raise CannotStateError("not installed")

    made = runner.run({"C20": LOW}, peers=[Absent])
    assert made.peers["Absent"].missing == dict.fromkeys(
        groups_of("C20"), "Absent is not there: not installed"
    )


def test_the_quick_subset_has_its_groups_only():
    made = runner.run({"C01": RIGHT, "C20": LOW}, is_quick=True)
    assert list(made.groups) == ["C01.iso", "C01.flux", "C20.black"]


def test_findings_that_do_not_fit_are_refused():
    group = groups_of("C20")["C20.black"]

    def twice(bench):
        yield Finding(group, group.values, np.zeros(8))
        yield Finding(group, group.values, np.zeros(8))

    def short(bench):
        yield Finding(group, group.values[:3], np.zeros(3))

    for run, message in ((twice, "was there already"), (short, "expected")):
        with pytest.raises(ValueError, match=message):
            list(runner.run_case(Case("C20", "", "daylight", run), Bench(Stranger())))


def test_findings_are_judged_by_the_tolerance_and_not_by_a_smaller_error_asked_for():
    made = runner.run({"C20": LOW}, error=1e-5)
    for key, finding in made.engine.findings.items():
        assert finding.group is load_groups()[key]


def test_cases_are_chosen_by_family_and_id(monkeypatch):
    cases = {"C01": RIGHT, "C05": PART, "C20": LOW}
    monkeypatch.setattr(runner, "all_cases", lambda: cases)
    assert list(runner.choose_cases()) == ["C01", "C05", "C20"]
    assert list(runner.choose_cases(["direct"])) == ["C01", "C05"]
    assert list(runner.choose_cases(["C20", "C01"])) == ["C01", "C20"]
    assert runner.families() == ("direct", "daylight")
    with pytest.raises(KeyError, match="plumbing"):
        runner.choose_cases(["direct", "plumbing"])


# ---- outcome ----


def test_the_outcome_counts_scored_values(tmp_path):
    made = runner.run({"C05": PART, "C20": LOW})
    told = outcome.compose_outcome(made)
    areas, street = groups_of("C05"), groups_of("C20")
    values = sum(group.values.size for group in [*areas.values(), *street.values()])
    right = areas["C05.cie53"].values.size + 16
    assert told["values"] == values
    assert told["within_1_percent"] == pytest.approx(right / values)
    assert told["bands"] == pytest.approx(dict.fromkeys(["1", "3", "5", "10"], right / values))
    assert told["groups"] == len(areas) + 2
    assert told["groups_failed"] == [*(k for k in areas if k != "C05.cie53"), "C20.black"]
    path = outcome.write_outcome(told, tmp_path / "new" / "validation.json")
    assert json.loads(path.read_text(encoding="utf-8")) == told
    rows = {row["id"]: row for row in told["detail"]}
    assert rows["C05.axis"]["missing"].startswith("broke off")
    columns = dict(zip(told["point_columns"], rows["C20.black"]["points"][0], strict=True))
    assert columns == pytest.approx(
        {
            "label": "floor centre",
            "reference": 0.4472136,
            "value": 0.991 * 0.4472136,
            "standard_error": 0.0,
            "allowed": 0.004472136,
            "relative_error": -0.009,
            "inside": True,
        }
    )


def test_informative_groups_are_told_but_not_counted():
    def give(bench):
        for group in bench.groups("C34").values():
            yield Finding(group, 2.0 * group.values, np.zeros_like(group.values))

    made = runner.run({"C34": Case("C34", "colour", "spectral", give)})
    told = outcome.compose_outcome(made)
    scored = {key for key in groups_of("C34") if key != "C34.rgb"}
    assert told["groups"] == len(scored) and set(told["groups_failed"]) == scored
    assert "C34.rgb" in [row["id"] for row in told["detail"]]


def test_the_table_names_what_failed():
    told = outcome.tell(runner.run({"C01": RIGHT, "C20": LOW}))
    rows = [line.split() for line in told.splitlines()]
    assert rows[0][:3] == ["groups", "failed", "values"]
    assert rows[2][:4] == ["daylight", "2", "1", "16"]
    assert rows[3][:3] == ["all", "9", "1"]
    assert "which is a bias" in told and "its errors do not explain" in told


# ---- command ----


@pytest.fixture
def command(monkeypatch, tmp_path, capsys):
    """Run the command with the cases from here and a report that only notes its folder."""
    written = []
    report = types.ModuleType("report")
    report.write_report = lambda run, folder: written.append(folder)
    monkeypatch.setitem(sys.modules, f"{suite.__name__}.report", report)
    monkeypatch.setattr(suite, "report", report, raising=False)
    monkeypatch.chdir(tmp_path)

    def start(cases, *arguments):
        monkeypatch.setattr(runner, "all_cases", lambda: cases)
        code = main(["validate", *arguments])
        return code, capsys.readouterr(), written

    return start


def give_exact_values(bench):
    """Case C20 as it should be."""
    for group in bench.groups("C20").values():
        yield Finding(group, group.values.copy(), np.zeros_like(group.values))


EXACT = Case("C20", "exact", "daylight", give_exact_values, ("C20.black",))


def test_the_command_writes_report_and_outcome(command, tmp_path):
    code, printed, written = command({"C20": EXACT}, "-o", "here")
    assert code == 0 and "Every scored group passes." in printed.out
    assert "C20.diffuse" in printed.err and "passes" in printed.err
    assert [str(folder) for folder in written] == ["here"]
    told = json.loads((tmp_path / "here" / "validation.json").read_text(encoding="utf-8"))
    assert told["values"] == 16 and told["within_1_percent"] == 1.0 and told["groups_failed"] == []


def test_the_command_fails_when_a_group_does(command):
    code, printed, _ = command({"C20": LOW})
    assert code == 1 and "C20.black" in printed.out and "bias" in printed.out


def test_a_part_of_the_suite_does_not_replace_the_whole_report(command):
    for arguments, folder in (
        ((), "docs/validation"),
        (("--family", "daylight"), "out/validation"),
        (("--quick",), "out/validation"),
    ):
        _, _, written = command({"C20": EXACT}, *arguments)
        assert written[-1].as_posix() == folder


def test_an_unknown_family_is_refused(command):
    code, printed, _ = command({"C20": EXACT}, "--family", "plumbing")
    assert code == 1
    assert (
        printed.err == "lumenray: the suite has no family or case plumbing; families are daylight\n"
    )


@pytest.mark.parametrize("wrong", ["0", "-1", "nan", "x", "1.5"])
def test_an_error_that_makes_no_sense_is_refused(wrong, capsys):
    with pytest.raises(SystemExit):
        main(["validate", "--error", wrong])
    assert "expected a share above 0 to 100 %" in capsys.readouterr().err


def test_an_installation_without_the_suite_says_so(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "lumenray.validation", None)
    assert main(["validate"]) == 1
    assert "this installation has no validation suite" in capsys.readouterr().err
    assert validate_command.REPORT_FOLDER.as_posix() == "docs/validation"
