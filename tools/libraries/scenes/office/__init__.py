"""A small office with daylight and electric light, built from nothing.

Room 5.4 x 4.2 x 2.8 m, window to the north (+y), door to the east (+x); one unit is a metre.
"""

from .. import staging
from .architecture import build_architecture
from .books import build_books
from .desktop import build_desktop
from .exterior import build_exterior
from .furniture import build_furniture
from .luminaires import build_luminaires
from .objects import build_objects
from .palette import build_palette
from .plant import build_floor_plant, build_sill_plant
from .sensors import build_sensors

SKY_COLOUR, SKY_LUMINANCE = (0.93, 0.97, 1.0), 1500.0
"""Overcast winter sky: linear colour, and luminance of a white pixel. [cd/m2]"""

WHITE_LUMINANCE = 200.0
"""Luminance that becomes 1.0 in the picture. [cd/m2]"""


def build_office():
    """Build the office in the current, empty file."""
    names = ("Architecture", "Furniture", "Luminaires", "Objects", "Exterior", "Bake", "Sensors")
    collections = {name: staging.new_collection(name) for name in names}
    palette = build_palette()
    build_architecture(palette, collections["Architecture"], collections["Bake"])
    build_furniture(palette, collections["Furniture"], collections["Bake"])
    build_luminaires(palette, collections["Luminaires"])
    build_desktop(palette, collections["Objects"])
    build_books(palette, collections["Objects"])
    build_objects(palette, collections["Objects"])
    build_floor_plant(palette, collections["Objects"])
    build_sill_plant(palette, collections["Objects"])
    build_exterior(palette, collections["Exterior"])
    staging.set_sky(SKY_COLOUR, SKY_LUMINANCE)
    build_sensors(collections["Sensors"])
    staging.new_camera((0.30, 0.30, 1.42), (90.0, 0.0, -48.0), lens=21.0, shift_y=0.03)
    staging.set_render(720, 450, WHITE_LUMINANCE, samples=32, view_transform="AgX")
