"""Samples and rays a second, by `etendue bench`, which lets the scenes take turns."""

SCENES = {"cbox-sphere": "Cornell box, mirror and glass", "bubble": "glass in glass, three lamps, sky", "cbox-bumpy": "500 000 triangles, diffuse"}


def rates(bench, what):
    """Per second of processor time where the driver computes on the processor, since others may use the machine as well; else per second."""
    spread = bench.get(f"{what}_per_cpu_second") or bench[f"{what}_per_second"]
    return {"rate": spread["median"], "slowest": spread["min"], "fastest": spread["max"]}


def run(studio):
    scenes = [studio.scene(name) for name in SCENES]
    limits = studio.pick(["--size", "400x300", "--repetitions", 5, "--rays", 1 << 17], ["--size", "32x24", "--quick"])
    report = studio.json("bench", *scenes, "--part", "samples", "--part", "rays", "--json", *limits, *studio.device_options())
    samples, rays = [], []
    for name, bench in zip(SCENES, report["scenes"]):
        samples.append({"scene": name, "what": SCENES[name], **rates(bench, "samples")})
        for row in bench["rays"]:
            rays.append({"scene": name, "class": row["class"], "order": row["order"], "steps": row["steps_per_ray"], **rates(row, "rays")})
    on_processor = bool(report["scenes"][0].get("samples_per_cpu_second"))
    studio.keep_table("time_rays", rays)
    studio.keep_data("time_performance", {
        "rows": samples, "rays": [row for row in rays if row["scene"] == "cbox-bumpy"], "repetitions": report["repetitions"],
        "size": limits[1].replace("x", "×"), "unit": "second of one core's time" if on_processor else "second",
    })  # yapf: disable
