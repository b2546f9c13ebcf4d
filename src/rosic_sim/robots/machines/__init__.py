"""The physics of the simulated robots: pure kinematics, no clock, no chance, no I/O.

Time is an argument everywhere; the same calls at the same times give the same motion to the last
bit. The same code runs in process and inside ROS 2 nodes. Start at `world.build_world`; every
machine keeps the promises of `machine.Machine`.

The simulations know where they are exactly: there is no sensor noise and no wheel slip. What is
honest is the motion: speed, acceleration and joint limits of the makers' data sheets hold in
every step, and what a machine reports is what it measured, never what it was asked.
"""

from __future__ import annotations
