"""Settings of the server, from the environment: every name begins with WAYMARK_."""

from __future__ import annotations

from ipaddress import ip_address
from pathlib import Path
from typing import Literal, Self

from pydantic import Field, model_validator
from pydantic_settings import BaseSettings, SettingsConfigDict


class Settings(BaseSettings):
    """How the server runs. The defaults are for one machine and nobody else on its network."""

    model_config = SettingsConfigDict(env_prefix="WAYMARK_", frozen=True, extra="forbid")

    host: str = Field("127.0.0.1", description="Address to listen on; 0.0.0.0 for every network.")
    port: int = Field(8000, ge=0, le=65535, description="Port to listen on; 0 takes a free one.")
    login: Literal["on", "off"] = Field(
        "on",
        description="Whether people log in and robots show tokens; off only on this machine's own address.",
    )
    robot_token: str | None = Field(
        None, min_length=16, description="A token robots may show besides those that people make."
    )
    commander_link: bool = Field(
        False, description="Print a new link for a commander, as when the last password is lost."
    )
    data_dir: Path = Field(Path("waymark-data"), description="Folder of the database.")
    database: str | None = Field(
        None, description="Database file or URL; by default a file in the data folder."
    )
    tls: bool = Field(False, description="Serve https with the certificate of `waymark ca`.")
    install_port: int = Field(
        8080, ge=0, le=65535, description="With tls: port without encryption where phones get the authority."
    )
    max_body_bytes: int = Field(4 * 2**20, ge=1024, description="Largest request body.")
    max_photo_bytes: int = Field(12 * 2**20, ge=1024, description="Largest photo, and picture of a plan.")
    max_waiting: int = Field(4000, ge=1, description="Observations of one robot that may wait for its agent.")
    snapshot_every: int = Field(300, ge=1, description="Observations between snapshots of an agent.")
    snapshot_every_s: float = Field(
        30.0, gt=0, description="Seconds between snapshots of an agent that works."
    )
    late_after_s: float = Field(2.5, gt=0, description="Silence after which a robot counts as late.")
    lost_after_s: float = Field(10.0, gt=0, description="Silence after which a robot counts as lost.")
    stop_reply_s: float = Field(0.5, gt=0, description="Longest wait for the agent of a stopped robot.")
    reply_s: float = Field(8.0, gt=0, description="Longest wait of a request for the agent's answer.")
    log_level: str = Field("WARNING", description="Least level that is logged: DEBUG, INFO, WARNING, ERROR.")

    @model_validator(mode="after")
    def _is_not_open_to_others(self) -> Self:
        if self.login == "off" and not is_loopback(self.host):
            raise ValueError(
                f"without log-in Waymark serves this machine alone, and others reach {self.host};"
                " leave log-in on, or listen on 127.0.0.1"
            )
        return self

    @property
    def address(self) -> str:
        """The address a browser on this machine opens."""
        host = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(self.host, self.host)
        return f"{'https' if self.tls else 'http'}://{host}:{self.port}"

    @property
    def tls_folder(self) -> Path:
        """Where the authority and the server's certificate lie."""
        return self.data_dir / "tls"

    @property
    def database_target(self) -> str:
        """The database's file or URL."""
        return self.database or str(self.data_dir / "waymark.db")


def is_loopback(host: str) -> bool:
    """Say whether an address can be reached from this machine alone."""
    if host == "localhost":
        return True
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return False
