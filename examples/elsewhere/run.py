"""A machine of one's own: all pixels on chip, no lists. Reads what `trace dump` writes."""
import csv, math, sys

LANES, AHEAD, BYTES = 64, 64, 32  # pixels a cycle, Gaussians fetched ahead, bytes of a Gaussian

out = csv.writer(sys.stdout, lineterminator="\n")
out.writerow(["frame", "what", "count", "cycle", "needed", "address"])
for folder in sys.argv[1:]:
    facts = dict(csv.reader(open(f"{folder}/facts.csv")))
    frame, size = facts["id"], {"x": int(facts["width_px"]), "y": int(facts["height_px"])}
    began, pixels = [0], 0  # when each Gaussian begins; pixels evaluated so far
    for splat in csv.DictReader(open(f"{folder}/splats.csv")):
        box = 1
        for axis, most in size.items():
            mean, reach = float(splat[f"mean_{axis}_px"]), 3 * math.sqrt(float(splat[f"cov_{2 * axis}_px2"]))
            box *= max(math.ceil(min(mean + reach, most)) - math.floor(max(mean - reach, 0)), 0)
        asked = began[max(len(began) - 1 - AHEAD, 0)]
        out.writerow([frame, "dram-read", BYTES, asked, began[-1] + 1, BYTES * int(splat["index"])])
        began.append(began[-1] + max(1, math.ceil(box / LANES)))
        pixels += box
    out.writerow([frame, "dram-write", 3 * size["x"] * size["y"], began[-1], "", 1 << 24])
    counts = {"cycles": began[-1] + 1, "alpha": pixels, "blend": pixels}
    counts |= {"sram-read.raster-pixels": 8 * pixels, "sram-write.raster-pixels": 8 * pixels}
    out.writerows([frame, what, count] for what, count in counts.items())
