"""The picture of a scene in the gallery: times, colours, camera."""

from typing import Annotated, Literal

from pydantic import Field

from snowmpm.scenes.spec import NonNegative, Spec

Pixels = Annotated[int, Field(strict=True, ge=64, le=4096)]


class Picture(Spec):
    """Settings of the gallery's picture; the simulation ignores them."""

    times: Annotated[tuple[NonNegative, ...], Field(min_length=1, max_length=6)] | None = None
    """times shown, one below the other [s]; the end when missing"""
    color: str | None = None
    """field that colours the snow, or "snow"; its speed when missing"""
    camera: str = "auto"
    """view, as for `snowmpm render --camera`"""
    inset: Literal["auto", "on", "off"] = "auto"
    """the whole in a corner, as for `snowmpm render --inset`"""
    size: tuple[Pixels, Pixels] = (1280, 480)
    """width and height of each picture [pixels]"""
    plot: Literal["history", "compression", "saw_test", "thalweg_time"] | None = None
    """curves below the last picture: history, saw_test or thalweg_time, as `snowmpm plot` draws them; compression,
    stress against strain"""
