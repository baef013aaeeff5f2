"""The question to the engine whether it can work, in a process of its own."""

import pytest

from lumenray.blender_addon.foundation import probe


def test_probe_answers_from_a_process_of_its_own():
    asked = probe.Probe()
    status = asked.wait()
    assert status.cause
    assert asked.poll() == status
    assert status.usable or status.remedy


@pytest.mark.parametrize(
    ("code", "answer", "complaint", "expected"),
    [
        (0, 'noise\nstatus={"usable": true, "cause": "c", "remedy": "", "found": []}\n', "", "c"),
        (-11, "", "LLVM ERROR: bad\n", "LLVM ERROR: bad"),
        (1, "", "Traceback\nImportError: no numpy\n", "ImportError: no numpy"),
        (0, "", "", "without a word"),
    ],
)
def test_probe_understands_what_a_process_leaves(code, answer, complaint, expected):
    status = probe.read_answer(code, answer, complaint)
    assert expected in status.cause
    assert status.usable or status.remedy
