"""Small TM-33 documents, and what was read of them."""

import numpy as np
import pytest

from lumenray.engine.errors import FileFormatError
from lumenray.engine.luminaires.distribution import intensity
from lumenray.engine.luminaires.formats.tm33.reader import parse_tm33


def data(rows, extra=""):
    """Elements of a table of (h, v, value)."""
    items = "\n".join(f'<IntData h="{h}" v="{v}">{value}</IntData>' for h, v, value in rows)
    return f"{extra}<NumberMeasured>{len(rows)}</NumberMeasured>\n{items}"


def luminous(rows, extra="<AbsolutePhotometry>true</AbsolutePhotometry>", tail=""):
    return f"<LuminousData><LuminousIntensity>{data(rows, extra)}</LuminousIntensity>{tail}</LuminousData>"


def emitter(*content):
    return (
        "<Emitter><Quantity>1</Quantity><Description>LED</Description>"
        + "\n".join(content)
        + "</Emitter>"
    )


def document(*emitters, goniometer="IES_C", root="IESTM33", body=(1.2, 0.3, 0.06)):
    """A document, which departs from nothing if its emitters do not."""
    length, width, height = body
    equipment = (
        f"<Gonioradiometer><Type>{goniometer}</Type></Gonioradiometer>" if goniometer else ""
    )
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<{root} xmlns="http://example.org/any">
<Version>1.0</Version>
<Header><Manufacturer>A &amp; B</Manufacturer><CatalogNumber>L-1</CatalogNumber>
<Description>Lamp</Description><Laboratory>Lab</Laboratory><ReportNumber>R1</ReportNumber>
<ReportDate>2024-05-06</ReportDate><Comment>one</Comment><Comment>two</Comment></Header>
<Luminaire><Dimensions><Length>{length}</Length><Width>{width}</Width><Height>{height}</Height></Dimensions>
<NumEmitter>{len(emitters)}</NumEmitter></Luminaire>
<Equipment>{equipment}</Equipment>
{"".join(emitters)}
</{root}>""".encode()


def parsed(*emitters, **kinds):
    return parse_tm33(document(*emitters, **kinds), "a.xml")


def refused(*emitters, **kinds):
    with pytest.raises(FileFormatError) as caught:
        parsed(*emitters, **kinds)
    assert str(caught.value).startswith("a.xml, line ")
    return caught.value


def grid(planes, polars=(0, 45, 90)):
    """Rows of a table from the values at 45 (or the middle) of each plane; 300 below, 0 at the horizontal."""
    return [
        (h, v, value)
        for h, middle in planes.items()
        for v, value in zip(polars, (300, middle, 0), strict=True)
    ]


def at_45(file, *azimuths):
    c = np.deg2rad(azimuths)
    return intensity(file.distribution, np.stack([np.cos(c), np.sin(c), -np.ones_like(c)], axis=1))


UNIFORM = [(0, 0, 100), (0, 90, 100), (0, 180, 100)]

FLAT = [(400, 1.0), (500, 1.0), (600, 1.0), (700, 1.0)]


def spectral(pairs, extra=""):
    items = "".join(f'<PwrData w="{w}">{value}</PwrData>' for w, value in pairs)
    return (
        "<SpectralData><EmitterSpectral>"
        f"<NumberWavelength>{len(pairs)}</NumberWavelength>{extra}{items}</EmitterSpectral></SpectralData>"
    )


FINE = [(nm, 1.0 if 400 < nm < 760 else 0.0) for nm in range(380, 785, 5)]
