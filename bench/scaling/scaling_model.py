# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes the bytes that a step sends and its operations from the rules by which ranks share it (docs/theory/transforms.md).

Bytes and messages are exact for the truncation of iDealias = 1: the test test_traffic holds the program to them. Times are
those of a machine that is described by a few rates.
"""

from math import ceil, log2, sqrt

INVERSE, FORWARD = 6, 3  # fields of a plain AB2 step
DERIVED = 1  # of the inverse ones: computed from others in physical z, neither transformed in z nor sent by columns
WORD = 16  # bytes of a complex number
PRODUCT_FLOPS = 40  # of a point of the grid: u x omega, largest velocity, projection and update

# The rates of a machine and of a flight, and the values that predictions assume. `rate` is that of one core while all other
# cores of its node compute as well. `network` is what one node sends while all nodes send to all others.
MACHINE = {
    "rate": 5.0e9,  # flop/s of a core
    "cores": 128,  # of a node
    "network": 10.0e9,  # byte/s out of a node
    "memory": 50.0e9,  # byte/s copied between ranks of a node
    "latency": 2.0e-6,  # s for each message of a rank
    "lapack": 20.0e9,  # flop/s of a core that factorises a matrix
    "stream": 10.0e9,  # byte/s that one core reads
    # A flexible wing computes a new response in this share of the steps. The blowfly did so in its first beat on 96 points, with
    # the default marker_response_limit. With the limit 0.2 the share is 0.08. Finer grids have the same share.
    "renewals": 0.2,
}


def share(n, parts, i):
    """Returns how many of n things part i has; the first parts have one more."""
    return n // parts + (1 if i < n % parts else 0)


def cutoff(n):
    """Returns a semi-axis of the ellipsoid of modes that are kept."""
    return 2 * (n // 2 - 1) / 3


def column_heights(grid):
    """Returns the number of sticks of each kept column kx."""
    kx, ky = cutoff(grid[0]), cutoff(grid[1])
    heights = []
    for jx in range(ceil(kx)):
        y = ky * sqrt(max(0.0, 1 - (jx / kx) ** 2))
        top = ceil(y) - 1  # strictly inside
        while (jx / kx) ** 2 + ((top + 1) / ky) ** 2 < 1 - 1e-12:
            top += 1
        while top >= 0 and (jx / kx) ** 2 + (top / ky) ** 2 >= 1 - 1e-12:
            top -= 1
        if top >= 0:
            heights.append(2 * top + 1)
    return heights


def process_grid(ranks, grid):
    """Returns the rows and columns of the ranks: slabs as long as every rank has a plane, otherwise the fewest rows; None if
    there is no such grid."""
    for rows in range(1, ranks + 1):
        if ranks % rows == 0 and ranks // rows <= grid[2] and rows <= grid[1]:
            return rows, ranks // rows
    return None


def traffic(grid, ranks, rows=None, inverse=INVERSE, forward=FORWARD):
    """Returns the bytes and messages that all ranks together send in one step, and the bytes of each exchange."""
    if rows is None:
        rows, columns = process_grid(ranks, grid)
    else:
        columns = ranks // rows
    heights = column_heights(grid)
    fields = inverse + forward
    by_column = by_row = messages = 0
    for row in range(rows):
        sticks = sum(heights[row::rows])
        kx = len(heights[row::rows])
        # Data that the rank itself owns are not sent.
        kept = sum(share(sticks, columns, c) * share(grid[2], columns, c) for c in range(columns))
        by_column += (sticks * grid[2] - kept) * WORD * (fields - DERIVED)
        owners = min(sticks, columns)
        messages += 2 * owners * (columns - 1) if columns > 1 else 0
        if rows > 1:
            by_row += kx * (grid[1] - share(grid[1], rows, row)) * grid[2] * WORD * fields
            if kx > 0:
                messages += 2 * columns * (rows - 1)
    return {"bytes": by_column + by_row, "messages": messages, "column": by_column, "row": by_row}


def step_flops(grid, fields=INVERSE + FORWARD):
    """Returns the floating-point operations of the pruned transforms and the products of one step, counted as 5 n log2 n."""
    nx, ny, nz = grid
    heights = column_heights(grid)
    lines = ny * nz * 2.5 * nx * log2(nx)
    planes = len(heights) * nz * 5 * ny * log2(ny)
    sticks = sum(heights) * 5 * nz * log2(nz)
    return fields * (lines + planes + sticks) - DERIVED * sticks + PRODUCT_FLOPS * nx * ny * nz


def fluid_seconds(grid, ranks, machine=MACHINE, inverse=INVERSE, forward=FORWARD):
    """Returns the predicted parts of a step, in seconds: compute, exchange off and on the node, latency; or None."""
    shape = process_grid(ranks, grid)
    if shape is None:
        return None
    rows, columns = shape
    sent = traffic(grid, ranks, rows, inverse, forward)
    nodes = max(1, ceil(ranks / machine["cores"]))
    # Ranks of a row are neighbours: their node also has the next columns.
    beside = max(1.0, machine["cores"] / rows)
    column_away = 0.0 if nodes == 1 else (columns - beside) / max(1, columns - 1)
    row_away = 0.0 if rows <= machine["cores"] else (rows - machine["cores"]) / (rows - 1)
    away = sent["column"] * max(0.0, column_away) + sent["row"] * row_away
    messages = 2 * ((columns - 1) + (rows - 1))
    # A step takes as long as the rank with most planes and lines.
    uneven = ceil(grid[2] / columns) * columns / grid[2] * ceil(grid[1] / rows) * rows / grid[1]
    return {
        "rows": rows,
        "columns": columns,
        "compute": step_flops(grid, inverse + forward) / (ranks * machine["rate"]) * uneven,
        "network": away / (nodes * machine["network"]),
        "memory": (sent["bytes"] - away) / (nodes * machine["memory"]),
        "latency": messages * machine["latency"] if ranks > 1 else 0.0,
    }


def total(parts):
    """Returns the seconds of a step."""
    return parts["compute"] + parts["network"] + parts["memory"] + parts["latency"]


# A blowfly's wing of 1015 points, measured on one core: the time of its own step, and the time that its coupling adds to a step
# of the fluid, relative to the latter. The markers of wings without thickness are two grid spacings apart: their number is a
# fit to wings of length 1 and area 0.334 on 64 to 256 points in a box of 4.
WING_SECONDS = 0.012
WINGS_PENALIZED = 0.083  # mask, pressure and its sampling
WINGS_THIN = 0.45  # three pruned passes
SOLVES = 24  # with the response of the flow, in a step of a wing
FEWEST_RANKS, FEWEST_MARKERS, PANEL = 8, 1000, 96  # that share a response; rows of a block of its inverse


def markers(spacing):
    """Returns the number of markers of one wing without thickness on a grid of this spacing [wing lengths]."""
    return 0.334 * 0.234 / spacing**2 + 0.62 / spacing


def wing_seconds(spacing, surface, ranks, machine=MACHINE):
    """Returns how long the wings take while the flow waits, and the bytes that a rank needs for it. Each of two wings has one
    rank, or a group of half of the ranks that shares the inverse of the response (src/fsi/thin/fsi_thin_wing.f90 has the
    rule)."""
    if surface == "penalized":
        return WING_SECONDS, 0.0
    unknowns, group = 3 * markers(spacing), ranks // 2
    matrix = 8 * unknowns**2
    solve = matrix / machine["stream"]  # both triangles of a factor are read once
    renew = unknowns**3 / 3 / machine["lapack"]
    if group >= FEWEST_RANKS and unknowns >= 3 * FEWEST_MARKERS:
        nodes = ceil(ranks / machine["cores"])
        # A broadcast goes through a tree; every node has ranks of both groups, and every rank of a node keeps a copy.
        tree = ceil(log2(group)) * machine["latency"]
        vector = 8 * unknowns * (2 / machine["network"] * (nodes > 1) + min(ranks, machine["cores"]) / machine["memory"])
        panels = ceil(unknowns / PANEL)
        solve = matrix / group / machine["stream"] + 2 * (tree + vector)
        renew = 2 * unknowns**3 / group / machine["lapack"] + panels * (tree + PANEL * vector)
        matrix /= group
    return WING_SECONDS + SOLVES * solve + machine["renewals"] * renew, matrix


def fitted(measurements, machine):
    """Returns the machine with the rates that the measurements (of `run`) give."""
    machine = dict(machine)
    rates, copies, network = [], [], []
    for m in measurements:
        busy = (m["wall_ms"] - m["exchange_ms"]) / 1e3
        if busy > 0:
            rates.append(step_flops(m["grid"]) / (m["ranks"] * busy))
    machine["rate"] = sorted(rates)[len(rates) // 2]
    for m in measurements:
        nodes = ceil(m["ranks"] / machine["cores"])
        if m["ranks"] > 1 and nodes == 1 and m["exchange_ms"] > 0:
            copies.append(m["bytes"] / (m["exchange_ms"] / 1e3))
    if copies:
        machine["memory"] = sorted(copies)[len(copies) // 2]
    for m in measurements:
        parts = fluid_seconds(m["grid"], m["ranks"], machine)
        rest = m["exchange_ms"] / 1e3 - parts["memory"] - parts["latency"]
        if parts["network"] > 0 and rest > 0:
            network.append(machine["network"] * parts["network"] / rest)
    if network:
        machine["network"] = sorted(network)[len(network) // 2]
    return machine
