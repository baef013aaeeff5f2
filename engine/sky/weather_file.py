"""The door of weather files, whatever their format."""

from ..errors import FileFormatError
from ..reading.content import read_bytes
from . import epw, wea
from .weather import Weather

MAXIMUM_SIZE = 32 << 20
"""Larger files are not read: a year by the minute has 90 MB, by five minutes 18. [byte]"""


def read_weather(path) -> Weather:
    """Read a weather file, EPW or WEA by its content.

    Raises
    ------
    FileFormatError    It is neither, or something is wrong; names the line.
    """
    data = read_bytes(path, MAXIMUM_SIZE)
    for reader in (epw, wea):
        if reader.is_own(data):
            return reader.parse(path, data)
    raise FileFormatError(
        path, "is no weather file: expected EPW, which begins with LOCATION, or WEA, with place"
    )
