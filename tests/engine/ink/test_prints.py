"""Jobs that compute pigment layers: what they tell on the way, how they end early, and go on."""

import json

import numpy as np
import pytest
from small_inks import make_ink

from lumenray.engine.errors import Cancelled
from lumenray.engine.ink import computed
from lumenray.engine.ink.ensemble import default_folder
from lumenray.engine.session import Session

SMALL = {"cell_um": 0.5, "band_step_nm": 80, "incidences": 2, "realisations": 2, "tolerance": 0.01}

CONTENT = make_ink(0.2, 0.3, thickness_um=0.5, solution=SMALL).content


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A job that was cancelled when a few units were done, and one that went on: what was told, and what came of it."""
    folder = tmp_path_factory.mktemp("inks")
    session, told, early = Session(), [], []

    def cancel(progress):
        early.append(progress)
        if progress.done > 0.0:
            session.cancel()

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LUMENRAY_INK_CACHE", str(folder))
        # A table that tells nothing finely takes no time.
        patch.setattr(computed, "TOLERANCE", 0.3)
        with pytest.raises(Cancelled, match="what was solved is kept"):
            session.compute_ink(json.dumps(CONTENT), draft=True, progress=cancel)
        solved = len(list(default_folder().rglob("*.npz")))
        made = session.compute_ink(json.dumps(CONTENT), draft=True, progress=told.append)
    return solved, early, told, made


def test_a_cancelled_job_keeps_what_was_solved_and_the_next_goes_on_there(kept):
    solved, early, told, _ = kept
    assert solved >= 1
    assert early[0].done == 0.0
    assert early[0].seconds_left is None
    assert told[0].done * len(told) > 0.0
    assert told[-1].done == 1.0
    assert told[-1].seconds_left == 0.0
    assert [each.done for each in told] == sorted(each.done for each in told)


def test_a_print_has_a_table_and_tells_its_errors(kept):
    made = kept[3]
    table = made.surface.front_reflection
    assert table.has_direct
    assert made.readings.shape == made.wavelengths.shape
    assert np.all(made.standard_errors >= 0.0)
    assert (made.realisations, made.seed) == (2, 0)
    assert len(made.key) == 64
    assert any("scalar" in note for note in made.notes)
