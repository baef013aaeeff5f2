"""Packed blocks."""

from lumenray.engine.reading.blocks import unpack_lz4


def test_lz4_repeats_what_was_unpacked():
    # One plain letter, 19 more from one place back, then one plain letter.
    assert unpack_lz4(b"\x1fa\x01\x00\x00\x10b", 21) == b"a" * 20 + b"b"
    assert unpack_lz4(b"\x32abc\x03\x00\x10!", 10) == b"abcabcabc!"
    # Too far back, and another size than stated.
    assert unpack_lz4(b"\x1fa\x02\x00\x00\x10b", 21) is None
    assert unpack_lz4(b"\x1fa\x01\x00\x00\x10b", 20) is None
