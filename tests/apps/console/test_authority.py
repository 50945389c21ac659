"""The installation's own authority: what devices that trust it take, and what they don't."""

from __future__ import annotations

import ipaddress
import os
import ssl
import stat
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from virtualrobot.errors import InvalidArgumentError
from virtualrobot_apps.console.authority import is_local, local_addresses, own_certificate


def shake_hands(served: Path, trusted: Path, name: str) -> None:
    """Have a client that trusts an authority meet a server by a name; raise SSLError when it doesn't take it."""
    server_side = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    server_side.load_cert_chain(served)
    client_side = ssl.create_default_context(cafile=str(trusted))
    up, down = ssl.MemoryBIO(), ssl.MemoryBIO()
    client = client_side.wrap_bio(down, up, server_hostname=name)
    server = server_side.wrap_bio(up, down, server_side=True)
    waiting = [client, server]
    while waiting:
        for side in tuple(waiting):
            try:
                side.do_handshake()
                waiting.remove(side)
            except ssl.SSLWantReadError:
                pass


def test_devices_that_trust_it_take_the_machine_by_its_addresses_and_names(tmp_path: Path) -> None:
    own = own_certificate(["cell.local", "192.168.7.7"], tmp_path / "own")
    for name in ("cell.local", "192.168.7.7", "localhost", *local_addresses()):
        shake_hands(own.file, own.authority, name)
    with pytest.raises(ssl.SSLCertVerificationError, match="match"):
        shake_hands(own.file, own.authority, "other.local")
    other = own_certificate((), tmp_path / "other")
    with pytest.raises(ssl.SSLCertVerificationError):
        shake_hands(own.file, other.authority, "localhost")
    assert own.address == "cell.local"


@pytest.mark.parametrize("version", [4, 6])
def test_the_link_names_an_address_by_which_the_machine_is_reached(version: int, tmp_path: Path) -> None:
    """A console listens by one version of IP: a link by the other one would be refused."""
    addresses = [ipaddress.ip_address(one) for one in local_addresses()]
    outside = [str(one) for one in addresses if one.version == version and not one.is_loopback]
    assert own_certificate((), tmp_path / "own", version).address == [*outside, "localhost"][0]


def test_it_is_made_once_and_its_keys_are_its_users_alone(tmp_path: Path) -> None:
    folder = tmp_path / "own"
    first = own_certificate((), folder)
    authority, served = first.authority.read_bytes(), first.file.read_bytes()
    again = own_certificate((), folder)
    assert again.authority.read_bytes() == authority and again.file.read_bytes() != served
    shake_hands(again.file, again.authority, "localhost")
    if os.name == "posix":
        assert {one.name: stat.S_IMODE(one.stat().st_mode) & 0o077 for one in folder.iterdir()} == {
            "authority.pem": 0o044,
            "authority-key.pem": 0,
            "console.pem": 0,
        }
        assert stat.S_IMODE(folder.stat().st_mode) & 0o077 == 0
    (folder / "authority.pem").write_bytes(own_certificate((), tmp_path / "other").authority.read_bytes())
    with pytest.raises(InvalidArgumentError, match=r"authority-key\.pem is not the key of"):
        own_certificate((), folder)
    (folder / "authority.pem").unlink()
    with pytest.raises(InvalidArgumentError, match="has no authority"):
        own_certificate((), folder)


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("not a folder", "utf-8")
    with pytest.raises(InvalidArgumentError, match="can't be kept in"):
        own_certificate((), tmp_path / "file" / "own")


@pytest.mark.parametrize(
    ("name", "local"),
    [
        ("10.1.2.3", True),
        ("172.31.255.255", True),
        ("172.32.0.0", False),
        ("8.8.8.8", False),
        ("fd00::1", True),
        ("2606:4700::1", False),
        ("cell.local", True),
        ("Cell.LOCAL", True),
        ("localhost", True),
        ("notlocal", False),
        ("cell.example", False),
        ("local.example", False),
    ],
)
def test_it_signs_for_no_name_of_the_internet(tmp_path: Path, name: str, local: bool) -> None:
    assert is_local(name) == local
    if not local:
        with pytest.raises(InvalidArgumentError, match="--tls-certificate"):
            own_certificate([name], tmp_path)
        assert not list(tmp_path.iterdir())


def test_whoever_has_its_key_stands_for_no_site_of_the_internet(tmp_path: Path) -> None:
    own = own_certificate((), tmp_path)
    authority = x509.load_pem_x509_certificate(own.authority.read_bytes())
    stolen = serialization.load_pem_private_key((tmp_path / "authority-key.pem").read_bytes(), None)
    assert isinstance(stolen, ec.EllipticCurvePrivateKey)
    key = ec.generate_private_key(ec.SECP256R1())
    forged = (
        x509.CertificateBuilder()
        .subject_name(x509.Name([]))
        .issuer_name(authority.subject)
        .public_key(key.public_key())
        .serial_number(1)
        .not_valid_before(authority.not_valid_before_utc)
        .not_valid_after(authority.not_valid_after_utc)
        .add_extension(x509.SubjectAlternativeName([x509.DNSName("bank.example")]), critical=True)
        .sign(stolen, hashes.SHA256())
    )
    file = tmp_path / "forged.pem"
    file.write_bytes(
        forged.public_bytes(serialization.Encoding.PEM)
        + key.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
    )
    with pytest.raises(ssl.SSLCertVerificationError, match="permitted subtree"):
        shake_hands(file, own.authority, "bank.example")
