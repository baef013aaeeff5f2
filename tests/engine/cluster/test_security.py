"""Addresses of clusters: plain lines stay on the machine."""

from pathlib import Path

import pytest

from lumenray.engine.cluster.security import Certificates, check_address, read_address
from lumenray.engine.errors import LumenrayError

FILES = Certificates(Path("ca.pem"), Path("own.pem"), Path("own.key"))


@pytest.mark.parametrize(
    ("text", "whole"),
    [
        ("tcp://127.0.0.1:9000", "tcp://127.0.0.1:9000"),
        ("localhost", "tcp://localhost:8786"),
        ("tls://render.office", "tls://render.office:8786"),
        ("tcp://[::1]:8786", "tcp://[::1]:8786"),
    ],
)
def test_addresses_are_read(text, whole):
    assert str(read_address(text)) == whole


@pytest.mark.parametrize(
    "text", ["", "http://here", "tcp://", "tcp://here:99999", "tls://here/path", "tcp://a@here"]
)
def test_what_is_no_address_is_refused(text):
    with pytest.raises(LumenrayError, match="no address of a cluster: expected tls://HOST:PORT"):
        read_address(text)


@pytest.mark.parametrize("host", ["127.0.0.1", "127.3.2.1", "localhost", "[::1]"])
def test_plain_lines_may_stay_on_the_machine(host):
    check_address(read_address(f"tcp://{host}:8786"), None)


# A name may mean the machine itself today and another one tomorrow.
@pytest.mark.parametrize(
    "host", ["[::]", "192.168.1.5", "render.office", "[fe80::1]", "127.0.0.1.evil.example"]
)
def test_plain_lines_off_the_machine_are_refused(host):
    with pytest.raises(LumenrayError, match="leaves this machine without TLS"):
        check_address(read_address(f"tcp://{host}:8786"), None)


def test_tls_needs_certificates_that_are_there():
    with pytest.raises(LumenrayError, match="needs certificates: give --tls-ca"):
        check_address(read_address("tls://render.office"), None)
    with pytest.raises(LumenrayError, match=r"ca\.pem: no such file"):
        check_address(read_address("tls://render.office"), FILES)
