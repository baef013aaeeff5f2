"""Absolute scale of a picture of the surroundings: what luminance a value of 1 stands for.

References
----------
G. Ward Larson, R. Shakespeare: Rendering with Radiance, 1998: pictures hold W/(m2 sr), of which 179 lm/W make luminances.
"""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from ..photometry.units import RADIANCE_EFFICACY
from ..scene.texture import ImageTexture
from ..sky.picture import find_illuminance

UPWARDS = (0.0, 0.0, 1.0)
"""Normal of a horizontal plane."""


@dataclass(frozen=True)
class Scale:
    """How it is stated how bright a picture is.

    Parameters
    ----------
    white : float    Luminance of a pixel whose Rec. 709 luminance is 1; 179 by Radiance's convention. [cd/m2]
    measured : float or None    Illuminance that was measured where the picture was taken, of a plane with the normal
        ``facing``, by all that the picture and its lights give; it holds before ``white``. [lx]
    facing : (float, float, float)    In the picture's directions.
    factor : float    What all of it is multiplied by. [-]
    """

    white: float = RADIANCE_EFFICACY
    measured: float | None = None
    facing: tuple[float, float, float] = UPWARDS
    factor: float = 1.0


def find_scale(scale: Scale, image: ImageTexture, lights=()) -> float:
    """Return the luminance of a pixel whose value is 1.

    Parameters
    ----------
    scale : Scale
    image : ImageTexture    Equirectangular; without its bright sources where those are lights.
    lights : iterable of (float, (3,) array)    Illuminances of planes that face them, in units of the picture's values, and
        unit vectors to them.

    Returns
    -------
    float    [cd/m2]

    Raises
    ------
    SceneError    The plane that was measured gets no light by the picture.
    """
    if scale.measured is None:
        return scale.white * scale.factor
    normal = np.asarray(scale.facing, dtype=np.float64)
    normal = normal / np.linalg.norm(normal)
    given = find_illuminance(image, np.eye(3), normal)
    given += sum(amount * max(float(normal @ towards), 0.0) for amount, towards in lights)
    if not given > 0.0:
        raise SceneError(
            "the picture gives no light to the plane that was measured, so that its illuminance cannot be scaled"
        )
    return scale.measured / given * scale.factor
