"""The command ``lumenray rayset prepare``: what scenes need of ray files, kept beside them, and how exact it is."""

from ..file_list import add_files, tell_each
from ..output import percent, sheet
from ..progress import Bar
from .file import add_assumptions, assumed_of


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    prepare = tasks.add_parser(
        "prepare", help="keep beside a ray file what scenes need of it, and tell how exact it is"
    )
    add_files(prepare, "ray file", "*.tm25ray")
    add_assumptions(prepare)
    prepare.set_defaults(run=run)


def run(options) -> int:
    """Prepare files, and tell about them; return the exit code."""
    from ...engine.raysets.emission import Wish
    from ...engine.raysets.file_names import ENDINGS
    from ...engine.raysets.index import index_path, obtain_light

    wish = Wish(assumed=assumed_of(options))

    def prepare(name):
        with Bar(name) as bar:
            light = obtain_light(name, wish, is_kept=True, progress=bar.share)
        return {**describe(light), "index": str(index_path(name))}

    return tell_each(options, ENDINGS, prepare, tell)


def describe(light) -> dict:
    """What is to be known of a prepared light, in JSON's terms."""
    emission = light.emission
    return {
        "rays": light.rays,
        "rays_held": len(emission.threshold),
        "body": light.body,
        "is_rotational": emission.axis is not None,
        "size_m": emission.size,
        "information_error": emission.information_error,
        "near_m": emission.near,
        "far_field": [
            {"distance_m": distance, "error": error}
            for distance, error in zip(emission.far_distances, emission.far_errors, strict=True)
        ],
        "warnings": [str(remark) for remark in light.remarks],
    }


def tell(row: dict) -> str:
    """Text for people about a prepared file."""
    far = [
        f"wrong by {percent(entry['error'], '.2g')} at {1e3 * entry['distance_m']:.3g} mm "
        f"({entry['distance_m'] / row['size_m']:g} sizes)"
        for entry in row["far_field"]
    ]
    own = percent(row["information_error"], ".2g")
    return sheet(
        row["file"],
        [
            ("rays held", f"{row['rays_held']} of {row['rays']}"),
            ("they start from", row["body"] + ", even about its axis" * row["is_rotational"]),
            ("own error", f"{own} of the light in a 192nd part of it"),
            ("as a point", far),
            ("as rays", f"within {1e3 * row['near_m']:.3g} mm, as a point beyond"),
            ("warnings", row["warnings"]),
            ("kept in", row["index"]),
        ],
    )
