"""Members that meet in joints, cut into straight elements: places that move and turns that rotate.

A place is a node's position, a turn its rotation. At a rigid joint all elements share both; an end that passes on no
moment has the place of its joint and a turn of its own, which every end has in store. Each element gives half of its
mass to its places, and to its turns the inertia of a straight half of it about its end, and of its section about its
axis:

    m l / 2,    J = diag(rho 2 I l / 2,  m l^3 / 24,  m l^3 / 24)    along and across it

so that the fastest vibration of any structure is at most that of its fastest element.
"""

import itertools
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from snowmpm.components.structures.section import Section


@dataclass(frozen=True, eq=False)
class Member:
    """A straight member from joint `first` to joint `last`; pinned: names of its ends that pass on no moment."""

    first: str
    last: str
    section: Section
    segments: int = 4
    pinned: tuple = ()

    @property
    def name(self):
        return f"{self.first}-{self.last}"


@dataclass(frozen=True, eq=False)
class FrameworkMesh:
    """joints: name -> number of its place and turn; places (p, 3) [m]; held (p,): those of feet; clamped (t,): turns of
    fixed feet; links (n, 4): first and last place, first and last turn of each element; of_member (n,); lengths (n,)
    [m]; triads (n, 3, 3): rows are its axis and two across; masses (p,) [kg]; end_inertias (n, 3, 3) [kg m2]: of each
    end; spare: number of the own turn of the first end of element 0, two an element."""

    joints: dict
    members: list
    places: np.ndarray
    held: np.ndarray
    clamped: np.ndarray
    links: np.ndarray
    of_member: np.ndarray
    lengths: np.ndarray
    triads: np.ndarray
    spare: int
    masses: np.ndarray = field(init=False)
    end_inertias: np.ndarray = field(init=False)

    def __post_init__(self):
        line_mass, polar = (np.array([self.section(e)[name] for e in range(len(self.links))])
                            for name in ("line_mass", "polar_mass"))
        half = 0.5 * line_mass * self.lengths
        masses = np.zeros(len(self.places))
        np.add.at(masses, self.links[:, :2], half[:, None])
        across = half * self.lengths**2 / 12.0
        local = np.stack([0.5 * polar * self.lengths, across, across], axis=1)
        object.__setattr__(self, "masses", masses)
        object.__setattr__(self, "end_inertias", np.einsum("eki,ek,ekj->eij", self.triads, local, self.triads))

    @classmethod
    def of(cls, joints, feet, members, plane):
        """joints: name -> (3,) [m]; feet: name -> "fixed" or "pinned"; members: `Member`s; plane: whether all of it
        stays in y = const."""
        number = {name: i for i, name in enumerate(joints)}
        places = [np.asarray(x, float) for x in joints.values()]
        links: list[Any] = []
        of_member: list[int] = []
        triads: list[Any] = []
        lengths: list[float] = []
        pins: list[Any] = []
        for k, member in enumerate(members):
            first, last = number[member.first], number[member.last]
            edge, n = places[last] - places[first], member.segments
            inner = range(len(places), len(places) + n - 1)
            chain = [first, *inner, last]
            places += [places[first] + edge * (s + 1) / n for s in range(n - 1)]
            pins += [(len(links) + (n - 1 if end else 0), end) for end, name in enumerate((member.first, member.last))
                     if name in member.pinned]
            links += [[a, b, a, b] for a, b in itertools.pairwise(chain)]
            of_member += [k] * n
            lengths += [np.linalg.norm(edge) / n] * n
            triads += [_triad(edge / np.linalg.norm(edge), plane)] * n
        spare = len(places)
        for e, end in pins:
            links[e][2 + end] = spare + 2 * e + end
        held, clamped = np.zeros(spare, bool), np.zeros(spare + 2 * len(links), bool)
        held[[number[name] for name in feet]] = True
        clamped[[number[name] for name, kind in feet.items() if kind == "fixed"]] = True
        return cls(number, list(members), np.array(places), held, clamped, np.array(links, np.int32),
                   np.array(of_member), np.array(lengths), np.array(triads), spare)

    def section(self, e):
        """`Section` of element e."""
        return self.members[self.of_member[e]].section

    def elements(self, k):
        """Numbers of the elements of member k, from its first to its last end."""
        return np.flatnonzero(self.of_member == k)

    def inertias(self, links):
        """J (t, 3, 3) [kg m2] of all turns where elements are linked so."""
        found = np.zeros((len(self.clamped), 3, 3))
        for end in (2, 3):
            np.add.at(found, links[:, end], self.end_inertias)
        return found


def _triad(along, plane):
    """Rows: along, and two across; in a plane the last one is its normal, +y."""
    normal = np.array([0.0, 1.0, 0.0]) if plane else np.cross(along, np.eye(3)[np.abs(along).argmin()])
    normal = normal / np.linalg.norm(normal)
    return np.array([along, np.cross(normal, along), normal])
