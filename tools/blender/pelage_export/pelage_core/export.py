"""From curves and meshes in rest pose to files."""

import os
import re

import numpy as np

from . import ExportError, files, hair

# A root farther from its mesh than this [m] is worth a warning.
FAR_ROOT = 0.005


class Report:
    """What an export did: `lines` and `warnings` for people; the counts for scripts."""

    def __init__(self):
        self.lines, self.warnings, self.paths = [], [], []
        self.strand_count = self.skipped_count = 0
        self.max_root_distance = 0.0


def export(path, curve_list, collision_surfaces, options, unit=1.0):
    """Writes NAME.tfx, NAME.tfxbone and the collision meshes: those that are chosen, all of them or
    none.

    :param path: of the .tfx file; the others lie next to it.
    :param curve_list: HairCurves in rest pose. :param collision_surfaces: Surfaces, may be empty.
    :param unit: metres of a unit of the scene, in which curves and surfaces are.
    :returns: Report. Raises ExportError.
    """
    if not curve_list:
        raise ExportError("there is no hair to export: select an object with particle hair, hair "
                          "curves or curves")
    base = _without(".tfx", path)
    report = Report()
    surfaces = [curves.surface for curves in curve_list if curves.surface is not None]
    bones = _bone_table(surfaces + list(collision_surfaces))
    factor = options.scale * unit
    groom = _Groom(curve_list, options, factor, bones, report)
    contents = {}
    if options.export_hair:
        contents[base + ".tfx"] = groom.tfx(
            hair.up_matrix(options.up_axis, options.invert_z) * factor)
    if options.export_bones and groom.bound:
        contents[base + ".tfxbone"] = files.tfxbone_bytes(
            list(bones), groom.strand_bones, groom.strand_weights)
    _add_meshes(contents, base, collision_surfaces, bones, options, factor, report)
    if not contents:
        raise ExportError("there is nothing to write: choose hair, bone weights of hair on a mesh, "
                          "or a collision mesh")
    return _write(contents, report)


def export_collision(path, surfaces, options, unit=1.0):
    """Writes collision meshes alone, all of them or none.

    :param path: of the .tfxmesh file; parts of a split mesh lie next to it. :param surfaces:
        Surfaces. :param unit: as in export(). :returns: Report. Raises ExportError.
    """
    if not surfaces:
        raise ExportError("there is no mesh to export: select a mesh")
    report, contents = Report(), {}
    _add_meshes(contents, _without(".tfxmesh", path), surfaces, _bone_table(surfaces), options,
                options.scale * unit, report)
    return _write(contents, report)


def _without(extension, path):
    base, found = os.path.splitext(path)
    return base if found.lower() == extension else path


def _add_meshes(contents, base, surfaces, bones, options, factor, report):
    axes = hair.up_matrix(options.up_axis, options.invert_z)
    for suffix, surface_parts in _split(surfaces, options.collision_split):
        name = base + suffix + ".tfxmesh"
        if name in contents:
            raise ExportError("two collision meshes would be called %s; rename an object or a "
                              "material" % os.path.basename(name))
        contents[name] = _mesh_bytes(surface_parts, bones, axes, factor, options.invert_z, report)


def _write(contents, report):
    files.write_files(contents)
    report.paths = list(contents)
    report.lines.append("wrote " + ", ".join(os.path.basename(name) for name in contents))
    return report


class _Groom:
    """All strands of an export, in the order of the file."""

    def __init__(self, curve_list, options, factor, bones, report):
        strands, uv, tints, influences = [], [], [], []
        for curves in curve_list:
            part = hair.resample(curves, options.vertices_per_strand,
                                 options.min_curve_length / factor)
            report.skipped_count += curves.curve_count - len(part.positions)
            strands.append(part)
            self._bind(curves, part, factor, bones, report, uv, tints, influences)
        self.positions = np.concatenate([part.positions for part in strands])
        count = report.strand_count = len(self.positions)
        if count == 0:
            raise ExportError("none of the %d curves is at least %g m long; check "
                              "min_curve_length and scale"
                              % (report.skipped_count, options.min_curve_length))
        self.masses = hair.inverse_masses(count, options.vertices_per_strand,
                                          options.both_ends_immovable)
        self.thickness = self._thickness(strands, factor, report)
        self.colors = self._colors(strands, tints)
        self.uv = None
        if any(part is not None for part in uv):
            self.uv = np.concatenate([np.zeros((len(part.positions), 2)) if known is None else known
                                      for part, known in zip(strands, uv)])
            if options.invert_v:
                self.uv[:, 1] = 1 - self.uv[:, 1]
        self.bound = any(part is not None for part in influences)
        if self.bound:
            self._join_influences(strands, influences)
        if options.randomize_strands:
            self._reorder(hair.random_order(count, options.seed))
        report.lines.insert(0, "%d strands of %d vertices" % (count, options.vertices_per_strand))
        if report.skipped_count:
            report.warnings.append("%d curves are shorter than %g m or have no length; they were "
                                   "left out" % (report.skipped_count, options.min_curve_length))

    @staticmethod
    def _bind(curves, part, factor, bones, report, uv, tints, influences):
        surface = curves.surface
        if surface is None:
            report.warnings.append("%s: no mesh under the hair; its strands have no bone weights "
                                   "and no UV" % curves.name)
            uv.append(None)
            tints.append(None)
            influences.append(None)
            return
        triangles, barycentric, distances = surface.closest(part.roots)
        uv.append(None if surface.uv is None else surface.uv_at(triangles, barycentric))
        tints.append(None if surface.colors is None else
                     surface.colors_at(triangles, barycentric))
        strand_bones, weights, unbound = surface.influences_at(triangles, barycentric)
        to_file = np.array([bones[name] for name in surface.bones], dtype=np.int64)
        influences.append((to_file[strand_bones], weights))
        if unbound:
            report.warnings.append("%s: %d roots are where %s has no bone weights; they follow "
                                   "'%s'" % (curves.name, unbound, surface.name,
                                             surface.bones[surface.fallback_bone]))
        far = distances * factor
        if far.size:
            report.max_root_distance = max(report.max_root_distance, float(far.max()))
            if far.max() > FAR_ROOT:
                report.warnings.append("%s: %d roots are more than %g m off %s, up to %.3g m"
                                       % (curves.name, int((far > FAR_ROOT).sum()), FAR_ROOT,
                                          surface.name, far.max()))

    @staticmethod
    def _thickness(strands, factor, report):
        if any(part.radii is None for part in strands):
            return None
        factors, mean = hair.thickness_factors(
            factor * np.concatenate([part.radii for part in strands]),
            np.concatenate([part.lengths for part in strands]))
        report.lines.append("mean fiber radius: %.3g m" % mean)
        return factors

    @staticmethod
    def _colors(strands, tints):
        """Colours of the curves; else those of the mesh at the roots; white where there is none."""
        if all(part.colors is None for part in strands) and all(t is None for t in tints):
            return None
        parts = []
        for part, tint in zip(strands, tints):
            if part.colors is not None:
                parts.append(part.colors)
            elif tint is not None:
                parts.append(np.repeat(tint[:, None], part.positions.shape[1], axis=1))
            else:
                parts.append(np.ones(part.positions.shape[:2] + (4,)))
        return np.concatenate(parts)

    def _join_influences(self, strands, influences):
        """Strands without a mesh follow bone 0."""
        all_bones, all_weights = [], []
        for part, known in zip(strands, influences):
            if known is None:
                known = (np.zeros((len(part.positions), 4), dtype=np.int64),
                         np.tile((1.0, 0.0, 0.0, 0.0), (len(part.positions), 1)))
            all_bones.append(known[0])
            all_weights.append(known[1])
        self.strand_bones = np.concatenate(all_bones)
        self.strand_weights = np.concatenate(all_weights)

    def _reorder(self, order):
        for name in ("positions", "masses", "thickness", "colors", "uv"):
            if getattr(self, name) is not None:
                setattr(self, name, getattr(self, name)[order])
        if self.bound:
            self.strand_bones = self.strand_bones[order]
            self.strand_weights = self.strand_weights[order]

    def tfx(self, matrix):
        return files.tfx_bytes(self.positions @ matrix.T, self.masses, self.uv, self.thickness,
                               self.colors)


def _bone_table(surfaces):
    """{name: index in the files}: the same in all files of an export."""
    table = {}
    for surface in surfaces:
        for name in surface.bones:
            table.setdefault(name, len(table))
    return table


def _split(surfaces, split):
    """Pairs of a suffix of the file name and a list of (Surface, its triangles)."""
    surfaces = list(dict.fromkeys(surfaces))
    if not surfaces:
        return []
    if split == "OBJECT":
        return [("_" + _file_name(s.name), [(s, s.triangles)]) for s in surfaces]
    if split == "WHOLE":
        return [("", [(s, s.triangles) for s in surfaces])]
    parts = {}
    for surface in surfaces:
        if surface.materials is None or not surface.material_names:
            parts.setdefault(surface.name, []).append((surface, surface.triangles))
            continue
        for index, name in enumerate(surface.material_names):
            chosen = surface.triangles[surface.materials == index]
            if len(chosen):
                parts.setdefault(name, []).append((surface, chosen))
    return [("_" + _file_name(name), part) for name, part in parts.items()]


def _file_name(name):
    return re.sub(r"[^\w.-]", "_", name)


def _mesh_bytes(parts, bones, axes, factor, mirrored, report):
    positions, normals, vertex_bones, weights, triangles = [], [], [], [], []
    first = 0
    for surface, chosen in parts:
        used, corners = np.unique(chosen, return_inverse=True)
        to_file = np.array([bones[name] for name in surface.bones], dtype=np.int64)
        part_bones, part_weights, unbound = surface.influences()
        if unbound and len(surface.bones) > 1:
            report.warnings.append("%s: %d vertices have no bone weights; they follow '%s'"
                                   % (surface.name, unbound,
                                      surface.bones[surface.fallback_bone]))
        positions.append(surface.positions[used] @ (axes * factor).T)
        normals.append(surface.normals[used] @ axes.T)
        vertex_bones.append(to_file[part_bones[used]])
        weights.append(part_weights[used])
        corners = corners.reshape(-1, 3) + first
        # Mirroring turns the inside out; the other way round it is right again.
        triangles.append(corners[:, ::-1] if mirrored else corners)
        first += len(used)
    return files.tfxmesh_bytes(list(bones), np.concatenate(positions), np.concatenate(normals),
                               np.concatenate(vertex_bones), np.concatenate(weights),
                               np.concatenate(triangles))
