"""A small campaign: coarse depth-averaged runs on the made-up valley, and a cluster of two workers to do them."""

from pathlib import Path

from snowmpm.campaigns.spec import CampaignFile

COARSE = {"solver.dx": 20.0, "solver.particles_per_cell": 2, "end_time": 40.0, "output.interval": 8.0,
          "terrain.friction": {"law": "voellmy", "mu": 0.25, "xi": 1500.0}}
FRICTION = {"mu": {"key": "terrain.friction.mu", "distribution": "uniform", "low": 0.2, "high": 0.35},
            "xi": {"key": "terrain.friction.xi", "distribution": "uniform", "low": 1000.0, "high": 2000.0}}


def small_file(runs=8, **options):
    """`CampaignFile` of some coarse runs; options: its keys."""
    data = {"name": "small", "scene": "avalanche_depth_averaged", "design": "latin_hypercube", "runs": runs,
            "set": COARSE, "parameters": FRICTION, "maps": {"cell": 20.0}, **options}
    if data["runs"] is None:
        del data["runs"]
    return CampaignFile.checked(data, "small.toml", Path.cwd())
