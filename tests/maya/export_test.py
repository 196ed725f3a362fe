"""Tests of the Maya exporter and its plug-in against a stand-in of Maya: python3 export_test.py."""

import importlib.util
import os
import struct
import sys
import tempfile
import unittest

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
TOOLS = os.path.normpath(os.path.join(HERE, "../../tools/maya"))
sys.dont_write_bytecode = True
sys.path.insert(0, HERE)

import maya_stand_in as stand_in  # noqa: E402

stand_in.install()
SCENE, UI = stand_in.SCENE, stand_in.UI


def load_plugin():
    """As Maya does: by its path, and without __file__."""
    spec = importlib.util.spec_from_file_location(
        "pelage_plugin", os.path.join(TOOLS, "pelage_plugin.py"))
    module = importlib.util.module_from_spec(spec)
    del module.__file__
    spec.loader.exec_module(module)
    return module


PLUGIN = load_plugin()
PLUGIN.initializePlugin(TOOLS)
import pelage_export  # noqa: E402  its folder is known since the plug-in was loaded
from pelage_core import ExportError  # noqa: E402
from pelage_core.options import COLLISION_OPTIONS, OPTIONS  # noqa: E402

SQUARE = [(0, 0, 0), (100, 0, 0), (100, 100, 0), (0, 100, 0)]  # [cm]


def make_scene():
    """A square of 1 m on two joints, in a pose, with two curves and a collar without joints."""
    stand_in.reset()
    for joint in ("|root", "|root|tip"):
        SCENE.add(joint, "joint")
    SCENE.add("|head", "transform")
    mesh = dict(points=SQUARE, normals=[(0, 0, 1)] * 4, polygons=[(0, 1, 2, 3)],
                uv=[(3, 2, 1, 0)], uvs=[(0, 1), (1, 1), (1, 0), (0, 0)])
    SCENE.add("|head|headShape", "mesh", cluster="skin", shaders=(["skinSG"], [0]), **mesh)
    SCENE.add("|head|headShapeOrig", "mesh", intermediate=True, **mesh)
    SCENE.clusters["skin"] = (["|root", "|root|tip"],
                              [(1 - p[0] / 100, p[0] / 100) for p in SQUARE])
    SCENE.attributes["skin.envelope"] = 1.0
    SCENE.pose = np.array((0, 0, 500.0))
    SCENE.add("|collar", "transform")
    SCENE.add("|collar|collarShape", "mesh", **{**mesh, "uv": [], "uvs": []})
    SCENE.add("|hair", "transform")
    SCENE.add("|hair|line", "transform")
    SCENE.add("|hair|line|lineShape", "nurbsCurve", degree=1,
              points=[(25, 50, 0), (25, 50, 10), (25, 50, 20)])
    SCENE.add("|hair|bow", "transform")
    SCENE.add("|hair|bow|bowShape", "nurbsCurve", degree=3,
              points=[(75, 50, 0), (75, 50, 10), (85, 50, 20), (95, 50, 20)])
    SCENE.sets["colliders"] = ["|collar"]
    SCENE.selection = ["|hair", "|head"]


class Maya(unittest.TestCase):
    def setUp(self):
        make_scene()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def lines(self, name):
        return self.read(name).decode().split("\n")


class Export(Maya):
    def test_curves_are_strands_in_metres(self):
        report = pelage_export.export(self.path("a.tfx"), vertices_per_strand=5)
        self.assertEqual([os.path.basename(p) for p in report.paths],
                         ["a.tfx", "a.tfxbone", "a.tfxmesh"])
        self.assertEqual(report.warnings, [])
        data = self.read("a.tfx")
        self.assertEqual(struct.unpack_from("<fII", data), (4.0, 2, 5))
        strands = np.frombuffer(data, "<f4", 40, 160).reshape(2, 5, 4)
        np.testing.assert_allclose(strands[0, :, :3],
                                   [(0.25, 0.5, z / 100) for z in (0, 5, 10, 15, 20)], atol=1e-7)
        # A cubic goes through its ends, and its middle is the mean of the control points' pairs.
        np.testing.assert_allclose(strands[1, [0, 4], :3], [(0.75, 0.5, 0), (0.95, 0.5, 0.2)],
                                   atol=1e-7)
        np.testing.assert_allclose(strands[1, 2, :3], (0.8125, 0.5, 0.1375), atol=5e-3)
        uv = np.frombuffer(data, "<f4", 4, struct.unpack_from("<5I", data, 12)[1])
        np.testing.assert_allclose(uv.reshape(2, 2), [(0.25, 0.5), (0.75, 0.5)], atol=1e-6)

    def test_meshes_are_in_bind_pose_with_the_weights_of_the_joints(self):
        pelage_export.export(self.path("a.tfx"))
        self.assertEqual(SCENE.attributes["skin.envelope"], 1.0)
        mesh = self.lines("a.tfxmesh")
        self.assertEqual(mesh[1:5], ["numOfBones 2", "# index name", "0 root", "1 tip"])
        self.assertIn("2 1 1 0 0 0 1 1 1 1 1 1 0 0 0", mesh)
        self.assertEqual(self.read("a.tfxbone")[-36:-20],
                         struct.pack("<iifi", 1, 1, 0.75, 0))

    def test_a_locked_envelope_is_an_error_and_writes_nothing(self):
        SCENE.locked.add("skin.envelope")
        with self.assertRaisesRegex(ExportError, "skin.envelope is locked"):
            pelage_export.export(self.path("a.tfx"))
        self.assertEqual(os.listdir(self.folder), [])

    def test_collision_meshes_of_a_set(self):
        pelage_export.export(self.path("a.tfx"), collision="COLLECTION", collision_set="colliders")
        self.assertEqual(self.lines("a.tfxmesh")[3:6], ["0 root", "1 tip", "2 collarShape"])
        with self.assertRaisesRegex(ExportError, "no set or group 'x'"):
            pelage_export.export(self.path("a.tfx"), collision="COLLECTION", collision_set="x")

    def test_meshes_without_hair(self):
        SCENE.selection = ["|head", "|collar"]
        report = pelage_export.export_collision(self.path("b.tfxmesh"), collision_split="OBJECT")
        self.assertEqual([os.path.basename(p) for p in report.paths],
                         ["b_headShape.tfxmesh", "b_collarShape.tfxmesh"])
        self.assertIn("2 1 1 0 0 0 1 1 1 1 1 1 0 0 0", self.lines("b_headShape.tfxmesh"))
        pelage_export.export_collision(self.path("c.tfxmesh"), collision_set="colliders")
        self.assertEqual(self.lines("c.tfxmesh")[3], "0 collarShape")
        SCENE.selection = ["|hair"]
        with self.assertRaisesRegex(ExportError, "no mesh to export"):
            pelage_export.export_collision(self.path("d.tfxmesh"))

    def test_the_base_mesh_counts_until_another_one_is_named(self):
        SCENE.selection = ["|collar"]
        self.assertEqual(pelage_export.set_base_mesh(), "collar")
        SCENE.selection = ["|hair", "|head"]
        pelage_export.export(self.path("a.tfx"), collision="NONE")
        self.assertIn(b"collarShape", self.read("a.tfxbone"))
        pelage_export.export(self.path("a.tfx"), collision="NONE", surface="head")
        self.assertIn(b"root", self.read("a.tfxbone"))
        with self.assertRaisesRegex(ExportError, "0 meshes are selected"):
            SCENE.selection = ["|hair"]
            pelage_export.set_base_mesh()


class PlugIn(Maya):
    def test_the_manager_loads_and_unloads_the_menu(self):
        self.assertTrue(callable(PLUGIN.maya_useNewAPI))
        PLUGIN.initializePlugin(TOOLS)
        menu = UI.labelled("menu", "pelage")
        self.assertEqual([label for label, _ in menu.items],
                         ["Export Hair ...", "Export Collision Mesh ...", "Set Base Mesh"])
        PLUGIN.uninitializePlugin(TOOLS)
        self.assertEqual(UI.controls, {})
        UI.batch = True
        PLUGIN.initializePlugin(TOOLS)
        PLUGIN.uninitializePlugin(TOOLS)
        self.assertEqual(UI.controls, {})

    def choose(self, index):
        PLUGIN.initializePlugin(TOOLS)
        UI.labelled("menu", "pelage").items[index][1](False)

    @staticmethod
    def press(label):
        UI.labelled("button", label).flags["command"](False)

    def test_each_dialog_has_its_options_and_exports(self):
        for index, names, extension in ((0, list(OPTIONS), "tfx"),
                                        (1, list(COLLISION_OPTIONS), "tfxmesh")):
            make_scene()
            self.choose(index)
            labels = [control.flags.get("label") for control in UI.controls.values()]
            for name in names:
                self.assertEqual(labels.count(OPTIONS[name].label), 1, name)
            UI.labelled("floatFieldGrp", "Scale").value = 2.0
            self.press("Export ...")  # no file is chosen
            self.assertEqual(os.listdir(self.folder), [])
            UI.file_name = self.path("dialog." + extension)
            self.press("Export ...")
            self.assertEqual([kind for kind, _ in UI.messages], ["info"])
            self.assertIn("2 2 2 0 0 0 1 1 1 1 1 1 0 0 0", self.lines("dialog.tfxmesh"))
            SCENE.selection = []
            self.press("Export ...")
            self.assertRegex(UI.messages[-1][1], "not exported: .*select")
            for name in os.listdir(self.folder):
                os.remove(self.path(name))

    def test_the_base_mesh_is_set_by_menu_and_dialog(self):
        SCENE.selection = ["|head"]
        self.choose(2)
        self.choose(0)
        field = UI.labelled("textFieldButtonGrp", "Base Mesh")
        self.assertEqual(field.value, "head")
        SCENE.selection = ["|collar"]
        field.flags["buttonCommand"](False)
        self.assertEqual(field.value, "collar")
        SCENE.selection = []
        self.choose(2)
        self.assertEqual(UI.messages[-1][0], "error")


if __name__ == "__main__":
    unittest.main()
