"""Runs a notebook in the current folder, headless; prints what its cells print. usage: run_notebook.py FILE"""

import os
import sys

os.environ.setdefault("MPLBACKEND", "module://matplotlib_inline.backend_inline")

import nbformat
from nbclient import NotebookClient

notebook = nbformat.read(sys.argv[1], as_version=4)
nbformat.validate(notebook)
NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
pictures = 0
for cell in notebook.cells:
    for output in cell.get("outputs", []):
        print(output.get("text", ""), end="")
        pictures += "image/png" in output.get("data", {})
print(f"{pictures} pictures")
if len(sys.argv) > 2:
    nbformat.write(notebook, sys.argv[2])
