"""What stands behind the claim to be right: closed forms, the reference, planted errors."""
import numpy as np

import plots
from studio import ROOT

SCENES = {"cbox-sphere": ("mirror and glass", "validate-cbox"), "bubble": ("glass in glass, sky", "validate-bubble"),
          "cbox-bumpy": ("500 000 triangles", "validate-bumpy")}  # yapf: disable


def t_test_options(studio):
    """A quick run asks the reference: a device compiles a kernel for each of the scenes, which takes longer than so few samples."""
    return ["--json", *studio.pick(studio.device_options(), ["--samples", 5000, "--device", "reference"])]


def t_tests(studio):
    options = t_test_options(studio)
    furnace, direct = studio.json("ttest", studio.scene("ttest-furnace"), studio.scene("ttest-direct"), *options, accept=(0, 1))
    labels = ["naive", "naive, with roulette", "light sampling with MIS", "light sampling, direct light only"]
    rows = []
    for i, test in enumerate(furnace["scenes"]):
        rows.append({"scene": f"furnace, albedo {0.5 if i < 4 else 0.8}", "strategy": labels[i % 4]} | keep(test))
    for i, test in enumerate(direct["scenes"]):  # naive, nee and mis for each triangle
        rows.append({"scene": f"direct light, triangle {i // 3 + 1}", "strategy": ["naive", "light sampling", "MIS"][i % 3]} | keep(test))
    studio.keep_table("ttests", rows)
    studio.keep_data("ttests", {
        "samples": direct["scenes"][0]["samples"], "rows": rows, "passed": sum(row["passed"] for row in rows), "count": len(rows),
        "level": direct["significanceLevel"], "furnace_level": furnace["testLevel"], "direct_level": direct["testLevel"],
        "smallest_p": min(row["p"] for row in rows if row["decided_by"] == "distribution"),
    })  # yapf: disable


def keep(test):
    return {"mean": test["mean"], "reference": test["reference"], "error": test["standardError"], "t": test["t"], "p": test["p"],
            "decided_by": test["decidedBy"], "passed": test["passed"], "verdict": "passed" if test["passed"] else "FAILED"}  # yapf: disable


def sizes_and_places(studio):
    """The same scene at other sizes and places (tests/scenes/scales.xml)."""
    options = t_test_options(studio)
    tests = studio.json("ttest", ROOT / "tests" / "scenes" / "scales.xml", *options, accept=(0, 1))[0]["scenes"]
    studio.keep_data("scales", {"count": len(tests), "passed": sum(test["passed"] for test in tests), "samples": tests[0]["samples"],
                                "smallest_p": min(test["p"] for test in tests)})


def planted_errors(studio):
    report = studio.json_file_of(studio.mutator, *studio.pick([], ["--only", "1"]), *studio.device_options(), accept=(0, 1))
    planted = [mutant for mutant in report["mutants"] if mutant["id"] != 0]
    studio.keep_data("mutants", {"count": len(planted), "caught": sum(mutant["caught"] for mutant in planted),
                                 "false_alarms": sum(mutant["caught"] for mutant in report["mutants"] if mutant["id"] == 0)})


def against_reference(studio):
    size = studio.pick((100, 75), (24, 18))
    rows = []
    for scene, (what, _) in SCENES.items():
        report = studio.json_file("validate", studio.scene(scene), "-D", f"camera.width={size[0]}", "-D", f"camera.height={size[1]}",
                                  "--spp", studio.pick(32, 16), "--samples", studio.pick(60000, 2000), *studio.device_options(),
                                  accept=(0, 1))  # yapf: disable
        l2 = report["L2"]
        rows.append({"scene": scene, "what": what, "samples": l2["samples"], "equal": l2["equalToTheBit"] / l2["samples"],
                     "flips": l2["flipsPerMillion"], "median": l2["medianError"], "p999": l2["p999Error"], "paired_p": l2["pairedP"],
                     "family_p": min(f["familyP"] for f in report["L3"]["families"]),
                     "verdict": report["verdict"]})  # yapf: disable
    studio.keep_data("validate", {"width": size[0], "height": size[1], "rows": rows})


def error_map(studio):
    """Device and reference with equal random numbers: rounding everywhere, and single pixels where a decision fell differently."""
    scene, size, spp = "cbox-bumpy", studio.pick((240, 180), (24, 18)), studio.pick(4, 1)
    device, _ = studio.render(scene, "map-device", spp=spp, size=size, seed=2).rgb()
    reference, _ = studio.render(scene, "map-reference", spp=spp, size=size, seed=2, device="reference").rgb()
    floor = 1e-3 * reference.mean()
    error = np.max(np.abs(device - reference), axis=2) / np.maximum(np.maximum(device.max(axis=2), reference.max(axis=2)), floor)
    figure, axis = plots.axes(6.4, 4.1)
    shown = axis.imshow(np.log10(np.maximum(error, 1e-8)), cmap="magma", vmin=-8, vmax=0, interpolation="nearest")
    axis.set_axis_off()
    bar = figure.colorbar(shown, ax=axis, ticks=range(-8, 1, 2), shrink=0.9)
    bar.ax.set_yticklabels([f"10$^{{{n}}}$" if n else "1" for n in range(-8, 1, 2)])
    bar.set_label("relative difference of the pixel")
    bar.outline.set_visible(False)
    studio.keep_plot("error-map", figure)
    studio.keep_data("error_map", {"spp": spp, "width": size[0], "height": size[1], "median": float(np.median(error)),
                                   "equal": float(np.mean(error == 0)), "beyond": float(np.mean(error > 1e-3))})


def run(studio):
    t_tests(studio)
    sizes_and_places(studio)
    against_reference(studio)
    error_map(studio)
    planted_errors(studio)
