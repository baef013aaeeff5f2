"""The command ``lumenray glare``: glare of luminance pictures."""

import math

from .file_list import add_files, tell_each
from .options import real
from .output import sheet

ENDINGS = (".exr", ".hdr", ".pic")
"""Ends of the names that are taken from a folder."""

VIEWS = ("perspective", "equirectangular", "equidistant", "equisolid", "orthographic")

MOST_SOURCES = 12
"""Sources that are told one by one."""

EPILOG = """examples:
  lumenray glare desk.exr
  lumenray glare fisheye.hdr --threshold 1000
  lumenray glare photo.exr --view equidistant --angle 180

Pictures are OpenEXR files with luminances (those of lumenray render say their view) or Radiance pictures. They are taken for
what an eye sees that looks along their axis; what lies behind it does not count. DGP and DGI need all that is before the
eye: a fisheye of 180 degrees or an equirectangular picture.
"""


def add_command(commands) -> None:
    """Describe the command to argparse."""
    glare = commands.add_parser(
        "glare", help="glare of luminance pictures: DGP, DGI, UGR, veiling luminance", epilog=EPILOG
    )
    add_files(glare, "luminance picture (.exr, .hdr)", "*.exr")
    glare.add_argument(
        "--view",
        choices=VIEWS,
        help="how the picture was taken (default: as the file says); fisheyes are equidistant, equisolid, orthographic",
    )
    glare.add_argument(
        "--angle",
        type=real(1e-3, 360.0),
        metavar="DEG",
        help="full angle across such a picture (default: 180, equirectangular 360); pixels are taken for square",
    )
    glare.add_argument(
        "--threshold",
        type=real(),
        default=2000.0,
        metavar="CD",
        help="luminance above which pixels are part of glare sources, in cd/m2 (default: 2000)",
    )
    glare.set_defaults(run=run)


def run(options) -> int:
    """Tell of the glare of pictures; return the exit code."""
    from ..engine.errors import LumenrayError

    if options.angle is not None and options.view is None:
        raise LumenrayError("--angle is of a picture whose --view is stated as well")
    return tell_each(options, ENDINGS, lambda name: describe(name, options), tell)


def describe(name: str, options) -> dict:
    """Row of a picture for JSON: numbers with their unit in the key, None where one has no meaning.

    Raises
    ------
    LumenrayError    The picture cannot be read or rated, or its view is not known.
    """
    from ..engine.analysis.picture_glare import rate_picture
    from ..engine.errors import FileFormatError
    from ..engine.formats.luminance_picture import read_luminance

    luminance, view = read_luminance(name)
    if options.view is not None:
        view = _stated_view(options, luminance.shape)
    if view is None:
        raise FileFormatError(name, "does not say its view; state --view and --angle")
    made = rate_picture(luminance, view, options.threshold)
    sources = made.sources
    return {
        "view": view.mapping.value,
        "size": [view.width, view.height],
        "solid_angle_sr": made.solid_angle,
        "vertical_illuminance_lx": made.illuminance,
        "direct_illuminance_lx": made.direct_illuminance,
        "mean_luminance_cd_per_m2": made.mean,
        "background_luminance_cd_per_m2": made.background,
        "threshold_cd_per_m2": options.threshold,
        "dgp": made.dgp,
        "dgi": made.dgi,
        "ugr": made.ugr,
        "veiling_luminance_cd_per_m2": made.veiling,
        "sources": [
            {
                "luminance_cd_per_m2": float(each),
                "solid_angle_sr": float(solid),
                "illuminance_lx": float(lux),
                "position_index": float(index),
                "off_axis_deg": math.degrees(math.acos(min(max(-float(towards[2]), -1.0), 1.0))),
            }
            for each, solid, lux, index, towards in zip(
                sources.luminances,
                sources.solid_angles,
                sources.illuminances,
                made.indices,
                sources.directions,
                strict=True,
            )
        ],
        "warnings": _warnings(made),
    }


def _stated_view(options, shape):
    from ..engine.analysis.picture_view import Mapping, PictureView

    height, width = shape
    mapping = Mapping[options.view.upper()]
    whole = 360.0 if mapping is Mapping.EQUIRECTANGULAR else 180.0
    across = math.radians(options.angle or (90.0 if mapping is Mapping.PERSPECTIVE else whole))
    ratio = height / width
    along = {
        Mapping.PERSPECTIVE: lambda: 2.0 * math.atan(ratio * math.tan(0.5 * across)),
        Mapping.EQUISOLID: lambda: 4.0 * math.asin(min(ratio * math.sin(0.25 * across), 1.0)),
        Mapping.ORTHOGRAPHIC: lambda: 2.0 * math.asin(min(ratio * math.sin(0.5 * across), 1.0)),
    }.get(mapping, lambda: ratio * across)()
    return PictureView.of_angles(mapping, width, height, across, along)


def _warnings(made) -> list[str]:
    said = []
    if made.solid_angle < 0.98 * 2.0 * math.pi:
        share = 100.0 * made.solid_angle / (2.0 * math.pi)
        said.append(
            f"the picture shows {share:.0f} % of what is before the eye: illuminance, DGP and DGI are of that part alone"
        )
    if made.dgp < 0.2:
        said.append("a DGP below 0.2 is outside what it was found for (0.2 to 0.8)")
    return said


def tell(row: dict) -> str:
    """Text for people about a row of `describe`."""
    return sheet(row["file"], _lines(row))


def _lines(row):
    width, height = row["size"]
    yield (
        "view",
        f"{row['view']}, {width} x {height} pixels, {row['solid_angle_sr']:.4g} sr before the eye",
    )
    direct = f"{row['direct_illuminance_lx']:.4g} lx of it from glare sources"
    yield "illuminance", f"{row['vertical_illuminance_lx']:.4g} lx at the eye, {direct}"
    background = f"background {row['background_luminance_cd_per_m2']:.4g} cd/m2"
    yield "luminance", f"mean {row['mean_luminance_cd_per_m2']:.4g} cd/m2, {background}"
    yield "DGP", f"{row['dgp']:.3f}"
    for name in ("DGI", "UGR"):
        value = row[name.lower()]
        yield name, "no glare source" if value is None else f"{value:.1f}"
    yield "veiling luminance", f"{row['veiling_luminance_cd_per_m2']:.4g} cd/m2"
    told = [
        f"{each['luminance_cd_per_m2']:.4g} cd/m2, {each['solid_angle_sr']:.3g} sr, {each['off_axis_deg']:.1f} deg off, "
        f"position index {each['position_index']:.3g}, {each['illuminance_lx']:.4g} lx"
        for each in row["sources"][:MOST_SOURCES]
    ]
    if len(row["sources"]) > MOST_SOURCES:
        told.append(f"and {len(row['sources']) - MOST_SOURCES} more")
    yield f"sources ({len(row['sources'])})", told
    yield "warnings", row["warnings"]
