#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The notebook of the tutorial runs to its end, and finds what it hides.

usage: notebook.py <folder of the programs> [FOLDER]

With FOLDER the files of the notebook stay there, with the executed notebook and its pictures.
"""
import os
import re
import sys
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient

SOURCE = Path(__file__).resolve().parents[2]
NOTEBOOK = SOURCE / "docs/guide/tutorial.ipynb"


def texts(cell):
    """What a cell printed and showed, as text."""
    return "\n".join(out.get("text", "") or out.get("data", {}).get("text/plain", "") for out in cell.get("outputs", []))


def main():
    programs, keep = Path(sys.argv[1]).resolve(), sys.argv[2:]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(keep[0] if keep else name).resolve()
        folder.mkdir(exist_ok=True)
        os.environ.update(FLUSI_BIN=str(programs), FLUSI_SOURCE=str(SOURCE), FLUSI_RUN=str(folder), MPLBACKEND="module://matplotlib_inline.backend_inline",
                          IPYTHONDIR=str(folder / ".ipython"), JUPYTER_DATA_DIR=str(folder / ".jupyter"))
        notebook = nbformat.read(NOTEBOOK, as_version=4)
        nbformat.validate(notebook)
        stored = [cell for cell in notebook.cells if cell.cell_type == "code" and (cell.outputs or cell.execution_count)]
        assert not stored, "the notebook is stored without outputs: clear them"
        try:
            NotebookClient(notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(folder)}}).execute()
        finally:
            nbformat.write(notebook, folder / "executed.ipynb")
        said = "\n".join(texts(cell) for cell in notebook.cells)
        pictures = sum("image/png" in out.get("data", {}) for cell in notebook.cells for out in cell.get("outputs", []))
        assert pictures == 3, f"{pictures} pictures"
        chi2, heights = map(float, re.search(r"chi\^2 = (\d+) of (\d+) heights", said).groups())
        # chi^2 of a right model has the mean n and the sd sqrt(2 n).
        assert chi2 > heights + 3 * (2 * heights)**0.5, (chi2, heights)
        verdict = re.search(r"^(\w+) - (.*)", said, re.M)
        print(f"chi^2 = {chi2:.0f} of {heights:.0f}; {verdict.group(0)}")
        assert verdict.group(1) == "named" and "changes along the span" in verdict.group(2), verdict.group(0)
        found = float(re.search(r"^E_gradient: (\S+);", said, re.M).group(1))
        assert -1.8 < found < -0.6, f"the gradient is {found}, not the -1.2 that was hidden"
        assert "fingerprint = " in said and "bending_left" in said, said


if __name__ == "__main__":
    main()
