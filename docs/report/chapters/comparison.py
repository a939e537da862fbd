"""Against other renderers and Embree, by tests/bench/compare: only where they are installed, and only when asked for (--only comparison)."""
import json
import os
import sys

from studio import ROOT

SCENES = ["cbox-sphere", "cbox-bumpy"]


def measured(spread):
    if spread is None:
        raise RuntimeError("a picture was too short to measure per processor second: take more samples")
    return spread


def ratio(row):
    """Etendue's rate per processor second over the other's, within one repetition each; none for Etendue itself."""
    values = measured(row.get("cpu_ratio", {"median": 1.0, "min": 1.0, "max": 1.0}))
    return {"ratio": values["median"], "least": values["min"], "most": values["max"]}


def run(studio):
    compare = ROOT / "tests" / "bench" / "compare" / "compare.py"
    embree = studio.program.parent.parent / "tests" / "bench" / "compare" / "embree_rays"
    out = studio.scratch / "compare.json"
    options = ["--etendue", studio.program, "--threads", len(os.sched_getaffinity(0)), "--json", out, "--size", "240x180", "--spp", 16,
               "--rays", 1 << 16, "--repetitions", 3, *(["--embree", embree] if embree.exists() else [])]  # yapf: disable
    studio.run(sys.executable, compare, *options, *[studio.scene(name) for name in SCENES])
    report = json.loads(out.read_text(encoding="utf-8"))
    samples, rays = [], []
    for name, part in zip(SCENES, report["samples"]):
        samples += [{"scene": name, "program": row["renderer"], "rate": row["samples_per_second"]["median"],
                     "cpu_rate": measured(row["samples_per_cpu_second"])["median"], **ratio(row)} for row in part["rows"] if "unsupported" not in row]
    for name, part in zip(SCENES, report["rays"]):
        rays += [{"scene": name, "class": row["class"], "order": row["order"], "program": row["program"],
                  "rate": row["rays_per_second"]["median"], "cpu_rate": row["rays_per_cpu_second"]["median"], **ratio(row)}
                 for row in part["rows"] if row["program"] != "etendue" and row["order"] == "picture"]  # yapf: disable
    studio.keep_data("time_compare", {"samples": samples, "rays": rays, "versions": report["versions"], "spp": report["spp"],
                                      "size": report["size"].replace("x", "×")})
