#!/usr/bin/env python3
"""Maps one unit of rtl/ to a standard-cell library, for a stated clock.

    python3 -m pip install -r rtl/synth/requirements.txt
    python3 rtl/synth/synthesise.py bsu --library nangate45 --period 2.0 --out /tmp/bsu45 \\
        --liberty NangateOpenCellLibrary_typical.lib

Clock gates are inserted in front of registers of at least --gate flip-flops with the same enable
(8 by default, 0 for none), several of them for wide registers. --prove compares the netlist with
the RTL. --cut MODULE leaves instances of a module out: what they are connected to becomes ports.
--parts FOLDER... takes the netlists of units that were mapped into these folders, as they are.

Writes into the folder of --out: NAME.json (the netlist, Yosys JSON), NAME.v (the same for a timing
analyser), NAME.sdc, and report.json: area, cells, flip-flops, clock gates, how often each cell is
used, and the critical path by OpenSTA where `sta` is found. Equal inputs give equal bytes.

Cells are chosen, sized and buffered by ABC for the period, with the driving cell and the load of the
table below at all inputs and outputs. There is no layout: areas are cell areas, wires are the
library's wire-load model where it has one (Nangate45) and nothing elsewhere.
"""

import argparse
import fnmatch
import gzip
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import traceback
from collections import Counter
from pathlib import Path

RTL = Path(__file__).resolve().parent.parent

# What a library needs to be said besides its Liberty files. Times in ns, capacitances in fF; `units`
# are a ns and a fF in those of the library. `invented` is the fixture of the tests.
# `dont_use`: scan and latch cells, clock gates, delay and clock buffers, three-state drivers, and the
# flip-flops of ASAP7 of four times the drive, which are its only ones that do not invert.
# `flip_flop_pins`: data, clock, output, inverse.
# `clock_gates`: cells for up to so many flip-flops; enable, clock and output pin, pins tied to 0.
LIBRARIES = {
    "nangate45": {
        "units": (1.0, 1.0),
        "driver": ("BUF_X2", "Z"),
        "load_ff": 5.0,
        "input_transition_ns": 0.02,
        "clock_transition_ns": 0.02,
        "clock_gates": [(16, "CLKGATE_X1"), (32, "CLKGATE_X2")],
        "flip_flop_pins": ("D", "CK", "Q", "QN"),
        "clock_gate_pins": ("E", "CK", "GCK", []),
        "dont_use": ["SDFF*", "DL?_*", "TLAT*", "TBUF*", "TINV*", "CLK*", "ANTENNA*", "FILL*"],
        "tie_high": ("LOGIC1_X1", "Z"),
        "tie_low": ("LOGIC0_X1", "Z"),
    },
    "asap7": {
        "units": (1000.0, 1.0),
        "driver": ("BUFx2_ASAP7_75t_R", "Y"),
        "load_ff": 2.0,
        "input_transition_ns": 0.01,
        "clock_transition_ns": 0.01,
        "clock_gates": [(16, "ICGx1_ASAP7_75t_R"), (32, "ICGx2_ASAP7_75t_R")],
        "flip_flop_pins": ("D", "CLK", None, "QN"),
        "clock_gate_pins": ("ENA", "CLK", "GCLK", ["SE"]),
        "dont_use": ["SDF*", "DLL*", "DHL*", "ICG*", "HB*", "CKINVDC*", "DFFASR*", "DFF?Qx4*"],
        "tie_high": ("TIEHIx1_ASAP7_75t_R", "H"),
        "tie_low": ("TIELOx1_ASAP7_75t_R", "L"),
    },
    "sky130hd": {
        "units": (1.0, 0.001),
        "driver": ("sky130_fd_sc_hd__buf_2", "X"),
        "load_ff": 10.0,
        "input_transition_ns": 0.05,
        "clock_transition_ns": 0.05,
        "clock_gates": [(16, "sky130_fd_sc_hd__dlclkp_1"), (32, "sky130_fd_sc_hd__dlclkp_2")],
        "flip_flop_pins": ("D", "CLK", "Q", None),
        "clock_gate_pins": ("GATE", "CLK", "GCLK", []),
        "dont_use": ["*__sdf*", "*__sedf*", "*__edf*", "*__dl*", "*__sdl*", "*__lpflow*",
                     "*__clk*", "*__ebuf*", "*__einv*", "*__probe*", "*__macro*", "*__fa*",
                     "*__ha_*", "*__dfr*", "*__dfs*", "*__dfb*"],
        "tie_high": ("sky130_fd_sc_hd__conb_1", "HI"),
        "tie_low": ("sky130_fd_sc_hd__conb_1", "LO"),
    },
    "sg13g2": {
        "units": (1.0, 0.001),
        "driver": ("sg13g2_buf_2", "X"),
        "load_ff": 10.0,
        "input_transition_ns": 0.05,
        "clock_transition_ns": 0.05,
        "clock_gates": [(32, "sg13g2_lgcp_1")],
        "flip_flop_pins": ("D", "CLK", "Q", "Q_N"),
        "clock_gate_pins": ("GATE", "CLK", "GCLK", []),
        "dont_use": ["*_sdf*", "*_dl*", "*_lgcp*", "*_slgcp*", "*_ebufn*", "*_einvn*",
                     "*_sighold", "*_antenna*", "*_fill*", "*_decap*"],
        "tie_high": ("sg13g2_tiehi", "L_HI"),
        "tie_low": ("sg13g2_tielo", "L_LO"),
    },
    "invented": {
        "units": (1.0, 1.0),
        "driver": ("BUF", "Y"),
        "load_ff": 5.0,
        "input_transition_ns": 0.05,
        "clock_transition_ns": 0.05,
        "clock_gates": [(32, "GATE")],
        "flip_flop_pins": ("D", "C", "Q", None),
        "clock_gate_pins": ("E", "C", "Q", []),
        "dont_use": [],
        "tie_high": ("ONE", "Y"),
        "tie_low": ("ZERO", "Y"),
    },
}

CONDITIONS = ["clock_transition_ns", "input_transition_ns", "load_ff"]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("unit", help="top module")
    parser.add_argument("--library", required=True, choices=sorted(LIBRARIES))
    parser.add_argument("--liberty", required=True, nargs="+", type=Path, help=".lib or .lib.gz")
    parser.add_argument("--period", required=True, type=float, help="of the clock, ns")
    parser.add_argument("--out", required=True, type=Path, help="folder, made if it is not there")
    parser.add_argument("--name", help="of the files; the unit's by default")
    parser.add_argument("--gate", type=int, default=8, metavar="FLIP-FLOPS",
                        help="registers from this size have their clock gated; 0: none (default 8)")
    parser.add_argument("--prove", action="store_true",
                        help="that the netlist is the RTL; minutes for more than small units")
    parser.add_argument("--cut", metavar="MODULE", help="whose instances are left out")
    parser.add_argument("--parts", nargs="+", type=Path, default=[], metavar="FOLDER",
                        help="of an earlier --out, with the parameters that its unit has here: "
                             "it is not mapped again")
    parser.add_argument("--set", action="append", default=[], metavar="PARAMETER=VALUE")
    parser.add_argument("--source", nargs="+", type=Path, help="all of rtl/*.sv by default")
    return parser.parse_args()


def unpacked(paths, folder):
    """The Liberty files as plain text in `folder`."""
    out = []
    for path in paths:
        data = path.read_bytes()
        if data[:2] == b"\x1f\x8b":
            data = gzip.decompress(data)
        if b"library" not in data[:100_000]:
            sys.exit(f"{path}: no Liberty file: no `library` in its first 100 kB")
        name = path.name.removesuffix(".gz")
        (folder / name).write_bytes(data)
        out.append(folder / name)
    return out


def cells_of(liberty):
    names = []
    for path in liberty:
        names += re.findall(r"^\s*cell\s*\(\s*\"?(\w+)\"?\s*\)", path.read_text(), re.MULTILINE)
    return sorted(set(names))


def sources(given):
    """Packages first, so that modules find them."""
    if given:
        return given
    found = sorted(RTL.glob("*.sv"))
    return sorted(found, key=lambda path: (not path.stem.endswith("_pkg"), path.name))


VECTOR = re.compile(r"^  assign \{ (.*) \} = (?:\{ (.*) \}|(\d+'b[01xz]+));$", re.MULTILINE)


def single_assignments(match):
    """`assign { a, b } = { c, d };` as one assignment a bit; none where the bit is of no matter."""
    left, right = (side.split(", ") for side in (match[1], match[2] or match[3]))
    bits = []
    for part in right:
        constant = re.fullmatch(r"\d+'b([01xz]+)", part)
        bits += [f"1'b{bit}" for bit in constant[1]] if constant else [part]
    assert len(left) == len(bits), match[0]
    pairs = zip(left, bits)
    return "\n".join(f"  assign {a} = {b};" for a, b in pairs if b not in ("1'bx", "1'bz"))


def apart(log, work, *arguments):
    """Runs `work` in a process of its own, with what Yosys and ABC print in `log`.

    Yosys ends its process where something is wrong, so nothing could be said in this one.
    """
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        with open(log, "wb") as file:
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
        failed = 1
        try:
            work(*arguments)
            failed = 0
        except SystemExit as said:
            print(said)
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(failed)
    _, status = os.waitpid(child, 0)
    if status:
        sys.exit(log.read_text(errors="replace")[-4000:] + "\nYosys failed; the end of its log is above")


def cut_out(design, args, folder):
    """Turns instances of a module into ports, but for those of clocks, resets and constants."""
    from pyosys import libyosys as ys

    before = folder / "cut.json"
    for step in [f"expose -evert t:*{args.cut}*", "opt_clean", f"write_json {before}"]:
        ys.run_pass(step, design)
    module = design.top_module()
    ports = json.loads(before.read_text())["modules"][module.name.unescape()]["ports"]
    given = {bit for port in ports.values() if port["direction"] == "input" for bit in port["bits"]}
    # Ports of the unit have no points in their names.
    for name, port in ((name, port) for name, port in ports.items() if "." in name):
        wire = module.wire(ys.IdString("\\" + name))
        passed_on = all(isinstance(bit, str) or bit in given for bit in port["bits"])
        if port["direction"] == "output" and passed_on:
            wire.port_output = False
        else:
            module.rename(wire, ys.IdString("\\" + re.sub(r"\W+", "_", name)))
    module.fixup_ports()
    ys.run_pass("opt_clean -purge", design)


def mapped_parts(args):
    """The netlists of --parts by their units."""
    found = {}
    for folder in args.parts:
        try:
            report = json.loads((folder / "report.json").read_text())
        except OSError as error:
            sys.exit(f"{folder}: no unit was mapped into it: {error}")
        made = report["library"], report["period_ns"]
        if made != (args.library, args.period):
            sys.exit(f"{folder}: mapped for {made[0]} and {made[1]} ns")
        found[report["unit"]] = next(p for p in folder.glob("*.json") if p.name != "report.json")
    return found


def leave_parts(design, parts):
    """Leaves modules out that are mapped; returns the units behind their names."""
    from pyosys import libyosys as ys

    left = {}
    for module in list(design.modules_.values()):
        name = module.name.str()
        # `\\unit`, or with parameters `$paramod$hash\\unit` or `$paramod\\unit\\...`.
        unit = next((unit for unit in parts if unit in name.split("\\")[1:2]), None)
        if unit is None or module.name == design.top_module().name:
            continue
        netlist = json.loads(parts[unit].read_text())["modules"]
        theirs = {name: len(port["bits"]) for name, port in netlist.popitem()[1]["ports"].items()}
        for port in module.ports:
            wire = module.wire(port)
            if theirs.get(port.unescape()) != wire.width:
                sys.exit(f"{parts[unit]}: {port.unescape()} has {wire.width} bits here: mapped "
                         "with other parameters (--set)")
        if unit in left.values():
            sys.exit(f"{unit} has instances with several parameters, and --parts one netlist")
        left[name] = unit
    for name in left:
        ys.run_pass(f"blackbox {name.removeprefix(chr(92))}", design)
    return left


def put_parts(design, parts, left):
    """Puts netlists where their modules were left out."""
    from pyosys import libyosys as ys

    for cell in [cell for cell in design.top_module().cells_.values() if cell.type.str() in left]:
        cell.type = ys.IdString("\\" + left[cell.type.str()])
    for name in left:
        ys.run_pass(f"delete {name.removeprefix(chr(92))}", design)
    for unit in sorted(set(left.values())):
        ys.run_pass(f"read_json {parts[unit]}", design)
        kept = parts[unit].stem
        if kept != unit:
            ys.run_pass(f"rename {kept} {unit}", design)
    ys.run_pass("flatten -noscopeinfo", design)


def gate_clocks(design, settings, smallest):
    """Clock gates for registers with an enable, none with more flip-flops than the largest takes."""
    from pyosys import libyosys as ys

    enable, clock, output, low = settings["clock_gate_pins"]
    sizes = settings["clock_gates"]
    kind = sizes[0][1]
    tied = " ".join(f"-tie_lo {pin}" for pin in low)
    # A reset in front of the enable goes behind it, and opens the gate too.
    ys.run_pass("dfflegalize -cell $_DFF_P_ x -cell $_DFFE_PP_ x -cell $_SDFF_PP?_ x "
                "-cell $_SDFFCE_PP?P_ x", design)
    for step in ["opt_merge", "opt_clean"]:
        ys.run_pass(step, design)
    ys.run_pass(f"clockgate -pos {kind} {enable}:{clock}:{output} {tied} -min_net_size {smallest}",
                design)
    module = design.top_module()
    pin = {name: ys.IdString("\\" + name) for name in (enable, clock, output, "C", *low)}
    cells = sorted(module.cells_.values(), key=lambda cell: cell.name.str())
    gated = {}
    for cell in cells:
        if cell.is_builtin_ff():
            wire = cell.getPort(pin["C"]).as_wire().name.str()
            gated.setdefault(wire, []).append(cell)
    for gate in [cell for cell in cells if cell.type.str() == "\\" + kind]:
        flip_flops = gated[gate.getPort(pin[output]).as_wire().name.str()]
        parts = -(-len(flip_flops) // sizes[-1][0])
        for part in range(parts):
            # As even as can be; bits of a word stay together.
            first, last = (len(flip_flops) * n // parts for n in (part, part + 1))
            size = next(name for most, name in sizes if last - first <= most)
            name = ys.IdString(f"{gate.name.str()}_{part}")
            own = module.addCell(name, ys.IdString("\\" + size))
            wire = ys.SigSpec(module.addWire(ys.IdString(f"{name.str()}_clock"), 1))
            for of in (enable, clock, *low):
                own.setPort(pin[of], gate.getPort(pin[of]))
            own.setPort(pin[output], wire)
            for flip_flop in flip_flops[first:last]:
                flip_flop.setPort(pin["C"], wire)
        module.remove(gate)


def map_unit(args, settings, liberty, unused, folder):
    """Runs Yosys; leaves NAME.json and NAME.v in the output folder."""
    from pyosys import libyosys as ys

    constraint = folder / "abc.constr"
    cell, _ = settings["driver"]
    constraint.write_text(f"set_driving_cell {cell}\nset_load {settings['load_ff']} [all_outputs]\n")
    libs = " ".join(f"-liberty {path}" for path in liberty)
    keep_out = " ".join(f"-dont_use {name}" for name in unused)
    chparam = " ".join("-chparam {} {}".format(*item.split("=", 1)) for item in args.set)
    high, low = settings["tie_high"], settings["tie_low"]
    out = args.out / args.name
    design = ys.Design()
    left = {}
    steps = [
        "read_verilog -sv -defer " + " ".join(str(path) for path in sources(args.source)),
        f"hierarchy -check -top {args.unit} {chparam}",
        f"rename -top {args.name}",
        lambda: left.update(leave_parts(design, args.parts)),
        *([f"blackbox *{args.cut}*"] if args.cut else []),
        "synth -flatten -noabc",
        lambda: cut_out(design, args, folder) if args.cut else None,
        lambda: gate_clocks(design, settings, args.gate) if args.gate else None,
        f"dfflibmap {libs} {keep_out}",
        "opt",
        f"abc {libs} -constr {constraint} -D {args.period * 1000:.0f} {keep_out}",
        "opt_clean -purge",
        f"hilomap -hicell {high[0]} {high[1]} -locell {low[0]} {low[1]}",
        lambda: put_parts(design, args.parts, left) if left else None,
        "setattr -mod -unset src -unset hdlname",
        "setattr -unset src -unset hdlname -unset keep",
        "rename -enumerate -pattern n% w:*.* w:*$* w:*[* %u %u",
        "rename -enumerate -pattern u% c:*",
        f"write_json {out}.json",
        # OpenSTA reads no vectors in connections.
        "splitnets -ports -format _",
        f"write_verilog -noattr -noexpr -nohex -nodec {out}.v",
    ]
    for step in steps:
        if callable(step):
            step()
        else:
            ys.run_pass(step, design)
    verilog = Path(f"{out}.v")
    verilog.write_text(VECTOR.sub(single_assignments, verilog.read_text()))


def prove(args, settings, liberty):
    """Proves the written netlist equal to the RTL.

    All signals that have kept their name, the outputs and registers among them, are equal in a cycle
    if they were in the one before (induction by SAT). A flip-flop behind a clock gate is taken for
    one with an enable: that gates do what they should between edges is not part of it. Both sides
    come from the same reading of the RTL, up to Yosys' generic gates.
    """
    from pyosys import libyosys as ys

    def run(*steps):
        for step in steps:
            ys.run_pass(step, design)

    def name(text):
        return ys.IdString("\\" + text)

    def pin(cell, of):
        return cell.getPort(name(of)) if of and cell.hasPort(name(of)) else None

    chparam = " ".join("-chparam {} {}".format(*item.split("=", 1)) for item in args.set)
    enable, clock, output, _ = settings["clock_gate_pins"]
    gates = {name(kind).str() for _, kind in settings["clock_gates"]}
    data, own_clock, plain, inverse = settings["flip_flop_pins"]
    design = ys.Design()
    run("read_verilog -sv -defer " + " ".join(str(path) for path in sources(args.source)),
        f"hierarchy -check -top {args.unit} {chparam}", "synth -flatten -noabc",
        "rename -top gold", "design -stash gold")
    run(*[f"read_liberty -ignore_miss_func -ignore_miss_data_latch {path}" for path in liberty],
        f"read_json {args.out / args.name}.json", f"rename {args.name} gate")
    module = design.module(name("gate"))
    enables = {}
    for cell in [cell for cell in module.cells_.values() if cell.type.str() in gates]:
        enables[pin(cell, output).as_wire().name.str()] = pin(cell, enable), pin(cell, clock)
        module.remove(cell)
    stores = [cell for cell in module.cells_.values() if pin(cell, own_clock)]
    for number, cell in enumerate(stores):
        gated = enables.get(pin(cell, own_clock).as_wire().name.str())
        of = module.addCell(name(f"stores_{number}"),
                            ys.IdString("$_DFFE_PP_" if gated else "$_DFF_P_"))
        stored = ys.SigSpec(module.addWire(name(f"stored_{number}"), 1))
        of.setPort(name("C"), gated[1] if gated else pin(cell, own_clock))
        of.setPort(name("D"), pin(cell, data))
        of.setPort(name("Q"), stored)
        if gated:
            of.setPort(name("E"), gated[0])
        if pin(cell, plain):
            module.connect(pin(cell, plain), stored)
        if pin(cell, inverse):
            module.addNotGate(name(f"inverse_{number}"), stored.as_bit(),
                              pin(cell, inverse).as_bit())
        module.remove(cell)
    run("hierarchy -top gate", "flatten", "proc", "opt_clean", "simplemap",
        "design -stash gate", "design -copy-from gold -as gold gold",
        "design -copy-from gate -as gate gate", "equiv_make gold gate equiv",
        "hierarchy -top equiv", "opt_clean -purge", "equiv_simple -short", "equiv_induct",
        "equiv_status -assert")


def constraints(args, settings):
    """The SDC: an ideal clock; inputs come with its edge, outputs are wanted at the next one."""
    period = args.period
    unit, load_unit = settings["units"]
    return "\n".join(
        [
            f"create_clock -name clk -period {period * unit:g} [get_ports clk]",
            f"set_clock_transition {settings['clock_transition_ns'] * unit:g} [get_clocks clk]",
            f"set_input_transition {settings['input_transition_ns'] * unit:g} [all_inputs]",
            f"set_load {settings['load_ff'] * load_unit:g} [all_outputs]",
            "set_input_delay 0 -clock clk [all_inputs]",
            "set_output_delay 0 -clock clk [all_outputs]",
            "",
        ]
    )


def timing(args, liberty):
    """Critical path by OpenSTA, ns and text; None where it is not installed."""
    sta = shutil.which("sta")
    if sta is None:
        return None
    out = args.out / args.name
    script = [f"read_liberty {path}" for path in liberty]
    script += [
        f"read_verilog {out}.v",
        f"link_design {args.name}",
        f"read_sdc {out}.sdc",
        "report_checks -path_delay max -digits 4",
        "exit",
    ]
    with tempfile.NamedTemporaryFile("w", suffix=".tcl") as file:
        file.write("\n".join(script) + "\n")
        file.flush()
        done = subprocess.run([sta, "-no_init", "-no_splash", "-exit", file.name],
                              capture_output=True, text=True, check=False)
    slack = re.search(r"(-?[\d.]+)\s+slack", done.stdout)
    if slack is None:
        sys.exit("OpenSTA failed:\n" + done.stdout[-2000:] + done.stderr[-2000:])
    unit, _ = LIBRARIES[args.library]["units"]
    return {"critical_path_ns": round(args.period - float(slack[1]) / unit, 4)}, done.stdout


def report(args, settings, liberty):
    """Counts and areas from the written netlist."""
    module = json.loads((args.out / f"{args.name}.json").read_text())["modules"][args.name]
    used = Counter(cell["type"] for cell in module["cells"].values())
    areas, flip_flops = {}, set()
    for path in liberty:
        for cell in re.split(r"^\s*cell\s*\(", path.read_text(), flags=re.MULTILINE)[1:]:
            name = re.match(r"\s*\"?(\w+)", cell)[1]
            areas[name] = float(re.search(r"\barea\s*:\s*([-+.\deE]+)", cell)[1])
            if re.search(r"^\s*ff\s*\(", cell, re.MULTILINE):
                flip_flops.add(name)
    strange = sorted(set(used) - set(areas))
    if strange:
        sys.exit(f"cells that no library has: {', '.join(strange)}")
    return {
        "unit": args.unit,
        "parameters": dict(item.split("=", 1) for item in args.set),
        "library": args.library,
        "liberty": [path.name for path in liberty],
        "period_ns": args.period,
        **{name: settings[name] for name in CONDITIONS},
        "area_um2": round(sum(areas[name] * n for name, n in used.items()), 3),
        "flip_flop_area_um2": round(sum(areas[n] * used[n] for n in used if n in flip_flops), 3),
        "cells": sum(used.values()),
        "flip_flops": sum(used[name] for name in flip_flops),
        "used": dict(sorted(used.items())),
    }


def main():
    args = arguments()
    args.name = args.name or args.unit
    if args.prove and args.cut:
        sys.exit("--prove compares whole units: leave --cut out")
    settings = LIBRARIES[args.library]
    args.parts = mapped_parts(args)
    args.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        liberty = unpacked(args.liberty, folder)
        unused = [name for name in cells_of(liberty)
                  if any(fnmatch.fnmatch(name, pattern) for pattern in settings["dont_use"])]
        apart(folder / "yosys.log", map_unit, args, settings, liberty, unused, folder)
        (args.out / f"{args.name}.sdc").write_text(constraints(args, settings))
        summary = report(args, settings, liberty)
        if args.prove:
            log = folder / "prove.log"
            apart(log, prove, args, settings, liberty)
            proven = re.findall(r"Of those cells (\d+) are proven and 0 are unproven", log.read_text())
            summary["points_proven_equal"] = int(proven[-1])
        times = timing(args, liberty)
        if times is None:
            print("critical path: skipped, no OpenSTA (`sta`) on the path", file=sys.stderr)
        else:
            summary.update(times[0])
            (args.out / "critical_path.txt").write_text(times[1])
    (args.out / "report.json").write_text(json.dumps(summary, indent=1) + os.linesep)
    shown = {key: value for key, value in summary.items() if key != "used"}
    print(json.dumps(shown, indent=1))


if __name__ == "__main__":
    main()
