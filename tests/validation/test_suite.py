"""The quick subset of the validation suite on the engine; everything is run by ``make validate``."""

import pytest

from lumenray.validation.bench import Bench, Engine
from lumenray.validation.cases import all_cases
from lumenray.validation.determinism import check_seeds
from lumenray.validation.reference import groups_of, load_groups
from lumenray.validation.runner import run_case
from lumenray.validation.verdict import judge

FAMILIES = {
    "direct",
    "photometry",
    "glass",
    "interreflection",
    "daylight",
    "specular",
    "stability",
    "spectral",
    "glare",
}

SEEDS = ("C05.cie53",)
"""Groups of the quick subset whose seeds are checked."""

LONG = ("C33", "C39", "C40")
"""Cases whose quick subset takes more than ten seconds."""


@pytest.fixture(scope="module")
def engine():
    """One engine for all cases, so that kernels stay compiled."""
    return Engine()


def test_every_case_is_there():
    cases = all_cases()
    assert list(cases) == [f"C{number:02d}" for number in range(1, 49)]
    assert {case.family for case in cases.values()} <= FAMILIES


@pytest.mark.parametrize("case", all_cases().values(), ids=lambda case: case.id)
def test_quick_groups_belong_to_their_case(case):
    assert set(case.quick) <= set(groups_of(case.id))


@pytest.mark.mitsuba
@pytest.mark.validation
@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, marks=[pytest.mark.slow] if case.id in LONG else [], id=case.id)
        for case in all_cases().values()
        if case.quick
    ],
)
@pytest.mark.slow
def test_quick_groups_pass(case, engine):
    bench = Bench(engine, frozenset(case.quick))
    verdicts = [judge(found) for found in run_case(case, bench)]
    assert sorted(verdict.group.id for verdict in verdicts) == sorted(case.quick)
    faults = [verdict.sentence for verdict in verdicts if verdict.is_scored and not verdict.passes]
    assert not faults, "\n".join(faults)


@pytest.mark.mitsuba
@pytest.mark.validation
@pytest.mark.parametrize("key", SEEDS)
def test_seeds_repeat_and_errors_are_honest(key, engine):
    case = all_cases()[load_groups()[key].case]

    def measure(seed):
        return next(run_case(case, Bench(engine, frozenset({key}), seed)))

    check = check_seeds(measure(1), measure, 1)
    assert check.passes, check.sentence
    assert check.chi_square is not None
