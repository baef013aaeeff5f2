"""A session with a cluster: who computes what, that both hold the same scene, and what is told where the cluster is lost."""

import numpy as np
import pytest
from cluster_fakes import RoomCrew
from small_scenes import box, paint

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.cluster import session as cluster
from lumenray.engine.cluster.session import ClusterSession
from lumenray.engine.cluster.shared_session import ClusterPlace, SharedSession
from lumenray.engine.errors import EngineLost, LumenrayError
from lumenray.engine.scene.light import Output, PointLight, Quantity
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.session import Session

pytestmark = pytest.mark.mitsuba

PLACES, UP = np.array([[0.5, 0.5, 0.4]]), np.array([[0.0, 0.0, 1.0]])
RULE = StopRule(samples=2048)
HERE = ("tcp://127.0.0.1:8786", "", "", "")


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch):
    monkeypatch.setattr(cluster, "LEAST_PATHS", 1)
    monkeypatch.setattr(cluster, "MOST_PATHS", 1)


class Crew(RoomCrew):
    """Workers that know when they were let go."""

    is_closed = is_lost = False

    def workers(self):
        if self.is_lost:
            raise EngineLost("the scheduler does not answer any more")
        return super().workers()

    def close(self):
        self.is_closed = True


@pytest.fixture
def crews(monkeypatch):
    """All crews that were reached, the newest last."""
    made = []

    def open_crew(place):
        made.append(Crew())
        return made[-1]

    monkeypatch.setattr(ClusterPlace, "open_crew", open_crew)
    return made


def lamp(intensity=100.0):
    output = Output(Quantity.LUMINOUS_INTENSITY, intensity)
    return PointLight("lamp", "lamp", output, np.array([1.0, 1.0, 1.5]))


def fill(session, reflectance=0.5):
    session.apply(SceneDelta(changed=(box(2, 2, 2), paint(reflectance), lamp())))
    return session


def measure(session):
    return session.measure(PLACES, UP, RULE, 3, method="paths", witness=False)


def test_jobs_go_to_the_cluster_and_back(crews):
    session, here = fill(SharedSession()), fill(Session())
    np.testing.assert_array_equal(measure(session).illuminance, measure(here).illuminance)
    assert not crews
    session.join(HERE)
    there = fill(ClusterSession(Crew()))
    np.testing.assert_array_equal(measure(session).illuminance, measure(there).illuminance)
    assert len(crews) == 1
    assert session.list_workers() == tuple(sorted(crews[0].workers().items()))
    session.join(HERE)
    measure(session)
    assert len(crews) == 1 and not crews[0].is_closed
    session.join(None)
    assert crews[0].is_closed
    assert session.list_workers() == ()
    np.testing.assert_array_equal(measure(session).illuminance, measure(here).illuminance)


def test_edits_reach_the_cluster(crews):
    session = fill(SharedSession(), reflectance=0.0)
    session.join(HERE)
    before = measure(session).illuminance
    session.apply(SceneDelta(changed=(lamp(200.0),)))
    np.testing.assert_allclose(measure(session).illuminance, 2.0 * before, rtol=1e-5)


def test_views_and_others_have_their_turn_while_workers_compute(crews):
    turns = []
    session = fill(SharedSession(lambda: turns.append(session.has_view_work)))
    session.join(HERE)
    measure(session)
    assert turns


def test_a_lost_cluster_is_told_and_looked_for_again(crews):
    session = fill(SharedSession())
    session.join(HERE)
    measure(session)
    crews[0].is_lost = True
    with pytest.raises(LumenrayError, match="does not answer") as caught:
        measure(session)
    # That error means this process, which is well.
    assert not isinstance(caught.value, EngineLost)
    assert crews[0].is_closed
    assert np.isfinite(measure(session).illuminance).all()
    assert len(crews) == 2


def test_some_files_are_not_enough():
    with pytest.raises(LumenrayError, match="three files"):
        ClusterPlace("tls://far:8786", authority="ca.pem").open_crew()
