"""Free rigid bodies: obstacles that snow, weight and contact move."""
