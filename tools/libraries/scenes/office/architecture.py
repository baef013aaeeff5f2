"""The shell of the office: masonry, finished surfaces to bake, window, door, radiator, vent."""

import numpy as np

from .. import textures
from ..assembly import Assembly
from ..shapes import Part, blocks, box, cylinder, lathe, prism, quad, rounded_box, tube
from . import room


def bars(xs, ys, depth, filled):
    """Return a flat lattice in x and y, raised along z by ``depth`` metres."""
    return blocks(xs, ys, (0.0, depth), lambda i, j, _: filled(i, j))


def upright(part):
    """Return a part drawn in x and y turned to stand in x and z, its depth along -y."""
    return part.turned("x", 90.0)


def _shell(palette, collection):
    gap, thick = room.LINING, room.WALL
    xs = (-thick, -gap, room.WINDOW_X[0] - gap, room.WINDOW_X[1] + gap)
    xs = (*xs, room.WIDTH + gap, room.WIDTH + room.DOOR_RECESS, room.WIDTH + thick)
    ys = (-thick, -gap, room.DOOR_Y[0] - gap, room.DOOR_Y[1] + gap)
    ys = (*ys, room.DEPTH + gap, room.DEPTH + room.OUTER_WALL)
    sill, head = room.WINDOW_Z[0] - 0.03, room.WINDOW_Z[1] + gap
    top = room.HEIGHT + room.PLENUM
    zs = (-0.25, -gap, sill, room.DOOR_Z + gap, head, top, top + 0.25)

    def solid(i, j, k):
        inside = 1 <= i <= 3 and 1 <= j <= 3 and 1 <= k <= 4
        window = i == 2 and j == 4 and 2 <= k <= 3
        door = i == 4 and j == 2 and 1 <= k <= 2
        return not (inside or window or door)

    shell = Assembly().add(palette["Plaster"], blocks(xs, ys, zs, solid))
    shell.build("Masonry", collection)


def _lining(us, vs, hole):
    """Return the faces of a wall in (u, v) without the cells where ``hole(i, j)``."""
    index, faces = {}, []
    for i in range(len(us) - 1):
        for j in range(len(vs) - 1):
            if not hole(i, j):
                corners = ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
                faces.append(tuple(index.setdefault(c, len(index)) for c in corners))
    return Part(np.array([(us[i], vs[j], 0.0) for i, j in index]), faces)


def _surfaces(palette, collection):
    paint, height = palette["Wall Paint"], room.HEIGHT
    low = room.SKIRTING - 0.01
    repeats = (room.WIDTH / textures.FLOOR_TILE, room.DEPTH / textures.FLOOR_TILE)
    floor = quad((0, 0, 0), (room.WIDTH, 0, 0), (0, room.DEPTH, 0), repeats)
    Assembly().add(palette["Oak Floor"], floor).build("Floor", collection)

    tiles = []
    for i in range(round(room.WIDTH / room.MODULE)):
        for j in range(round(room.DEPTH / room.MODULE)):
            if (i, j) in room.PANEL_CELLS:
                continue
            corner = (i * room.MODULE + room.FLANGE / 2, j * room.MODULE + room.FLANGE / 2, height)
            side = room.MODULE - room.FLANGE
            tiles.append(quad(corner, (0, side, 0), (side, 0, 0)))
    Assembly().add(palette["Ceiling Tile"], *tiles).build("Ceiling", collection)

    x0, x1 = room.WINDOW_X
    z0, z1 = room.WINDOW_Z[0] - 0.025, room.WINDOW_Z[1]
    reveal = room.WINDOW_FRAME_Y - room.DEPTH
    sheet = _lining((0, x0, x1, room.WIDTH), (low, z0, z1, height), lambda i, j: (i, j) == (1, 1))
    north = [
        upright(sheet).moved(y=room.DEPTH),
        quad((x0, room.DEPTH, z0), (0, reveal, 0), (0, 0, z1 - z0)),
        quad((x1, room.DEPTH, z0), (0, reveal, 0), (0, 0, z1 - z0)),
        quad((x0, room.DEPTH, z1), (x1 - x0, 0, 0), (0, reveal, 0)),
    ]
    north[1:] = [facing(part, ((x0 + x1) / 2, room.DEPTH, (z0 + z1) / 2)) for part in north[1:]]
    Assembly().add(paint, *north).build("Wall North", collection)

    y0, y1 = room.DOOR_Y
    sheet = _lining((0, y0, y1, room.DEPTH), (low, room.DOOR_Z, height), lambda i, j: i == 1 > j)
    east = upright(sheet).turned("z", 90.0).moved(x=room.WIDTH)
    middle = (room.WIDTH / 2, room.DEPTH / 2, height / 2)
    Assembly().add(paint, facing(east, middle)).build("Wall East", collection)
    south = quad((0, 0, low), (room.WIDTH, 0, 0), (0, 0, height - low))
    Assembly().add(paint, facing(south, middle)).build("Wall South", collection)
    west = quad((0, 0, low), (0, room.DEPTH, 0), (0, 0, height - low))
    Assembly().add(paint, facing(west, middle)).build("Wall West", collection)


def facing(part, target):
    """Return a flat part with its normal towards the side on which ``target`` lies."""
    a, b, c = (part.points[index] for index in part.faces[0][:3])
    return part if np.dot(np.cross(b - a, c - a), np.asarray(target) - a) > 0 else part.flipped()


def _skirting(palette, collection):
    gap, deep, high = 0.0005, 0.014, room.SKIRTING
    y0, y1 = room.DOOR_Y[0] - 0.062, room.DOOR_Y[1] + 0.062
    xs = (gap, gap + deep, room.WIDTH - gap - deep, room.WIDTH - gap)
    ys = (gap, gap + deep, y0, y1, room.DEPTH - gap - deep, room.DEPTH - gap)

    def solid(i, j, _):
        return j in (0, 4) or i == 0 or (i == 2 and j != 2)

    board = blocks(xs, ys, (room.REST, high), solid)
    Assembly().add(palette["White Lacquer"], board).build("Skirting", collection)


def _window(palette, collection):
    frame, steel = palette["White Lacquer"], palette["Brushed Steel"]
    x0, x1 = (room.WINDOW_X[0] + 0.001, room.WINDOW_X[1] - 0.001)
    z0, z1 = room.WINDOW_Z[0] - 0.027, room.WINDOW_Z[1] - 0.001
    y, rail, sash = room.WINDOW_FRAME_Y, 0.055, 0.060
    middles = [x0 + (x1 - x0) * k / 3 for k in (1, 2)]
    xs = [x0, x0 + rail]
    for middle in middles:
        xs += [middle - rail / 2, middle + rail / 2]
    xs += [x1 - rail, x1]
    zs = (z0, z0 + rail + 0.025, z1 - rail, z1)
    outer = bars(xs, zs, 0.075, lambda i, j: i % 2 == 0 or j != 1)
    parts = [upright(outer).moved(y=y + 0.0755)]
    panes, handles = [], []
    for left, right in zip(xs[1:-1:2], xs[2::2], strict=True):
        us = (left + 0.002, left + sash, right - sash, right - 0.002)
        vs = (zs[1] + 0.002, zs[1] + sash, zs[2] - sash, zs[2] - 0.002)
        leaf = bars(us, vs, 0.055, lambda i, j: (i, j) != (1, 1))
        parts.append(upright(leaf).moved(y=y + 0.047))
        pane = quad((us[1], y + 0.02, vs[1]), (us[2] - us[1], 0, 0), (0, 0, vs[2] - vs[1]))
        panes.append(pane)
        # A stop behind the joint of leaf and frame, so that no light comes round the leaf.
        us = (left + 0.0002, left + 0.02, right - 0.02, right - 0.0002)
        vs = (zs[1] + 0.0002, zs[1] + 0.02, zs[2] - 0.02, zs[2] - 0.0002)
        stop = bars(us, vs, 0.012, lambda i, j: (i, j) != (1, 1))
        parts.append(upright(stop).moved(y=y + 0.060))
        # A bead hides the edge of the pane, as putty or rubber would.
        bead = bars(
            (us[1] - 0.004, us[1] + 0.012, us[2] - 0.012, us[2] + 0.004),
            (vs[1] - 0.004, vs[1] + 0.012, vs[2] - 0.012, vs[2] + 0.004),
            0.012,
            lambda i, j: (i, j) != (1, 1),
        )
        parts.append(upright(bead).moved(y=y + 0.026))
        hold = (left + sash / 2 + 0.001, y - 0.0085, (zs[1] + zs[2]) / 2)
        handles.append(
            rounded_box((0.028, 0.010, 0.07), 0.004).moved(hold[0], hold[1] - 0.005, hold[2])
        )
        path = [(hold[0], hold[1] - 0.006, hold[2]), (hold[0], y - 0.05, hold[2])]
        handles.append(tube(path, 0.007))
        lever = rounded_box((0.020, 0.014, 0.13), 0.006)
        handles.append(lever.moved(hold[0], y - 0.052, hold[2] - 0.05))
    Assembly().add(frame, *parts).build("Window Frame", collection)
    Assembly().add(palette["Window Pane"], *panes).build("Window Panes", collection)
    Assembly().add(steel, *handles).build("Window Handles", collection)

    ears, thick = 0.05, 0.025
    xs = (room.WINDOW_X[0] - ears, x0, x1, room.WINDOW_X[1] + ears)
    ys = (room.DEPTH - 0.12, room.DEPTH - 0.0005, room.WINDOW_FRAME_Y)
    zs = (room.WINDOW_Z[0] - thick + 0.0005, room.WINDOW_Z[0])
    board = blocks(xs, ys, zs, lambda i, j, _: j == 0 or i == 1)
    Assembly().add(palette["White Lacquer"], board).build("Window Sill", collection)
    ledge = box(
        (x1 - x0, 0.12, 0.004), ((x0 + x1) / 2, room.DEPTH + 0.30, room.WINDOW_Z[0] - 0.024)
    )
    outside = Assembly().add(palette["Aluminium"], ledge.moved(y=0.002))
    outside.build("Window Ledge", collection)


def _door(palette, collection):
    y0, y1 = room.DOOR_Y
    x, head = room.WIDTH, room.DOOR_Z
    # Architrave: stands 12 mm proud of the wall and lines the recess.
    us = (y0 - 0.06, y0 + 0.02, y1 - 0.02, y1 + 0.06)
    casing = bars(us, (room.REST, head - 0.02, head + 0.06), 0.012, lambda i, j: i != 1 or j == 1)
    us = (y0 + 0.0005, y0 + 0.02, y1 - 0.02, y1 - 0.0005)
    vs = (room.REST, head - 0.02, head - 0.0005)
    jamb = bars(us, vs, room.DOOR_RECESS - 0.006, lambda i, j: i != 1 or j == 1)
    turn = {"axis": "z", "degrees": 90.0}
    frame = [
        upright(casing).turned(**turn).moved(x=x - 0.0125),
        upright(jamb).turned(**turn).moved(x=x + 0.0002),
    ]
    lacquer = Assembly().add(palette["Grey Lacquer"], *frame)
    lacquer.build("Door Frame", collection)
    width, height = (y1 - y0) - 0.046, head - 0.020 - 0.003 - 0.006
    leaf = rounded_box((0.042, width, height), 0.002)
    leaf = leaf.moved(x + 0.040, (y0 + y1) / 2, 0.006 + height / 2)
    door = Assembly().add(palette["White Lacquer"], leaf)
    door.build("Door Leaf", collection)

    face, y, z = x + 0.019, y1 - 0.09, 1.03
    rose = cylinder(0.026, 0.008, 32, 0.002).turned("y", -90.0)
    knob = [
        (face - 0.006, y, z),
        (face - 0.035, y, z),
        (face - 0.05, y - 0.012, z),
        (face - 0.052, y - 0.12, z),
    ]
    lever = tube(np.array(knob), 0.009, 16)
    key = cylinder(0.009, 0.012, 24, 0.001).turned("y", -90.0)
    steel = Assembly().add(palette["Brushed Steel"], rose.moved(face - 0.0003, y, z), lever)
    steel.add(palette["Brushed Steel"], rose.moved(face - 0.0003, y, z - 0.09))
    steel.add(palette["Chrome"], key.moved(face - 0.004, y, z - 0.09))
    for level in (0.25, 1.03, 1.80):
        steel.add(
            palette["Brushed Steel"],
            cylinder(0.007, 0.09, 16, 0.001).moved(x - 0.021, y0 + 0.022, level),
        )
    steel.build("Door Handle", collection)


def _radiator(palette, collection):
    width, low, high = 2.0, 0.13, 0.73
    ribs = 28
    y = room.DEPTH - 0.075
    front, back = [], []
    for k in range(ribs * 4 + 1):
        x = -width / 2 + width * k / (ribs * 4)
        wave = (0.0, 0.005, 0.005, 0.0)[k % 4] if 3 < k < ribs * 4 - 3 else 0.0
        front.append((x, -0.035 + wave))
    back = [(width / 2, 0.035), (-width / 2, 0.035)]
    body = prism(front + back, high - low).moved(z=low)
    cover = blocks(
        np.linspace(-width / 2 - 0.003, width / 2 + 0.003, 2 * 40 + 2),
        (-0.038, -0.02, 0.02, 0.038),
        (high + 0.0005, high + 0.012),
        lambda i, j, _: j != 1 or i % 2 == 0,
    )
    pipes = []
    for x in (-0.9, -0.85):
        path = [(x, 0.0, low - 0.002), (x, 0.0, 0.04), (x, 0.0, room.REST)]
        pipes.append(tube(np.array(path), 0.009, 16))
        pipes.append(
            lathe([(0.0105, 0.0), (0.024, 0.0), (0.022, 0.008), (0.0105, 0.008)]).moved(
                x, 0.0, room.REST
            )
        )
    valve = tube(
        [(width / 2 + 0.001, 0.0, high - 0.05), (width / 2 + 0.035, 0.0, high - 0.05)], 0.011
    )
    grip = (
        cylinder(0.023, 0.06, 24, 0.006)
        .turned("y", 90.0)
        .moved(width / 2 + 0.034, 0.0, high - 0.05)
    )
    holders = [box((0.03, 0.036, 0.10), (x, 0.0542, high - 0.12)) for x in (-0.7, 0.7)]
    item = Assembly().add(palette["White Steel"], body, cover, *holders)
    item.add(palette["Brushed Steel"], *pipes, valve).add(palette["White Lacquer"], grip)
    item.build("Radiator", collection, (sum(room.WINDOW_X) / 2, y, 0.0))


def _ceiling_grid(palette, collection):
    half = room.FLANGE / 2
    xs, ys = [0.0005], [0.0005]
    for edges, length in ((xs, room.WIDTH), (ys, room.DEPTH)):
        edges.append(half)
        for k in range(1, round(length / room.MODULE)):
            edges += [k * room.MODULE - half, k * room.MODULE + half]
        edges += [length - half, length - 0.0005]
    grid = bars(xs, ys, 0.007, lambda i, j: i % 2 == 0 or j % 2 == 0)
    grid = grid.moved(z=room.HEIGHT - 0.0065)
    Assembly().add(palette["White Steel"], grid).build("Ceiling Grid", collection)


def _ventilation(palette, collection):
    width, height, border = 0.60, 0.20, 0.025
    us, vs = (0, border, width - border, width), (0, border, height - border, height)
    frame = upright(bars(us, vs, 0.012, lambda i, j: (i, j) != (1, 1)))
    parts = [frame]
    for k in range(9):
        blade = box((width - 2 * border - 0.001, 0.014, 0.0015)).turned("x", 35.0)
        parts.append(blade.moved(width / 2, -0.006, border + 0.0085 + k * 0.0165))
    back = box((width - 0.01, 0.001, height - 0.01), (width / 2, 0.0006, height / 2))
    vent = Assembly().add(palette["White Steel"], *[p.moved(y=-0.0005) for p in parts])
    vent.add(palette["Black Plastic"], back)
    at = (room.WIDTH - 0.002, 2.9, room.HEIGHT - 0.32)
    vent.build("Ventilation Grille", collection, at, turn=-90.0)


def _switches(palette, collection):
    plate = rounded_box((0.008, 0.081, 0.081), 0.003)
    rocker = rounded_box((0.006, 0.055, 0.055), 0.002).turned("y", 3.0).moved(x=-0.004)
    item = Assembly().add(palette["White Lacquer"], plate, rocker)
    item.build("Light Switch", collection, (room.WIDTH - 0.0045, room.DOOR_Y[1] + 0.16, 1.05))
    socket = Assembly()
    for k in range(2):
        y = 0.0815 * k
        socket.add(palette["White Lacquer"], plate.moved(y=y))
        ring = lathe([(0.017, 0.0), (0.022, 0.0), (0.022, 0.0025), (0.017, 0.0025)], 24)
        socket.add(palette["White Lacquer"], ring.turned("y", -90.0).moved(-0.0035, y, 0.0))
        holes = [
            cylinder(0.0025, 0.001, 12).turned("y", -90.0).moved(-0.0035, y + s * 0.0095)
            for s in (-1, 1)
        ]
        socket.add(palette["Black Plastic"], *holes)
    socket.build("Sockets", collection, (room.WIDTH - 0.0045, 3.62, 0.30))


def build_architecture(palette, architecture, bake):
    """Build the room; the surfaces whose lux maps are of interest go to ``bake``."""
    _shell(palette, architecture)
    _surfaces(palette, bake)
    _skirting(palette, architecture)
    _window(palette, architecture)
    _door(palette, architecture)
    _radiator(palette, architecture)
    _ceiling_grid(palette, architecture)
    _ventilation(palette, architecture)
    _switches(palette, architecture)
