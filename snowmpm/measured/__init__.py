"""What benchmarks and studies measured, as tables that ship: costs of a step, borders of stability."""
