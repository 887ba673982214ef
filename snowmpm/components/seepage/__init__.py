"""SPH of water that seeps through grains at rest, leaves them and pools."""
