"""What the pen writes: only letters that its font has."""

import pytest

from lumenray.engine.analysis.canvas import open_chart
from lumenray.engine.analysis.letters import plain_letters
from lumenray.libraries.cities.catalogue import shipped_cities


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("Tromsø, Köln, Łódź", "Tromso, Koln, Lodz"),
        ("Straße 7–9 ‘a’", "Strasse 7-9 'a'"),  # noqa: RUF001
        ("0–5 cd/m²", "0-5 cd/m2"),
        ("30° of 5 µm", "30° of 5 um"),
        ("東京", "??"),
        ("plain", "plain"),
    ],
)
def test_texts_keep_what_they_say(text, written):
    assert plain_letters(text) == written


def test_font_has_every_letter_of_the_cities():
    canvas = open_chart((200, 200), dark=False)
    font = canvas._font(12)
    nothing = bytes(font.getmask("\u0e01"))
    for city in shipped_cities():
        shown = plain_letters(city.title)
        assert "?" not in shown
        assert all(bytes(font.getmask(sign)) != nothing for sign in shown), city.title


def test_lengths_are_those_of_what_is_written():
    canvas = open_chart((200, 200), dark=False)
    assert canvas.measure("Köln", 12) == canvas.measure("Koln", 12)
