"""Pictures of runs in three dimensions as a film camera would take them, drawn by PyVista without a display."""
