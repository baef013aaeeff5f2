"""The command ``lumenray luminaire ugr``: tables of unified glare ratings from photometric files."""

from ..file_list import add_files, tell_each
from ..options import real
from ..output import table
from .info import ENDINGS


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    ugr = tasks.add_parser("ugr", help="table of unified glare ratings (CIE 190)")
    add_files(ugr, "IES, EULUMDAT or TM-33 file", "*.ldt")
    ugr.add_argument(
        "--spacing",
        type=real(),
        default=0.25,
        metavar="H",
        help="between luminaires, in heights above the eye (default: 0.25, as makers' tables have it)",
    )
    ugr.set_defaults(run=run)


def run(options) -> int:
    """Tell the tables of files; return the exit code."""
    from ...engine.luminaires.formats.reader import read_luminaire

    def describe_file(name):
        return describe(read_luminaire(name), options.spacing)

    return tell_each(options, ENDINGS, describe_file, tell)


def describe(file, spacing: float) -> dict:
    """Row of a photometric file for JSON: ratings by room, view and reflectances; None where nothing that shines is seen."""
    from ...engine.analysis.ugr_table import HEIGHT, REFLECTANCES, ROOMS, VIEWS, find_ugr_table

    made = find_ugr_table(file, spacing)
    return {
        "spacing_h": spacing,
        "h_m": HEIGHT,
        "reflectances": [list(each) for each in REFLECTANCES],
        "views": list(VIEWS),
        "rooms": [
            {"x_h": x, "y_h": y, **dict(zip(VIEWS, values, strict=True))}
            for (x, y), values in zip(ROOMS, made.values, strict=True)
        ],
        "warnings": [str(remark) for remark in file.remarks],
    }


def tell(row: dict) -> str:
    """Text for people about a row of `describe`."""
    heads = ["/".join(f"{100 * each:.0f}" for each in rho) for rho in row["reflectances"]]
    views, columns = row["views"], len(heads)
    lines = [
        ["X x Y", *(view if i == 0 else "" for view in views for i in range(columns))],
        ["ceiling/walls/plane", *heads * len(views)],
    ]
    for room in row["rooms"]:
        values = [value for view in views for value in room[view]]
        cells = ["-" if value is None else f"{value:.1f}" for value in values]
        lines.append([f"{room['x_h']}H x {room['y_h']}H", *cells])
    title = f"{row['file']}: UGR, luminaires {row['h_m']:g} m (H) above the eye, {row['spacing_h']:g} H apart"
    return "\n".join([title, table(lines), *(f"  {text}" for text in row["warnings"])])
