"""From a scene to a simulation at time zero."""
