# SPDX-License-Identifier: GPL-3.0-or-later
"""The package reads what the programs write, into tables with units, and finds and starts the programs."""
import ast
import json
import os
import re
import stat
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import flusi_msm
from flusi_msm import InputError, RunError, workflow
from flusi_msm.matlab import unique
from flusi_msm.programs import find_program, run, text_of_input
from flusi_msm.tables import si_factor, si_name
from json_schema import validate
from synthetic import SOURCE, run_tool, write_field

L, F, RHO = 9e-3, 158.0, 1.2


@pytest.fixture
def run_folder(tmp_path):
    """A series of 2.5 beats of known means, with units, and a field."""
    t = np.linspace(0, 2.5, 251)
    rows = np.stack([t, 3 + np.sin(2 * np.pi * t), t], 1)
    head = f"% units: L = {L} m, 1/T = {F} 1/s, rho = {RHO} kg/m^3\n%      time [T]  Fx [rho L^4/T^2]  aerodynamic power [rho L^5/T^3]\n"
    (tmp_path / "forces.t").write_text(head + "\n".join(" ".join(f"{v:.10E}" for v in row) for row in rows) + "\n")
    x = np.arange(6) * 0.5
    write_field(tmp_path, "ux", "000500", np.broadcast_to(x, (3, 4, 6)).copy(), (3.0, 2.0, 1.5), 0.5)
    return tmp_path


def test_series_and_stroke_averages(run_folder):
    table = flusi_msm.read_series(run_folder / "forces.t")
    assert list(table.columns) == ["Fx", "aerodynamic power"] and table.index.name == "time"
    assert table.attrs["units"]["Fx"] == "rho L^4/T^2"
    means = flusi_msm.stroke_average(table)
    # Of the sine the trapezoidal rule over whole beats is exact, of a line too.
    np.testing.assert_allclose(means["Fx"], [3, 3], atol=1e-9)
    np.testing.assert_allclose(means["aerodynamic power"], [0.5, 1.5], atol=1e-9)
    assert list(flusi_msm.stroke_average(table, first=1).index) == [1]
    np.testing.assert_allclose(flusi_msm.stroke_average(table, period=0.77)["aerodynamic power"], 0.77 * np.array([0.5, 1.5, 2.5]), rtol=1e-9)
    with pytest.raises(InputError, match="no whole beat"):
        flusi_msm.stroke_average(table, period=3.0)


def test_si_units(run_folder):
    si = flusi_msm.to_si(flusi_msm.read_series(run_folder / "forces.t"))
    force, power = RHO * L**4 * F**2, RHO * L**5 * F**3
    assert si["Fx"].iloc[0] == pytest.approx(3 * force)
    assert si["aerodynamic power"].iloc[-1] == pytest.approx(2.5 * power) and si.index[-1] == pytest.approx(2.5 / F)
    assert si.attrs["units"] == {"time": "s", "Fx": "N", "aerodynamic power": "W"}
    np.testing.assert_allclose(flusi_msm.stroke_average(si, period=1 / F)["Fx"], 3 * force, rtol=1e-8)
    scales = {"length": L, "frequency": F, "density": RHO}
    for unit, factor in (("L/T^2", L * F**2), ("rad/T", F), ("1/T", F), ("", 1.0), ("s", 1.0)):
        assert si_factor(unit, scales) == pytest.approx(factor)
    assert si_name("rho L^2") == "kg/m^3 m^2"
    with pytest.raises(InputError, match="furlong"):
        si_factor("furlong", scales)
    (run_folder / "bare.t").write_text("% time [T]  Fx [rho L^4/T^2]\n0 1\n1 1\n")
    with pytest.raises(InputError, match=r"give \[units\]"):
        flusi_msm.to_si(flusi_msm.read_series(run_folder / "bare.t"))


def test_fields(run_folder):
    pytest.importorskip("xarray")
    found = flusi_msm.list_fields(run_folder)
    assert list(found) == ["ux"] and found["ux"] == [run_folder / "ux_000500.h5"]
    field = flusi_msm.read_field(found["ux"][0])
    assert field.dims == ("z", "y", "x") and field.attrs["time"] == 0.5
    np.testing.assert_allclose(field.isel(z=1, y=2), field["x"], atol=1e-6)
    assert float(field.sel(x=1.1, method="nearest").mean()) == pytest.approx(1.0)


def test_measurement(tmp_path):
    x, y = np.linspace(0, 9e-3, 10), np.linspace(-3e-3, 0, 4)
    rest = np.zeros((4, 10))
    rest[0, 0] = np.nan
    bent = 1e-5 * np.arange(10.0) * np.ones((4, 1))
    flusi_msm.write_measurement(tmp_path / "m.h5", x, y, rest, {"tip": (bent, {"force": 2e-4, "direction": [0, 0, 1.0], "point": [8e-3, -1e-3],
                                                                            "order": 1})}, {"height": 1e-5}, {"order_is_random": 1}, "a test")
    found = flusi_msm.read_measurement(tmp_path / "m.h5")
    assert (found.title, found.accuracy, found.calibration) == ("a test", {"height": 1e-5}, {"order_is_random": 1})
    assert np.isnan(found.deformation("tip")[0, 0]) and found.deformation("tip")[1, 9] == pytest.approx(9e-5)
    row = found.loads().loc["tip"]
    assert (row["force"], row["x"], row["largest"]) == (2e-4, 8e-3, pytest.approx(9e-5))
    with pytest.raises(InputError, match="other has no heights"):
        found.deformation("other")
    with pytest.raises(InputError, match="not a measurement file"):
        flusi_msm.read_measurement(SOURCE / "wings/plate.h5")


def test_diagnosis(tmp_path):
    data = {"schema": "flusi-msm diagnosis", "schema_version": 2, "verdict": {"word": "adequate", "sentence": "It fits."},
            "baseline": {"parameters": [{"name": "E", "value": 9e9}]},
            "effects": [{"name": "a", "posterior": 0.1}, {"name": "b", "posterior": 0.7}, {"name": "c"}]}
    (tmp_path / "diagnosis.json").write_text(json.dumps(data))
    found = flusi_msm.read_diagnosis(tmp_path / "diagnosis.json")
    assert (found.verdict, found.sentence) == ("adequate", "It fits.")
    assert list(found.causes().index) == ["b", "a", "c"] and found.parameters().loc["E", "value"] == 9e9
    for text, words in (("{", "not JSON"), ("[]", "not the diagnosis.json")):
        (tmp_path / "other.json").write_text(text)
        with pytest.raises(InputError, match=words):
            flusi_msm.read_diagnosis(tmp_path / "other.json")


def test_schema_of_diagnoses(tmp_path):
    """The schema is valid itself, and validating names the place of a mistake."""
    wrong = validate({}, SOURCE / "docs/formats/diagnosis.schema.json")
    assert wrong and all(text.startswith("$") for text in wrong)
    path = tmp_path / "schema.json"
    path.write_text(json.dumps({"type": "object", "properties": {"n": {"type": "array", "items": {"type": "integer"}}}}))
    assert validate({"n": [1, 2]}, path) == []
    assert validate({"n": [1, "2"]}, path) == ["$.n[1]: '2' is not of type 'integer'"]
    path.write_text(json.dumps({"type": "thing"}))
    with pytest.raises(Exception, match="thing"):
        validate({}, path)


def test_matlab(run_folder):
    from scipy.io import loadmat
    done = run_tool("to_mat", run_folder, "--fields", "ux")
    assert done.returncode == 0, done.stderr
    found = loadmat(run_folder / "run.mat", squeeze_me=True, struct_as_record=False)
    np.testing.assert_allclose(found["forces"].time, np.linspace(0, 2.5, 251), atol=1e-9)
    assert found["forces"].aerodynamic_power.shape == (251,) and found["forces_units"].Fx == "rho L^4/T^2"
    assert found["ux_000500"].data.shape == (3, 4, 6) and found["ux_000500"].time == 0.5
    assert unique(["a b", "a.b", "3", "x" * 80])[:3] == ["a_b", "a_b_2", "x3"]
    done = run_tool("to_mat", run_folder, "--fields", "uq")
    assert done.returncode == 2 and "no fields of uq" in done.stderr


# ---- programs ------------------------------------------------------------------------------------

def program(folder, name, text):
    path = folder / name
    path.write_text("#!/bin/sh\n" + text)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)


def test_programs_are_found_and_their_failures_told(tmp_path, monkeypatch):
    monkeypatch.setenv("FLUSI_BIN", str(tmp_path))
    with pytest.raises(InputError, match="flusi: not found in FLUSI_BIN"):
        find_program("flusi")
    program(tmp_path, "flusi", 'echo "$PWD $1"; exit $2\n')
    assert find_program("flusi") == (tmp_path / "flusi").resolve()
    done = run("flusi", ["a.ini", "0"], tmp_path)
    assert done.output == f"{tmp_path} a.ini\n"
    with pytest.raises(InputError, match="a.ini"):
        run("flusi", ["a.ini", "2"], tmp_path)
    with pytest.raises(RunError, match="exit code 3") as error:
        run("flusi", ["a.ini", "3"], tmp_path, echo=True)
    assert error.value.code == 3 and "a.ini" in error.value.output
    assert run("flusi", ["a.ini", "11"], tmp_path, good=(0, 11)).code == 11
    program(tmp_path, "flusi", "exec sleep 100\n")
    with pytest.raises(RunError, match="no end within"):
        run("flusi", [], tmp_path, timeout=0.2)


def test_input_files():
    text = text_of_input({"Wing": {"file": "a.h5", "E": np.float64(1e10), "left": None}, "Time": {"on": True, "x": [1, 2.5], "nt": 3}})
    assert text == "[Wing]\nfile = a.h5;\nE = 10000000000.0;\n[Time]\non = yes;\nx = 1 2.5;\nnt = 3;\n"


def test_fly_writes_its_input_and_returns_the_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("FLUSI_BIN", str(tmp_path))
    program(tmp_path, "flusi", 'cp "$1" seen.ini; printf "%% time [T]  Fx [-]\\n0 1\\n1 3\\n" > forces.t\n')
    result = flusi_msm.fly({"Time": {"nt": 1}}, tmp_path / "run")
    assert (tmp_path / "run/seen.ini").read_text() == "[Time]\nnt = 1;\n"
    assert result.names() == ["forces"]
    assert flusi_msm.stroke_average(result.series())["Fx"].tolist() == [2.0]
    (tmp_path / "x").mkdir()
    (tmp_path / "x/in.ini").write_text("[Time]\nnt = 2;\n")
    assert flusi_msm.fly(tmp_path / "x/in.ini").folder == tmp_path / "x"
    with pytest.raises(InputError, match="no such file"):
        flusi_msm.fly(tmp_path / "nothing.ini")


def test_everything_public_is_typed_and_there():
    for name in flusi_msm.__all__:
        assert getattr(flusi_msm, name) is not None
    for function in (workflow.train, workflow.diagnose, workflow.fly, flusi_msm.read_series, flusi_msm.stroke_average, flusi_msm.read_measurement):
        arguments = function.__code__.co_varnames[:function.__code__.co_argcount]
        assert {*arguments, "return"} <= set(function.__annotations__), function
    with pytest.raises(AttributeError):
        flusi_msm.nothing


def test_every_function_has_hints():
    """Read from the sources, so that nothing heavy is imported. Whether hints are right is for mypy."""
    lacking = []
    for path in sorted((SOURCE / "tools/flusi_msm").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
                own = node.args
                named = [*own.posonlyargs, *own.args, *own.kwonlyargs, *filter(None, (own.vararg, own.kwarg))]
                bare = [one.arg for one in named if one.annotation is None and one.arg not in ("self", "cls")]
                if bare or node.returns is None:
                    lacking.append(f"{path.relative_to(SOURCE)}:{node.lineno}: {node.name}: {', '.join(bare) or 'what it returns'}")
    assert not lacking, "without hints:\n" + "\n".join(lacking)


def test_import_is_light():
    """A tool that draws wings does not wait for pandas."""
    code = "import sys, flusi_msm, flusi_msm.wing.file; assert 'pandas' not in sys.modules and 'flusi_msm.workflow' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True, env={**os.environ, "PYTHONPATH": str(Path(SOURCE, "tools"))})


def test_everything_is_installed():
    """The package that pip installs has every folder of modules, and the command of every tool that does not need the source."""
    tomllib = pytest.importorskip("tomllib")
    told = tomllib.loads((SOURCE / "tools/pyproject.toml").read_text())
    folders = {str(path.parent.relative_to(SOURCE / "tools")).replace("/", ".") for path in (SOURCE / "tools/flusi_msm").rglob("*.py")}
    assert folders == set(told["tool"]["setuptools"]["packages"])
    commands = {name.removeprefix("flusi-").replace("-", "_"): place for name, place in told["project"]["scripts"].items()}
    for place in commands.values():
        module, function = place.split(":")
        assert callable(getattr(import_module(module), function)), place
    tools = {path.name for path in (SOURCE / "tools").iterdir() if path.is_file() and "flusi_msm.project_python" in path.read_text(errors="replace")}
    only_source = {"make_wings", "reproduce-paper"}
    assert tools - only_source <= set(commands) <= tools


def test_ruff_reads_every_command():
    """Commands have no ending by which ruff would find them: pyproject.toml lists those in Python."""
    tomllib = pytest.importorskip("tomllib")
    told = tomllib.loads((SOURCE / "pyproject.toml").read_text())["tool"]["ruff"]["extend-include"]
    python = {f"tools/{path.name}" for path in (SOURCE / "tools").iterdir()
              if path.is_file() and path.suffix == "" and re.match("#!.*python", path.read_text(errors="replace"))}
    assert {name for name in told if name.startswith("tools/")} == python
    assert len(told) == len(set(told))
    assert all((SOURCE / name).is_file() for name in told)


def test_old_names_tell_the_new_ones():
    for old, new in (("blindgen", "blind_generate"), ("blindscore", "blind_score"), ("reproduce-paper", "reproduce_paper")):
        for name, notice in ((old, f"{old}: this tool is called {new}; the older name works too\n"), (new, "")):
            done = subprocess.run([sys.executable, "-B", SOURCE / "tools" / name, "--help"], capture_output=True, text=True, check=False)
            assert (done.returncode, done.stderr) == (0, notice), done.stderr
