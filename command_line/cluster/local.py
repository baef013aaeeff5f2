"""The command ``lumenray cluster local``: a scheduler and workers on this machine, for trying."""

import time

from ...engine.errors import EngineLost
from ..options import whole
from ..output import say


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    local = tasks.add_parser("local", help="start a scheduler and workers here, for trying")
    local.add_argument(
        "-n", "--workers", type=whole(1, 256), default=2, metavar="N", help="workers (default: 2)"
    )
    local.add_argument(
        "--port", type=whole(1, 65535), metavar="P", help="of the scheduler (default: 8786)"
    )
    local.add_argument(
        "--threads",
        type=whole(1, 1024),
        metavar="N",
        help="of each worker (default: the processors shared out)",
    )
    local.set_defaults(run=run)


def run(options) -> int:
    """Keep a cluster on this machine until Ctrl-C; return the exit code."""
    from ...engine.cluster.hosts import LocalCluster
    from ...engine.cluster.security import PORT

    with LocalCluster(options.workers, options.port or PORT, options.threads) as cluster:
        address, count = cluster.address, len(cluster.workers)
        say(f"{count} workers at {address}: --cluster {address} has them compute, Ctrl-C ends them")
        try:
            while cluster.scheduler.is_running:
                time.sleep(0.5)
        except KeyboardInterrupt:
            say("ended")
            return 0
    raise EngineLost("the scheduler ended by itself; free memory and start it again")
