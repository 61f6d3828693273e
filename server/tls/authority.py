"""A local certificate authority that can vouch for the field's own hosts and nothing else.

Phones that install it trust it for the names and networks in its name constraints (RFC 5280, 4.2.1.10) and
for no other site: who steals its key cannot pose as a bank. The server's certificate lives for 30 days and
is made anew at a start. Keys are files of their owner alone (0600).
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from ipaddress import IPv4Network, IPv6Network, ip_address, ip_network
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.serialization import (
    Encoding,
    NoEncryption,
    PrivateFormat,
    load_pem_private_key,
)
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

ALWAYS = ("localhost", "127.0.0.1", "::1")
_AUTHORITY, _SERVER = timedelta(days=365), timedelta(days=30)
_RENEW_BEFORE = timedelta(days=10)
_EARLIER = timedelta(days=1)  # a phone's clock may be behind
_NETWORKS = {4: 24, 6: 64}  # of a host's address: it may get another one of the same network
Network = IPv4Network | IPv6Network


class AuthorityError(ValueError):
    """There is no authority, or it may not vouch for a host; the message says what to do."""


@dataclass(frozen=True, slots=True)
class Authority:
    """The files of an authority and of the server's certificate, in a folder."""

    folder: Path

    @property
    def certificate(self) -> Path:
        """What phones install."""
        return self.folder / "ca.crt"

    @property
    def server_certificate(self) -> Path:
        """The server's certificate."""
        return self.folder / "server.crt"

    @property
    def server_key(self) -> Path:
        """The server's private key."""
        return self.folder / "server.key"

    @property
    def key(self) -> Path:
        """The authority's private key."""
        return self.folder / "ca.key"

    @property
    def exists(self) -> bool:
        """Whether it was made."""
        return self.certificate.exists() and self.key.exists()

    def create(self, hosts: Sequence[str]) -> None:
        """Make an authority for these hosts and the networks of their addresses; what was there is replaced.

        Raises:
            AuthorityError: a host is no name and no address.
        """
        names, networks = _permitted(hosts)
        self.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        key = ec.generate_private_key(ec.SECP256R1())
        subject = _name(f"Waymark at {hosts[0] if hosts else 'localhost'}")
        permitted = [*map(x509.DNSName, names), *map(x509.IPAddress, networks)]
        made = _builder(subject, subject, key.public_key(), _AUTHORITY)
        made = made.add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        made = made.add_extension(_usage(signs_certificates=True), critical=True)
        made = made.add_extension(x509.NameConstraints(permitted, None), critical=True)
        _write_key(self.key, key)
        _write(self.certificate, made.sign(key, SHA256()))
        self.issue(hosts)

    def issue(self, hosts: Sequence[str]) -> None:
        """Make a certificate for the server under these names.

        Raises:
            AuthorityError: the authority may not vouch for one of them.
        """
        certificate, key = self._load()
        wanted = list(dict.fromkeys((*hosts, *ALWAYS)))
        for host in wanted:
            if not _covers(certificate, host):
                raise AuthorityError(
                    f"the authority does not vouch for {host}; make a new one with --new, and install that on"
                    " the phones"
                )
        own = ec.generate_private_key(ec.SECP256R1())
        made = _builder(_name("Waymark server"), certificate.subject, own.public_key(), _SERVER)
        made = made.add_extension(
            x509.SubjectAlternativeName([_general_name(host) for host in wanted]), critical=False
        )
        made = made.add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        made = made.add_extension(_usage(signs_certificates=False), critical=True)
        made = made.add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
        signer = certificate.extensions.get_extension_for_class(x509.SubjectKeyIdentifier).value
        issuer = x509.AuthorityKeyIdentifier.from_issuer_subject_key_identifier(signer)
        made = made.add_extension(issuer, critical=False)
        _write_key(self.server_key, own)
        _write(self.server_certificate, made.sign(key, SHA256()))

    def renew(self) -> None:
        """Make the server's certificate anew, for the same hosts, when it ends within ten days.

        Raises:
            AuthorityError: there is no authority, or it has ended itself.
        """
        if not self.exists or not self.server_certificate.exists():
            raise AuthorityError(
                f"there is no authority in {self.folder}; make one with waymark ca --host NAME"
            )
        now = datetime.now(UTC)
        if _read(self.certificate).not_valid_after_utc < now + _RENEW_BEFORE:
            raise AuthorityError("the authority is about to end; make a new one with waymark ca --new")
        if _read(self.server_certificate).not_valid_after_utc < now + _RENEW_BEFORE:
            self.issue(self.hosts)

    @property
    def hosts(self) -> tuple[str, ...]:
        """The hosts that the server's certificate is for."""
        found = _read(self.server_certificate).extensions.get_extension_for_class(x509.SubjectAlternativeName)
        return tuple(str(name.value) for name in found.value)

    @property
    def ends(self) -> datetime:
        """When phones have to install a new one."""
        ends: datetime = _read(self.certificate).not_valid_after_utc
        return ends

    @property
    def fingerprint(self) -> str:
        """SHA-256 of its certificate as phones show it, in pairs of hexadecimal digits."""
        digest: bytes = _read(self.certificate).fingerprint(SHA256())
        return digest.hex(":").upper()

    def _load(self) -> tuple[x509.Certificate, ec.EllipticCurvePrivateKey]:
        key = load_pem_private_key(self.key.read_bytes(), None)
        if not isinstance(key, ec.EllipticCurvePrivateKey):
            raise AuthorityError(f"{self.key} holds no key of this program; make a new one with --new")
        return _read(self.certificate), key


def _permitted(hosts: Sequence[str]) -> tuple[list[str], list[Network]]:
    """Return the names and networks of hosts. Both kinds are always there: a kind left out is not limited."""
    names: list[str] = []
    networks: list[Network] = []
    for host in dict.fromkeys((*hosts, *ALWAYS)):
        general = _general_name(host)
        if isinstance(general, x509.DNSName):
            names.append(general.value)
        else:
            address = ip_address(host)
            length = address.max_prefixlen if address.is_loopback else _NETWORKS[address.version]
            networks.append(ip_network(f"{host}/{length}", strict=False))
    return names, networks


def _covers(certificate: x509.Certificate, host: str) -> bool:
    limits = certificate.extensions.get_extension_for_class(x509.NameConstraints).value
    for permitted in limits.permitted_subtrees or ():
        value = permitted.value
        if isinstance(permitted, x509.DNSName) and (host == value or host.endswith(f".{value}")):
            return True
        with suppress(ValueError):  # a name is in no network
            if isinstance(permitted, x509.IPAddress) and ip_address(host) in value:
                return True
    return False


def _general_name(host: str) -> x509.DNSName | x509.IPAddress:
    try:
        return x509.IPAddress(ip_address(host))
    except ValueError:
        pass
    labels = host.split(".")
    if not all(label.replace("-", "a").isalnum() and label.isascii() for label in labels):
        raise AuthorityError(f"{host} is no name and no address of a host; leave out https:// and the port")
    return x509.DNSName(host.lower())


def _builder(
    subject: x509.Name, issuer: x509.Name, key: ec.EllipticCurvePublicKey, lasts: timedelta
) -> x509.CertificateBuilder:
    now = datetime.now(UTC)
    return (
        x509.CertificateBuilder(issuer, subject, key, x509.random_serial_number())
        .not_valid_before(now - _EARLIER)
        .not_valid_after(now + lasts)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key), critical=False)
    )


def _usage(signs_certificates: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=not signs_certificates,
        key_cert_sign=signs_certificates,
        crl_sign=signs_certificates,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        encipher_only=False,
        decipher_only=False,
    )


def _name(text: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, text[:64])])


def _read(path: Path) -> x509.Certificate:
    return x509.load_pem_x509_certificate(path.read_bytes())


def _write(path: Path, certificate: x509.Certificate) -> None:
    path.write_bytes(certificate.public_bytes(Encoding.PEM))


def _write_key(path: Path, key: ec.EllipticCurvePrivateKey) -> None:
    """Write a key that only its owner can read, from its first byte on."""
    path.unlink(missing_ok=True)
    data = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(data)
