"""Options of an export: the same names, meanings and defaults in Blender, in Maya and, with dashes,
in pelage-convert."""

from . import ExportError

MIN_VERTICES, MAX_VERTICES = 2, 256
MAX_SEED = 2**31 - 1  # what a property of Blender can hold
UP_AXES = ("X", "Y", "Z")
COLLISIONS = ("NONE", "SURFACE", "COLLECTION")
SPLITS = ("WHOLE", "OBJECT", "MATERIAL")


class Option:
    """What the user interfaces show of an option; `kind` is int, float, bool, str, or a tuple of
    the values to choose from."""

    def __init__(self, kind, default, label, text, low=None, high=None):
        self.kind, self.default, self.label, self.text = kind, default, label, text
        self.low, self.high = low, high


# up_axis has the default of the program: each exporter sets its own.
OPTIONS = {
    "vertices_per_strand": Option(
        int, 16, "Vertices per Strand",
        "Vertices of every strand; curves are resampled at equal distances along their length",
        MIN_VERTICES, MAX_VERTICES),
    "min_curve_length": Option(
        float, 0.0, "Minimum Curve Length",
        "Shorter curves are left out [m]; 0 keeps all that have a length", 0.0, 1e6),
    "both_ends_immovable": Option(
        bool, False, "Both Ends Immovable",
        "The last two vertices of a strand follow the bones, too, as the first two do"),
    "invert_z": Option(
        bool, False, "Invert Z",
        "Mirror hair and meshes: z becomes -z, in the axes of the file"),
    "invert_v": Option(
        bool, False, "Invert V",
        "v becomes 1 - v: for engines whose textures start at the top"),
    "randomize_strands": Option(
        bool, False, "Randomize Strands",
        "Shuffle the strands, so that the first ones alone cover the groom (level of detail)"),
    "seed": Option(int, 1, "Seed", "Another seed is another order of the strands", 0, MAX_SEED),
    "scale": Option(
        float, 1.0, "Scale", "Factor on all lengths, after the units of the scene", 1e-9, 1e9),
    "up_axis": Option(
        UP_AXES, "Y", "Up Axis", "Axis that points up in the scene; it becomes y in the files"),
    "export_hair": Option(bool, True, "Hair", "Write the strands: a .tfx file"),
    "export_bones": Option(
        bool, True, "Bone Weights",
        "Write which bones move each root: a .tfxbone file, for the strands of the same options"),
    "collision": Option(
        COLLISIONS, "SURFACE", "Collision Mesh", "What the .tfxmesh file is made of"),
    "collision_split": Option(
        SPLITS, "WHOLE", "Split",
        "One .tfxmesh file in all, or one for each object or material"),
}

# Names of the options of an export of collision meshes alone.
COLLISION_OPTIONS = ("scale", "up_axis", "invert_z", "collision_split")


class ExportOptions:
    """Values of OPTIONS; those not given have their defaults. Misfits raise ExportError."""

    def __init__(self, **values):
        for name in values:
            if name not in OPTIONS:
                raise ExportError("there is no option '%s'" % name)
        for name, option in OPTIONS.items():
            value = values.get(name, option.default)
            if isinstance(option.kind, tuple):
                if value not in option.kind:
                    raise ExportError("%s is '%s'; it must be one of %s"
                                      % (name, value, ", ".join(option.kind)))
            elif option.kind is bool:
                value = bool(value)
            else:
                try:
                    value = option.kind(value)
                except (TypeError, ValueError, OverflowError):
                    raise ExportError("%s is '%s', which is not a number" % (name, value))
                if not option.low <= value <= option.high:
                    raise ExportError("%s is %s; it must be %s to %s"
                                      % (name, value, option.low, option.high))
            setattr(self, name, value)
