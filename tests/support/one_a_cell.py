"""Adapters that let the particles of a cell share their change of volume, or deform as one (`components.f_bar`)."""

from snowmpm.components.f_bar.implicit import CellVolumes
from snowmpm.components.f_bar.mpm import CellMeans


def shared(kind, dim=2):
    """Of explicit MPM. kind: True, "whole" or False."""
    return [CellMeans(kind, dim)] if kind else []


def volumes_shared(wanted):
    """Of steps that are solved for."""
    return [CellVolumes()] if wanted else []
