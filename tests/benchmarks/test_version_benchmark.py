"""What the comparison of two versions makes of their times and errors, and which folders it refuses."""

import pytest

from lumenray.benchmarks.versions import run as versions
from lumenray.engine.errors import LumenrayError


def runs(start, each, error, counts=(8, 72)):
    """Seconds and errors of a version whose time and error follow from what they are made of."""
    return {
        str(count): [{"seconds": start + each * count, "error": error / count**0.5}] * 3
        for count in counts
    }


def test_time_is_parted_into_the_start_and_samples():
    start, each, error = versions.split_time(runs(12.0, 0.4, 0.6))
    assert (start, each, error) == pytest.approx((12.0, 0.4, 0.6))


def test_to_the_same_error_counts_time_and_the_square_of_the_error():
    # Half the error of a sample at three times its cost: three quarters of the time to an error.
    result = {"runs": {"paths": {"here": runs(24.0, 1.2, 0.3), "there": runs(12.0, 0.4, 0.6)}}}
    shares = versions.compare(result, "paths")
    assert shares == pytest.approx({"start": 2.0, "sample": 3.0, "error": 0.75})
    assert [bar.passed for bar in versions.check_bars(result)] == [True]
    result["runs"]["paths"]["here"] = runs(24.0, 0.6, 0.6)
    assert [bar.passed for bar in versions.check_bars(result)] == [False]


def test_a_folder_that_is_no_version_is_refused(tmp_path):
    with pytest.raises(LumenrayError, match="no checkout of Lumenray"):
        versions.run(tmp_path)
