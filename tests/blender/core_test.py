"""Tests of the exporters' part without a modelling program: python3 core_test.py."""

import os
import struct
import sys
import tempfile
import unittest

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(HERE, "../../tools/blender/pelage_export"))

from pelage_core import ExportError, export, files, hair  # noqa: E402
from pelage_core.nurbs import nurbs_points, uniform_knots
from pelage_core.options import COLLISION_OPTIONS, ExportOptions  # noqa: E402
from pelage_core.random_pcg import Random  # noqa: E402
from pelage_core.surface import Surface, polygon_corners, strongest  # noqa: E402


def square(bones=("left", "right"), name="square"):
    """The unit square in z = 0, facing +z; `left` moves x = 0 and `right` x = 1; uv is xy."""
    positions = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    triangles = np.array([(0, 1, 2), (0, 2, 3)])
    return Surface(name, positions, np.tile((0.0, 0, 1), (4, 1)), triangles, bones,
                   [[0, 1]] * 4, [[1 - p[0], p[0]] for p in positions],
                   uv=positions[triangles][:, :, :2], materials=[0, 1],
                   material_names=["a", "b"])


def straight(roots, length=1.0, vertices=3, surface=None, radii=None):
    roots = np.asarray(roots, dtype=float)
    steps = np.linspace(0, length, vertices)
    points = np.concatenate([root + np.outer(steps, (0, 0, 1)) for root in roots])
    return hair.HairCurves("hair", [vertices] * len(roots), points, radii, surface=surface)


def read_tfx(data):
    version, strands, vertices, *offsets = struct.unpack_from("<fII5I", data)
    positions = np.frombuffer(data, "<f4", strands * vertices * 4, offsets[0])
    return version, positions.reshape(strands, vertices, 4), offsets


class Resampling(unittest.TestCase):
    def test_vertices_are_at_equal_lengths_and_the_ends_stay(self):
        corner = hair.HairCurves("c", [3], [(0, 0, 0), (1, 0, 0), (1, 3, 0)])
        strands = hair.resample(corner, 5, 0)
        np.testing.assert_allclose(
            strands.positions[0], [(0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 2, 0), (1, 3, 0)],
            atol=1e-12)
        self.assertEqual(strands.lengths[0], 4)

    def test_repeated_vertices_do_not_matter(self):
        curves = hair.HairCurves("c", [4], [(0, 0, 0), (0, 0, 0), (2, 0, 0), (2, 0, 0)])
        np.testing.assert_allclose(hair.resample(curves, 3, 0).positions[0, :, 0], [0, 1, 2])

    def test_curves_that_are_short_or_have_no_length_are_left_out(self):
        points = [(0, 0, 0), (0, 0, 1), (5, 5, 5), (0, 0, 0), (0, 0, 2), (3, 3, 3), (3, 3, 3)]
        curves = hair.HairCurves("c", [2, 1, 2, 2], points)
        self.assertEqual(len(hair.resample(curves, 2, 0).positions), 2)
        kept = hair.resample(curves, 2, 1.5)
        np.testing.assert_array_equal(kept.positions[:, 1, 2], [2])

    def test_a_thickness_of_1_is_80_um_across(self):
        factors, mean = hair.thickness_factors(np.array([4e-5, 1.2e-4]), np.array([3.0, 1.0]))
        self.assertAlmostEqual(mean, 6e-5)
        np.testing.assert_allclose(factors, [1, 3])
        self.assertIsNone(hair.thickness_factors(np.zeros(2), np.array([3.0, 1.0]))[0])

    def test_the_mean_radius_of_a_curve_counts_its_parts_by_length(self):
        curves = hair.HairCurves("c", [3], [(0, 0, 0), (1, 0, 0), (4, 0, 0)], [2, 2, 6])
        self.assertAlmostEqual(hair.resample(curves, 2, 0).radii[0], (1 * 2 + 3 * 4) / 4)

    def test_a_coordinate_that_is_no_number_is_an_error_that_names_its_curve(self):
        points = np.zeros((4, 3))
        points[3, 1] = np.nan
        with self.assertRaisesRegex(ExportError, "position of curve 1"):
            hair.HairCurves("c", [2, 2], points)


class Axes(unittest.TestCase):
    def test_every_up_axis_becomes_y_by_a_rotation(self):
        for axis, up in (("X", (1, 0, 0)), ("Y", (0, 1, 0)), ("Z", (0, 0, 1))):
            matrix = hair.up_matrix(axis, False)
            np.testing.assert_array_equal(matrix @ up, (0, 1, 0))
            self.assertEqual(np.linalg.det(matrix), 1)

    def test_invert_z_mirrors_the_axes_of_the_file(self):
        np.testing.assert_array_equal(hair.up_matrix("Z", False) @ (1, 2, 3), (1, 3, -2))
        np.testing.assert_array_equal(hair.up_matrix("Z", True) @ (1, 2, 3), (1, 3, 2))


class Nurbs(unittest.TestCase):
    def test_a_rational_curve_of_degree_2_is_a_circle(self):
        corner = [(1, 0, 0, 2), (1, 1, 0, 4), (0, 1, 0, 6)]
        points = nurbs_points(corner, [1, np.sqrt(0.5), 1], 3, uniform_knots(3, 3, True, False))
        self.assertEqual(len(points), 9)
        np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1]), 1)
        np.testing.assert_allclose(points[[0, -1]], [corner[0], corner[2]], atol=1e-15)

    def test_every_kind_of_knots_keeps_a_line_and_stays_in_its_hull(self):
        for count, order, ends, bezier in [(2, 2, True, False), (5, 4, True, False),
                                           (5, 4, False, False), (7, 4, False, True),
                                           (9, 3, True, True), (6, 6, False, False)]:
            line = np.outer(np.arange(count), (1.0, 2, 3))
            knots = uniform_knots(count, order, ends, bezier)
            self.assertEqual(len(knots), count + order)
            points = nurbs_points(line, np.ones(count), order, knots)
            np.testing.assert_allclose(points, np.outer(points[:, 0], (1, 2, 3)), atol=1e-12)
            self.assertTrue((np.diff(points[:, 0]) > 0).all())
            if ends:
                np.testing.assert_allclose(points[[0, -1]], line[[0, -1]], atol=1e-12)


class RandomNumbers(unittest.TestCase):
    def test_they_are_those_of_the_authors_demo(self):
        # pcg32_srandom(42, 54), https://www.pcg-random.org: pcg32-demo.
        random = Random(42, 54)
        self.assertEqual([random.bits() for _ in range(6)], [
            0xa15c02b7, 0x7b47f409, 0xba1d3330, 0x83d2f293, 0xbfa4784b, 0xcbed606e])

    def test_numbers_below_a_limit_are_without_bias(self):
        limit = 2**31 + 1  # about half of all draws are in the incomplete block
        draws = Random(5)
        fair = [bits % limit for bits in (draws.bits() for _ in range(40))
                if bits >= 2**32 - limit]
        random = Random(5)
        self.assertEqual([random.below(limit) for _ in fair], fair)
        self.assertGreater(40, len(fair))
        self.assertEqual(random.below(0), 0)

    def test_a_permutation_has_each_number_once_and_depends_on_the_seed(self):
        order = Random(3).permutation(100)
        self.assertEqual(sorted(order), list(range(100)))
        self.assertEqual(order, Random(3).permutation(100))
        self.assertNotEqual(order, Random(4).permutation(100))


class ClosestPoints(unittest.TestCase):
    def test_no_point_of_the_mesh_is_nearer_than_the_one_found(self):
        generator = np.random.RandomState(1)
        vertices = generator.rand(200, 3)
        triangles = generator.randint(0, 200, (300, 3))  # some are degenerate
        surface = Surface("s", vertices, vertices, triangles, ["b"], np.zeros((200, 1)),
                          np.ones((200, 1)))
        points = generator.rand(400, 3) * 3 - 1
        found, barycentric, distances = surface.closest(points)
        corners = vertices[triangles]
        nearest = (corners[found] * barycentric[:, :, None]).sum(axis=1)
        np.testing.assert_allclose(np.linalg.norm(points - nearest, axis=1), distances, atol=1e-9)
        self.assertTrue((barycentric >= -1e-12).all())
        np.testing.assert_allclose(barycentric.sum(axis=1), 1)
        # Any other point of the mesh is at least as far.
        samples = generator.dirichlet((0.5, 0.5, 0.5), 40)
        dense = (corners[:, None] * samples[None, :, :, None]).sum(axis=2).reshape(-1, 3)
        for point, distance in zip(points, distances):
            self.assertLessEqual(distance, np.linalg.norm(dense - point, axis=1).min() + 1e-12)

    def test_of_triangles_that_are_equally_near_the_first_one_counts(self):
        positions = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], dtype=float)
        surface = Surface("s", positions, positions, [(0, 1, 2)] * 100, ["b"], np.zeros((3, 1)),
                          np.ones((3, 1)))
        self.assertEqual(surface.closest([(0.2, 0.2, 1), (5, 5, 5)])[0].tolist(), [0, 0])

    def test_no_points_are_fine(self):
        self.assertEqual([len(part) for part in square().closest([])], [0, 0, 0])

    def test_a_point_above_a_face_projects_onto_it(self):
        triangles, barycentric, distances = square().closest([(0.75, 0.25, 0.5)])
        np.testing.assert_allclose(square().uv_at(triangles, barycentric), [(0.75, 0.25)])
        np.testing.assert_allclose(distances, [0.5])


class Corners(unittest.TestCase):
    def test_a_vertex_has_its_own_corner_in_each_polygon(self):
        # A square and a triangle that share the vertices 1 and 2.
        corners = polygon_corners([4, 3], [0, 1, 2, 3, 2, 1, 5], [0, 0, 1],
                                  np.array([(0, 1, 2), (0, 2, 3), (1, 5, 2)]))
        np.testing.assert_array_equal(corners, [(0, 1, 2), (0, 2, 3), (5, 6, 4)])


class Influences(unittest.TestCase):
    def test_the_four_largest_are_kept_and_sum_to_one(self):
        bones, weights, unbound = strongest(
            np.array([[0, 1, 2, 3, 4, 4]]), np.array([[0.05, 0.3, 0.2, 0.1, 0.2, 0.15]]), 5, 0)
        np.testing.assert_array_equal(bones, [[4, 1, 2, 3]])
        np.testing.assert_allclose(weights, np.array([[0.35, 0.3, 0.2, 0.1]]) / 0.95)
        self.assertEqual(unbound, 0)

    def test_a_row_without_weights_follows_the_fallback_and_is_counted(self):
        bones, weights, unbound = strongest(
            np.array([[0, 1], [1, 0]]), np.array([[0, np.nan], [0.5, 0]]), 3, 2)
        np.testing.assert_array_equal(bones, [[2] * 4, [1] * 4])
        np.testing.assert_array_equal(weights, [[1, 0, 0, 0]] * 2)
        self.assertEqual(unbound, 1)

    def test_weights_are_blended_between_the_corners(self):
        surface = square()
        bones, weights, _ = surface.influences_at(*surface.closest([(0.25, 0.5, 0.1)])[:2])
        np.testing.assert_array_equal(bones[0, :2], [0, 1])
        np.testing.assert_allclose(weights[0], [0.75, 0.25, 0, 0])


class Files(unittest.TestCase):
    def test_the_header_of_a_tfx_has_160_bytes_and_the_offsets_of_its_arrays(self):
        data = files.tfx_bytes(np.ones((2, 3, 3)), np.zeros((2, 3)), np.zeros((2, 2)), [1, 2])
        version, positions, offsets = read_tfx(data)
        self.assertEqual((version, positions.shape), (4.0, (2, 3, 4)))
        self.assertEqual(offsets, [160, 256, 0, 272, 0])
        self.assertEqual(len(data), 280)

    def test_numbers_of_a_tfxmesh_read_back_to_the_same_float(self):
        values = np.random.RandomState(2).randn(300, 3) * 10.0**np.arange(-8, 4).repeat(25)[:, None]
        text = files.tfxmesh_bytes(["b"], values, values, np.zeros((300, 4), dtype=int),
                                   np.tile((1.0, 0, 0, 0), (300, 1)), [(0, 1, 2)]).decode()
        lines = [line.split() for line in text.split("\n") if line.count(" ") == 14]
        self.assertEqual(len(lines), 300)
        read = np.array([[float(word) for word in line[1:4]] for line in lines], dtype=np.float32)
        np.testing.assert_array_equal(read, values.astype(np.float32))

    def test_what_a_reader_would_refuse_is_not_written(self):
        with self.assertRaisesRegex(ExportError, "coordinate"):
            files.tfx_bytes(np.full((1, 2, 3), 2e6), np.zeros((1, 2)))
        with self.assertRaisesRegex(ExportError, "coordinate"):
            files.tfx_bytes(np.full((1, 2, 3), np.nan), np.zeros((1, 2)))
        for name in ("", " head", "a\nb", "x" * 4096):
            with self.assertRaisesRegex(ExportError, "name"):
                files.tfxbone_bytes([name], np.zeros((1, 4), dtype=int), np.zeros((1, 4)))

    def test_a_file_that_cannot_be_written_leaves_the_others_as_they_were(self):
        with tempfile.TemporaryDirectory() as folder:
            first, second = os.path.join(folder, "a"), os.path.join(folder, "no_folder", "b")
            files.write_files({first: b"old"})
            with self.assertRaisesRegex(ExportError, "cannot write .*no_folder"):
                files.write_files({first: b"new", second: b"new"})
            with open(first, "rb") as file:
                self.assertEqual(file.read(), b"old")
            self.assertEqual(os.listdir(folder), ["a"])
            os.mkdir(os.path.join(folder, "c"))
            with self.assertRaisesRegex(ExportError, "is a folder"):
                files.write_files({first: b"new", os.path.join(folder, "c"): b"new"})
            self.assertEqual(sorted(os.listdir(folder)), ["a", "c"])


class Exports(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.path = os.path.join(self._folder.name, "x.tfx")

    def export(self, curves, surfaces=(), **options):
        return export.export(self.path, curves, list(surfaces), ExportOptions(**options))

    def read(self, extension=".tfx"):
        with open(self.path[:-4] + extension, "rb") as file:
            return file.read()

    def test_shuffled_strands_keep_their_own_data(self):
        surface = square()
        roots = [(x / 50, 0.5, 0) for x in range(50)]
        self.export([straight(roots, surface=surface)], randomize_strands=True, seed=9)
        _, positions, offsets = read_tfx(self.read())
        x = positions[:, 0, 0]
        self.assertFalse((np.diff(x) > 0).all())
        uv = np.frombuffer(self.read(), "<f4", 100, offsets[1]).reshape(50, 2)
        np.testing.assert_allclose(uv[:, 0], x, atol=1e-6)
        weights = np.frombuffer(self.read(".tfxbone")[-50 * 36:], dtype=np.dtype([
            ("strand", "<i4"), ("of", [("bone", "<i4"), ("weight", "<f4")], 4)]))
        right = (weights["of"]["weight"] * (weights["of"]["bone"] == 1)).sum(axis=1)
        np.testing.assert_allclose(right, x, atol=1e-6)

    def test_lengths_are_scaled_before_they_are_judged(self):
        curves = [straight([(0, 0, 0)], 1.0, surface=square()), straight([(1, 0, 0)], 3.0)]
        report = self.export(curves, scale=0.01, min_curve_length=0.02)
        self.assertEqual((report.strand_count, report.skipped_count), (1, 1))
        _, positions, _ = read_tfx(self.read())
        np.testing.assert_allclose(positions[0, -1, :3], (0.01, 0, 0.03), atol=1e-8)

    def test_a_mirrored_mesh_still_faces_outwards(self):
        self.export([straight([(0, 0, 0)])], [square()], invert_z=True)
        text = self.read(".tfxmesh").decode().split("\n")
        first = next(i for i, line in enumerate(text) if line.startswith("numOfTriangles")) + 2
        self.assertEqual(text[first], "0 2 1 0")
        normal = next(line for line in text if line.count(" ") == 14).split()[4:7]
        self.assertEqual([float(word) for word in normal], [0, 0, -1])

    def test_bones_have_the_same_index_in_all_files(self):
        other = square(bones=("right", "tail"), name="other")
        self.export([straight([(0, 0, 0)], surface=square()),
                     straight([(1, 0, 0)], surface=other)], [other])
        self.assertIn("numOfBones 3\n# index name\n0 left\n1 right\n2 tail\n",
                      self.read(".tfxmesh").decode())
        weights = self.read(".tfxbone")
        self.assertEqual(weights[:4], struct.pack("<i", 3))
        # The second root is where `other` has all weight on its second bone, the tail.
        self.assertEqual(weights[-32:-24], struct.pack("<if", 2, 1.0))

    def test_a_mesh_is_split_by_material_or_object(self):
        surface = square()
        report = self.export([straight([(0, 0, 0)])], [surface], collision_split="MATERIAL")
        self.assertEqual([os.path.basename(path) for path in report.paths],
                         ["x.tfx", "x_a.tfxmesh", "x_b.tfxmesh"])
        self.assertIn("numOfVertices 3\n", self.read("_a.tfxmesh").decode())
        with self.assertRaisesRegex(ExportError, "two collision meshes"):
            self.export([straight([(0, 0, 0)])], [surface, square()], collision_split="OBJECT")

    def test_hair_bones_and_meshes_are_written_as_chosen(self):
        surface = square()
        for chosen in ((True, True), (True, False), (False, True), (False, False)):
            report = self.export([straight([(0, 0, 0)], surface=surface)], [surface],
                                 export_hair=chosen[0], export_bones=chosen[1])
            names = [name for name, wanted in zip(("x.tfx", "x.tfxbone"), chosen) if wanted]
            self.assertEqual([os.path.basename(path) for path in report.paths],
                             names + ["x.tfxmesh"])
        with self.assertRaisesRegex(ExportError, "nothing to write"):
            self.export([straight([(0, 0, 0)])], export_hair=False)

    def test_meshes_alone_are_those_of_an_export_with_hair(self):
        surface = square()
        options = dict(scale=2, up_axis="Z", invert_z=True)
        self.assertLess(set(options), set(COLLISION_OPTIONS))
        self.export([straight([(0, 0, 0)], surface=surface)], [surface], **options)
        with_hair = self.read(".tfxmesh")
        path = os.path.join(self._folder.name, "alone.tfxmesh")
        report = export.export_collision(path, [surface], ExportOptions(**options))
        self.assertEqual(report.paths, [path])
        with open(path, "rb") as file:
            self.assertEqual(file.read(), with_hair)
        with self.assertRaisesRegex(ExportError, "no mesh"):
            export.export_collision(path, [], ExportOptions())

    def test_roots_off_the_mesh_are_reported_with_their_distance(self):
        report = self.export([straight([(0.5, 0.5, 0.25)], surface=square())])
        self.assertEqual(report.max_root_distance, 0.25)
        self.assertRegex(report.warnings[0], "1 roots .* 0.25 m")

    def test_wrong_options_and_empty_exports_are_errors_and_write_nothing(self):
        for options in ({"vertices_per_strand": 1}, {"scale": 0}, {"scale": float("nan")},
                        {"up_axis": "W"}, {"no_such_option": 1}, {"seed": "x"}):
            with self.assertRaises(ExportError):
                self.export([straight([(0, 0, 0)])], **options)
        with self.assertRaisesRegex(ExportError, "no hair"):
            self.export([])
        with self.assertRaisesRegex(ExportError, "none of the 1 curves"):
            self.export([straight([(0, 0, 0)])], min_curve_length=2)
        self.assertEqual(os.listdir(self._folder.name), [])


if __name__ == "__main__":
    unittest.main()
