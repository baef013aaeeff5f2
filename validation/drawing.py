"""Technical pictures of set-ups: surfaces, lights, sensors, the sky, a scale and the axes."""

from dataclasses import dataclass

import numpy as np
from PIL import Image

from lumenray.engine.scene.light import (
    CloudySky,
    FormulaSky,
    ImageWorld,
    Luminaire,
    PerezSky,
    PointLight,
    SpotLight,
    SunLight,
    UniformWorld,
)

from .bench import Setup
from .canvas import INK, SCALE, SOFT, Canvas
from .facets import LOOKS, MARGIN, collect_meshes, collect_sheets, light_places, region_of_interest
from .layers import paint_sheets
from .view import choose_view

SIZE = (640, 420)
"""Of a picture. [pixel]"""

SENSOR, LAMP, LAMP_EDGE, SKY = "#c8102e", "#ffc800", "#7a5a00", "#2f6fae"

GRID = "#dfe3e8"

MOST_SQUARES = 40
"""Squares of the grid along one side."""

LONG_LABEL, SHORT_LABEL, FEW_LABELS = 9, 5, 8
"""Labels are drawn as numbers when some are longer than the first, or than the second and more than the third."""

MOST_LABELS = 32
"""Points that are labelled; of more only some."""

LABEL_HEIGHT = 12.0
"""Of the place that a label takes. [pixel]"""

SYMBOL = 6.0
"""Radius of a light's symbol. [pixel]"""


def draw_setup(setup: Setup, size: tuple[int, int] = SIZE) -> Image.Image:
    """Draw scene and sensors of a case.

    Parameters
    ----------
    setup : Setup
    size : tuple of int    [pixel]
    """
    scene = _Scene(setup, size)
    sheet = Canvas(size)
    _draw_grid(sheet, scene)
    canvas = Canvas(size, paint_sheets(scene.sheets, scene.view, sheet.image, scene.seen))
    spots = _Spots(size)
    _draw_legend(canvas, scene)
    _draw_sky(canvas, scene, spots)
    _draw_glow(canvas, scene, spots)
    for light in scene.lights:
        _draw_light(canvas, scene, light, spots)
    _draw_sensors(canvas, scene, spots)
    _draw_scale(canvas, scene, spots)
    return canvas.finish()


def is_numbered(labels) -> bool:
    """Tell whether points are drawn with their numbers, from 1, because their labels are long."""
    longest = max((len(label) for label in labels), default=0)
    return longest > LONG_LABEL or (len(labels) > FEW_LABELS and longest > SHORT_LABEL)


class _Scene:
    """What is drawn, relative to a middle so that far coordinates keep their digits."""

    def __init__(self, setup: Setup, size):
        positions = np.asarray(setup.positions, dtype=np.float64).reshape(-1, 3)
        normals = np.asarray(setup.normals, dtype=np.float64).reshape(-1, 3)
        is_placed = np.isfinite(positions).all(axis=1)
        self.sensors, self.normals = positions[is_placed], normals[is_placed]
        self.is_numbered = is_numbered(setup.labels)
        names = setup.labels
        if len(names) != len(positions):
            # The sensors are a grid or the like, and the labels are those of what is made of them.
            names = ("",) * len(positions)
        elif self.is_numbered:
            names = tuple(str(i + 1) for i in range(len(positions)))
        self.labels = [names[i] for i in np.flatnonzero(is_placed)]
        self.items = setup.items
        self.lights = [
            i for i in setup.items if isinstance(i, PointLight | SpotLight | Luminaire | SunLight)
        ]
        meshes = collect_meshes(setup.items)
        places = light_places(setup.items)
        self.region = region_of_interest(meshes, np.concatenate([self.sensors, places]))
        self.drawn = self.region.grow(MARGIN)
        self.sheets = collect_sheets(setup.items, meshes, self.drawn)
        self.places = places
        corners = [np.concatenate(sheet.polygons) for sheet in self.sheets]
        held = np.concatenate([self.sensors, places, *corners])
        if not len(held) or np.ptp(held, axis=0).max() == 0.0:
            held = np.stack([self.region.low, self.region.high])
        self.seen = np.concatenate([self.sensors, places])
        beams = [np.asarray(i.direction, float) for i in self.lights if isinstance(i, SunLight)]
        beams = np.array([beam / np.linalg.norm(beam) for beam in beams]).reshape(-1, 3)
        window = ((46, 44), (size[0] - 46, size[1] - 64))
        self.view = choose_view(held, self.sensors, self.normals, beams, *window)
        self.step = _round_length(58.0 / self.view.scale)
        self.grid = self._lay_grid()
        if self.grid is not None:
            (x, y, z), (u, v, _) = self.grid
            held = np.concatenate([held, [(x, y, z), (u, y, z), (u, v, z), (x, v, z)]])
            self.view = choose_view(held, self.sensors, self.normals, beams, *window)

    def _lay_grid(self) -> np.ndarray | None:
        """Corners of squares in the lowest plane, (2, 3), where nothing lies there. [m]"""
        ground = self.region.low[2]
        lies = [
            sheet.normal is not None
            and abs(sheet.normal[2]) > 0.999
            and sheet.polygons[0][0][2] < ground + 0.02 * self.region.size
            for sheet in self.sheets
        ]
        low = np.floor(self.region.low / self.step - 0.3) * self.step
        high = np.ceil(self.region.high / self.step + 0.3) * self.step
        if any(lies) or ((high - low)[:2] / self.step).max() > MOST_SQUARES:
            return None
        return np.array([(low[0], low[1], ground), (high[0], high[1], ground)])


@dataclass
class _Spots:
    """What is taken up already, as boxes (low x, low y, high x, high y). [pixel]"""

    size: tuple[int, int]

    def __post_init__(self):
        self.boxes: list[tuple[float, float, float, float]] = []

    def take(self, box) -> None:
        self.boxes.append(box)

    def take_line(self, start, end) -> None:
        """Take up small boxes along a line."""
        for share in np.linspace(0.0, 1.0, 5):
            x, y = np.asarray(start) + share * (np.asarray(end) - np.asarray(start))
            self.take((x - 1.5, y - 1.5, x + 1.5, y + 1.5))

    def overlap(self, box) -> float:
        """Area that a box shares with what is there, and with the border."""
        area = sum(
            max(0.0, min(box[2], other[2]) - max(box[0], other[0]))
            * max(0.0, min(box[3], other[3]) - max(box[1], other[1]))
            for other in self.boxes
        )
        out = max(0.0, 4 - box[0]) + max(0.0, box[2] - self.size[0] + 4)
        out += max(0.0, 4 - box[1]) + max(0.0, box[3] - self.size[1] + 32)
        return area + 1000.0 * out


def _draw_grid(canvas: Canvas, scene: _Scene) -> None:
    """Draw squares in the lowest plane, and plumb lines of the lights."""
    if scene.grid is None:
        return
    low, high = scene.grid
    ground = low[2]
    for x in np.arange(low[0], high[0] + 0.5 * scene.step, scene.step):
        canvas.line(scene.view.project([(x, low[1], ground), (x, high[1], ground)]), GRID, 0.75)
    for y in np.arange(low[1], high[1] + 0.5 * scene.step, scene.step):
        canvas.line(scene.view.project([(low[0], y, ground), (high[0], y, ground)]), GRID, 0.75)
    for place in scene.places if len(scene.places) <= 12 else ():
        foot = (place[0], place[1], ground)
        canvas.dashed(scene.view.project([place, foot]), "#b8a060", 0.75, (4.0, 4.0))


def _draw_legend(canvas: Canvas, scene: _Scene) -> None:
    """Name the kinds of surfaces and symbols that occur, in a line at the bottom."""
    shown = [look for look in LOOKS if any(sheet.look == look for sheet in scene.sheets)]
    y = canvas.size[1] - 14
    x = 14.0
    for look in shown:
        colour = next(sheet.colour for sheet in scene.sheets if sheet.look == look)
        fill = tuple(int(255 + max(LOOKS[look][1], 0.35) * (c - 255)) for c in colour)
        canvas.box((x, y - 5), (x + 14, y + 5), fill, tuple(int(0.55 * c) for c in colour))
        x = _write_on(canvas, (x + 20, y), look)
    if any(not isinstance(light, SunLight) for light in scene.lights):
        _lamp(canvas, (x + 7, y), 5.0)
        x = _write_on(canvas, (x + 20, y), "light")
    if len(scene.sensors):
        canvas.dot((x + 6, y), SENSOR, 3.5)
        _write_on(canvas, (x + 16, y), "sensor")


def _write_on(canvas: Canvas, place, text: str) -> float:
    canvas.write(place, text, 12, "lm", INK)
    return place[0] + canvas.measure(text, 12) + 18


def _draw_sky(canvas: Canvas, scene: _Scene, spots: _Spots) -> None:
    """State the surroundings in the upper left corner, with a dome for a sky."""
    world = next(
        (i for i in scene.items if isinstance(i, UniformWorld | FormulaSky | ImageWorld)), None
    )
    suns = [light for light in scene.lights if isinstance(light, SunLight)]
    lines = [_describe_world(world)] if world is not None else []
    lines += [_describe_sun(sun) for sun in suns]
    lines = [line for line in lines if line]
    if not lines:
        return
    x = 14.0
    if world is not None:
        dome = [SCALE * v for v in (14, 8, 36, 30)]
        canvas.pen.pieslice(dome, 180, 360, fill="#d6e6f6", outline=SKY, width=SCALE)
        x = 46.0
    for row, line in enumerate(lines):
        canvas.write((x, 14 + 16 * row), line, 12, "lm", SKY if world is not None else INK)
    wide = max(canvas.measure(line, 12) for line in lines)
    spots.take((10, 4, x + wide + 6, 14 + 16 * len(lines)))


def _describe_world(world) -> str:
    if isinstance(world, UniformWorld):
        return f"uniform surroundings, {_number(world.luminance)} cd/m2" if world.luminance else ""
    if isinstance(world, ImageWorld):
        return "surroundings from a picture"
    match world:
        case CloudySky():
            name = f"sky of cloudiness {world.cloudiness:g}"
        case PerezSky():
            name = f"all-weather sky of clearness {world.clearness:g}"
        case _:
            name = "traditional overcast sky" if world.type == 16 else f"CIE sky type {world.type}"
    told = f"{name}, {_number(world.illuminance)} lx horizontal"
    if world.ground_reflectance:
        told += f", ground of reflectance {world.ground_reflectance:g}"
    return told


def _describe_sun(sun: SunLight) -> str:
    x, y, z = -np.asarray(sun.direction, dtype=np.float64)
    elevation = np.degrees(np.arctan2(z, np.hypot(x, y)))
    disk = f", disk of {np.degrees(sun.angle):.3g}\u00b0" if sun.angle else ", parallel"
    return f"sun {elevation:.3g}\u00b0 above the horizon{disk}"


def _number(value: float) -> str:
    return f"{value:,.0f}".replace(",", " ") if 1000 <= value < 1e6 else f"{value:.4g}"


def _draw_glow(canvas: Canvas, scene: _Scene, spots: _Spots) -> None:
    """Show which way flat emitters shine, and where they are when they are too small to be seen."""
    glowing = [s for s in scene.sheets if s.look == "glowing" and s.normal is not None]
    for sheet in glowing if len(glowing) <= 6 else ():
        corners = np.concatenate(sheet.polygons)
        spread = np.ptp(scene.view.project(corners), axis=0).max()
        start = scene.view.project(0.5 * (corners.min(axis=0) + corners.max(axis=0)))
        tip = start + 30.0 * scene.view.turn(sheet.normal)
        canvas.arrow(start, tip, LAMP_EDGE, 1.5, 6.0)
        spots.take_line(start, tip)
        if spread < 2.0 * SYMBOL:
            _lamp(canvas, start, 0.8 * SYMBOL)
            spots.take((start[0] - 8, start[1] - 8, start[0] + 8, start[1] + 8))


def _draw_light(canvas: Canvas, scene: _Scene, light, spots: _Spots) -> None:
    view = scene.view
    if isinstance(light, SunLight):
        _draw_sun(canvas, scene, light)
        return
    if isinstance(light, Luminaire):
        frame = np.asarray(light.frame, dtype=np.float64)
        place, aim, side = frame[:3, 3], -frame[:3, 2], frame[:3, 0]
    elif isinstance(light, SpotLight):
        place, aim, side = light.position, np.asarray(light.direction), None
    else:
        place, aim, side = light.position, None, None
    x, y = view.project(place)
    many = sum(not isinstance(other, SunLight) for other in scene.lights)
    radius = SYMBOL if many <= 12 else (4.0 if many <= 60 else 2.0)
    if isinstance(light, PointLight) and light.radius * view.scale > radius:
        radius = light.radius * view.scale
    if aim is not None and many <= 60:
        tip = np.array((x, y)) + 30.0 * view.turn(aim)
        canvas.arrow((x, y), tip, LAMP_EDGE, 1.5, 6.0)
        spots.take_line((x, y), tip)
    if side is not None and many <= 12:
        end = np.array((x, y)) + 22.0 * view.turn(side)
        canvas.line([(x, y), end], LAMP_EDGE, 1.0)
        canvas.write(end + 7.0 * view.turn(side), "C0", 10, "mm", LAMP_EDGE, has_halo=True)
        spots.take((end[0] - 12, end[1] - 8, end[0] + 12, end[1] + 8))
    if many <= 60:
        _lamp(canvas, (x, y), radius)
        spots.take((x - 1.5 * radius, y - 1.5 * radius, x + 1.5 * radius, y + 1.5 * radius))
    else:
        canvas.dot((x, y), LAMP, radius, LAMP_EDGE)


def _lamp(canvas: Canvas, place, radius: float) -> None:
    """A disk with short rays."""
    for angle in np.arange(8) * np.pi / 4.0:
        ray = np.array((np.cos(angle), np.sin(angle)))
        canvas.line([place + 1.3 * radius * ray, place + 1.75 * radius * ray], LAMP_EDGE, 1.0)
    canvas.dot(place, LAMP, radius, LAMP_EDGE)


def _draw_sun(canvas: Canvas, scene: _Scene, sun: SunLight) -> None:
    """Three parallel arrows that end where the sun's light comes in."""
    view = scene.view
    direction = np.asarray(sun.direction, dtype=np.float64)
    direction = direction / np.linalg.norm(direction)
    along = view.turn(direction)
    across = np.array((-along[1], along[0])) / max(float(np.linalg.norm(along)), 1e-9)
    middle = 0.5 * (scene.region.low + scene.region.high)
    end = view.project(middle - 0.5 * scene.region.size * direction)
    low = np.array((70.0, 60.0)) + np.maximum(80.0 * along, 0.0)
    end = np.clip(end, low, np.array(canvas.size) - (70.0, 110.0))
    for shift in (-26.0, 0.0, 26.0):
        tip = end + shift * across
        canvas.arrow(tip - 80.0 * along, tip, "#e0a000", 2.0, 9.0)


def _draw_sensors(canvas: Canvas, scene: _Scene, spots: _Spots) -> None:
    places = scene.view.project(scene.sensors)
    long = 24.0 if len(places) <= 16 else 16.0
    tips = places.copy()
    for k, normal in enumerate(scene.normals):
        if np.isfinite(normal).all() and np.linalg.norm(normal) > 0.0:
            tips[k] += long * scene.view.turn(normal / np.linalg.norm(normal))
    radius = 4.2 if len(places) <= 40 else 2.7
    for place, tip in zip(places, tips, strict=True):
        canvas.arrow(place, tip, SENSOR, 1.2, 5.0)
        spots.take_line(place, tip)
    for x, y in places:
        canvas.dot((x, y), SENSOR, radius, "#ffffff")
        spots.take((x - radius - 1, y - radius - 1, x + radius + 1, y + radius + 1))
    # Sensors that are drawn on top of each other share a label.
    keys = np.round(np.concatenate([places, tips], axis=1) / 3.0).astype(int)
    shared: dict[tuple, list[int]] = {}
    for k, key in enumerate(keys):
        shared.setdefault(tuple(key), []).append(k)
    crowd = {key: sum(key[:2] == other[:2] for other in shared) for key in shared}
    step = max(-(-len(shared) // MOST_LABELS), 1)
    for key, members in list(shared.items())[::step]:
        label = _join([scene.labels[k] for k in members], scene.is_numbered)
        if not label:
            continue
        _draw_label(canvas, label, places[members[0]], tips[members[0]], crowd[key] == 1, spots)


def _join(labels: list[str], is_numbered: bool) -> str:
    if len(labels) > 2 and labels[0]:
        return f"{labels[0]} {'-' if is_numbered else '...'} {labels[-1]}"
    return ", ".join(label for label in labels if label)


def _draw_label(canvas: Canvas, label: str, place, tip, is_alone: bool, spots: _Spots) -> None:
    """Write a label where it covers least: behind a lonely sensor, else before its normal; or nowhere."""
    width, height = canvas.measure(label, 12) + 3, LABEL_HEIGHT
    away = (place - tip) if is_alone else (tip - place)
    length = np.linalg.norm(away)
    anchor = place if is_alone else tip
    best = None
    for distance in (9.0, 15.0, 23.0, 33.0):
        for angle in np.arange(16) * np.pi / 8.0:
            way = np.array((np.cos(angle), np.sin(angle)))
            centre = anchor + way * (distance + 0.5 * width * abs(way[0]))
            box = (
                centre[0] - 0.5 * width,
                centre[1] - 0.5 * height,
                centre[0] + 0.5 * width,
                centre[1] + 0.5 * height,
            )
            likes = float(way @ away / length) if length > 1.0 else float(-way[1])
            cost = spots.overlap(box) + 1.2 * distance - 4.0 * likes
            if best is None or cost < best[0]:
                best = (cost, centre, box, distance)
    _, centre, box, distance = best
    if spots.overlap(box) > 0.35 * width * height:
        return
    if distance > 16.0:
        canvas.line([anchor, anchor + 0.7 * (centre - anchor)], "#e08a96", 0.75)
    canvas.write(centre, label, 12, "mm", INK, has_halo=True)
    spots.take(box)


def _draw_scale(canvas: Canvas, scene: _Scene, spots: _Spots) -> None:
    """Axes and a scale bar in the freest corner; the bar measures what is not foreshortened."""
    view, length = scene.view, scene.step
    arm = length * view.scale
    ways = view.turn(np.eye(3)) * min(arm, 42.0)
    wide, high = 128.0, 92.0
    corners = [
        (8.0, canvas.size[1] - 34 - high),
        (canvas.size[0] - wide - 8, canvas.size[1] - 34 - high),
    ]
    corners += [(canvas.size[0] - wide - 8, 8.0), (8.0, 34.0)]
    pixels = np.asarray(canvas.image.convert("L"), dtype=np.int16)
    low = min(
        corners,
        key=lambda c: (
            _darkness(pixels, c, wide, high) + spots.overlap((c[0], c[1], c[0] + wide, c[1] + high))
        ),
    )
    box = np.array([ways.min(axis=0).clip(max=0.0), ways.max(axis=0).clip(min=0.0)])
    middle = np.array((low[0] + 0.5 * wide, low[1] + 0.5 * (high - 26))) - box.mean(axis=0)
    for way, name, colour in zip(ways, "xyz", ("#a02020", "#207020", "#2040a0"), strict=True):
        canvas.arrow(middle, middle + way, colour, 1.5, 6.0)
        reach = max(float(np.linalg.norm(way)), 1e-9)
        canvas.write(middle + way * (1.0 + 9.0 / reach), name, 12, "mm", colour, has_halo=True)
    y = low[1] + high - 6
    start, end = low[0] + 0.5 * (wide - arm), low[0] + 0.5 * (wide + arm)
    canvas.line([(start, y), (end, y)], INK, 1.5)
    told = _length(length) if scene.grid is None else f"grid {_length(length)}"
    for x in (start, end):
        canvas.line([(x, y - 4), (x, y + 4)], INK, 1.5)
    canvas.write((0.5 * (start + end), y - 10), told, 12, "mm", SOFT, has_halo=True)


def _darkness(pixels: np.ndarray, corner, wide: float, high: float) -> float:
    x, y = (int(SCALE * v) for v in corner)
    part = pixels[max(y, 0) : y + int(SCALE * high), max(x, 0) : x + int(SCALE * wide)]
    return float((255 - part).mean() * 40.0)


def _round_length(metres: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is no longer."""
    power = 10.0 ** np.floor(np.log10(metres))
    return float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= metres))


def _length(metres: float) -> str:
    if metres >= 1000.0:
        return f"{metres / 1000.0:g} km"
    return f"{metres:g} m" if metres >= 0.1 else f"{metres * 1000.0:g} mm"
