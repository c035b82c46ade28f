# SPDX-License-Identifier: GPL-3.0-or-later
"""tools/check_structure accepts a clean source and names every broken rule."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

TOOL = Path(__file__).resolve().parents[3] / "tools" / "check_structure"
CLEAN = """! print * and use x in a comment
module base_thing
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_kinds, &
    only: rp
  implicit none
  character(*), parameter :: text = 'do print *, that ! use'//achar(output_unit + int(1.0_rp))
contains
  module procedure nothing
  end procedure nothing
end module base_thing
"""


def check(source, name="base_thing.f90", layer="base", tests=(), kind="tests/unit", content=""):
    """(exit code, output) for a tree with this one file, and files in tests/unit with this content."""
    with tempfile.TemporaryDirectory() as root:
        folder = Path(root) / "src" / layer
        folder.mkdir(parents=True)
        (folder / name).write_text(source)
        for test in tests:
            path = Path(root) / kind / test
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(content)
        done = subprocess.run([sys.executable, str(TOOL), root], capture_output=True, text=True, check=False)
        return done.returncode, done.stdout


def module(name):
    return f"module {name}\nend module {name}\n"


class CheckStructure(unittest.TestCase):
    def assert_found(self, source, where_and_what, name="base_thing.f90", layer="base", **others):
        code, output = check(source, name, layer, **others)
        self.assertEqual(code, 1, output)
        self.assertIn(where_and_what, output)
        self.assertIn(" 1 problem(s)", output)

    def test_clean_source_passes(self):
        self.assertEqual(check(CLEAN), (0, "1 files, 0 problem(s)\n"))

    def test_submodule_is_named_after_its_file(self):
        source = "submodule (base_thing) base_thing_body\nend submodule base_thing_body\n"
        self.assertEqual(check(source, "base_thing_body.f90")[0], 0)
        self.assert_found(source, "base_other.f90:1: module base_thing_body", "base_other.f90")

    def test_file_and_module_name_differ(self):
        self.assert_found(CLEAN, "other.f90:2: module base_thing in a file called other.f90", "other.f90")

    def test_a_forgotten_component_is_found(self):
        source = """module base_case
  type :: wing_t
    integer :: span = 0
  end type wing_t
  type, extends(wing_t) :: case_t
    character(:), allocatable :: name !< of it
    integer :: load = 1, zero(2) = [1, 2]
    logical :: is_new
  contains
    procedure :: count
    procedure :: visit => case_visit
  end type case_t
contains
  subroutine case_visit(self, visitor)
    call visitor%visit('name', self%name) ! self%zero
    call visitor%visit('load', self%load, 'self%zero')
    call visitor%visit('span', self%span)
    call visitor%leave_out('is_new')
  end subroutine case_visit
  subroutine other(self)
    self%zero = 1
  end subroutine other
end module base_case
"""
        self.assert_found(source, ":5: component zero of case_t is not visited by case_visit", "base_case.f90")
        right = source.replace("'self%zero')", "self%zero)")
        self.assertEqual(check(right, "base_case.f90"), (0, "1 files, 0 problem(s)\n"))
        self.assert_found(right.replace("visit('span', self%span)", "visit('span')"), "component span of case_t", "base_case.f90")
        self.assert_found(right.replace("'is_new'", "'is_new is_old'"), "case_t has no component is_old, which case_visit leaves out",
                          "base_case.f90")
        self.assert_found(right.replace("  contains\n", "    real :: later\n  contains\n"), "component later of case_t",
                          "base_case.f90")

    def test_modules_begin_with_the_prefix_of_their_layer(self):
        for layer, name in (("io/hdf5", "io_fields"), ("solid_msm/wing", "solid_wing"), ("programs/common", "common_keys"),
                            ("programs/flusi/output", "flusi_series"), ("programs/msm_train", "train_log"),
                            ("programs/msm_diagnose", "diagnose_json")):
            self.assertEqual(check(module(name), f"{name}.f90", layer), (0, "1 files, 0 problem(s)\n"))
        for folder, layer, name, prefix in (("io/hdf5", "io", "hdf5_fields", "io_"), ("solid_msm", "solid_msm", "msm_wing", "solid_"),
                                            ("programs/flusi/wing", "flusi", "train_log", "flusi_"),
                                            ("programs/msm_train", "msm_train", "training_log", "train_")):
            self.assert_found(module(name), f":1: module {name} in the layer {layer}; names of its modules begin with {prefix}",
                              f"{name}.f90", folder)

    def test_main_program_needs_no_prefix(self):
        self.assertEqual(check("program flusi\nend program flusi\n", "flusi.f90", "programs/flusi")[0], 0)

    def test_unit_tests_are_in_folders_of_layers(self):
        good = ("base/test_thing.f90", "base/CMakeLists.txt", "CMakeLists.txt", "programs/test_x.f90", "tools/test_x.py")
        self.assertEqual(check(CLEAN, tests=good)[0], 0)
        self.assert_found(CLEAN, "tests/unit/test_thing.f90:1: unit tests are in the folder", tests=("test_thing.f90",))
        self.assert_found(CLEAN, "tests/unit/bass:1: there is no layer bass", tests=("bass/test_thing.f90",))

    def test_folders_in_a_circle(self):
        def uses(layer, edges):
            """What the check finds in a layer whose folders use each other as `edges` say."""
            with tempfile.TemporaryDirectory() as root:
                for folder in {folder for edge in edges for folder in edge}:
                    path = Path(root) / "src" / layer / folder / f"{layer}_{folder}.f90"
                    path.parent.mkdir(parents=True)
                    lines = [f"use {layer}_{used}, only: x\n" for user, used in edges if user == folder]
                    path.write_text(module(f"{layer}_{folder}").replace("\nend", "\n" + "".join(lines) + "x = 1\nend", 1))
                return subprocess.run([sys.executable, str(TOOL), root], capture_output=True, text=True, check=False).stdout

        self.assertEqual(uses("io", [("a", "b"), ("b", "c"), ("a", "c")]), "3 files, 0 problem(s)\n")
        found = uses("io", [("a", "b"), ("b", "c"), ("c", "a"), ("c", "d")])
        for edge in ("folder a uses b", "folder b uses c", "folder c uses a"):
            self.assertIn(edge, found)
        self.assertIn(" 3 problem(s)", found)
        self.assertIn("src/io/a/io_a.f90:2: io: folder a uses b, which uses a", found)

    def test_verifications_are_in_folders_of_layers(self):
        verification = {"kind": "tests/verification"}
        self.assertEqual(check(CLEAN, tests=("base/test_thing.f90", "beam.py"), **verification)[0], 0)
        self.assert_found(CLEAN, "tests/verification/bass:1: there is no layer bass", tests=("bass/test_thing.f90",), **verification)
        self.assert_found(CLEAN, "tests/verification/test_x.f90:1: verification tests are in the folder", tests=("test_x.f90",),
                          **verification)

    def test_sizes_in_tests_and_benchmarks(self):
        def long(n, name="long"):
            return f"subroutine {name}()\n" + (n - 2)*"x = 1\n" + f"end subroutine {name}\n"
        for kind, file in (("tests/support", "case.f90"), ("bench", "step/case.f90")):
            where = {"tests": (file,), "kind": kind}
            self.assertEqual(check(CLEAN, content=long(60), **where)[0], 0)
            self.assert_found(CLEAN, f"{kind}/{file}:1: procedure long has 61 lines", content=long(61), **where)
            self.assert_found(CLEAN, f"{kind}/{file}:1: 133 characters", content="!" + 132*"x" + "\n", **where)
            self.assert_found(CLEAN, "401 lines; at most 400", content=401*"x = 1\n", **where)
        wing = {"tests": ("sample_wings.f90",), "kind": "tests/support"}
        self.assertEqual(check(CLEAN, content=long(61, "make_fly_wing"), **wing)[0], 0)
        self.assert_found(CLEAN, "make_fly_wing is short enough now", content=long(60, "make_fly_wing"), **wing)

    def test_sources_are_listed_once(self):
        for text, problem in (("SOURCES base_a.f90\n  io/base_b.f90)", None), ("SOURCES base_a.f90)", "io/base_b.f90 is listed 0 times"),
                              ("base_a.f90 io/base_b.f90 base_a.f90", "base_a.f90 is listed 2 times"),
                              ("base_a.f90 io/base_b.f90 base_c.f90", "there is no base_c.f90")):
            with tempfile.TemporaryDirectory() as root:
                layer = Path(root) / "src" / "base"
                (layer / "io").mkdir(parents=True)
                (layer / "base_a.f90").write_text(module("base_a"))
                (layer / "io" / "base_b.f90").write_text(module("base_b"))
                (layer / "CMakeLists.txt").write_text(text)
                done = subprocess.run([sys.executable, str(TOOL), root], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, problem is not None, done.stdout)
            self.assertIn(f"src/base/CMakeLists.txt:1: {problem}" if problem else "0 problem(s)", done.stdout)

    def test_two_modules(self):
        self.assert_found(CLEAN + "module base_thing\nend module base_thing\n", ":12: second module")

    def test_use_without_only(self):
        self.assert_found(CLEAN.replace("use base_kinds, &\n    only: rp", "use base_kinds"),
                          ":4: use base_kinds without only")
        self.assert_found(CLEAN.replace(", only: output_unit", ""), ":3: use iso_fortran_env without only")

    def test_unused_imports(self):
        source = """module base_case
  use base_kinds, only: {} ! rp
  implicit none
  real :: a = {}
end module base_case
"""
        for imported, statement in (("rp", "1.0_rp"), ("rp", "1e-3_RP"), ("i8", "0_i8"), ("rp", ".5_rp"), ("a_t", "b(a_t)"),
                                    ("b => c", "b + 1"), ("operator(+), assignment(=)", "1"), ("b, &\n  & c", "b + &\n c")):
            self.assertEqual(check(source.format(imported, statement), "base_case.f90"), (0, "1 files, 0 problem(s)\n"), imported)
        for imported, statement in (("rp", "1.0"), ("i8", "0 ! i8"), ("i8", "'i8'"), ("c => i8", "i8"), ("i8", "b%i8"),
                                    ("i8", "b % i8"), ("b, &\n  & i8, &\n  c", "b*c"), ("e3", "1e3")):
            name = imported.split(" =>")[0] if "&" not in imported else "i8"
            self.assert_found(source.format(imported, statement), f"base_case.f90:2: {name} is imported and not used",
                              "base_case.f90")
        included = source.format("c_int", "1").replace("implicit none", "include 'other.f03'")
        self.assertEqual(check(included, "base_case.f90")[0], 0, "what is included may use it")

    def test_public_names_that_nobody_imports(self):
        source = """module base_case
  implicit none
  private
  public :: used, &
            {}
  integer, parameter, public :: FIRST = 1, SECOND(2) = [1, 2]
  type :: used
    integer, public :: number
  end type used
end module base_case
"""
        test = "program p\n  use base_case, only: used, mine => renamed, SECOND\nend program p\n"
        files = {"tests": ("base/test_case.f90",), "content": test}
        self.assertEqual(check(source.format("renamed"), "base_case.f90", **files)[0], 0)
        self.assert_found(source.format("mine"), "base_case.f90:4: mine is public, and no other file imports it", "base_case.f90",
                          **files)
        self.assert_found(source.format("renamed").replace("FIRST = 1, SECOND(2) = [1, 2]", "first = max(1, 2)"),
                          "base_case.f90:6: first is public", "base_case.f90", **files)

    def test_long_procedures_of_python(self):
        def script(lines):
            return "#!/usr/bin/env python3\ndef long(x):\n" + "    x += 1\n" * (lines - 1)
        for name in ("long.py", "long"):
            files = {"kind": "tools", "tests": (name,)}
            self.assertEqual(check(CLEAN, content=script(60), **files)[0], 0, name)
            self.assert_found(CLEAN, f"{name}:2: procedure long has 61 lines; at most 60", content=script(61), **files)
        self.assertEqual(check(CLEAN, kind="tools", tests=("text",), content="no Python: (")[0], 0)

    def test_long_lists_of_arguments(self):
        def source(name, count):
            names = ", &\n    ".join(f"a{i}" for i in range(count))
            return (f"module {name}\ncontains\n  pure subroutine long(&\n    {names}) bind(c)\n  end subroutine long\n"
                    f"end module {name}\n")
        self.assertEqual(check(source("base_case", 8), "base_case.f90")[0], 0)
        self.assertEqual(check(source("base_case", 0), "base_case.f90")[0], 0)
        self.assert_found(source("base_case", 9), "base_case.f90:3: procedure long has 9 arguments; at most 8", "base_case.f90")
        permitted = source("base_wording", 9).replace("long", "word_factor")
        self.assertEqual(check(permitted, "base_wording.f90")[0], 0)
        self.assert_found(permitted.replace("a7, ", ""), "word_factor has few arguments: take it out", "base_wording.f90")

    def test_types_of_many_components(self):
        def source(count):
            return ("module base_case\n  type :: case_t\n    integer :: a(2, 3) = reshape([1, 2], [2, 3]), b = f(1, 2)\n" +
                    (count - 2)*"    real :: c\n" + "  contains\n    procedure :: d\n  end type case_t\nend module base_case\n")
        self.assertEqual(check(source(25), "base_case.f90"), (0, "1 files, 0 problem(s)\n"))
        self.assert_found(source(26), "base_case.f90:2: type case_t has 26 components; at most 25", "base_case.f90")

    def test_print(self):
        self.assert_found(CLEAN.replace("implicit none", "print *, 'x'"), ":6: print")
        self.assert_found(CLEAN.replace("implicit none", "if (a) print '(a)', 'x'"), ":6: print")

    def test_words_decide_nothing_in_layers_of_physics(self):
        source = "module fluid_flow\ncontains\n  subroutine go\n    {}\n  end subroutine go\nend module fluid_flow\n"
        for statement in ("if (p%kind == 'dynamic') a = 1", "if (any(w /= [character(4) :: 'xy', 'xz'])) a = 1",
                          "if ('free' == kind) a = 1", "case ('cavity', 'top')", "where (p%kind(:) == 'fixed') u = 0",
                          "if (index(p%side, 'dorsal') > 0) a = 1"):
            self.assert_found(source.format(statement), "fluid_flow.f90:4: decides by a word", "fluid_flow.f90", "fluid")
        for statement in ("if (problem == '') a = 1", "if (name(n:) == ':') a = 1", "a = b ! == 'x'", "call fail('a == b')", "case (MEAN_FREE)",
                          "if (index(name, ':') > 0) a = 1"):
            self.assertEqual(check(source.format(statement), "fluid_flow.f90", "fluid")[0], 0, statement)
        reader = source.replace("fluid_flow", "fluid_flow_keys").format("if (word == '1') a = 1")
        self.assertEqual(check(reader, "fluid_flow_keys.f90", "fluid")[0], 0, "words are read")
        program = source.replace("fluid_flow", "train_flow").format("if (word == '1') a = 1")
        self.assert_found(program, "train_flow.f90:4: decides by a word", "train_flow.f90", "programs/msm_train")
        reader = source.replace("fluid_flow", "simulation_translations").format("if (word == '1') a = 1")
        self.assertEqual(check(reader, "simulation_translations.f90", "programs/simulation")[0], 0, "a program reads words")
        other = source.replace("fluid_flow", "io_flow").format("if (word == '1') a = 1")
        self.assertEqual(check(other, "io_flow.f90", "io")[0], 0, "other layers have words")

    def test_tab_and_trailing_blank(self):
        self.assert_found(CLEAN.replace("implicit", "\timplicit"), ":6: tab")
        self.assert_found(CLEAN.replace("none", "none "), ":6: trailing blank")

    def test_long_file(self):
        self.assertEqual(check(CLEAN + 389 * "! line\n")[0], 0)
        self.assert_found(CLEAN + 390 * "! line\n", "401 lines; at most 400")

    def test_long_line(self):
        self.assertEqual(check(CLEAN + "! " + 130*"x" + "\n")[0], 0)
        self.assert_found(CLEAN + "! " + 131*"x" + "\n", ":12: 133 characters; at most 132")

    def test_long_procedure(self):
        def source(n):
            return CLEAN.replace("contains\n", "contains\n  pure type(a_t) function long(x) result(y)\n" + n*"    y = x\n" +
                                 "  end function long\n")
        self.assertEqual(check(source(58))[0], 0)
        self.assert_found(source(59), ":9: procedure long has 61 lines; at most 60")

    def test_crowded_folder(self):
        for count in (25, 26):
            with tempfile.TemporaryDirectory() as root:
                folder = Path(root) / "src" / "base"
                folder.mkdir(parents=True)
                for i in range(count):
                    (folder / f"base_{i}.f90").write_text(module(f"base_{i}"))
                done = subprocess.run([sys.executable, str(TOOL), root], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, count > 25, done.stdout)
            self.assertEqual("src/base:0: 26 files; at most 25" in done.stdout, count > 25, done.stdout)

    def test_no_sources(self):
        with tempfile.TemporaryDirectory() as root:
            done = subprocess.run([sys.executable, str(TOOL), root], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("no Fortran sources", done.stderr)


if __name__ == "__main__":
    unittest.main()
