"""The part of the exporters that no modelling program is needed for: options, resampling, binding
of roots to a mesh, and the writers of .tfx, .tfxbone and .tfxmesh. Python 3.7 or newer and numpy.
"""


class ExportError(Exception):
    """Why nothing was exported, in words that an artist can act on."""
