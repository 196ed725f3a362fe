"""Writers of .tfx, .tfxbone and .tfxmesh; their layout is in docs/assets_formats.md."""

import os
import struct
import tempfile

import numpy as np

from . import ExportError

_HEADER_SIZE = 160
_MAX_COORDINATE = 1e6
_MAX_NAME = 4095  # bytes


def tfx_bytes(positions, inverse_masses, strand_uv=None, thickness=None, colors=None):
    """A .tfx file, version 4.0.

    :param positions: [strand, vertex, 3] in metres. :param inverse_masses: [strand, vertex].
    :param strand_uv: [strand, 2]. :param thickness: [strand] factors >= 0.
    :param colors: [strand, vertex, 4].
    """
    strand_count, vertex_count = inverse_masses.shape
    if strand_count == 0:
        raise ExportError("there is no strand to export")
    if not 2 <= vertex_count <= 256:
        raise ExportError("%d vertices a strand; it must be 2 to 256" % vertex_count)
    _check_coordinates(positions.reshape(-1, 3), "hair")
    vertices = np.empty((strand_count, vertex_count, 4), dtype="<f4")
    vertices[:, :, :3] = positions
    vertices[:, :, 3] = inverse_masses
    # In the order of the offsets: positions, strand UV, vertex UV, thickness, colours.
    arrays = [vertices, strand_uv, None, thickness, colors]
    for what, array in zip(("position", "UV", "UV", "thickness", "colour"), arrays):
        if array is not None and not np.isfinite(np.asarray(array, dtype="<f4")).all():
            raise ExportError("hair: a %s is not a finite number" % what)
    arrays = [None if array is None else np.ascontiguousarray(array, dtype="<f4").tobytes()
              for array in arrays]
    offsets, end = [], _HEADER_SIZE
    for array in arrays:
        if array is not None and end >= 2**32:
            raise ExportError("the groom is larger than the 4 GB of a .tfx file; split it")
        offsets.append(0 if array is None else end)
        end += 0 if array is None else len(array)
    header = struct.pack("<fII5I", 4.0, strand_count, vertex_count, *offsets)
    return b"".join([header.ljust(_HEADER_SIZE, b"\0")] + [a for a in arrays if a is not None])


def tfxbone_bytes(bones, strand_bones, strand_weights):
    """A .tfxbone file: names, and [strand, 4] bones and weights."""
    parts = [struct.pack("<i", len(bones))]
    for index, name in enumerate(bones):
        text = _bone_name(name) + b"\0"
        parts.append(struct.pack("<ii", index, len(text)) + text)
    count = strand_bones.shape[0]
    records = np.zeros(count, dtype=[("strand", "<i4")] + [
        field for k in range(4) for field in (("bone%d" % k, "<i4"), ("weight%d" % k, "<f4"))])
    records["strand"] = np.arange(count)
    for k in range(4):
        records["bone%d" % k] = strand_bones[:, k]
        records["weight%d" % k] = strand_weights[:, k]
    return b"".join(parts + [struct.pack("<i", count), records.tobytes()])


def tfxmesh_bytes(bones, positions, normals, vertex_bones, vertex_weights, triangles):
    """A .tfxmesh file. Numbers are the shortest that read back to the same float."""
    _check_coordinates(positions, "the collision mesh")
    lines = ["# collision mesh: metres, bind pose", "numOfBones %d" % len(bones), "# index name"]
    lines += ["%d %s" % (index, _bone_name(name).decode("utf-8"))
              for index, name in enumerate(bones)]
    lines += ["numOfVertices %d" % len(positions),
              "# index, position, normal, 4 bones, 4 weights"]
    floats = np.concatenate((positions, normals), axis=1).astype(np.float32)
    weights = vertex_weights.astype(np.float32)
    for index in range(len(positions)):
        lines.append(" ".join([str(index)] + [_number(value) for value in floats[index]]
                              + [str(bone) for bone in vertex_bones[index]]
                              + [_number(value) for value in weights[index]]))
    lines += ["numOfTriangles %d" % len(triangles), "# index, 3 vertices"]
    lines += ["%d %d %d %d" % (index, t[0], t[1], t[2]) for index, t in enumerate(triangles)]
    return ("\n".join(lines) + "\n").encode("utf-8")


def write_files(files):
    """Writes all files ({path: bytes}) or none: each next to its place first, then renamed."""
    for path in files:
        if os.path.isdir(path):
            raise ExportError("%s is a folder, not a file" % path)
    waiting, current = [], ""
    try:
        for current, data in files.items():
            folder = os.path.dirname(os.path.abspath(current))
            handle, temporary = tempfile.mkstemp(
                prefix=".%s." % os.path.basename(current), suffix=".part", dir=folder)
            waiting.append((temporary, current))
            with os.fdopen(handle, "wb") as out:
                out.write(data)
            os.chmod(temporary, 0o666 & ~_umask())  # mkstemp() lets nobody else read it
        while waiting:
            temporary, current = waiting[0]
            os.replace(temporary, current)
            waiting.pop(0)
    except OSError as error:
        raise ExportError("cannot write %s: %s" % (current, error.strerror or error)) from error
    finally:
        for temporary, _ in waiting:
            os.remove(temporary)


def _umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _number(value):
    """The shortest text that reads back to the same 32-bit float."""
    if value == 0:
        return "0"
    if 1e-4 <= abs(value) < 1e7:
        return np.format_float_positional(value, trim="-")
    return np.format_float_scientific(value, trim="-", exp_digits=1)


def _check_coordinates(points, what):
    if not np.all(np.abs(points) <= _MAX_COORDINATE):
        raise ExportError("%s: a coordinate is beyond +-1e6 m; is the scale right?" % what)


def _bone_name(name):
    text = name.encode("utf-8")
    bad = any(c in name for c in "\0\r\n") or name != name.strip()
    if bad or not 1 <= len(text) <= _MAX_NAME:
        raise ExportError("the bone '%s' cannot be written: a name must have 1 to %d bytes, no "
                          "line ends, and no blank at its ends" % (name, _MAX_NAME))
    return text
