"""`waymark ca`: a local authority, so that phones trust a server that no public one can vouch for."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from server.cli.console import CommandError
from server.cli.serve import DataOption

_HOW = """Android: Settings, Security, Encryption, Install a certificate, CA certificate.
iPhone:  open the link in Safari, then Settings, Profile downloaded, Install; then General, About, Certificate
         Trust Settings: switch it on.
Compare the fingerprint before you trust it:
{fingerprint}
It vouches for {hosts} and the networks of these addresses alone, until {ends:%d %B %Y}.
Its keys lie in {folder}."""


def ca(
    hosts: Annotated[
        list[str],
        typer.Option("--host", metavar="NAME|ADDRESS", help="What phones call the server; may be repeated."),
    ],
    data: DataOption = None,
    new: Annotated[
        bool, typer.Option("--new", help="Replace the authority; every phone installs it again.")
    ] = False,
) -> None:
    """Make a local authority and the server's certificate, and show the code by which phones install it.

    Then start `waymark serve --tls`, which also hands the authority to phones.
    """
    import segno

    from server.settings import Settings
    from server.tls.authority import Authority, AuthorityError
    from server.tls.install import PATH

    given: dict[str, Any] = {} if data is None else {"data_dir": data}
    settings = Settings(**given)
    authority = Authority(settings.tls_folder)
    try:
        if new or not authority.exists:
            authority.create(hosts)
        else:
            authority.issue(hosts)
    except AuthorityError as error:
        raise CommandError(str(error)) from error
    except OSError as error:
        raise CommandError(f"{error.filename}: {error.strerror}") from error
    host = f"[{hosts[0]}]" if ":" in hosts[0] else hosts[0]
    link = f"http://{host}:{settings.install_port}{PATH}"
    segno.make_qr(link).terminal(compact=True)
    print(f"While waymark serve --tls runs, a phone installs the authority from {link}")
    print(
        _HOW.format(
            fingerprint=authority.fingerprint,
            hosts=", ".join(authority.hosts),
            ends=authority.ends,
            folder=authority.folder,
        )
    )
