"""Options by which commands compute on a cluster, and the session that they then compute with."""

from contextlib import contextmanager
from pathlib import Path

from ..engine.errors import LumenrayError


def add_cluster(parser) -> None:
    """Let a command compute on a cluster."""
    group = parser.add_argument_group("cluster (default: this machine computes)")
    group.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="scheduler whose workers compute, such as tls://render.office:8786; tcp:// only on this machine",
    )
    add_certificates(group)


def add_certificates(group) -> None:
    """Let a command show who it is; off the machine that is needed."""
    group.add_argument("--tls-ca", type=Path, metavar="CA.pem", help="authority that is trusted")
    group.add_argument(
        "--tls-cert", type=Path, metavar="CERT.pem", help="own certificate, of that authority"
    )
    group.add_argument("--tls-key", type=Path, metavar="KEY.pem", help="its key")


def certificates_of(options):
    """Return the certificates that a command was told of, None if none were.

    Raises
    ------
    LumenrayError    Only some of the three are there.
    """
    from ..engine.cluster.security import OPTIONS, Certificates

    files = options.tls_ca, options.tls_cert, options.tls_key
    if all(path is None for path in files):
        return None
    if any(path is None for path in files):
        raise LumenrayError(f"TLS needs all of {OPTIONS}")
    return Certificates(*files)


@contextmanager
def open_crew(options):
    """Give the workers of the cluster that a command was told of; None without one.

    Raises
    ------
    LumenrayError    The address may not be used, Dask is not installed, or nobody answers.
    """
    if options.cluster is None:
        if certificates_of(options) is not None:
            raise LumenrayError("certificates are for --cluster, which was not given")
        yield None
        return
    from ..engine.cluster.dask_crew import DaskCrew
    from ..engine.cluster.security import read_address

    crew = DaskCrew(read_address(options.cluster), certificates_of(options))
    try:
        yield crew
    finally:
        crew.close()


@contextmanager
def open_engine(options):
    """Give an empty session that computes on the cluster that a command was told of, or on this machine."""
    with open_crew(options) as crew:
        if crew is None:
            from ..engine.session import Session

            yield Session()
        else:
            from ..engine.cluster.session import ClusterSession

            yield ClusterSession(crew)
