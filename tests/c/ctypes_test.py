"""The C interface from Python: a binding that is made of the header's text runs a scene and draws a frame.

    ctypes_test.py LIBRARY HEADER NM [HELLO]

HELLO is sample/hello_c, whose tip is that of the scene here. Exit status 77: no Vulkan device.
"""
import array
import ctypes
import os
import pathlib
import re
import subprocess
import sys
import unittest

LIBRARY, HEADER, NM, HELLO = (sys.argv[1:] + [None])[:4]
lib = ctypes.CDLL(LIBRARY)
text = re.sub(r"//.*", "", pathlib.Path(HEADER).read_text(encoding="utf-8"))
functions = re.findall(r"PELAGE_C_API[\w\s*]*?\b(pelage_\w+)\(", text)

KINDS = {"uint32_t": ctypes.c_uint32, "int32_t": ctypes.c_int32, "uint64_t": ctypes.c_uint64, "float": ctypes.c_float,
         "double": ctypes.c_double, "pelage_id": ctypes.c_uint64, "pelage_buffer_id": ctypes.c_uint64,
         "pelage_function": ctypes.c_void_p}


def fields_of(body):
    """(name, type) of the members of a struct."""
    for member in filter(None, (m.strip() for m in body.split(";"))):
        called = re.search(r"\(\*(\w+)\)\(", member)
        if called:
            yield called[1], ctypes.c_void_p
            continue
        kind, names = re.match(r"((?:const )?\w+[\s*]*(?:const\*)?)\s*(.*)", member, re.S).groups()
        if "*" in kind:
            of = ctypes.c_char_p if kind.replace(" ", "") == "constchar*" else ctypes.c_void_p
        else:
            of = KINDS[kind.strip()]
        for name, sizes in re.findall(r"(\w+)((?:\[\d+\])*)", names):
            whole = of
            for size in reversed(re.findall(r"\d+", sizes)):
                whole = whole * int(size)
            yield name, whole


structs = {name: type(name, (ctypes.Structure,), {"_fields_": list(fields_of(body))})
           for body, name in re.findall(r"typedef struct pelage_\w+ \{(.*?)\} (pelage_\w+);", text, re.S)}


class PelageError(Exception):
    pass


lib.pelage_last_error.restype = ctypes.c_char_p


def call(name, *arguments):
    """Calls a function; an error is an exception with its message. Numbers are as wide as the declaration says."""
    declared = re.search(r"\b%s\((.*?)\);" % name, text, re.S)[1].split(",")
    given = []
    for declaration, argument in zip(declared, arguments, strict=True):
        kind = declaration.split()[0]
        if isinstance(argument, (int, float)) and "*" not in declaration and kind != "size_t":
            argument = {**KINDS, "int64_t": ctypes.c_int64}[kind](argument)
        elif isinstance(argument, int):
            argument = ctypes.c_size_t(argument)
        given.append(argument)
    if getattr(lib, name)(*given) != 0:
        raise PelageError(lib.pelage_last_error().decode())


def made(name, *arguments):
    """The object that a function makes, which the last argument takes."""
    out = ctypes.c_void_p()
    call(name, *arguments, ctypes.byref(out))
    return out


def struct(name, **members):
    value = structs[name]()
    call(name + "_init", ctypes.byref(value), ctypes.sizeof(value))
    for member, of in members.items():
        setattr(value, member, of)
    return value


def floats(*values):
    return (ctypes.c_float * len(values))(*values)


class Library(unittest.TestCase):
    def test_exports_the_functions_of_the_header_alone(self):
        symbols = subprocess.run([NM, "-D", "--defined-only", LIBRARY], check=True, text=True,
                                 stdout=subprocess.PIPE).stdout
        exported = [line.split()[-1] for line in symbols.splitlines()]
        self.assertEqual(sorted(exported), sorted(functions))
        self.assertGreater(len(functions), 60)

    def test_structs_have_the_sizes_of_the_header(self):
        checked = [name for name, of in structs.items() if of._fields_[0][0] == "struct_size"]
        self.assertGreater(len(checked), 10)
        for name in checked:
            self.assertEqual(struct(name).struct_size, ctypes.sizeof(structs[name]), name)
            with self.assertRaisesRegex(PelageError, name + r" has \d+ bytes, but \d+ in this library"):
                call(name + "_init", ctypes.byref(structs[name]()), ctypes.sizeof(structs[name]) + 4)

    def test_version_is_that_of_the_header(self):
        header = pathlib.Path(HEADER).with_name("version.h").read_text(encoding="utf-8")
        major, minor, patch = (int(re.search(r"VERSION_%s (\d+)" % part, header)[1])
                               for part in ("MAJOR", "MINOR", "PATCH"))
        self.assertEqual(lib.pelage_version(), 10000 * major + 100 * minor + patch)


class Scene(unittest.TestCase):
    SIZE = 96

    def setUp(self):
        self.asset = made("pelage_asset_generate", 7, 500)
        self.scene = made("pelage_scene_create")
        hair = ctypes.c_uint64()
        call("pelage_scene_add_hair", self.scene, self.asset, None, ctypes.byref(hair))
        self.hair = hair.value
        self.device = made("pelage_headless_create", None)

    def tearDown(self):
        for handle in (self.scene, self.asset, self.device):
            call("pelage_destroy", handle)

    def run_frame(self, view=None, settings=None):
        """The pixels of the view, if there is one."""
        frame = made("pelage_scene_simulate", self.scene, 1 / 60)
        pixels = array.array("f", bytes(16 * self.SIZE * self.SIZE))
        if view is None:
            call("pelage_headless_run", self.device, frame, None, 0)
        else:
            call("pelage_frame_draw", frame, ctypes.byref(view), settings, None)
            target = struct("pelage_headless_target", width=self.SIZE, height=self.SIZE,
                            pixels=pixels.buffer_info()[0])
            call("pelage_headless_run", self.device, frame, ctypes.byref(target), 1)
        call("pelage_destroy", frame)
        return pixels

    def tip(self):
        info = struct("pelage_hair_info")
        call("pelage_scene_get_hair_info", self.scene, self.hair, ctypes.byref(info))
        tip = floats(0, 0, 0, 0)
        call("pelage_read", self.device, info.positions, (info.vertices_per_strand - 1) * 16, tip, 16)
        return list(tip)[:3]

    def test_runs_as_hello_does(self):
        for _ in range(60):
            self.run_frame()
        line = "tip of strand 0: (%.4f, %.4f, %.4f) m\n" % tuple(self.tip())
        if HELLO:
            self.assertEqual(subprocess.run([HELLO], check=True, text=True, stdout=subprocess.PIPE).stdout, line)

    def test_draws_hair_that_bones_and_settings_move(self):
        settings = made("pelage_settings_create")
        call("pelage_settings_load", settings, b"text", b'{"material": {"fiberRadius": 0.001}}')
        call("pelage_settings_set", settings, b"simulation.bendLength", (ctypes.c_double * 1)(0.02), 1)
        call("pelage_scene_set_settings", self.scene, self.hair, settings)
        before = self.tip_after(floats(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0))
        moved = self.tip_after(floats(1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0))
        self.assertAlmostEqual(moved[0], before[0] + 0.5, delta=0.1)
        view = struct("pelage_view", width=self.SIZE, height=self.SIZE)
        call("pelage_view_look_at", ctypes.byref(view), floats(0.5, 0.3, 0.9), floats(0.5, 0.2, 0), floats(0, 1, 0),
             0.6, 0.1, 10)
        pixels = self.run_frame(view, settings)
        covered = sum(alpha > 0 for alpha in pixels[3::4])
        self.assertGreater(covered, 0.05 * self.SIZE ** 2)
        self.assertLess(covered, 0.8 * self.SIZE ** 2)
        self.assertEqual(pixels[3], 0, "a corner")
        call("pelage_destroy", settings)

    def tip_after(self, bone):
        call("pelage_scene_set_bones", self.scene, self.hair, bone, 1)
        call("pelage_scene_reset", self.scene, self.hair)
        for _ in range(5):
            self.run_frame()
        return self.tip()

    def test_errors_are_exceptions_with_messages(self):
        for message, arguments in {
                "pelage_scene is NULL": ("pelage_scene_remove", None, 1),
                "pelage_scene is a pelage_asset": ("pelage_scene_remove", self.asset, 1),
                "removed, or of another scene": ("pelage_scene_remove", self.scene, 1),
                "has 1 bones, not 2": ("pelage_scene_set_bones", self.scene, self.hair, floats(*[0] * 24), 2),
                "'damping' is no parameter": ("pelage_settings_get", made("pelage_settings_create"), b"damping",
                                              None, 1)}.items():
            with self.assertRaisesRegex(PelageError, message):
                call(*arguments)


if __name__ == "__main__":
    try:
        call("pelage_destroy", made("pelage_headless_create", None))
    except PelageError as error:
        print("no Vulkan device:", error)
        sys.exit(1 if os.environ.get("PELAGE_REQUIRE_DEVICES") == "1" else 77)
    unittest.main(argv=sys.argv[:1])
