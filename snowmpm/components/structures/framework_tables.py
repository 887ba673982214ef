"""Structures of members that meet in joints."""

from collections import Counter
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from snowmpm.components.structures.tables import MOST, Bending, kind
from snowmpm.errors import did_you_mean
from snowmpm.scenes.space import Vector, dimension
from snowmpm.scenes.spec import Number, Positive, Spec, refuse

Label = Annotated[str, Field(strict=True, pattern=r"^[A-Za-z0-9]+$", max_length=20)]
Segments = Annotated[int, Field(strict=True, ge=1, le=32)]


class Member(Spec):
    """A straight member from one joint to another."""

    ends: tuple[Label, Label]
    """names of the joints that it goes from and to"""
    pinned: tuple[Label, ...] = ()
    """those of its ends that pass on no moment"""
    width: Positive | None = None
    """outer diameter; 2-D: thickness of the plate [m]; that of the structure when missing"""
    wall: Positive | None = None
    """thickness of the tube, 3-D only [m]; that of the structure when missing"""
    segments: Segments | None = None
    """elements; as many as of the structure when missing"""

    @property
    def name(self) -> str:
        return "-".join(self.ends)


@kind("framework")
class Framework(Bending):
    """A portal, fence, tripod or truss: straight members between joints that are rigid unless a member is pinned
    there."""

    EXAMPLES: ClassVar = {"joints": {"a": [6.0, 0.0], "b": [6.0, 2.0]}, "feet": {"a": "fixed"}}

    KEYS: ClassVar = ("joints", "members")
    MAKES: ClassVar = f"{__package__}.from_scene:framework"
    joints: Annotated[dict[Label, Vector], Field(min_length=2, max_length=64)]
    """name of each joint, and where it is [m]"""
    feet: Annotated[dict[Label, Literal["fixed", "pinned"]], Field(min_length=1)]
    """joints that are held by the ground: fixed (they do not turn either), or pinned"""
    members: Annotated[tuple[Member, ...], Field(min_length=1, max_length=64)]
    """one table a member"""
    poisson_ratio: Annotated[Number, Field(gt=-1.0, lt=0.5)] = 0.3
    """of its material, for torsion [-]"""
    segments: Segments = 4
    """elements of a member that does not say how many"""
    response: Literal["dynamic", "static"] = "dynamic"
    """dynamic: it moves with its mass; static: in each step it is where it would rest under the loads of that step,
    with coupling = "one_way" only"""

    def length(self, member: Member) -> float:
        """Length of a `Member` [m]."""
        a, b = (self.joints[name] for name in member.ends)
        return sum((x - y) ** 2 for x, y in zip(a, b, strict=True)) ** 0.5

    def of(self, member: Member, key: str) -> Any:
        """Width, wall or segments of a `Member`."""
        own = member[key]
        return self[key] if own is None else own

    def _place(self, i, key):
        """Key and value of what member i has, its own or that of the structure."""
        own = self.members[i][key]
        return (key, self[key]) if own is None else (f"members.{i}.{key}", own)

    @model_validator(mode="after")
    def _at_rest_it_does_not_answer(self):
        if self.response == "static" and self.coupling != "one_way":
            raise refuse('must be "dynamic" where coupling is not "one_way": snow would meet something without mass',
                         "response", self.response)
        return self

    @model_validator(mode="after")
    def _joints_are_there(self):
        known = ", ".join(self.joints)
        for name in self.feet:
            if name not in self.joints:
                raise refuse(f"must name one of the joints: {known}{did_you_mean(name, self.joints)}", "feet", name)
        for i, member in enumerate(self.members):
            for name in member.ends:
                if name not in self.joints:
                    near = did_you_mean(name, self.joints)
                    raise refuse(f"must be two of the joints: {known}{near}", f"members.{i}.ends", list(member.ends))
            if member.ends[0] == member.ends[1]:
                raise refuse("must be two different joints", f"members.{i}.ends", list(member.ends))
            for name in member.pinned:
                if name not in member.ends:
                    raise refuse(f"must be among its ends, {' and '.join(member.ends)}", f"members.{i}.pinned",
                                 list(member.pinned))
        return self

    @model_validator(mode="after")
    def _members_are_joined_once(self):
        count = Counter(frozenset(member.ends) for member in self.members)
        for i, member in enumerate(self.members):
            if count[frozenset(member.ends)] > 1:
                raise refuse("two members join the same joints", f"members.{i}.ends", list(member.ends))
        for name in self.joints:
            if not any(name in member.ends for member in self.members):
                raise refuse("no member ends there", f"joints.{name}", list(self.joints[name]))
        return self

    @model_validator(mode="after")
    def _members_are_slender(self):
        for i, member in enumerate(self.members):
            length, width, wall = self.length(member), self.of(member, "width"), self.of(member, "wall")
            if length < 3.0 * width * (1.0 - 1e-9):
                raise refuse(f"must be three times its width, {width:g}, or longer: it bends as a slender beam, and is"
                             f" {length:g} long", f"members.{i}.ends", list(member.ends))
            if wall is not None and dimension() == 2:
                raise refuse("is for tubes, in 3-D scenes", *self._place(i, "wall"))
            if wall is not None and wall > 0.5 * width:
                raise refuse(f"must be at most half of width, {0.5 * width:g}", *self._place(i, "wall"))
        if (total := sum(self.of(member, "segments") for member in self.members)) > MOST:
            raise refuse(f"must be fewer: {total} elements of all members, and {MOST} at most", "segments",
                         self.segments)
        return self
