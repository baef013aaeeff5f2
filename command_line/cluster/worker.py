"""The command ``lumenray cluster worker``: computes for a cluster."""

from ..cluster_options import add_certificates, certificates_of
from ..options import whole
from ..output import say


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    worker = tasks.add_parser("worker", help="compute for a cluster")
    words = "of the scheduler, such as tls://render.office:8786"
    worker.add_argument("address", metavar="ADDRESS", help=words)
    worker.add_argument(
        "--threads",
        type=whole(1, 1024),
        metavar="N",
        help="that compute (default: one for each processor)",
    )
    add_certificates(worker)
    worker.set_defaults(run=run)


def run(options) -> int:
    """Be a worker until Ctrl-C, or until the scheduler is gone; return the exit code."""
    from ...engine.cluster import hosts
    from ...engine.cluster.security import read_address

    address = read_address(options.address)

    def tell(own: str) -> None:
        say(f"worker at {own} of {address}")

    hosts.run_worker(address, certificates_of(options), options.threads, tell)
    return 0
