"""Masses of bodies, and limits and motors of joints, that a plugin or a program has set.

They are in states, branches, batches and the history, with the same bits; a reset makes
them what the files say.
"""

import math

import numpy as np
import pytest
from test_branches import actions_of, assert_goes_on, assert_goes_on_alike, drive, physics

from flatland2d import Simulation, SimulationBatch
from flatland_server import BatchRole, ModelPlugin, PluginLoader


def rig(model, k):
    """Gives a robot's bodies other masses, and its hinge limits and a motor."""
    base, front = (model.bodies[name].physics_body for name in ("base", "front"))
    base.set_mass(1.0 + k, inertia=0.02 * k, local_center=(-0.05, 0.03 * k))
    front.set_mass(0.3 * k, local_center=(0.04, 0.0))
    hinge = model.get_joint("front").physics_joint
    hinge.limits = (-0.2 * k, 0.5)
    hinge.motor = (2.0 - k, 0.1)


def rigging(model):
    """The limits, motor and mass that `rig` sets."""
    hinge = model.get_joint("front").physics_joint
    bodies = [body.physics_body for body in model.bodies.values()]
    masses = [(body.mass, body.inertia, body.local_center) for body in bodies]
    return [masses, hinge.limits, hinge.motor]


class Rigger(ModelPlugin):
    """Sets them when it starts."""

    batch_role = BatchRole()

    def on_initialize(self, config):
        rig(self.model, 2)


class Winder(ModelPlugin):
    """Sets them in its hook, others each time."""

    def on_initialize(self, config):
        pass

    def before_physics_step(self, timekeeper):
        rig(self.model, 1.5 + math.sin(7.0 * timekeeper.seconds))

    def get_state(self):
        return None


class Loader(PluginLoader):
    def load(self, type, base):
        return {"Rigger": Rigger, "Winder": Winder}.get(type) or super().load(type, base)


DRIVES = ["DiffDrive", "TricycleDrive"]


@pytest.mark.parametrize("name", DRIVES)
def test_states_branches_and_batches_have_what_a_program_has_set(world_of, name):
    world = world_of(noise="0.02", drive=name)
    with Simulation(world, seed=2) as simulation, Simulation(world, seed=2) as plain:
        robot = simulation.models["robot"]
        of_file = rigging(robot.model)
        rig(robot.model, 2)
        drive(simulation, 20), drive(plain, 20)
        assert physics(simulation.save_state()) != physics(plain.save_state())
        state = simulation.save_state()
        with simulation.branch(3, threads=2) as batch:
            assert_goes_on(batch, simulation)
            batch.reset()
            [of_batch] = batch.save_states(np.arange(3) == 1)
            simulation.load_state(state)
            assert_goes_on(batch, simulation, seed=5)
            rig(robot.model, 1)  # others than when it has branched off
            batch.load_states(simulation.save_state())
            assert_goes_on(batch, simulation)
        for each in (state, of_batch):
            with Simulation(world) as other:
                assert rigging(other.models["robot"].model) == of_file
                other.load_state(each)
                assert rigging(other.models["robot"].model) != of_file
                simulation.load_state(each)
                assert_goes_on_alike(other, simulation)
        simulation.reset()
        assert rigging(simulation.models["robot"].model) == of_file


def test_environments_of_a_batch_may_differ_in_mass_and_joints(world_of):
    world = world_of()
    with SimulationBatch(world, 6, threads=2) as batch:
        simulations = [Simulation(world, seed=k) for k in range(6)]
        for k, each in enumerate(simulations):
            if k % 3:
                rig(each.models["robot"].model, k)
        batch.load_states([each.save_state() for each in simulations])
        actions = actions_of(simulations[0], 30, np.random.default_rng(1))
        found = [batch.step(np.tile(each, (6, 1)), 7) for each in actions]
        saved = batch.save_states()
        for k, each in enumerate(simulations):
            rows = drive(each, 30, 1)
            for observation, (ranges, pose, velocity, _) in zip(found, rows):
                assert np.array_equal(observation.ranges[k], ranges)
                assert np.array_equal(observation.poses[k], pose)
                assert np.array_equal(observation.velocities[k], velocity)
            expected = rigging(each.models["robot"].model)
            each.load_state(saved[k])
            assert rigging(each.models["robot"].model) == expected
            each.close()
        batch.reset()
        with Simulation(world) as fresh:
            assert_goes_on(batch, fresh)


@pytest.mark.parametrize("name", DRIVES)
def test_a_batch_has_what_a_plugin_sets_when_it_starts(world_of, name):
    world = world_of(drive=name, others="\n  - {type: Rigger, name: rigger}")
    simulation = Simulation(world, loader=Loader())
    with simulation, SimulationBatch(world, 3, loader=Loader()) as batch:
        assert_goes_on(batch, simulation)
        batch.reset()
        simulation.reset()
        assert simulation.models["robot"].model.base.physics_body.mass == 3.0
        assert_goes_on(batch, simulation)


def test_seek_restores_masses_and_joints_of_that_time(world_of):
    world = world_of(noise="0.02", others="\n  - {type: Winder, name: winder}")
    with Simulation(world, seed=3, loader=Loader()) as simulation:
        simulation.keep_history(interval=0.3)

        def seen():
            robot = simulation.models["robot"]
            return [*rigging(robot.model), simulation.poses.tolist(), robot.velocity]

        states = {}
        for _ in range(30):
            drive(simulation, 1, steps=13)
            states[simulation.time] = seen()
        last = simulation.save_state()
        for time in [*list(states)[-2::-5], *list(states)[1::4]]:
            assert simulation.seek(time).time == time
            assert seen() == states[time]
        assert simulation.seek(max(states)).save_state() == last
        simulation.reset()
        for time in list(states)[:10]:
            drive(simulation, 1, steps=13)
            assert (simulation.time, seen()) == (time, states[time])
