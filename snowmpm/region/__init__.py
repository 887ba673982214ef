"""A whole region: potential release areas, a flow from each of them, and maps over all."""
