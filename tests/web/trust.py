"""A browser's own store of trust (NSS) with one authority in it, as a person installs it on a phone."""

from __future__ import annotations

import ctypes
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding

_TRUSTED = 0x08 | 0x10  # CERTDB_VALID_CA | CERTDB_TRUSTED_CA (nss/certdb.h)


class _Trust(ctypes.Structure):
    _fields_ = [("tls", ctypes.c_uint), ("mail", ctypes.c_uint), ("code", ctypes.c_uint)]


def install(home: Path, certificate: Path) -> None:
    """Trust an authority's certificate (PEM) for TLS in the browsers of the user whose home this is.

    The same calls as ``certutil -N`` and ``certutil -A -t C,,`` make; Chromium brings the libraries with it.
    """
    nss, smime = ctypes.CDLL("libnss3.so"), ctypes.CDLL("libsmime3.so")
    for call in (nss.PK11_GetInternalKeySlot, smime.CERT_DecodeCertFromPackage, nss.CERT_GetDefaultCertDB):
        call.restype = ctypes.c_void_p
    folder = home / ".pki" / "nssdb"
    folder.mkdir(parents=True)
    der = x509.load_pem_x509_certificate(certificate.read_bytes()).public_bytes(Encoding.DER)

    def done(status: int) -> None:
        assert status == 0, nss.PORT_GetError()

    done(nss.NSS_InitReadWrite(f"sql:{folder}".encode()))
    slot = ctypes.c_void_p(nss.PK11_GetInternalKeySlot())
    done(nss.PK11_InitPin(slot, None, b""))
    authority = ctypes.c_void_p(smime.CERT_DecodeCertFromPackage(der, len(der)))
    done(nss.PK11_ImportCert(slot, authority, ctypes.c_ulong(0), b"authority", 0))
    trust = _Trust(_TRUSTED, 0, 0)
    store = ctypes.c_void_p(nss.CERT_GetDefaultCertDB())
    done(nss.CERT_ChangeCertTrust(store, authority, ctypes.byref(trust)))
    nss.CERT_DestroyCertificate(authority)
    nss.PK11_FreeSlot(slot)
    done(nss.NSS_Shutdown())
