"""Water that fills the pores of the snow and flows through them by Darcy's law."""
