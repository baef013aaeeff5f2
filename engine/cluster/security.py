"""Addresses of clusters, and who may be talked to over them: off the machine itself only with certificates of both ends."""

import ipaddress
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

from ..errors import LumenrayError

PORT = 8786
"""Where schedulers listen if nothing else is said."""

OPTIONS = "--tls-ca, --tls-cert and --tls-key"


@dataclass(frozen=True)
class Certificates:
    """Files in PEM: who is trusted, who we are, and what proves it."""

    authority: Path
    certificate: Path
    key: Path


@dataclass(frozen=True)
class Address:
    """Where a scheduler is. ``protocol``: ``tls`` or ``tcp``."""

    protocol: str
    host: str
    port: int

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{self.protocol}://{host}:{self.port}"

    @property
    def is_own_machine(self) -> bool:
        """Whether nobody outside this machine can listen. Names other than ``localhost`` are not asked for."""
        if self.host == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False


def read_address(text: str) -> Address:
    """Read an address such as ``tls://render.office:8786``; tcp and the usual port where they are not said.

    Raises
    ------
    LumenrayError    It is none.
    """
    whole = text if "://" in text else f"tcp://{text}"
    try:
        parts = urlsplit(whole)
        host, port = parts.hostname, parts.port
    except ValueError:
        host, port = None, None
    is_more = host and (parts.path or parts.query or parts.fragment or parts.username)
    is_word = host and not any(letter.isspace() for letter in host)
    if not is_word or is_more or parts.scheme not in ("tcp", "tls"):
        raise LumenrayError(
            f"'{text}' is no address of a cluster: expected tls://HOST:PORT, or tcp://127.0.0.1:PORT on this machine"
        )
    return Address(parts.scheme, host, PORT if port is None else port)


def check_address(address: Address, certificates: Certificates | None) -> None:
    """Refuse to talk where others can listen or answer.

    Raises
    ------
    LumenrayError    The line leaves the machine without TLS, or there is TLS without certificates, or a file is missing.
    """
    if address.protocol == "tcp" and not address.is_own_machine:
        raise LumenrayError(
            f"{address} leaves this machine without TLS, so that anybody on the way could run code on both ends: use "
            f"tls://{address.host}:{address.port} with {OPTIONS}"
        )
    if address.protocol == "tls" and certificates is None:
        raise LumenrayError(f"{address} needs certificates: give {OPTIONS}")
    if certificates is not None:
        for path in (certificates.authority, certificates.certificate, certificates.key):
            if not path.is_file():
                raise LumenrayError(f"{path}: no such file, expected a certificate or key in PEM")


def make_security(address: Address, certificates: Certificates | None):
    """Dask's `Security`: both ends show certificates of the same authority; plain lines only where `check_address` allows.

    Raises
    ------
    LumenrayError    As of `check_address`.
    """
    from distributed.security import Security

    check_address(address, certificates)
    if address.protocol == "tcp":
        return Security(require_encryption=False)
    # Dask asks both ends for a certificate of this authority (ssl.CERT_REQUIRED); host names do not count.
    ca, cert, key = (
        str(each) for each in (certificates.authority, certificates.certificate, certificates.key)
    )
    ends = {
        f"tls_{end}_{part}": path
        for end in ("client", "scheduler", "worker")
        for part, path in (("cert", cert), ("key", key))
    }
    return Security(tls_ca_file=ca, require_encryption=True, **ends)
