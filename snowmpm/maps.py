"""Peak values in plan over a run: what hazard mapping works with."""

import numpy as np

UNITS = {"peak_depth": "m", "peak_speed": "m/s", "deposit_depth": "m"}


class PeakMaps:
    """Largest flow depth and speed that each plan cell has seen.

    depth [m]: volume of snow standing over a cell divided by the cell's plan area, that is measured vertically;
    speed [m/s]: mass-weighted mean over the particles of the cell. NaN where no snow ever was.
    """

    def __init__(self, lower, upper, cell):
        """lower, upper: plan corners (2,) [m]; cell: side of a cell [m]."""
        self.lower, self.cell = np.asarray(lower, float), float(cell)
        self.shape = tuple(np.maximum(1, np.ceil((np.asarray(upper) - self.lower) / cell).astype(int)))
        self.values = {name: np.zeros(self.shape) for name in ("peak_depth", "peak_speed")}

    def see(self, positions, volumes, masses, speeds):
        """Take in a state: positions (n, 3) [m] in the coordinates of the corners."""
        index = np.floor((positions[:, :2] - self.lower) / self.cell).astype(np.int64)
        inside = ((index >= 0) & (index < self.shape)).all(axis=1)
        flat = np.ravel_multi_index(index[inside].T, self.shape)
        size = self.shape[0] * self.shape[1]

        def total(weights):
            return np.bincount(flat, weights[inside], size).reshape(self.shape)

        depth, mass = total(volumes) / self.cell**2, total(masses)
        speed = total(masses * speeds) / np.maximum(mass, 1e-300)
        np.maximum(self.values["peak_depth"], depth, out=self.values["peak_depth"])
        np.maximum(self.values["peak_speed"], speed, out=self.values["peak_speed"])
        self.values["deposit_depth"] = depth

    def rasters(self):
        """name -> (values (rows along y, columns along x), x0, y0, cell) with the centre of the first cell."""
        x0, y0 = self.lower + 0.5 * self.cell
        touched = self.values["peak_depth"] > 0.0
        return {name: (np.where(touched, values, np.nan).T, x0, y0, self.cell) for name, values in self.values.items()}
