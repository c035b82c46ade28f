#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks XDMF indices: well-formed, times growing, every file and dataset there with the size stated.

usage: check_xdmf.py <h5dump> <index.xmf> ...
Needs nothing but the standard library; datasets are looked at with `h5dump -A`.
"""
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ET


def header(h5dump, path):
    """Type, sizes and attributes of all datasets of a file, as text."""
    return subprocess.run([h5dump, "-m", "%.17g", "-A", path], capture_output=True, text=True, check=True).stdout


def dataset_info(text, name):
    """Sizes and bytes per number of a dataset."""
    out = text[text.index(f'DATASET "{name}"'):]
    sizes = re.search(r"DATASPACE\s+SIMPLE\s*\{\s*\(([^)]*)\)", out).group(1)
    bits = re.search(r"H5T_IEEE_F(\d+)", out).group(1)
    return [int(n) for n in sizes.split(",")], int(bits) // 8


def attribute(text, name, which):
    """Numbers of an attribute of a dataset."""
    out = text[text.index(f'DATASET "{name}"'):]
    data = re.search(rf'ATTRIBUTE "{which}" \{{.*?DATA\s*\{{(.*?)\}}', out, re.S).group(1)
    return [float(x) for x in re.sub(r"\(\d+\):", " ", data).replace(",", " ").split()]


def check(h5dump, index):
    folder = os.path.dirname(os.path.abspath(index))
    root = ET.parse(index).getroot()
    assert root.tag == "Xdmf" and root.get("Version") == "3.0", "not XDMF 3"
    series = root.find("./Domain/Grid")
    assert series.get("GridType") == "Collection" and series.get("CollectionType") == "Temporal", "no time series"
    times, files = [], 0
    for grid in series.findall("Grid"):
        times.append(float(grid.find("Time").get("Value")))
        topology = grid.find("Topology")
        assert topology.get("TopologyType") == "3DCoRectMesh", topology.attrib
        nodes = [int(n) for n in topology.get("Dimensions").split()]
        origin, spacing = ([float(x) for x in item.text.split()] for item in grid.findall("Geometry/DataItem"))
        assert grid.findall("Attribute"), "a grid without fields"
        for field in grid.findall("Attribute"):
            items = field.findall("DataItem")
            assert len(items) == 1 and field.get("Center") == "Node"
            if field.get("AttributeType") == "Vector":
                assert items[0].get("Function") == "JOIN($0, $1, $2)"
                assert [int(n) for n in items[0].get("Dimensions").split()] == nodes + [3]
                items = items[0].findall("DataItem")
                stem = field.get("Name")
                assert [i.text.split(":/")[1] for i in items] == [stem + c for c in "xyz"], "components out of order"
            for item in items:
                file, name = item.text.strip().split(":/")
                assert not os.path.isabs(file), "absolute path"
                path = os.path.join(folder, file)
                assert os.path.exists(path), f"{file} is missing"
                text = header(h5dump, path)
                sizes, width = dataset_info(text, name)
                stated = [int(n) for n in item.get("Dimensions").split()]
                assert sizes == nodes == stated, f"{file}: {sizes} is not {nodes}"
                assert width == int(item.get("Precision")), f"{file}: {width} bytes"
                files += 1
                assert attribute(text, name, "time") == [times[-1]], f"{file}: another time"
                size = attribute(text, name, "domain_size")[::-1]
                assert attribute(text, name, "origin")[::-1] == origin
                for n, h, length in zip(nodes, spacing, size):
                    # The last point lies inside of the box, and at most one (strided) spacing before its end.
                    assert (n - 1) * h < length <= n * h * (1 + 1e-12), f"{file}: spacing {h}, box {length}"
    assert times and times == sorted(set(times)), f"times {times}"
    print(f"pass  {index}: {len(times)} times, {files} files")


if __name__ == "__main__":
    for name in sys.argv[2:]:
        check(sys.argv[1], name)
