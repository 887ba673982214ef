"""A dilute cloud of ice grains in air above a depth-averaged flow: an experiment, see `cautions`."""
