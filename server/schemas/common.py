"""What the wire models share: strictness, names, numbers, poses and the form of an error."""

from __future__ import annotations

import base64
import binascii
from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

NAME_PATTERN = r"^[A-Za-z0-9][A-Za-z0-9._:~-]*$"


class Wire(BaseModel):
    """A wire model: unknown fields, numbers as text, NaN and infinity are refused."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


def _is_base64(text: str) -> str:
    try:
        base64.b64decode(text, validate=True)
    except binascii.Error as error:
        raise ValueError(f"has to be base64: {error}") from error
    return text


Name = Annotated[str, Field(min_length=1, max_length=64, pattern=NAME_PATTERN)]
Metres = Annotated[float, Field(ge=-1e6, le=1e6)]
Radians = Annotated[float, Field(ge=-1e4, le=1e4)]
Seconds = Annotated[float, Field(ge=-1e12, le=1e12)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Base64 = Annotated[str, Field(max_length=16_384), AfterValidator(_is_base64)]
TeamBytes = Annotated[str, Field(max_length=44_000), AfterValidator(_is_base64)]
Corner = Annotated[list[Metres], Field(min_length=2, max_length=2)]
Covariance = Annotated[
    list[float], Field(min_length=3, max_length=3, description="xx, xy, yy in square metres.")
]


class PoseWire(Wire):
    """A pose in the plane."""

    x_m: Metres = Field(description="Position along x.")
    y_m: Metres = Field(description="Position along y.")
    yaw_rad: Radians = Field(description="Heading, counter-clockwise from x.")


class ErrorDetail(Wire):
    """What went wrong."""

    code: str = Field(description="For programs.", examples=["unknown_robot"])
    message: str = Field(description="For people: what is wrong and what to do.")
    field: str | None = Field(description="The field it is about.", examples=["observations.3.imu.yaw_rad"])


class ErrorWire(Wire):
    """Every refusal has this form."""

    error: ErrorDetail
