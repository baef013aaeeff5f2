"""Spectra at sensors that stand in the scene: action on the eye and colours of two groups of lamps, mixed and judged."""

import csv

import bpy
import numpy as np
import pytest
from blender_bakes import add_lamp

from lumenray.blender_addon.sensors import asked, files, judging, results, words
from lumenray.blender_addon.sensors.places import signature_of
from lumenray.blender_addon.sensors.readings import read_readings, readings_of, write_readings
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.judgement.requirement import Requirement
from lumenray.engine.judgement.verdict import State
from lumenray.engine.light_mix import NEUTRAL, Level, LightMix

pytestmark = [pytest.mark.usefixtures("extension"), pytest.mark.slow]

RATIOS = {"A": 0.4964, "D65": 1.0}
"""Melanopic daylight efficacy ratios of the CIE's toolbox for illuminants. (CIE S 026)"""


@pytest.fixture
def readings():
    """A sensor below a lamp of illuminant A and one of D65, of 1000 lm each, 2 m above it."""
    from lumenray.engine.session import Session

    for name in RATIOS:
        lamp = add_lamp(name, group=name)
        lamp.data.lumenray.spectrum, lamp.data.lumenray.illuminant = "ILLUMINANT", name
    empty = bpy.data.objects.new("Eye", None)
    own = empty.lumenray.sensor
    own.is_sensor = True
    before = signature_of(empty)
    own.use_spectrum, own.area = True, "MELANOPIC"
    assert signature_of(empty) != before
    bpy.context.scene.collection.objects.link(empty)
    bpy.context.scene.lumenray.light_mix.groups = "GROUPS"
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    job, _ = asked.prepare(depsgraph, rule=StopRule(samples=4096))
    job.run(Session())
    results.store(job)
    return readings_of(empty)


def test_light_at_a_sensor_acts_on_the_eye_and_has_a_colour(readings, tmp_path):
    lux = 1000.0 / (4.0 * np.pi) / 4.0
    only_a = LightMix((Level("D65", is_on=False),))
    for levels, exact in ((only_a, RATIOS["A"] * lux), (NEUTRAL, sum(RATIOS.values()) * lux)):
        spectra = readings.mixed_spectra(levels)
        found, error = spectra.equivalent_daylight[0, -1], spectra.equivalent_daylight_error[0, -1]
        assert abs(found - exact) < 4.0 * error + 0.002 * exact
        assert error < 0.02 * exact
    told = dict(words.describe_light(readings, only_a))
    assert int(told["colour"].split()[0]) == pytest.approx(2856, abs=60)
    assert "Ra 9" in told["indices"] or "Ra 100" in told["indices"]
    again = read_readings(write_readings(readings))
    np.testing.assert_array_equal(again.mixed_spectra().bands, readings.mixed_spectra().bands)
    files.write_rows(tmp_path / "out.csv", [("Eye", readings)], only_a)
    (row,) = csv.DictReader((tmp_path / "out.csv").open())
    assert float(row["melanopic_edi_lx"]) == pytest.approx(RATIOS["A"] * lux, rel=0.05)
    document = files.describe_readings("Eye", readings, only_a)
    assert document["spectral"]["cct_k"][0] == pytest.approx(2856, abs=60)
    # Judged by what is melanopic, not by lux.
    need = Requirement("a", "a", "a", "", {"melanopic": {"mean": 1.2 * lux}}, {})
    for levels, state in ((NEUTRAL, State.MET), (only_a, State.NOT_MET)):
        judged = judging.judge_sensors([("Eye", readings, "melanopic")], need, levels)
        assert judged.areas["Eye"].state is state
    # And its colour rendering, which a requirement without sensors with a spectrum leaves open.
    for ra, state in ((80.0, State.MET), (100.0, State.NOT_MET)):
        need = Requirement("a", "a", "a", "", {"melanopic": {"mean": 0.2 * lux}}, {"ra": ra})
        judged = judging.judge_sensors([("Eye", readings, "melanopic")], need, only_a)
        (rendering,) = [each for each in judged.areas["Eye"].verdicts if each.limit == ra]
        assert rendering.state is state or (ra == 100.0 and rendering.state is State.UNDECIDED)
        assert judged.missing == []
