"""The commands ``lumenray cluster``: a scheduler, workers, and both on this machine for trying."""

from ..options import add_group
from . import local, scheduler, worker

EPILOG = """examples:
  lumenray cluster local -n 2
  lumenray measure office.blend -o lux.csv --cluster tcp://127.0.0.1:8786

  lumenray cluster scheduler tls://render.office:8786 --tls-ca ca.pem --tls-cert own.pem --tls-key own.key
  lumenray cluster worker tls://render.office:8786 --tls-ca ca.pem --tls-cert own.pem --tls-key own.key

Who holds a certificate of the authority can run code on all machines of the cluster: give none to strangers.
"""


def add_command(commands) -> None:
    """Describe the commands to argparse."""
    words = "processes that compute for others"
    add_group(commands, "cluster", words, EPILOG, (local, scheduler, worker))
