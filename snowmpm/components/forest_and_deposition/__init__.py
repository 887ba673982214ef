"""Trees on the ground of a depth-averaged flow, and snow that becomes ground where it stops."""
