#!/usr/bin/env python3
"""Compares our energy of a mapped unit with OpenSTA's tables, on the same netlist and activity.

    python3 rtl/synth/check_power.py bsu --library nangate45 --folder /tmp/bsu45 --liberty FILE...

The folder is what synthesise.py wrote. The unit is run with random inputs by the example `netlist`
of powergs-gates, which gives toggles a cycle of every driving pin and what our prices make of them.
OpenSTA gives, for every cell, the load of each output and the internal energy of each group of its
tables, at the transition times and loads that it has propagated itself. Both are joined here:
switching, internal power and leakage are compared, and the script fails if one is off by more than
5 %.

Why not OpenSTA's own sum: version 2.0.17, the one that Debian has, cannot be told the activity of an
output (`set_power_pin_activity` holds for loads alone), and it adds the groups of an output up
instead of taking their weighted mean, so that a gate of three inputs costs up to three times and a
flip-flop's output twice its tables (later versions divide by the sum of the weights). Its leakage of
states is weighted with a sum above 1 in the same way. So its tables, loads and transition times are
taken, with weights that are 1 in sum; where a condition names an output of a gate, which follows from
the inputs, or the inverse of a stored bit, that is left out. Groups of ground pins are left out too:
they are the same charge as those of the supply pins.

Flip-flops behind a clock gate have their clock in the cycles in which it is open, as many as its
output rises. A gate's own energy is that of the state it is in: closed or open, and of an edge of its
enable what is different at the next falling edge of the clock. OpenSTA prints both edges of a table
together; where one is needed it is half of them.
"""

import argparse
import gzip
import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from itertools import product
from pathlib import Path

from synthesise import LIBRARIES

ROOT = Path(__file__).resolve().parents[2]
LIMIT = 0.05

OUTPUT = re.compile(r"power: switching \S+/\S+ activity = (\S+) volt = \S+ (\S+)")
PIN = re.compile(r"power: internal (\S+)/(\S+) \((\S+)\)")
LEAKAGE = re.compile(r"power: leakage (\S+) (\S+) (\S+) \* \S+")
WHOLE = re.compile(r"power: leakage cell (\S+) (\S+)")
GROUP = re.compile(r"power:\s+(\S+) -> \S+ (.*?)\s+-?[\d.]+ ([\d.]+)\s+(\S+)\s+\S+ (.*)$")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("unit")
    parser.add_argument("--library", required=True)
    parser.add_argument("--folder", required=True, type=Path)
    parser.add_argument("--liberty", required=True, nargs="+", type=Path)
    return parser.parse_args()


def ours(args, out):
    """Activity of each driving pin, `(cell, pin) -> toggles a cycle`, and our powers."""
    command = ["cargo", "run", "--release", "--quiet", "-p", "powergs-gates", "--example",
               "netlist", "--", "activity", args.folder / f"{args.unit}.json", *args.liberty, out]
    done = subprocess.run([str(part) for part in command], cwd=ROOT, check=True,
                          capture_output=True, text=True)
    activity = {}
    for line in out.read_text().splitlines():
        cell, pin, toggles, _ = line.split()
        activity[cell, pin] = float(toggles)
    return activity, json.loads(done.stdout)


def opensta(args, folder):
    """What OpenSTA prints of every cell, at one toggle a cycle everywhere and all states alike."""
    script = []
    for path in args.liberty:
        data = path.read_bytes()
        plain = folder / path.name.removesuffix(".gz")
        plain.write_bytes(gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data)
        script.append(f"read_liberty {plain}")
    script += [
        f"read_verilog {args.folder / args.unit}.v",
        f"link_design {args.unit}",
        f"read_sdc {args.folder / args.unit}.sdc",
        "set_power_activity -global -activity 1 -duty 0.5",
        "sta::set_debug power 2",
        "report_power -digits 6",
    ]
    file = folder / "power.tcl"
    file.write_text("\n".join(script) + "\n")
    done = subprocess.run(["sta", "-no_init", "-no_splash", "-exit", file], check=True, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return done.stdout


class Condition:
    """A condition as OpenSTA prints it: `(!CK*D)*!Q`."""

    def __init__(self, text):
        self.tokens = re.findall(r"[\w\[\]]+|[!*+^()]", text)

    def evaluate(self, value):
        """With value(name) between 0 and 1, names taken as independent; None: left out."""
        self.at = 0
        result = self.sum(value)
        return 1.0 if result is None else result

    def take(self, *marks):
        if self.at < len(self.tokens) and self.tokens[self.at] in marks:
            self.at += 1
            return True
        return False

    def sum(self, value):
        a = self.product(value)
        while self.take("+"):
            b = self.product(value)
            a = b if a is None else a if b is None else 1 - (1 - a) * (1 - b)
        return a

    def product(self, value):
        a = self.factor(value)
        while True:
            if self.take("^"):
                b = self.factor(value)
                a = a * (1 - b) + b * (1 - a)
            elif self.take("*"):
                b = self.factor(value)
                a = b if a is None else a if b is None else a * b
            else:
                return a

    def factor(self, value):
        if self.take("!"):
            inner = self.factor(value)
            return None if inner is None else 1 - inner
        if self.take("("):
            inner = self.sum(value)
            self.take(")")
            return inner
        name = self.tokens[self.at]
        self.at += 1
        return float(name) if name in "01" else value(name)


def cells(text):
    """For each cell its outputs' energy of a toggle, and groups of each pin; leakage of kinds."""
    out = defaultdict(lambda: {"kind": None, "outputs": {}, "groups": defaultdict(list)})
    leakage, whole = defaultdict(dict), {}
    switching = None
    for line in text.splitlines():
        if found := OUTPUT.match(line):
            switching = float(found[2]) / float(found[1])
        elif found := PIN.match(line):
            cell = out[found[1]]
            pin, cell["kind"] = found[2], found[3]
            if switching is not None:
                cell["outputs"][pin] = switching
                switching = None
        elif found := LEAKAGE.match(line):
            # A ground pin leaks 0.
            if float(found[3]) != 0:
                leakage[found[1]][found[2]] = float(found[3])
        elif found := WHOLE.match(line):
            whole[found[1]] = float(found[2])
        elif found := GROUP.match(line):
            if found[5].strip() in ("VSS", "GND"):
                continue
            cell["groups"][pin].append(
                (found[1], found[2].strip(), float(found[3]), float(found[4]), found[5]))
    mean = {kind: sum(states.values()) / len(states) for kind, states in leakage.items()}
    return out, whole | mean


def energy(group):
    """Mean energy of both edges, J: OpenSTA prints their sum times the duty."""
    _, when, printed, joules, _ = group
    duty = Condition(when).evaluate(lambda _: 0.5) if when else printed
    return joules / (2 * duty)


def output_energy(groups):
    total = 0.0
    for supply in {group[4] for group in groups}:
        own = [group for group in groups if group[4] == supply]
        weights = [Condition(group[1]).evaluate(lambda _: 0.5) if group[1] else 0.5
                   for group in own]
        total += sum(w * energy(g) for w, g in zip(weights, own)) / sum(weights)
    return total


def input_energy(groups, outputs, stores):
    def value(name):
        if stores:
            return None if name == "QN" and "Q" in text else 0.5
        return None if name in outputs else 0.5

    total = 0.0
    for group in groups:
        text = re.findall(r"\w+", group[1])
        total += energy(group) * (Condition(group[1]).evaluate(value) if group[1] else 1.0)
    return total


def clock_energy(groups, changes, clocked):
    """Of both edges in a share of cycles; a bit changes where it differs from what is in front."""
    total = 0.0
    for group in groups:
        for data, stored in product((0, 1), repeat=2):
            share = changes / 2 if data != stored else (clocked - changes) / 2
            state = {"D": data, "Q": stored, "QN": 1 - stored}
            holds = Condition(group[1]).evaluate(lambda name: state[name]) if group[1] else 1.0
            total += 2 * energy(group) * share * holds
    return total


def gate_energy(groups, pins, opened, turns):
    """Of a clock gate, a cycle: open in a share of cycles, its enable rises and falls `turns` times."""
    enable, clock, output, low = pins

    def edge(of, on, high, out):
        """Mean of both edges of the groups of a pin that hold in a state."""
        state = {enable: on, clock: high, output: out, **{pin: 0 for pin in low}}
        return sum(energy(group) for group in groups[of]
                   if not group[1] or Condition(group[1]).evaluate(lambda name: state[name]))

    opening = edge(enable, 0, 1, 0) + edge(clock, 1, 1, 0) - edge(clock, 0, 1, 0)
    closing = edge(enable, 1, 1, 1) + edge(output, 0, 1, 1) - edge(output, 1, 1, 1)
    closed, open_ = 2 * edge(clock, 0, 0, 0), 2 * edge(output, 1, 1, 1)
    return closed * (1 - opened) + open_ * opened + turns * (opening + closing)


def theirs(args, text, activity):
    """Powers from OpenSTA's energies and our activity, W."""
    netlist = json.loads((args.folder / f"{args.unit}.json").read_text())
    netlist = netlist["modules"][args.unit]
    period = json.loads((args.folder / "report.json").read_text())["period_ns"] * 1e-9
    parts, leakages = cells(text)
    of_net = {}
    for name, port in netlist["ports"].items():
        for bit, net in enumerate(port["bits"]):
            single = len(port["bits"]) == 1
            of_net[net] = activity.get(("-", name if single else f"{name}_{bit}"))
    for name, cell in netlist["cells"].items():
        for pin, (net,) in cell["connections"].items():
            if (name, pin) in activity:
                of_net[net] = activity[name, pin]
    gates = {name for _, name in LIBRARIES[args.library]["clock_gates"]}
    gate_pins = LIBRARIES[args.library]["clock_gate_pins"]
    of_clock = {}
    for name, cell in netlist["cells"].items():
        if cell["type"] in gates:
            of_clock[cell["connections"][gate_pins[2]][0]] = activity[name, gate_pins[2]] / 2
    switching = internal = 0.0
    for name, cell in netlist["cells"].items():
        read = parts[name]
        clocks = [pin for pin in cell["connections"] if pin in ("CK", "CLK")]
        if cell["type"] in gates:
            enable, _, output, _ = gate_pins
            switching += read["outputs"][output] * activity[name, output] / period
            turns = (of_net.get(cell["connections"][enable][0]) or 0.0) / 2
            internal += gate_energy(read["groups"], gate_pins, activity[name, output] / 2,
                                    turns) / period
            continue
        for pin, (net,) in cell["connections"].items():
            groups = read["groups"][pin]
            if pin in read["outputs"]:
                switching += read["outputs"][pin] * activity[name, pin] / period
                internal += output_energy(groups) * activity[name, pin] / period if groups else 0
            elif pin in clocks:
                first = next(out for out in read["outputs"] if (name, out) in activity)
                clocked = of_clock.get(net, 1.0)
                internal += clock_energy(groups, activity[name, first], clocked) / period
            else:
                energies = input_energy(groups, read["outputs"], bool(clocks))
                internal += energies * (of_net.get(net) or 0.0) / period
    leakage = sum(leakages.get(cell["type"], 0.0) for cell in netlist["cells"].values())
    return {"switching_w": switching, "internal_w": internal, "leakage_w": leakage}


def main():
    args = arguments()
    if shutil.which("sta") is None:
        print("power check: skipped, no OpenSTA (`sta`) on the path")
        return
    args.folder, args.liberty = args.folder.resolve(), [path.resolve() for path in args.liberty]
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        activity, powers = ours(args, folder / "activity.txt")
        reference = theirs(args, opensta(args, folder), activity)
    worst = 0.0
    for part, expected in reference.items():
        difference = powers[part] / expected - 1
        worst = max(worst, abs(difference))
        print(f"{args.unit} {args.library} {part[:-2]:9} ours {powers[part] * 1e3:.5f} mW, "
              f"OpenSTA {expected * 1e3:.5f} mW, {difference:+.2%}")
    print(json.dumps(powers))
    if worst > LIMIT:
        sys.exit(f"a part is off by more than {LIMIT:.0%}")


if __name__ == "__main__":
    main()
