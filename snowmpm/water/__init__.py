"""Water in the pores of snow and soil: its flow through the cells that hold material, its pressure, its budget."""
