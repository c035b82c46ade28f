# SPDX-License-Identifier: GPL-3.0-or-later
"""The command make_wing: makes wing files from drawings, from tables and from numbers."""
from __future__ import annotations

import argparse
import sys
from pathlib import Path

from flusi_msm.errors import InputError, Problems, check_folder, run_command
from flusi_msm.magnitude import AREAL, DIAMETERS, magnitude_doubt
from flusi_msm.wing.file import Z_SIDES, Wing, WingMass, add_z_side, write_wing
from flusi_msm.wing.mesh import default_edge, mesh_wing, missing_edges
from flusi_msm.wing.network import SNAP, build_network
from flusi_msm.wing.report import Quality, quality_of, report
from flusi_msm.wing.shapes import make_calliphora, make_plate, make_strip
from flusi_msm.wing.trace import Sketch, Trace, polygon_area, trace_of

MM = 1e-3
SMALL_ANGLE = 8.0  # degrees; smaller angles are reported
KINDS = ("calliphora", "plate", "strip")
USAGE = """make_wing DRAWING.svg [-o wing.h5]        outline and veins traced in Inkscape (docs/guide/make-wing.md)
       make_wing WING.toml [-o wing.h5]          the same in a table, or a table that adds to a drawing
       make_wing WING.ini --length MM            a Fourier outline of FLUSI or WABBIT, without veins
       make_wing calliphora FILE [--edge MM]     the blowfly wing of this package
       make_wing plate FILE [--length MM] [--chord MM] [--edge MM] [--spars N] [--diameters ROOT TIP]
       make_wing strip FILE [--length MM] [--width MM] [--cells N] [--diameter UM]"""


def traced_wing(sketch: Sketch, problems: Problems, edge: float | None = None, snap: float | None = None,
                mesher: str = "auto") -> Wing:
    """Returns the wing that a sketch describes; lengths in metres, None: the default. Raises InputError with all mistakes."""
    trace = trace_of(sketch, problems)
    if trace is None:
        problems.stop_if_any()
        raise AssertionError("no trace, and nothing said why")
    snap = snap or sketch.snap or SNAP * trace.length
    _check_lengths(trace, edge or sketch.edge, snap, problems)
    net = build_network(trace, snap, problems)
    problems.stop_if_any()
    assert net is not None
    if trace.z_side and trace.z_side not in Z_SIDES:
        raise InputError(f"{trace.source}: z_side = '{trace.z_side}' must be one of {', '.join(Z_SIDES)}")
    edge = edge or sketch.edge or default_edge(abs(polygon_area(trace.outline)))
    wing = mesh_wing(trace, net, edge, mesher, problems)
    if sketch.membrane_mass:
        doubt = magnitude_doubt(sketch.membrane_mass / float(wing.areas().sum()), AREAL, "kg/m^2", "membranes of insects")
        if doubt:
            problems.notice(f"{trace.source}: mass of the membrane {1e9 * sketch.membrane_mass:.4g} ug: {doubt} (--membrane-mass is in ug)")
        if not sketch.mass_source:
            problems.notice(f"{trace.source}: where the mass of the membrane comes from is not said: --mass-source TEXT")
        wing.mass = WingMass("uniform", sketch.membrane_mass, sketch.mass_source or "who made the wing with make_wing")
    for name, (_, diameters) in wing.veins.items():
        doubt = magnitude_doubt(float(max(diameters)), DIAMETERS, "m", "veins of insects")
        if doubt:
            problems.notice(f"{trace.source}: vein '{name}': its diameter of {doubt}")
    angle = wing.smallest_angle()
    if angle < SMALL_ANGLE:
        x, y = 1e3 * quality_of(wing).worst
        problems.notice(f"{trace.source}: a triangle at ({x:.3g}, {y:.3g}) mm has an angle of {angle:.1f} degrees: lines are very close "
                        "there; join them, or draw them further apart")
    for name, place in missing_edges(wing):
        x, y = 1e3 * place
        problems.error(f"{trace.source}: vein '{name}': its line at ({x:.3g}, {y:.3g}) mm could not be kept in the mesh, because another "
                       "one is too close: choose --edge smaller or --snap larger, or draw them further apart")
    problems.stop_if_any()
    if not sketch.is_in_frame:
        problems.notice(f"+z of the wing points {'to' if trace.faces_viewer else 'away from'} who looks at the drawing "
                        "(x from root to tip, y toward the leading edge)")
    return wing


def _check_lengths(trace: Trace, edge: float | None, snap: float, problems: Problems) -> None:
    for name, value, least, most in (("edge", edge, 1e-3, 0.5), ("snap", snap, 1e-5, 0.1)):
        if value is not None and not least * trace.length <= value <= most * trace.length:
            problems.error(f"--{name} {1e3 * value:.4g}: is in mm and must lie between {least:g} and {most:g} of the wing's length "
                           f"of {1e3 * trace.length:.4g} mm")


def read_sketch(path: str, problems: Problems, options: argparse.Namespace) -> Sketch:
    """Reads the sketch in a file of any kind."""
    kind = Path(path).suffix.lower()
    if kind == ".svg":
        from flusi_msm.wing.svg import read_svg
        sketch = read_svg(path, problems, options.metres_per_unit, options.true_size)
    elif kind == ".toml":
        from flusi_msm.wing.toml_file import read_toml
        sketch = read_toml(path, problems)
    elif kind == ".ini":
        from flusi_msm.wing.toml_file import read_ini
        sketch = read_ini(path, problems, options.length and options.length * MM, options.root_part)
    elif Path(path).exists():
        raise InputError(f"{path}: is no .svg, .toml or .ini file")
    else:
        raise InputError(f"{path}: there is no such file, and no built-in wing of this name ({', '.join(KINDS)})")
    names = {vein.name: vein for vein in sketch.veins}
    for name in options.free_end:
        if name in names:
            names[name].free_end = True
        else:
            problems.error(f"--free-end {name}: there is no such vein; there are {', '.join(names)}")
    if options.z_side:
        sketch.z_side = options.z_side
    if options.membrane_mass:
        sketch.membrane_mass = options.membrane_mass * 1e-9
    sketch.mass_source = options.mass_source or sketch.mass_source
    return sketch


def save_picture(wing: Wing, quality: Quality, path: Path) -> None:
    import matplotlib
    matplotlib.use("Agg")
    from flusi_msm.style import save, use_style
    from flusi_msm.wing.picture import draw_wing
    use_style()
    save(draw_wing(wing, quality), path)


def _drawing_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="make_wing", usage=USAGE, description="Makes wing files (docs/formats/wing-format.md).")
    parser.add_argument("drawing", metavar="DRAWING", help=".svg, .toml or .ini")
    parser.add_argument("-o", "--output", metavar="FILE", help="wing file to write (default: as DRAWING, with .h5)")
    parser.add_argument("--edge", type=float, metavar="MM", help="edge length of the mesh (default: about 1000 points)")
    parser.add_argument("--snap", type=float, metavar="MM", help="lines that are closer than this are meant to meet (default: "
                        f"{SNAP:g} of the wing's length)")
    parser.add_argument("--metres-per-unit", type=float, metavar="M", help="scale of an SVG file without a scale bar")
    parser.add_argument("--true-size", action="store_true", help="the page of the SVG file is as large as the wing")
    parser.add_argument("--length", type=float, metavar="MM", help="of the wing, for an .ini file: from the hinge to the tip")
    parser.add_argument("--root-part", type=float, default=0.03, metavar="PART", help="of the length that is held, for an .ini file "
                        "(default: 0.03)")
    parser.add_argument("--free-end", action="append", default=[], metavar="VEIN", help="a vein that may end in the membrane")
    parser.add_argument("--membrane-mass", type=float, metavar="UG", help="of the membrane, which is spread evenly")
    parser.add_argument("--mass-source", metavar="TEXT", help="where the mass of the membrane comes from, for the wing file")
    parser.add_argument("--mesher", choices=("auto", "gmsh", "own"), default="auto", help="what makes the triangles (auto: gmsh "
                        "where it can be loaded)")
    parser.add_argument("--picture", metavar="PNG", help="picture to write (default: as the wing file, with .png)")
    parser.add_argument("--no-picture", action="store_true")
    add_z_side(parser)
    return parser


def make_from_drawing(arguments: list[str]) -> None:
    parser = _drawing_parser()
    options = parser.parse_args(arguments)
    for name in ("edge", "snap", "metres_per_unit", "length", "membrane_mass", "root_part"):
        value = getattr(options, name)
        if value is not None and not 0 < value < 1e30:
            parser.error(f"--{name.replace('_', '-')} must be positive")
    check_folder(options.output)
    problems = Problems()
    sketch = read_sketch(options.drawing, problems, options)
    wing = traced_wing(sketch, problems, options.edge and options.edge * MM, options.snap and options.snap * MM, options.mesher)
    output = Path(options.output or Path(options.drawing).with_suffix(".h5"))
    write_wing(output, wing)
    quality = quality_of(wing)
    for text in problems.notices:
        print(f"notice    {text}")
    print("\n".join(report(wing, quality)))
    print(f"written   {output}")
    if not options.no_picture:
        save_picture(wing, quality, Path(options.picture or output.with_suffix(".png")))


def make_from_numbers(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="make_wing", usage=USAGE)
    kinds = parser.add_subparsers(dest="kind", required=True)
    fly = kinds.add_parser("calliphora", help="the wing of a blowfly")
    fly.add_argument("--edge", type=float, default=0.183, metavar="MM", help="edge length (0.183: 1000 points)")
    plate = kinds.add_parser("plate", help="a rectangle with spars")
    plate.add_argument("--length", type=float, default=9.0, metavar="MM")
    plate.add_argument("--chord", type=float, default=3.0, metavar="MM")
    plate.add_argument("--edge", type=float, default=0.25, metavar="MM")
    plate.add_argument("--spars", type=int, default=3, metavar="N")
    plate.add_argument("--diameters", type=float, nargs=2, default=(100.0, 40.0), metavar=("ROOT", "TIP"),
                       help="of the spars [um]")
    strip = kinds.add_parser("strip", help="a filament for two-dimensional flows")
    strip.add_argument("--length", type=float, default=1000.0, metavar="MM")
    strip.add_argument("--width", type=float, default=1000.0, metavar="MM", help="one unit of length of the run")
    strip.add_argument("--cells", type=int, default=48, metavar="N", help="along the length")
    strip.add_argument("--diameter", type=float, default=1.0e5, metavar="UM", help="of the middle spar")
    for kind in (fly, plate, strip):
        kind.add_argument("file", metavar="FILE", help="wing file to write")
        add_z_side(kind)
    options = parser.parse_args(arguments)
    if options.kind == "calliphora":
        wing = make_calliphora(options.edge)
    elif options.kind == "strip":
        wing = make_strip(options.length, options.width, options.cells, options.diameter)
    else:
        wing = make_plate(options.length, options.chord, options.edge, options.spars, options.diameters)
    wing.z_side = options.z_side
    write_wing(options.file, wing)
    print(f"{options.file}: {wing.title}\n{wing.summary()}")


def command() -> None:
    """Runs the command with the arguments of sys.argv."""
    arguments = sys.argv[1:]
    make = make_from_numbers if arguments and arguments[0] in KINDS else make_from_drawing
    run_command(Path(sys.argv[0]).name, lambda: make(arguments))


if __name__ == "__main__":
    command()
