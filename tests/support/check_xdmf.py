#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks XDMF indices of fields and of wings: well-formed, times growing, every file and dataset there with the
size and type stated.

usage: check_xdmf.py <h5dump> <index.xmf> ...
Needs nothing but the standard library; datasets are looked at with `h5dump -A`.
"""
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ET


HEADERS = {}  # type, sizes and attributes of all datasets of a file, as text


def read_headers(h5dump, folder, root):
    """All files that an index names, by one call. (What follows -A may be taken for its argument.)"""
    named = {item.text.strip().split(":/")[0] for item in root.iter("DataItem") if ":/" in (item.text or "")}
    paths = sorted(path for path in (os.path.join(folder, file) for file in named) if os.path.exists(path))
    text = subprocess.run([h5dump, "-A", "-m", "%.17g", *paths], capture_output=True, text=True, check=True).stdout
    parts = re.split(r'^HDF5 "(.*)" \{$', text, flags=re.M)[1:]
    HEADERS.update(zip(parts[::2], parts[1::2]))


def header(path):
    assert path in HEADERS, f"{path} is missing"
    return HEADERS[path]


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


def check_wing(h5dump, folder, wing):
    """A collection of membrane and veins: every dataset is there as stated, and cells use points that exist."""
    grids = wing.findall("Grid")
    names = [grid.get("Name") for grid in grids]
    assert names and set(names) <= {"membrane", "veins"}, f"grids {names}"
    files = 0
    for grid in grids:
        topology, geometry = grid.find("Topology"), grid.find("Geometry")
        is_membrane = grid.get("Name") == "membrane"
        assert topology.get("TopologyType") == ("Triangle" if is_membrane else "Mixed"), topology.attrib
        assert geometry.get("GeometryType") == "XYZ", geometry.attrib
        n_points = int(geometry.find("DataItem").get("Dimensions").split()[0])
        fields = {field.get("Name"): field for field in grid.findall("Attribute")}
        assert "displacement" in fields and (is_membrane or "diameter" in fields), f"fields {list(fields)}"
        for field in fields.values():
            assert field.get("Center") == "Node"
            sizes = [n_points, 3] if field.get("AttributeType") == "Vector" else [n_points]
            assert [int(n) for n in field.find("DataItem").get("Dimensions").split()] == sizes, field.attrib
        for item in grid.iter("DataItem"):
            check_item(folder, item)
            files += 1
        cells = integers(h5dump, folder, topology.find("DataItem"))
        if is_membrane:
            corners, count = cells, len(cells) // 3
        else:
            corners, count, at = [], 0, 0
            while at < len(cells):
                assert cells[at] == 2 and cells[at + 1] > 1, "a cell of the veins is a polyline"
                corners += cells[at + 2:at + 2 + cells[at + 1]]
                at += 2 + cells[at + 1]
                count += 1
        assert count == int(topology.get("NumberOfElements")), f"{count} cells"
        assert min(corners) == 0 and max(corners) == n_points - 1, "cells use all points"
    return files


def integers(h5dump, folder, item):
    """All numbers of a dataset of integers."""
    file, name = item.text.strip().split(":/")
    out = subprocess.run([h5dump, "-y", "-w", "0", "-d", name, os.path.join(folder, file)], capture_output=True,
                         text=True, check=True).stdout
    data = re.search(r"DATA \{(.*?)\}", out, re.S).group(1)
    return [int(n) for n in data.replace(",", " ").split()]


def check_surface(h5dump, folder, grid):
    """One surface: triangles with vectors on the points and scalars on the triangles."""
    topology, geometry = grid.find("Topology"), grid.find("Geometry")
    assert topology.get("TopologyType") == "Triangle" and geometry.get("GeometryType") == "XYZ"
    n_points = int(geometry.find("DataItem").get("Dimensions").split()[0])
    n_cells = int(topology.get("NumberOfElements"))
    for field in grid.findall("Attribute"):
        sizes = [n_points if field.get("Center") == "Node" else n_cells] + [3] * (field.get("AttributeType") == "Vector")
        assert field.get("Center") in ("Node", "Cell"), field.attrib
        assert [int(n) for n in field.find("DataItem").get("Dimensions").split()] == sizes, field.attrib
    for item in grid.iter("DataItem"):
        check_item(folder, item)
    cells = integers(h5dump, folder, topology.find("DataItem"))
    assert len(cells) == 3 * n_cells and min(cells) == 0 and max(cells) == n_points - 1, "cells use all points"
    return len(list(grid.iter("DataItem")))


def check_item(folder, item):
    """A dataset is there with the size and type stated."""
    file, name = item.text.strip().split(":/")
    assert "/" not in file, "the index is not beside its files"
    part = header(os.path.join(folder, file))
    part = part[part.index(f'DATASET "{name}"'):]
    sizes = re.search(r"SIMPLE \{ \(([^)]*)\)", part).group(1).replace(",", "").split()
    assert sizes == item.get("Dimensions").split(), f"{file}: {name} has the size {sizes}"
    kind, bits = re.search(r"H5T_(IEEE_F|STD_I)(\d+)LE", part).groups()
    stated = {"Float": "IEEE_F", "Int": "STD_I"}[item.get("NumberType")], int(item.get("Precision"))
    assert (kind, int(bits) // 8) == stated, f"{file}: {name} is {kind}{bits}"


def check_wings(h5dump, folder, series):
    """One wing, or a time series of wings."""
    if series.get("CollectionType") == "Spatial":
        return [], check_wing(h5dump, folder, series)
    times, files = [], 0
    for wing in series.findall("Grid"):
        times.append(float(wing.find("Time").get("Value")))
        if wing.get("GridType") == "Uniform":
            files += check_surface(h5dump, folder, wing)
        else:
            assert wing.get("CollectionType") == "Spatial", wing.attrib
            files += check_wing(h5dump, folder, wing)
        file = wing.find(".//DataItem").text.strip().split(":/")[0]
        text = header(os.path.join(folder, file))
        stored = re.search(r'ATTRIBUTE "time" \{.*?\(0\): (\S+)', text, re.S).group(1)
        assert float(stored) == times[-1], f"{file}: another time"
    assert times and times == sorted(set(times)), f"times {times}"
    return times, files


def check(h5dump, index):
    folder = os.path.dirname(os.path.abspath(index))
    root = ET.parse(index).getroot()
    read_headers(h5dump, folder, root)
    assert root.tag == "Xdmf" and root.get("Version") == "3.0", "not XDMF 3"
    series = root.find("./Domain/Grid")
    if series.find(".//Topology").get("TopologyType") != "3DCoRectMesh":
        times, files = check_wings(h5dump, folder, series)
        print(f"pass  {index}: {len(times)} times, {files} datasets")
        return
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
                text = header(os.path.join(folder, file))
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
