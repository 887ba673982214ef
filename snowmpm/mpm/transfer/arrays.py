"""What transfers take beside the particles, in groups (`compiler.groups`)."""

from typing import NamedTuple

from snowmpm.compiler.groups import Array, Real


class Tiles(NamedTuple):
    """Nodes of n tiles, and the box of active nodes of each."""

    nodes: Array
    active_nodes: Array
    n: int


class Step(NamedTuple):
    """dt [s]; dx [m]; share of FLIP."""

    dt: Real
    dx: Real
    flip_ratio: Real


class Scheme(NamedTuple):
    """flip: nodes have a second half, for the internal impulse; basis: name of a stencil; gradient: "affine" or "shape"
    (`scatter`); affine: whether C counts and is handed on (APIC, AFLIP)."""

    flip: bool
    basis: str
    gradient: str
    affine: bool
