#!/usr/bin/env python3
"""Runs the code cells of examples/localize.ipynb on a small town, and checks the file's form and the types of the package.

usage: notebook_test.py SOURCE BUILD SIGHTLINE SIGHTLINE_TOWN      exit 77: no Python with NumPy
"""
import ast
import inspect
import json
import os
import pathlib
import subprocess
import sys
import tempfile

CONFIG = """annotation: {ranges_m: [10, 30], split: auto}
mapping: {scans: mapping/scans, poses: mapping/poses.tum}
localization: {scans: drive_1/scans, poses: drive_1/poses.tum}
measure-error: {offset_count: 3, reference: known}
train-model: {trees: 20}
"""


def check_form(notebook):
    """nbformat 4.5, as nbformat.v4.5.schema.json has it."""
    assert set(notebook) == {"cells", "metadata", "nbformat", "nbformat_minor"}, set(notebook)
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    ids = [cell["id"] for cell in notebook["cells"]]
    assert len(set(ids)) == len(ids)
    for cell in notebook["cells"]:
        assert all(isinstance(line, str) for line in cell["source"]) and isinstance(cell["metadata"], dict)
        if cell["cell_type"] == "code":
            assert set(cell) == {"cell_type", "execution_count", "id", "metadata", "outputs", "source"}
            assert cell["execution_count"] is None and cell["outputs"] == [], "committed without outputs"
        else:
            assert set(cell) == {"cell_type", "id", "metadata", "source"} and cell["cell_type"] == "markdown"


def check_types(package):
    """Every public name, method and parameter is in __init__.pyi, which has no other."""
    import sightline
    tree = ast.parse((package / "sightline" / "__init__.pyi").read_text())
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    values = {node.target.id for node in tree.body if isinstance(node, ast.AnnAssign)}
    assert set(sightline.__all__) <= set(classes) | set(functions) | values, \
        set(sightline.__all__) - set(classes) - set(functions) - values

    def parameters(node):
        return {one.arg for one in node.args.args + node.args.kwonlyargs + node.args.posonlyargs} - {"self"}

    for name, node in functions.items():
        assert parameters(node) == set(inspect.signature(getattr(sightline, name)).parameters), name
    for name, node in classes.items():
        real = getattr(sightline, name, None)
        if real is None:  # a type of an answer, not exported
            continue
        fields = {one.target.id for one in node.body if isinstance(one, ast.AnnAssign)}
        if hasattr(real, "_fields_"):
            public = {field[0] for field in real._fields_ if not field[0].startswith("_")} - {"reserved"}
            assert fields == public, (name, fields ^ public)
        for method in (one for one in node.body if isinstance(one, ast.FunctionDef)):
            assert hasattr(real, method.name), (name, method.name)
            member = inspect.getattr_static(real, method.name)
            if isinstance(member, property) or method.name.startswith("__"):
                continue
            assert parameters(method) == set(inspect.signature(member).parameters) - {"self"}, (name, method.name)
        for member in vars(real):
            typed = fields | {one.name for one in node.body if isinstance(one, ast.FunctionDef)}
            if not member.startswith("_") and member not in dict(getattr(real, "_fields_", [])):
                assert member in typed, (name, member)


def check_refusals(map_path):
    import numpy
    import sightline
    scan = numpy.zeros((3, 3))
    start = sightline.pose((0, 0, 0), (0, 0, 0, 1))
    for arguments, expected in (({"stamps_s": [1.0, 1.0]}, "ascend"), ({"stamps_s": [1.0]}, "fewer")):
        try:
            sightline.localize(map_path, [scan, scan], start, **arguments)
        except ValueError as error:
            assert expected in str(error), error
        else:
            raise AssertionError(arguments)
    nothing = sightline.localize(map_path, [], start)
    assert nothing.T_world_vehicle.shape == (0, 4, 4) and nothing.covariance.shape == (0, 6, 6)


def run_cells(source, folder):
    notebook = json.loads((source / "examples" / "localize.ipynb").read_text())
    check_form(notebook)
    os.environ["SIGHTLINE_TOWN"] = str(folder)
    names = {"__name__": "__main__"}
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), f"cell {cell['id']}", "exec"), names)
    errors_m = names["errors_m"]
    assert names["drive"].is_localized.all() and (errors_m <= 0.10).mean() > 0.95, errors_m
    assert (names["drive"].integrity == 1).all()


def inner(source, folder):
    check_types(source / "formats" / "reader" / "python")
    run_cells(source, folder)
    check_refusals(folder / "town.slmap")


def python_with_numpy():
    for python in (sys.executable, "/usr/bin/python3"):
        if subprocess.run([python, "-c", "import numpy"], stderr=subprocess.DEVNULL).returncode == 0:
            return python
    return None


def main():
    if sys.argv[1] == "--inner":
        return inner(pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]))
    source, build, sightline, town = sys.argv[1:5]
    python = python_with_numpy()
    if python is None:
        print("no Python with NumPy")
        return 77
    environment = dict(os.environ, PYTHONPATH=f"{source}/formats/reader/python", PYTHONDONTWRITEBYTECODE="1",
                       LD_LIBRARY_PATH=f"{build}/formats/reader:{build}/passes/vehicle")
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([town, "--seed", "3", "--length-m", "60", "--drives", "1", "--output", folder, "--force"], check=True,
                       stdout=subprocess.DEVNULL)
        config = pathlib.Path(folder) / "town.yaml"
        config.write_text(CONFIG)
        subprocess.run([sightline, "compile", config, "-q", "-o", pathlib.Path(folder) / "town.slmap"], check=True)
        return subprocess.run([python, __file__, "--inner", source, folder], env=environment).returncode


if __name__ == "__main__":
    sys.exit(main())
