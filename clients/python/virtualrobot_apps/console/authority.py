"""Certificates of the installation's own: an authority, made once and trusted once by each device, and what it signs.

Browsers show a cell in a room only for pages by https. The authority can sign for private addresses and names of the
local network alone (name constraints, RFC 5280, section 4.2.1.10), so that whoever had its key could stand for no site
of the Internet.
"""

from __future__ import annotations

import datetime
import ipaddress
import os
import socket
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import platformdirs
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID
from virtualrobot.errors import InvalidArgumentError

Address = ipaddress.IPv4Address | ipaddress.IPv6Address
Network = ipaddress.IPv4Network | ipaddress.IPv6Network

PRIVATE: tuple[Network, ...] = tuple(
    ipaddress.ip_network(text)
    for text in (
        *("127.0.0.0/8", "10.0.0.0/8", "172.16.0.0/12", "192.168.0.0/16", "169.254.0.0/16"),
        *("::1/128", "fc00::/7", "fe80::/10"),
    )
)
"""Addresses that belong to no one on the Internet: loopback, RFC 1918, link-local, RFC 4193."""

LOCAL_NAMES = ("local", "localhost", "internal", "home.arpa")
"""Names, and all below them, that nobody on the Internet can have (RFC 6761, 6762, 8375; `internal` by ICANN, 2024)."""

AUTHORITY_DAYS = 3650
SERVER_DAYS = 397
"""Days for which a server's certificate is good: Apple's devices take no more than 825, other browsers 398."""
_BEFORE = datetime.timedelta(days=1)
"""Time before now at which certificates begin: clocks of headsets are off."""


@dataclass(frozen=True, slots=True)
class Own:
    """Certificates that are made, and where they lead.

    Attributes:
        file: a certificate for this machine with its key, PEM.
        authority: the authority's certificate, PEM, which devices trust.
        address: what the link names: the first other name, or the machine's address on the network.
    """

    file: Path
    authority: Path
    address: str


def own_certificate(names: Sequence[str] = (), folder: Path | None = None, version: int | None = None) -> Own:
    """Return a new certificate of this machine, by an authority that is made when there is none.

    Args:
        names: names that browsers call the machine by, besides its addresses and its own.
        folder: where the authority is kept; None: the user's folder for state.
        version: of IP, 4 or 6, by which the machine can be reached; None: by both.

    Raises:
        InvalidArgumentError: for a name of the Internet, a folder that can't be written, and when the authority's files
            don't fit each other.
    """
    folder = folder or Path(platformdirs.user_state_path("virtualrobot", appauthor=False)) / "authority"
    for name in names:
        if not is_local(name):
            raise InvalidArgumentError(
                f"the installation's own authority signs for private addresses and names in "
                f"{', '.join(f'.{one}' for one in LOCAL_NAMES)} alone, not for {name!r}: give --tls-certificate and "
                "--tls-key"
            )
    try:
        return _issued(names, folder, version)
    except OSError as error:
        said = f"the installation's own authority can't be kept in {folder}: {error.strerror or error}"
        raise InvalidArgumentError(said) from None


def _issued(names: Sequence[str], folder: Path, version: int | None) -> Own:
    authority, key = _authority(folder)
    addresses = local_addresses()
    all_names = list(dict.fromkeys((*names, "localhost", f"{socket.gethostname().partition('.')[0]}.local")))
    server_key = ec.generate_private_key(ec.SECP256R1())
    builder = _builder("VirtualRobot console", authority.subject, server_key.public_key(), SERVER_DAYS)
    certificate = (
        builder.add_extension(
            x509.SubjectAlternativeName([*map(_general, all_names), *map(_general, addresses)]), False
        )
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
        .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(key.public_key()), critical=False)
        .sign(key, hashes.SHA256())
    )
    file = folder / "console.pem"
    _write(file, certificate.public_bytes(serialization.Encoding.PEM) + _pem(server_key))
    known = [ipaddress.ip_address(one) for one in addresses]
    outside = [str(one) for one in known if not one.is_loopback and one.version == (version or one.version)]
    return Own(file, folder / "authority.pem", next(iter((*names, *outside)), "localhost"))


def is_local(name: str) -> bool:
    """Return whether the authority may sign for a name or an address."""
    with suppress(ValueError):
        address = ipaddress.ip_address(name)
        return any(address in network for network in PRIVATE)
    return any(name.lower() == one or name.lower().endswith(f".{one}") for one in LOCAL_NAMES)


def local_addresses() -> list[str]:
    """Return the private addresses of this machine, the one towards other machines first, loopback last."""
    found: list[str] = []
    # A socket for datagrams that is connected sends nothing, and knows which address it would send from.
    for family, elsewhere in ((socket.AF_INET, "192.0.2.1"), (socket.AF_INET6, "2001:db8::1")):
        with suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as asking:
            asking.connect((elsewhere, 9))
            found.append(asking.getsockname()[0])
    with suppress(OSError):
        found += [str(said[4][0]).partition("%")[0] for said in socket.getaddrinfo(socket.gethostname(), None)]
    outside = [one for one in dict.fromkeys(found) if is_local(one) and not ipaddress.ip_address(one).is_loopback]
    return [*outside, "127.0.0.1", "::1"]


def _authority(folder: Path) -> tuple[x509.Certificate, ec.EllipticCurvePrivateKey]:
    """Return the authority of a folder and its key."""
    certificate_file, key_file = folder / "authority.pem", folder / "authority-key.pem"
    if not key_file.exists():
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        _make_authority(certificate_file, key_file)
    try:
        certificate = x509.load_pem_x509_certificate(certificate_file.read_bytes())
        key = serialization.load_pem_private_key(key_file.read_bytes(), None)
    except (OSError, ValueError) as error:
        raise InvalidArgumentError(
            f"{folder} has no authority: {error}; without the folder a new one is made"
        ) from None
    if not isinstance(key, ec.EllipticCurvePrivateKey) or key.public_key() != certificate.public_key():
        raise InvalidArgumentError(
            f"{key_file} is not the key of {certificate_file}; without the folder a new authority is made, which "
            "devices have to trust anew"
        )
    return certificate, key


def _make_authority(certificate_file: Path, key_file: Path) -> None:
    key = ec.generate_private_key(ec.SECP256R1())
    name = f"VirtualRobot on {socket.gethostname()}"[:64]
    usage = dict.fromkeys(
        (
            *("digital_signature", "content_commitment", "key_encipherment", "data_encipherment", "key_agreement"),
            *("encipher_only", "decipher_only"),
        ),
        False,
    )
    permitted = [*map(x509.DNSName, LOCAL_NAMES), *map(x509.IPAddress, PRIVATE)]
    certificate = (
        _builder(name, _name(name), key.public_key(), AUTHORITY_DAYS)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(x509.KeyUsage(key_cert_sign=True, crl_sign=True, **usage), critical=True)
        .add_extension(x509.NameConstraints(permitted_subtrees=permitted, excluded_subtrees=None), critical=True)
        .sign(key, hashes.SHA256())
    )
    _write(certificate_file, certificate.public_bytes(serialization.Encoding.PEM), mode=0o644)
    _write(key_file, _pem(key))


def _builder(name: str, issuer: x509.Name, key: ec.EllipticCurvePublicKey, days: int) -> x509.CertificateBuilder:
    now = datetime.datetime.now(datetime.UTC)
    return (
        x509.CertificateBuilder()
        .subject_name(_name(name))
        .issuer_name(issuer)
        .public_key(key)
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - _BEFORE)
        .not_valid_after(now - _BEFORE + datetime.timedelta(days=days))
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key), critical=False)
    )


def _name(name: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])


def _general(name: str) -> x509.GeneralName:
    with suppress(ValueError):
        return x509.IPAddress(ipaddress.ip_address(name))
    return x509.DNSName(name)


def _pem(key: ec.EllipticCurvePrivateKey) -> bytes:
    return key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )


def _write(file: Path, data: bytes, mode: int = 0o600) -> None:
    """Write a whole file at once, which others may not read unless `mode` lets them."""
    new = file.with_name(f".{file.name}-{os.getpid()}")
    with suppress(FileNotFoundError):
        new.unlink()
    with open(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as written:
        written.write(data)
    new.replace(file)
