"""Implicit MPM: steps that are solved for, in time or at rest, on the particles, laws and surfaces of `snowmpm.mpm`."""
