"""Snow cover under a flow in space that is thinner than its cells: taken up at the bed, by the laws of `.laws`.

Over each node of the grid in plan lies its share of the cover. What a law takes of it, from the speed, the thickness
and the friction of the flow above (`stepping.basal_friction`), adds up until it makes a particle: of the material of
the lowest particle there and with its stress, at half its own height above the ground. The snow over it is raised by
its volume. A cover that friction sets in motion joins with the impulse of that, or else at rest, and shares its
velocity with all snow above. Snow that flies takes nothing up; nor do laws by friction under snow that counts as at
rest, on which friction is less than that of sliding.

A flow may pass over a node before the law has taken a whole particle there. So each node begins with a part of one, all
parts equally often: over many nodes as much joins as the laws take, to a few particles.
"""

import numpy as np

from snowmpm.components.entrainment.declare import borne_by
from snowmpm.ground.friction import GroundFriction
from snowmpm.ground.states import evaluated
from snowmpm.particles.blocks import fields_of
from snowmpm.particles.population import Population
from snowmpm.particles.store import IDENTITY, MATERIAL
from snowmpm.quantities.motion import MOVING_SPEED
from snowmpm.stepping.basal_friction import ROOM, OverGround
from snowmpm.stepping.component import Adapter

LOOK = 0.5
"""Cells that snow and waves over the bed may go before the law is asked anew."""
JOIN = 2.0
"""Cells that they may go before what has been taken joins, which costs as much as some steps."""
LEAST = 0.125
"""Volume of the smallest particles over the usual one; of a thinner cover, one joins at a part of the nodes."""
TOUCHES = 1.0
"""Cells that snow may lie or fly above the ground to count as flow over it."""
SPREAD = np.array([[0.7548776662466927, 0.5698402909980532], [0.6180339887498949, 0.0]])
"""Parts of a cell by which one particle lies beside the one before: in 3-D, in 2-D."""


def adapter(model):
    """`SnowCover` of the scene of a `Model`."""
    scene, surface = model.scene, model.surface
    law = GroundFriction(scene.terrain.entrainment, scene.base_dir, surface.system, scene.source)
    nodes = OverGround(model.lower, model.upper, scene.solver.dx, surface.height, model.first_gravity)
    where = nodes.plan, surface, nodes.gravity
    return SnowCover(model, nodes, type(law.law), law.numbers_at(*where),
                     model.friction.stress_at(*where) if borne_by(scene) else None)


class SnowCover(Adapter):
    """What the flow of an `MpmSolver` takes up from the ground."""

    name = "entrainment"

    def __init__(self, model, nodes, law, numbers, stress):
        """nodes: `OverGround`; numbers (nodes, PARAMETERS) of the class `law`; stress: of friction, as
        `GroundFriction.stress_at` gives it, or None where the law asks for none."""
        self._model, self._nodes, self._law, self._numbers, self._stress = model, nodes, law, numbers, stress

    def begin(self, solver):
        """Share the cover out to the nodes, and each share to particles of about the usual volume."""
        self._solver, model, nodes = solver, self._model, self._nodes
        population, names = model.population, self._law.PARAMETERS._fields
        thickness, density = (self._numbers[:, names.index(name)] for name in ("thickness", "density"))
        half, plan = 0.5 * solver.dx, nodes.plan
        self._plan_area = np.maximum(0.0, np.minimum(plan + half, model.upper[:-1])
                                     - np.maximum(plan - half, model.lower[:-1])).prod(axis=1)
        bare = nodes.holes.ravel() | self._built_over()
        self._cover = np.where(bare, 0.0, thickness * density * self._plan_area / nodes.cosines.ravel())
        usual = solver.particles.mass / population.volumes.sum() * model.scene.solver.spacing(solver.dim) ** solver.dim
        self._portion = np.maximum(self._cover / np.maximum(1.0, np.round(self._cover / usual)), LEAST * usual)
        places = np.indices(nodes.shape).reshape(2, -1)
        self._begun = (SPREAD[3 - solver.dim] @ places) % 1.0 * self._portion
        self._flows = np.array([law.YIELDS for law in model.all_laws])
        self._places, self._bodies = population.positions, model.body_of
        self._first = len(self._places)
        self._wave = float(np.sqrt(np.linalg.norm(solver.gravity) * solver.dx))
        self.restart()

    def _built_over(self):
        """Nodes (n,) on whose ground an obstacle stands that does not move."""
        model, plan = self._model, self._nodes.plan
        found = np.zeros(len(plan), bool)
        for obstacle in model.obstacles:
            if obstacle.still:
                corners = obstacle.shape.drawing()[0][:, :-1]
                near = np.flatnonzero(((plan >= corners.min(axis=0)) & (plan <= corners.max(axis=0))).all(axis=1))
                ground = np.asarray(model.surface.height(plan[near]), float)
                near, ground = near[np.isfinite(ground)], ground[np.isfinite(ground)]
                if len(near):
                    found[near] |= obstacle.shape.query(np.column_stack([plan[near], ground + self._height]))[0] < 0.0
        return found

    @property
    def _height(self):
        """At which particles join, above level ground [m]."""
        return 0.5 * self._model.scene.solver.spacing(self._solver.dim)

    def restart(self):
        """Time zero is now."""
        self._left, self._owed = self._cover.copy(), self._begun.copy()
        # mass [kg] since a particle joined at the node, and the impulse [N s] that friction gave it
        self._since, self._push = np.zeros(len(self._cover)), np.zeros(len(self._cover))
        self._way = self._looked = self._elapsed = self._joined = self._energy = self._mixed = 0.0
        self._given = np.zeros(self._solver.dim)
        self._keep(self._places[: self._first], self._bodies[: self._first])

    def _keep(self, places, bodies):
        """Particles have numbers after those of the start."""
        self._places, self._bodies = places, bodies
        store = self._solver.particles
        store.origins, store.bodies = (None, None) if len(places) == self._first else (places, bodies)

    def end_step(self, dt):
        """Take up what the flow has set in motion since the last look."""
        solver = self._solver
        if solver.damping_factor == 1.0 and solver.particles.count:
            self._elapsed += dt
            self._way += (solver.extremes.speed + self._wave) * dt / solver.dx
            if self._way - self._looked > LOOK:
                self._take_up()
                self._looked, self._elapsed = self._way, 0.0
            if self._way > JOIN:
                self._way = self._looked = 0.0
                ready = np.flatnonzero((self._since > 0.0) & (self._owed >= self._portion * (1.0 - 1e-9)))
                if len(ready):
                    self._join(ready)

    def _take_up(self):
        """What the law takes in the time since the last look."""
        over = self._nodes.states(self._solver.particles)
        rows, (density, _, speed, thick) = over.rows, over.states.T
        tau = np.zeros(len(rows))
        if self._stress:
            dry, rate = self._stress(rows, over.states).T
            tau = np.where(speed > MOVING_SPEED, np.maximum(0.0, dry + rate * speed), 0.0)
        rates, borne = evaluated(self._law.intake, self._law.PARAMETERS, self._numbers[rows],
                                 np.column_stack([density, tau, speed, thick])).T
        # of the bed of a node, as much as its snow covers that is as thick as around it
        bed = np.where(over.gaps < TOUCHES * self._solver.dx, over.volumes / thick, 0.0)
        # friction takes no more momentum than the flow has: at speeds near 0 the law of a strength would
        wanted = np.minimum(np.maximum(0.0, rates) * bed * self._elapsed, density * over.volumes)
        taken = np.minimum(wanted, self._left[rows])
        self._left[rows] -= taken
        self._owed[rows] += taken
        self._since[rows] += taken
        self._push[rows] += (1.0 - borne) * tau * bed * self._elapsed * taken / np.maximum(wanted, 1e-300)

    def _join(self, ready):
        """Let what is owed at nodes join as particles, where there is snow."""
        solver, store, dim = self._solver, self._solver.particles, self._solver.dim
        table, labels, densities = store.table(), store.labels(), store.densities()
        x = store.positions(table[:, store.layout.columns("position")].astype(float))
        cells = (x[:, :-1] - self._model.lower[:-1]) / solver.dx + ROOM
        place = np.column_stack([np.floor(cells + 0.5).astype(int), np.zeros((len(x), 3 - dim), int)])
        node = np.ravel_multi_index(tuple(place.T), self._nodes.shape, mode="clip")
        above = np.flatnonzero(np.isin(node, ready) & self._flows[labels[:, MATERIAL]])
        above = above[np.lexsort((x[above, -1], node[above]))]
        ready, lowest = np.unique(node[above], return_index=True)
        donors = above[lowest]
        if not len(ready):
            return
        counts = np.floor(self._owed[ready] / self._portion[ready] + 1e-9).astype(int)
        portion, speed = self._portion[ready], self._push[ready] / self._since[ready]
        self._owed[ready] = np.maximum(0.0, self._owed[ready] - counts * portion)
        self._since[ready] = self._push[ready] = 0.0

        masses = table[:, store.layout.offsets["volume"]].astype(float) * densities
        over = above, np.searchsorted(ready, node[above])
        velocity = self._mix(table, masses, over, donors, counts * portion, speed)
        each, donor = np.repeat(np.arange(len(ready)), counts), np.repeat(donors, counts)
        numbers, mass = len(self._places) + np.arange(len(each)), portion[each]
        columns = {name: table[donor, store.layout.columns(name)].astype(float) for name in store.layout.sizes}
        added = Population(
            self._beside(self._nodes.plan[ready[each]], self._nodes.cosines.ravel()[ready[each]], numbers),
            mass / densities[donor], labels[donor, MATERIAL], velocities=velocity[each], elastic=columns["elastic"],
            stress=columns["stress"], volume_ratio=columns["volume_ratio"][:, 0], state=columns["state"],
            field=np.repeat(fields_of(store.blocks.keys, dim), np.diff(store.blocks.start))[donor],
            columns={name: columns[name] for name, _ in store.layout.more})
        rise = self._rise(cells, ready[each], added.volumes * added.volume_ratio)
        table[:, store.layout.offsets["position"] + dim - 1] += (rise / solver.dx).astype(table.dtype)
        store.overwrite(table)
        elastic = store.materials.elastic_energy(added.material, added.stress, added.state, added.volumes)
        self._energy += float(elastic - solver.gravity[-1] * (masses @ rise)
                              - mass @ (added.positions @ solver.gravity))
        self._joined += float(mass.sum())
        solver.receive(added, numbers)
        self._keep(np.vstack([self._places, added.positions]),
                   np.concatenate([self._bodies, self._bodies[labels[donor, IDENTITY]]]))

    def _mix(self, table, masses, over, donors, joining, speed):
        """Let what joins share its velocity with all snow above, as a depth-averaged law has it; -> that of what joins
        at each node (k, dim): the one of the lowest particle, a row of `donors`. over: rows of the snow above, and
        which node each is over; joining (k,) [kg]; speed (k,) [m/s] that friction has given it along the flow."""
        at = self._solver.particles.layout.columns("velocity")
        rows, which = over
        mass, before, low = masses[rows], table[rows, at].astype(float), table[donors, at].astype(float)
        own = low * (speed / np.maximum(np.linalg.norm(low, axis=1), 1e-30))[:, None]
        share = joining / (joining + np.bincount(which, mass, len(joining)))
        change = (own - low) * share[:, None]
        table[rows, at] = after = (before + change[which]).astype(table.dtype)
        given = joining @ own
        self._solver.add_impulse(given)
        self._given += given
        self._energy += 0.5 * float(joining @ (own**2).sum(axis=1))
        self._mixed += 0.5 * float(mass @ (before**2 - after.astype(float) ** 2).sum(axis=1)
                                   + joining @ (own**2 - (low + change) ** 2).sum(axis=1))
        return low + change

    def _rise(self, cells, nodes, volumes):
        """How far snow at `cells` (n, dim - 1) in plan is raised by volumes that join at nodes (k,) [m]: linear between
        nodes."""
        from scipy.ndimage import map_coordinates  # slow to import

        dim, shape = self._solver.dim, self._nodes.shape
        raised = np.bincount(nodes, volumes, len(self._cover)) / np.maximum(self._plan_area, 1e-300)
        return map_coordinates(raised.reshape(shape)[:, slice(None) if dim == 3 else 0], cells.T, order=1,
                               mode="constant")

    def _beside(self, plan, cosines, numbers):
        """Places of particles with these numbers near nodes in plan, on the ground."""
        solver, model = self._solver, self._model
        step = SPREAD[3 - solver.dim, : solver.dim - 1]
        edge = 0.01 * solver.dx
        beside = np.clip(plan + ((np.outer(numbers, step)) % 1.0 - 0.5) * solver.dx, model.lower[:-1] + edge,
                         model.upper[:-1] - edge)
        height = np.asarray(model.surface.height(beside), float)
        hole = np.isnan(height)
        if hole.any():
            beside[hole] = plan[hole]
            height[hole] = model.surface.height(plan[hole])
        return np.column_stack([beside, height + self._height / cosines])

    def entrained(self):
        """Mass that has joined [kg]."""
        return self._joined

    def given(self, lift):
        """Energy of what has joined, and of raising the snow above."""
        return {"cover_energy": self._energy + self._joined * lift}

    def impulses(self):
        """That of cover which friction has set in motion."""
        return [self._given]

    def damping_work(self):
        """Energy that was lost when what joined shared its velocity with the snow beside it."""
        return self._mixed

    def units(self):
        """Unit of the energy."""
        return {"cover_energy": "J/m" if self._solver.dim == 2 else "J"}

    def work(self):
        """Particles that are looked at."""
        return {"step": 1, "particle": self._solver.particles.count}

    @property
    def bytes(self):
        """Of the tables of nodes."""
        return 8 * (8 + self._numbers.shape[1]) * len(self._cover)

    def state(self):
        """What is left, what is owed, and which particles have come."""
        return {"left": self._left.copy(), "owed": self._owed.copy(), "since": self._since.copy(),
                "push": self._push.copy(), "given": self._given.copy(), "sums": np.array([
                    self._way, self._looked, self._elapsed, self._joined, self._energy, self._mixed]),
                "places": self._places[self._first :].copy(), "bodies": self._bodies[self._first :].copy()}

    def restore(self, state):
        """Take over what `state()` gave. Raises ValueError for what no run leaves."""
        found = {name: np.array(state[name], float) for name in ("left", "owed", "since", "push", "given", "sums",
                                                                 "places", "bodies")}
        now, most = self.state(), len(self._model.scene.bodies)
        fits = all(np.isfinite(values).all() and values.shape[1:] == now[name].shape[1:]
                   and (name in ("places", "bodies") or values.shape == now[name].shape)
                   for name, values in found.items())
        bodies = found["bodies"].astype(int)
        if not (fits and len(bodies) == len(found["places"]) and ((bodies >= 0) & (bodies < most)).all()
                and (found["left"] >= 0.0).all() and (found["left"] <= self._cover).all()
                and (found["owed"] >= 0.0).all() and (found["owed"] <= self._cover + self._portion).all()):
            raise ValueError("snow cover that is none of this scene")
        self._left, self._owed, self._since, self._push, self._given = (
            found[name] for name in ("left", "owed", "since", "push", "given"))
        self._way, self._looked, self._elapsed, self._joined, self._energy, self._mixed = map(float, found["sums"])
        self._keep(np.vstack([self._places[: self._first], found["places"]]),
                   np.concatenate([self._bodies[: self._first], bodies]))
