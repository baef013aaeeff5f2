"""The command ``lumenray cluster scheduler``: hands out the work of a cluster."""

from ..cluster_options import add_certificates, certificates_of
from ..output import say


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    scheduler = tasks.add_parser("scheduler", help="hand out the work of a cluster")
    words = "where it listens, such as tls://render.office:8786"
    scheduler.add_argument("address", metavar="ADDRESS", help=words)
    add_certificates(scheduler)
    scheduler.set_defaults(run=run)


def run(options) -> int:
    """Be a scheduler until Ctrl-C; return the exit code."""
    from ...engine.cluster import hosts
    from ...engine.cluster.security import read_address

    address = read_address(options.address)
    hosts.run_scheduler(address, certificates_of(options), lambda own: say(f"scheduler at {own}"))
    return 0
