#!/usr/bin/env python3
"""How fine the fixed time step lets the game fluid be: prints the table of notes/fluid.md. From the repository, once it
is built, /usr/bin/python3 notes/experiments/fluid_time_step.py

A cube of 16^3 particles that nothing holds settles, at 470 a metre. About where it settled the step is linear, and a
power iteration finds by which factor a motion grows in it. Distances scale as 1/n and the linear forces as n^2, so the
same cube says what happens at other n particles a metre. Beside that stands what `lockstep run` makes of a cube of that
n.
"""

import pathlib
import subprocess
import tempfile

import numpy as np

SETTLED = 470  # particles a metre
TIME_STEP = 0.001  # s
REST_DENSITY = 1000
SCENE = """kind = "fluid"
particles_per_metre = {n}
walls = false
gravity = [0, 0, 0]
[[block]]
min = [-{half}, -{half}, -{half}]
max = [{half}, {half}, {half}]
"""


def run(n, steps):
    """Positions and velocities of the cube after some steps of the program; None if it refused to make them."""
    with tempfile.TemporaryDirectory() as folder:
        scene, end = pathlib.Path(folder, "cube.toml"), pathlib.Path(folder, "end.fluid")
        scene.write_text(SCENE.format(n=n, half=8 / n + 1e-7))
        command = ["build/lockstep", "run", "--scene", scene, "--frames", str(steps), "--out", end]
        if subprocess.run(command, capture_output=True).returncode:
            return None
        # particles a metre, how many, and of each its position, half-step velocity and velocity
        state = np.fromfile(end, "<f4", offset=8).reshape(-1, 9).astype(float)
    return state[:, :3], state[:, 6:]


class Linear:
    """The forces at rest in the settled cube, with the constants of common/fluid/model.h, and their derivatives."""

    def __init__(self, position):
        self.count = len(position)
        h = 1.695 / SETTLED
        mass = REST_DENSITY / SETTLED**3
        apart = position[:, None] - position[None]
        squared = (apart**2).sum(-1)
        self.i, self.j = np.nonzero((squared < h * h) & ~np.eye(self.count, dtype=bool))
        self.apart = apart[self.i, self.j]
        self.distance = np.sqrt(squared[self.i, self.j])
        density_coefficient = mass * 315 / (64 * np.pi * h**9)
        self.density = density_coefficient * (h**6 + self.sum((h * h - self.distance**2) ** 3))
        density = np.sqrt(self.density[self.i] * self.density[self.j])
        overlap = h - self.distance
        # Pressure is zero here, the density being the rest density: what changes it is the change of densities alone.
        self.density_gradient = -6 * density_coefficient * (h * h - self.distance**2)[:, None] ** 2 * self.apart
        self.pressure = (3 * 15 / (np.pi * h**6) * 0.5 * 3 * mass * overlap**2 / (self.distance * density**2))[
            :, None
        ] * self.apart
        self.viscosity = (0.4 * 45 / (np.pi * h**6) * mass * overlap / density**2)[:, None]

    def sum(self, pairs):
        """Of what the pairs give to their first particle."""
        columns = pairs.reshape(len(pairs), -1).T
        sums = [np.bincount(self.i, column, self.count) for column in columns]
        return sums[0] if pairs.ndim == 1 else np.stack(sums, 1)

    def push(self, displacement):
        """Accelerations by small displacements."""
        density = self.sum((self.density_gradient * (displacement[self.i] - displacement[self.j])).sum(1))
        return self.sum(self.pressure * (density[self.i] + density[self.j])[:, None])

    def drag(self, velocity):
        """Accelerations by velocities."""
        return self.sum(self.viscosity * (velocity[self.j] - velocity[self.i]))


def greatest(operator, start):
    """The greatest eigenvalue of minus a linear operator."""
    for _ in range(400):
        start = start / np.linalg.norm(start)
        image = -operator(start)
        value, start = (start * image).sum(), image
    return value


def growth(linear, n, time_step, start, steps=400, judged=100):
    """The factor by which the last of the steps let half-step velocities grow, from random displacements."""
    scale = (n / SETTLED) ** 2
    displacement, half_velocity, velocity = start, 0 * start, 0 * start  # velocities in m a step
    for step in range(steps):
        if step == steps - judged:
            before = np.linalg.norm(half_velocity)
        acceleration = scale * (time_step**2 * linear.push(displacement) + time_step * linear.drag(velocity))
        half_velocity, last = half_velocity + acceleration, half_velocity
        displacement = displacement + half_velocity
        velocity = (last + half_velocity) / 2
    return (np.linalg.norm(half_velocity) / before) ** (1 / judged)


def main():
    linear = Linear(run(SETTLED, 1000)[0])
    start = np.random.default_rng(1).normal(size=(linear.count, 3))
    nearest = np.full(linear.count, np.inf)
    np.minimum.at(nearest, linear.i, linear.distance)
    print(
        f"settled at {SETTLED} a metre: densities within {np.abs(linear.density / REST_DENSITY - 1).max():.1e} of the"
        " rest density,"
    )
    print(f"nearest neighbours at {np.median(nearest) * SETTLED:.2f} of the lattice's spacing,")
    print(
        f"greatest (w dt)^2 {greatest(linear.push, start) * TIME_STEP**2:.2f}, l dt"
        f" {greatest(linear.drag, start) * TIME_STEP:.2f}"
    )
    print(f"{'a metre':>8} {'growth a step':>14} {'speed after 600':>16} {'after 3000 steps, rms, m/s':>27}")
    for n in (470, 500, 520, 540, 560, 600, 640, 700, 800):
        ends = [run(n, steps) for steps in (600, 3000)]
        speeds = [f"{np.sqrt((end[1] ** 2).sum(1).mean()):.1e}" if end else "refused" for end in ends]
        print(f"{n:8} {growth(linear, n, TIME_STEP, start):14.3f} {speeds[0]:>16} {speeds[1]:>27}")
    print(f"     800 {growth(linear, 800, 0.4 * TIME_STEP, start):14.3f} at 0.4 of the time step")


if __name__ == "__main__":
    main()
