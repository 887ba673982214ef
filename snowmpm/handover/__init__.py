"""Snow from one method to another while a scene runs: particles in space become columns in plan, and back."""
