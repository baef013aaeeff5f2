"""Addresses of clusters: plain lines stay on the machine."""

import shutil
import ssl
import subprocess
import sys
from pathlib import Path

import pytest

from lumenray.engine.cluster.dask_crew import load_dask
from lumenray.engine.cluster.security import (
    Certificates,
    check_address,
    make_security,
    read_address,
)
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


@pytest.fixture(scope="module")
def certificates(tmp_path_factory):
    """Files that openssl has made: an authority that is its own certificate."""
    folder = tmp_path_factory.mktemp("certificates")
    openssl = shutil.which("openssl")
    if openssl is None:
        pytest.skip("openssl is not there")
    files = Certificates(folder / "own.pem", folder / "own.pem", folder / "own.key")
    subprocess.run(
        [openssl, "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes",
         "-subj", "/CN=cluster", "-keyout", files.key, "-out", files.certificate],
        check=True, capture_output=True,
    )  # fmt: skip
    return files


def test_both_ends_have_to_show_a_certificate(certificates):
    pytest.importorskip("distributed")
    security = make_security(read_address("tls://render.office"), certificates)
    assert security.require_encryption
    for role in ("scheduler", "worker"):
        listening = security.get_listen_args(role)["ssl_context"]
        assert listening.verify_mode is ssl.CERT_REQUIRED
    for role in ("client", "scheduler", "worker"):
        calling = security.get_connection_args(role)["ssl_context"]
        assert calling.verify_mode is ssl.CERT_REQUIRED


def test_without_dask_somebody_is_told_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(LumenrayError, match=r"clusters need Dask.*pip install lumenray\[cluster\]"):
        load_dask()


def test_commands_load_dask_only_where_a_cluster_is_asked_for():
    code = (
        "import sys; from lumenray.command_line.main import build_parser; "
        "build_parser('cluster'); build_parser('ink'); "
        "sys.exit('dask' in sys.modules or 'distributed' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
