"""What components of water share: permeability, drag, cells that hold material, columns and balance of the water."""
