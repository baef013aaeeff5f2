"""Damage to text files, of the kinds that disks, editors, mail and hostile people do."""

import re

import numpy as np

NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?")

NUMBERS = [
    *b"0 -0 1 -1 2 0.5 -0.5 90 180 360 400 nan NaN inf -inf Infinity 1e308 -1e308 1e309".split(),
    *b"1e-300 1e-320 1e30 1.0D3 1,5 1.2.3 1_000 0x10 99999999 999999999999999999999 4294967296".split(),
    *b"65536 2147483647 -2147483648 3.0 3.5 .5 5. + - . e1 ** N/A".split(),
]
"""What numbers are replaced by: signs, limits, other notations and things that are none."""

MAXIMUM_GROWTH = 4096
"""Longest piece that is doubled, so that repeated damage does not make huge files. [byte]"""


def mutate(data: bytes, rng: np.random.Generator) -> bytes:
    """Return the data with one to five random damages."""
    for _ in range(rng.integers(1, 6)):
        data = _DAMAGES[rng.integers(len(_DAMAGES))](data, rng)
    return data


def damage(data, rng):
    """Any damage, or that of a few numbers and of a line, which leaves the file alive for longer."""
    if rng.integers(2):
        return mutate(data, rng)
    for _ in range(rng.integers(1, 3)):
        found = list(NUMBER.finditer(data))
        match = found[rng.integers(len(found))]
        data = data[: match.start()] + NUMBERS[rng.integers(len(NUMBERS))] + data[match.end() :]
    lines = data.splitlines(keepends=True)
    place = int(rng.integers(len(lines)))
    lines[place : place + 1] = lines[place : place + 1] * int(rng.choice([0, 1, 1, 1, 1, 2]))
    return b"".join(lines)


def _place(size: int, rng) -> int:
    return int(rng.integers(size + 1))


def _flip_byte(data, rng):
    if not data:
        return data
    at = int(rng.integers(len(data)))
    return data[:at] + bytes([data[at] ^ (1 << int(rng.integers(8)))]) + data[at + 1 :]


def _set_byte(data, rng):
    if not data:
        return data
    at = int(rng.integers(len(data)))
    return data[:at] + bytes([int(rng.integers(256))]) + data[at + 1 :]


def _insert_bytes(data, rng):
    at = _place(len(data), rng)
    pieces = [
        rng.bytes(int(rng.integers(1, 9))),
        b"\0",
        b"\x1a",
        b"\r",
        b"\n",
        b"\t",
        b",",
        b" ",
        b"-",
    ]
    return data[:at] + pieces[rng.integers(len(pieces))] + data[at:]


def _delete_bytes(data, rng):
    at = _place(len(data), rng)
    return data[:at] + data[at + int(rng.integers(1, 40)) :]


def _double_piece(data, rng):
    at = _place(len(data), rng)
    piece = data[at : at + int(rng.integers(1, MAXIMUM_GROWTH))]
    return data[:at] + piece + data[at:]


def _truncate(data, rng):
    return data[: _place(len(data), rng)]


def _drop_start(data, rng):
    return data[_place(len(data), rng) :]


def _with_lines(change):
    """Damage of a list of lines, in place, as one of bytes."""

    def damage(data, rng):
        lines = data.splitlines(keepends=True)
        if lines:
            change(lines, rng)
        return b"".join(lines)

    return damage


def _delete_line(lines, rng):
    del lines[rng.integers(len(lines))]


def _double_line(lines, rng):
    at = int(rng.integers(len(lines)))
    lines.insert(at, lines[at][:MAXIMUM_GROWTH])


def _swap_lines(lines, rng):
    a, b = rng.integers(len(lines), size=2)
    lines[a], lines[b] = lines[b], lines[a]


def _join_lines(lines, rng):
    at = int(rng.integers(len(lines)))
    lines[at] = lines[at].rstrip(b"\r\n")


def _blank_line(lines, rng):
    lines.insert(_place(len(lines), rng), b"\r\n")


def _with_number(change):
    """Damage of one number of the text; ``change`` returns what it becomes."""

    def damage(data, rng):
        found = list(NUMBER.finditer(data))
        if not found:
            return data
        match = found[rng.integers(len(found))]
        return data[: match.start()] + change(match.group(), rng) + data[match.end() :]

    return damage


def _replace_number(_, rng):
    return NUMBERS[rng.integers(len(NUMBERS))]


def _double_number(token, _):
    return token + b" " + token


def _delete_number(*_):
    return b""


def _negate_number(token, _):
    return token[1:] if token.startswith(b"-") else b"-" + token


def _lengthen_number(token, rng):
    return token + bytes(rng.choice(np.frombuffer(b"0123456789.eE", np.uint8), 3))


def _nudge_number(token, rng):
    return b"%d" % (int(token) + int(rng.integers(-2, 3))) if token.isdigit() else token


def _comma_decimals(data, _):
    return data.replace(b".", b",")


def _mac_ends(data, _):
    return data.replace(b"\r\n", b"\r").replace(b"\n", b"\r")


def _other_encoding(data, rng):
    return data.decode("latin-1").encode(("utf-16", "utf-8-sig", "utf-16-le")[rng.integers(3)])


def _change_case(data, _):
    return data.swapcase()


_TEXT_DAMAGES = [
    *map(_with_lines, (_delete_line, _double_line, _swap_lines, _join_lines, _blank_line)),
    _with_number(_double_number),
    _with_number(_delete_number),
    _with_number(_negate_number),
    _with_number(_lengthen_number),
    _with_number(_nudge_number),
]

_DAMAGES = [
    *_TEXT_DAMAGES,
    *_TEXT_DAMAGES,
    # The commonest in hostile files, so weighted.
    *[_with_number(_replace_number)] * 6,
    *(_flip_byte, _set_byte, _insert_bytes, _delete_bytes, _double_piece) * 2,
    *(_truncate, _drop_start, _comma_decimals, _mac_ends, _other_encoding, _change_case),
]
