#!/usr/bin/env python3
"""Real SRAM macros beside CACTI: how energy, leakage, area and access time grow with size.

    rtl/sram/slopes.py --liberty MACRO.lib.gz... [--cacti arch-configs/sram/cacti-7.csv] > slopes.md

Reads Liberty files of IHP's single-port macros (SG13G2, 130 nm), writes Markdown: a row per macro,
and the exponents of both. Levels of two nodes cannot be compared; exponents can.
"""

import argparse
import csv
import gzip
import math
import pathlib
import re
import sys


def text(path):
    data = pathlib.Path(path).read_bytes()
    if data[:2] == b"\x1f\x8b":
        data = gzip.decompress(data)
    return data.decode()


def number(pattern, body, path):
    found = re.search(pattern, body)
    if found is None:
        sys.exit(f"{path}: no `{pattern}`: not a single-port macro of IHP's generator")
    return float(found.group(1))


def macro(path):
    """A macro: words, bits, pJ of a read and of a write, uW of leakage, mm2, ns."""
    body = text(path)
    clock = body[body.find("pin(A_CLK)"):]
    power = r'when : "A_MEN\s*& {}A_WEN\s*& {}A_REN";\s*rise_power\("scalar"\)\{{\s*values \(([\d.]+)\)'
    pin = body[body.find("bus(A_DOUT)"):]
    delays = re.search(r"cell_rise\(\w+\) \{.*?values \((.*?)\);", pin, re.S)
    if delays is None:
        sys.exit(f"{path}: no delay of A_DOUT")
    return {
        "words": 1 << int(number(r"address_width : (\d+)", body, path)),
        "bits": int(number(r"word_width : (\d+)", body, path)),
        "read": number(power.format("!", ""), clock, path),
        "write": number(power.format("", "!"), clock, path),
        "leakage": number(r"cell_leakage_power : ([\d.]+)", body, path) / 1000,
        "area": number(r"\barea\s*: ([\d.]+)", body, path) / 1e6,
        # Into a small load, with a steep clock.
        "access": float(re.search(r"[\d.]+", delays.group(1)).group(0)),
    }


def exponent(points):
    """The exponent of y over x through all points, least squares of logarithms."""
    points = [(math.log(x), math.log(y)) for x, y in points]
    mean = [sum(p[i] for p in points) / len(points) for i in (0, 1)]
    return sum((x - mean[0]) * (y - mean[1]) for x, y in points) / sum((x - mean[0]) ** 2 for x, _ in points)


def main():
    args = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    args.add_argument("--liberty", nargs="+", required=True, metavar="FILE")
    args.add_argument("--cacti", default="arch-configs/sram/cacti-7.csv", metavar="FILE")
    args = args.parse_args()
    macros = sorted((macro(path) for path in args.liberty), key=lambda m: (m["bits"], m["words"]))
    print("| words x bits | bytes | read, pJ | write, pJ | write / read | leakage, uW | area, mm² | um² a byte | access, ns |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|--:|")
    for m in macros:
        size = m["words"] * m["bits"] // 8
        print(
            f"| {m['words']} x {m['bits']} | {size} | {m['read']:.1f} | {m['write']:.1f} | {m['write'] / m['read']:.2f} "
            f"| {m['leakage']:.2f} | {m['area']:.4f} | {1e6 * m['area'] / size:.1f} | {m['access']:.2f} |"
        )
    rows = csv.DictReader(line for line in text(args.cacti).splitlines() if not line.startswith("#"))
    rows = [r for r in rows if (r["node_nm"], r["cell"], r["periphery"], r["ports"]) == ("28", "hp", "hp", "1rw")]
    cacti = [
        {
            "words": int(r["size_b"]) // int(r["word_b"]), "bits": 8 * int(r["word_b"]), "read": float(r["read_pj"]),
            "write": float(r["write_pj"]), "leakage": float(r["leakage_mw"]), "area": float(r["area_mm2"]),
        }
        for r in rows
    ]
    print("\n| exponent of | over | IHP, 130 nm | of | CACTI, 28 nm | of |")
    print("|---|---|--:|---|--:|---|")

    def cells(all_rows, what, over, fixed, value, between):
        own = [m for m in all_rows if m[fixed] == value and between[0] <= m[over] <= between[1]]
        points = [(m[over], m[what]) for m in own if m.get(what)]
        if len({x for x, _ in points}) < 2:
            return "- | -"
        over = sorted(x for x, _ in points)
        return f"{exponent(points):.2f} | {over[0]} to {over[-1]}, at {value} {fixed}"

    # CACTI's tables begin at words of 4 bytes; widths are those with most rows in the same range.
    for what in ("read", "write", "leakage", "area", "access"):
        ihp = cells(macros, what, "words", "bits", 64, (64, 2048))
        print(f"| {what} | words | {ihp} | {cells(cacti, what, 'words', 'bits', 128, (64, 2048))} |")
    for what in ("read", "write", "leakage", "area"):
        ihp = cells(macros, what, "bits", "words", 1024, (8, 64))
        print(f"| {what} | bits | {ihp} | {cells(cacti, what, 'bits', 'words', 1024, (64, 512))} |")


main()
