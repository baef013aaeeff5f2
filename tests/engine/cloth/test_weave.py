"""Where yarns run."""

import numpy as np
import pytest

from lumenray.engine.cloth import weave


def test_jammed_weave_is_peirces():
    """60 degrees, 0.866 of both diameters, 21 % crimp (B6)."""
    jam = weave.jammed_plain()
    assert np.degrees(jam.weave_angle) == pytest.approx(60.0)
    assert (jam.pitch, jam.crimp) == pytest.approx((0.8660254, 0.2091996))


@pytest.mark.parametrize("ratio, crimp", [(0.3, 0.05339603), (0.8, 0.32066822)])
def test_crimp_is_that_of_a_cosine(ratio, crimp):
    """Elliptic integrals (B6), within the chords of the drawn line."""
    assert weave.crimp([True, False], ratio, 1.0) == pytest.approx(crimp, rel=1e-4)


def test_patterns_have_their_counts():
    """Twill 2/1 is up in two of three, satin of five in four; no two interlacings of satin touch."""
    assert weave.twill_pattern(2, 1).mean() == pytest.approx(2 / 3)
    satin = weave.satin_pattern(5, 2)
    assert satin.sum() == 20
    down = np.argwhere(~satin)
    apart = np.abs(down[:, None] - down)
    apart = np.minimum(apart, 5 - apart).sum(axis=2)
    assert apart[~np.eye(5, dtype=bool)].min() > 2
    with pytest.raises(ValueError, match="from 2 to 4"):
        weave.satin_pattern(6, 2)
