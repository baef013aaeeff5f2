"""Scenes in Radiance's own language."""

from dataclasses import dataclass, field

import numpy as np

from lumenray.engine.luminaires.distribution import flux, scaled
from lumenray.engine.luminaires.formats.lm63.writer import write_lm63
from lumenray.engine.luminaires.formats.record import LuminaireFile
from lumenray.engine.scene.light import (
    AreaLight,
    CieSky,
    FormulaSky,
    ImageWorld,
    Luminaire,
    PointLight,
    SpotLight,
    SunLight,
)
from lumenray.engine.scene.material import (
    Black,
    Diffuse,
    Emission,
    Glossy,
    TabulatedPane,
    ThinGlass,
    Transparent,
)

from ..bench import CannotStateError
from .contents import (
    Contents,
    Face,
    Part,
    area_luminance,
    candelas,
    luminaire_flux,
    neutral_value,
    scattered,
    sun_illuminance,
)
from .flat_lights import SMALL_MESH, box_around, cut, ellipse_strips, triangle_strips
from .skies import OVERCAST, ground_luminance, letters_of, luminance_scale, parts_of, unit_sun

LUMENS_PER_WATT = 179.0
"""Radiance's own factor between its white radiance and luminance, which ies2rad divides by. [lm/W]"""


POINT_RADIUS = 1e-4
"""Radius of the sphere that stands for a point, over the distance of the nearest sensor."""

APEX = 1e-6
"""Distance of a spot light's tip behind its middle."""

LUMINAIRE_RADIUS = 0.0005
"""Radius of the sphere that stands for a luminaire without extent, the least that ies2rad takes. [m]"""

SUN_ANGLE = 0.001
"""Angular diameter that stands for 0. [deg]"""


PANE_STEPS = 360
"""Into which the angle of incidence is divided for a pane's table."""


SELF_SHARE = 0.999
"""Share of the reflecting material where a surface reflects and glows, which takes a mixture of two."""


@dataclass
class RadianceScene:
    """A scene as text, and what it needs.

    Parameters
    ----------
    text : list of str    Primitives.
    meshes : dict of str to (vertices, triangles)    Of larger meshes by name, to be compiled.
    files : dict of str to bytes    Further files by name.
    luminaires : list of (str, str)    Name of the LM-63 file without its end, and options of xform.
    is_open : bool    Whether there are surroundings.
    has_glow : bool    Whether something shines that is not aimed at.
    has_extent : bool    Whether flat lights are aimed at.
    has_round : bool    Whether there are spheres or a sun's disk.
    scatter : float    Largest share of light that a surface scatters.
    lights : int    Number of lights that are aimed at.
    mirrors : int    Number of mirrors.
    cube : tuple of float    Lowest corner and side of a cube that holds all with some room; empty: nothing is finite.
    """

    text: list[str] = field(default_factory=list)
    meshes: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    files: dict[str, bytes] = field(default_factory=dict)
    luminaires: list[tuple[str, str]] = field(default_factory=list)
    is_open: bool = False
    has_glow: bool = False
    has_extent: bool = False
    has_round: bool = False
    scatter: float = 0.0
    lights: int = 0
    mirrors: int = 0
    cube: tuple[float, ...] = ()


def write_scene(
    contents: Contents, sensors: np.ndarray, middle, size: float, direct: bool, aims: bool
) -> RadianceScene:
    """Translate a scene.

    Parameters
    ----------
    contents : Contents
    sensors : (n, 3) array    In units of ``size`` about ``middle``, as everything that is written.
    middle : (3,) array    [m]
    size : float    [m]
    direct : bool    Whether surfaces shall scatter and mirror nothing.
    aims : bool    Whether area lights are aimed at, or met by the hemisphere's rays.

    Raises
    ------
    CannotStateError    Radiance has nothing for a part of it.
    """
    return _Writer(sensors, np.asarray(middle), size, direct, aims).write(contents)


class _Writer:
    def __init__(self, sensors, middle, size, direct, aims):
        self.scene = RadianceScene()
        self.sensors, self.middle, self.size = sensors, middle, size
        self.direct, self.aims = direct, aims
        self.count = 0
        self.points: list[np.ndarray] = []

    def write(self, contents: Contents) -> RadianceScene:
        if not self.direct:
            self.scene.scatter = max(
                (scattered(part.material.surface) for part in contents.parts), default=0.0
            )
        for part in contents.parts:
            moved = (part.vertices - self.middle) / self.size
            self._part(Part(moved, part.triangles, part.material))
        for light in contents.lights:
            self._light(light)
        if contents.world is not None:
            self._world(contents.world)
        if self.points:
            points = np.concatenate(self.points)
            low, high = points.min(axis=0), points.max(axis=0)
            # Rays that enter a tight cube close to a face on its side may miss it.
            side = 2.0 * max(float((high - low).max()), 1.0)
            self.scene.cube = (*(0.5 * (low + high - side)), side)
        return self.scene

    # ---- surfaces ----

    def _part(self, part: Part) -> None:
        surface, emission = part.material.surface, part.material.emission
        if emission is not None:
            self._emitter(part, surface, emission)
            return
        match surface:
            case Black():
                name = self._plain(0.0, 0.0)
            case Diffuse():
                name = self._plain(
                    neutral_value(surface.reflectance), neutral_value(surface.transmittance)
                )
            case Glossy() if surface.roughness == 0.0:
                self._mirror(part, neutral_value(surface.reflectance))
                return
            case ThinGlass():
                value = neutral_value(surface.transmittance)
                name = self._define("glass", [], [value, value, value, surface.ior])
            case TabulatedPane():
                name = self._pane(surface.angles, surface.transmittance, surface.reflectance)
            case Transparent():
                value = neutral_value(surface.transmittance)
                if value == 1.0:
                    return
                ends = np.array([0.0, 90.0])
                name = self._pane(ends, np.full(2, value), np.zeros(2))
            case _:
                raise CannotStateError(f"no material of Radiance is the same as {_named(surface)}")
        self._surface(part, name)

    def _surface(self, part: Part, material: str) -> None:
        if len(part.triangles) > SMALL_MESH:
            name = self._name("m")
            self.scene.meshes[name] = part.vertices, part.triangles
            self.points.append(part.vertices)
            self._add(material, "mesh", [f"{name}.rtm"], [])
            return
        for face in part.faces():
            self._polygon(material, face.corners)

    def _plain(self, reflectance: float, transmittance: float) -> str:
        if self.direct:
            reflectance = transmittance = 0.0
        total = reflectance + transmittance
        if transmittance == 0.0:
            return self._define("plastic", [], [total, total, total, 0, 0])
        share = transmittance / total
        return self._define("trans", [], [total, total, total, 0, 0, share, 0])

    def _mirror(self, part: Part, reflectance: float) -> None:
        if len(part.triangles) > SMALL_MESH:
            raise CannotStateError("curved mirrors make no image sources")
        if self.direct:
            self._surface(part, self._plain(0.0, 0.0))
            return
        self._surface(part, self._define("mirror", [], [reflectance] * 3))
        self.scene.mirrors += len(part.faces())

    def _pane(self, angles, transmittance, reflectance) -> str:
        """Material that lets light straight through and mirrors it, by the angle of incidence."""
        file = self._name("p")
        places = np.linspace(0.0, 90.0, PANE_STEPS + 1)
        lines = [
            f"angle = 180 / PI * Acos(if(Rdot, Rdot, -Rdot)) * {PANE_STEPS / 90.0:.9g};",
            f"cell = if(angle - {PANE_STEPS - 1}, {PANE_STEPS - 1}, floor(angle));",
        ]
        for name, values in (("tr", transmittance), ("re", reflectance)):
            table = ",\n".join(f"{value:.9g}" for value in np.interp(places, angles, values))
            lines += [
                f"{name}_at(i) : select(i,\n{table});",
                f"{name} = {name}_at(cell + 1) + (angle - cell) *",
                f"({name}_at(cell + 2) - {name}_at(cell + 1));",
            ]
        self.scene.files[f"{file}.cal"] = "\n".join([*lines, ""]).encode()
        return self._define(
            "BRTDfunc",
            ["re", "re", "re", "tr", "tr", "tr", "0", "0", "0", f"{file}.cal"],
            [0.0] * 9,
        )

    def _emitter(self, part: Part, surface, emission: Emission) -> None:
        if emission.pattern is not None:
            raise CannotStateError("patterns of emission are not translated")
        reflectance = 0.0
        match surface:
            case Black():
                pass
            case Diffuse() if surface.transmittance is None:
                reflectance = 0.0 if self.direct else neutral_value(surface.reflectance)
            case _:
                raise CannotStateError(f"no material of Radiance glows and is {_named(surface)}")
        level = emission.luminance
        if reflectance > 0.0:
            # A mixture of two materials: each counts by its share.
            share = max(SELF_SHARE, reflectance)
            matt = self._define("plastic", [], [reflectance / share] * 3 + [0, 0])
            glow = self._define("glow", [], [level / (1.0 - share)] * 3 + [0])
            file = self._name("x")
            self.scene.files[f"{file}.cal"] = f"share = {share:.9g};\n".encode()
            mixture = self._name("x")
            self.scene.text.append(
                f"void mixfunc {mixture}\n4 {matt} {glow} share {file}.cal\n0\n0\n"
            )
            self._surface(part, mixture)
            self.scene.has_glow = True
            return
        if emission.two_sided:
            raise CannotStateError("a face of Radiance shines on one side only")
        if len(part.triangles) > SMALL_MESH:
            self._surface(part, self._define("glow", [], [level] * 3 + [0]))
            self.scene.has_glow = True
            return
        for face in part.faces():
            if len(face.corners) == 4:
                self._shine(face, level)
                continue
            for strip in triangle_strips(face):
                self._shine(strip, level, least=1)

    # ---- lights ----

    def _shine(self, face: Face, luminance: float, least: int = 4) -> None:
        if not self.aims:
            glow = self._define("glow", [], [luminance] * 3 + [0])
            self._polygon(glow, face.corners)
            self.scene.has_glow = True
            return
        light = self._define("light", [], [luminance] * 3)
        self.scene.has_extent = True
        # Where light is reflected every tile is looked at from every place.
        tiles = [face.corners] if self.scene.scatter > 0.0 else cut(face, self.sensors, least)
        self.scene.lights += len(tiles)
        for tile in tiles:
            self._polygon(light, tile)

    def _light(self, light) -> None:
        match light:
            case PointLight():
                self._sphere(light.position, light.radius, candelas(light))
            case SpotLight() if light.blend == 0.0 and light.radius == 0.0:
                # The vector's length is the distance of the cone's tip behind the source.
                aim = APEX * np.asarray(light.direction, dtype=np.float64)
                cone = [2.0 * np.degrees(light.half_angle), *aim]
                self._sphere(light.position, 0.0, candelas(light), cone)
            case SpotLight():
                raise CannotStateError(
                    "spot lights have no soft edge and no size of Blender's kind"
                )
            case AreaLight():
                self._area(light)
            case SunLight():
                self._sun(light)
            case Luminaire():
                self._luminaire(light)

    def _sphere(self, position, radius: float, intensity: float, cone=()) -> None:
        place = (np.asarray(position, dtype=np.float64) - self.middle) / self.size
        is_glow = radius > 0.0 and not self.aims and not cone
        self.scene.has_glow |= is_glow
        self.scene.lights += not is_glow
        self.scene.has_round |= radius > 0.0 and not is_glow
        radius /= self.size
        if radius == 0.0:
            away = np.linalg.norm(self.sensors - place, axis=1)
            # Far sensors must be able to hit it with their double precision.
            radius = max(POINT_RADIUS * away.min(), min(0.1 * away.min(), 1e-7 * away.max()))
        level = intensity / (np.pi * (radius * self.size) ** 2)
        kind = "spotlight" if cone else ("glow" if is_glow else "light")
        material = self._define(kind, [], [*[level] * 3, *([0] if is_glow else cone)])
        self._add(material, "sphere", [], [*place, radius])
        self.points.append(np.stack([place - radius, place + radius]))

    def _area(self, light: AreaLight) -> None:
        level = area_luminance(light)
        box = box_around(light)
        face = Face((box.corners - self.middle) / self.size)
        if light.shape == "rectangle":
            self._shine(face, level)
            return
        for strip in ellipse_strips(face):
            self._shine(strip, level, least=1)

    def _sun(self, light: SunLight) -> None:
        angle = max(np.degrees(light.angle), SUN_ANGLE)
        # Radiance takes the solid angle of the disk for its projection.
        level = sun_illuminance(light) / (2.0 * np.pi * (1.0 - np.cos(np.radians(0.5 * angle))))
        self._add(
            self._define("light", [], [level] * 3),
            "source",
            [],
            [*(-np.asarray(light.direction, dtype=np.float64)), angle],
        )
        self.scene.lights += 1
        self.scene.has_round |= light.angle > 0.0

    def _luminaire(self, light: Luminaire) -> None:
        if light.opening.shape != "point":
            raise CannotStateError("openings of luminaires differ in what they mean")
        total = luminaire_flux(light)
        distribution = scaled(light.distribution, total / flux(light.distribution))
        file = LuminaireFile(
            "LM-63-2002",
            "C",
            "none",
            distribution,
            light.opening,
            np.degrees(distribution.azimuth),
            np.degrees(distribution.polar),
            is_absolute=True,
        )
        name = self._name("l")
        turn = np.asarray(light.frame, dtype=np.float64)[:3, :3]
        place = (np.asarray(light.frame, dtype=np.float64)[:3, 3] - self.middle) / self.size
        data = write_lm63(file)
        kind = _photometric_type(data)
        if kind == "3":
            raise CannotStateError("ies2rad refuses files of type A")
        if kind == "2":
            # Of type B it has up along x and right along -y.
            turn = turn @ np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        self.scene.files[f"{name}.ies"] = data
        options = f"{_turns(turn)} -s {1.0 / self.size:.12g} -t {_numbers(place)}"
        self.scene.luminaires.append((name, options))
        reach = LUMINAIRE_RADIUS / self.size
        self.points.append(np.stack([place - reach, place + reach]))
        self.scene.lights += 1

    # ---- surroundings ----

    def _world(self, world) -> None:
        modifier = "void"
        level = 1.0
        if isinstance(world, FormulaSky):
            modifier = self._sky(world)
        elif isinstance(world, ImageWorld):
            modifier = self._picture(world)
        else:
            level = world.luminance
        glow = self._define("glow", [], [level] * 3 + [0], modifier)
        self._add(glow, "source", [], [0, 0, 1, 360])
        self.scene.has_glow = self.scene.is_open = True

    def _sky(self, sky: FormulaSky) -> str:
        scale = luminance_scale(sky)
        x, y, z = unit_sun(sky)
        lines = [
            f"cosine = Dx * {x:.12g} + Dy * {y:.12g} + Dz * {z:.12g};",
            "chi = Acos(cosine);",
        ]
        terms = []
        for number, (share, part) in enumerate(parts_of(sky)):
            if isinstance(part, CieSky) and part.type == OVERCAST:
                lines.append(f"part{number} = (1 + 2 * Dz) / 3;")
            else:
                a, b, c, d, e, edge, floor = letters_of(part)
                lines += [
                    f"scattered = {c:.12g} * (exp({d:.12g} * chi) - {edge:.12g}) + {e:.12g} * cosine * cosine;",
                    f"gradation = 1 + {a:.12g} * exp({b:.12g} / if(Dz - {floor:g}, Dz, {floor:g}));",
                    f"part{number} = gradation * (1 + scattered);",
                ]
            terms.append(f"{scale * share:.12g} * part{number}")
        above = " + ".join(terms)
        lines.append(f"bright = if(Dz, {above}, {ground_luminance(sky):.12g});")
        name = self._name("s")
        self.scene.files[f"{name}.cal"] = "\n".join([*lines, ""]).encode()
        self.scene.text.append(f"void brightfunc {name}\n2 bright {name}.cal\n0\n0\n")
        return name

    def _picture(self, world: ImageWorld) -> str:
        """Even cells of one colour, looked up by the whole numbers of row and column."""
        pixels = np.asarray(world.image.pixels, dtype=np.float64)
        if world.image.interpolation != "closest" or np.ptp(pixels[..., :3], axis=-1).any():
            raise CannotStateError("pictures of the surroundings with colours are not translated")
        rows, columns = pixels.shape[:2]
        values = world.luminance_per_unit * pixels[..., 0]
        name = self._name("s")
        x, y, z = (
            f"(Dx * {r[0]:.12g} + Dy * {r[1]:.12g} + Dz * {r[2]:.12g})" for r in world.rotation
        )
        self.scene.files[f"{name}.cal"] = "\n".join(
            [
                f"px = {x};",
                f"py = {y};",
                f"pz = {z};",
                f"row_at = floor((0.5 + atan2(pz, sqrt(px * px + py * py)) / PI) * {rows});",
                f"column_at = floor((0.5 - atan2(py, px) / (2 * PI)) * {columns});",
                f"row = if(row_at - {rows - 1}, {rows - 1}, row_at);",
                f"column = if(column_at - {columns - 1}, {columns - 1}, column_at);",
                "",
            ]
        ).encode()
        numbers = "\n".join(_numbers(line) for line in values)
        head = f"2\n0 {rows - 1} {rows}\n0 {columns - 1} {columns}\n"
        self.scene.files[f"{name}.dat"] = f"{head}{numbers}\n".encode()
        self.scene.text.append(
            f"void brightdata {name}\n5 noop {name}.dat {name}.cal row column\n0\n0\n"
        )
        return name

    # ---- text ----

    def _polygon(self, material: str, corners: np.ndarray) -> None:
        self._add(material, "polygon", [], corners.ravel())
        self.points.append(corners)

    def _name(self, letter: str) -> str:
        self.count += 1
        return f"{letter}{self.count}"

    def _define(self, kind: str, strings, reals, modifier: str = "void") -> str:
        name = self._name("k")
        self._add(modifier, kind, strings, reals, name)
        return name

    def _add(self, modifier: str, kind: str, strings, reals, name: str | None = None) -> None:
        first = " ".join([str(len(strings)), *strings])
        last = f"{len(reals)} {_numbers(reals)}"
        self.scene.text.append(f"{modifier} {kind} {name or self._name('o')}\n{first}\n0\n{last}\n")


def _photometric_type(data: bytes) -> str:
    """Number of the type in the line after TILT=NONE."""
    return data.decode("ascii").split("TILT=NONE")[1].split()[5]


def _numbers(values) -> str:
    return " ".join(f"{value:.12g}" for value in values)


def _named(surface) -> str:
    return type(surface).__name__


def _turns(rotation: np.ndarray) -> str:
    """Options of xform that turn by a matrix: about x, then y, then z."""
    r = rotation
    about_y = np.arcsin(np.clip(-r[2, 0], -1.0, 1.0))
    about_x, about_z = np.arctan2(r[2, 1], r[2, 2]), np.arctan2(r[1, 0], r[0, 0])
    x, y, z = (f"{np.degrees(angle):.12g}" for angle in (about_x, about_y, about_z))
    return f"-rx {x} -ry {y} -rz {z}"
