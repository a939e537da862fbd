"""The three materials; the share of light that glass reflects, sampled and exact; do samples follow their densities?"""
import xml.etree.ElementTree as xml

import numpy as np

import plots

GLASS, AIR = 1.5046, 1.000277  # the defaults of the scene format


def fresnel(angle, n_o, n_i):
    """Exact unpolarised reflectance at `angle` (radians) from a medium of index n_o against one of n_i [Born1999]."""
    cos_o, sin_t = np.cos(angle), np.sin(angle) * n_o / n_i
    cos_t = np.sqrt(np.maximum(0.0, 1.0 - sin_t**2))
    s = (n_o * cos_o - n_i * cos_t) / (n_o * cos_o + n_i * cos_t)
    p = (n_i * cos_o - n_o * cos_t) / (n_i * cos_o + n_o * cos_t)
    return np.where(sin_t >= 1.0, 1.0, 0.5 * (s**2 + p**2))


def albedo_test(studio, n_o, n_i, angles, samples):
    """`etendue ttest` of a dielectric at these angles of incidence (degrees). The mean weight of its samples is F + (1 − F) (n_o/n_i)²."""
    scale = (n_o / n_i) ** 2
    exact = fresnel(np.radians(angles), n_o, n_i)
    root = xml.Element("test", type="ttest")
    for name, values in (("angles", angles), ("references", exact + (1 - exact) * scale)):
        xml.SubElement(root, "string", name=name, value=", ".join(f"{v:.12g}" for v in values))
    xml.SubElement(root, "float", name="significanceLevel", value="0.01")
    xml.SubElement(root, "integer", name="sampleCount", value=str(samples))
    bsdf = xml.SubElement(root, "bsdf", type="dielectric")
    xml.SubElement(bsdf, "float", name="intIOR", value=str(n_i))  # wo is on the side of the normal: the exterior
    xml.SubElement(bsdf, "float", name="extIOR", value=str(n_o))
    path = studio.scratch / "fresnel.xml"
    xml.ElementTree(root).write(path)
    report = studio.json("ttest", path, "--json", *studio.device_options(), accept=(0, 1))[0]
    rows = []
    for angle, f, test in zip(angles, exact, report["scenes"]):
        rows.append({"from": n_o, "to": n_i, "degrees": float(angle), "exact": float(f),
                     "sampled": (test["mean"] - scale) / (1 - scale), "error": test["standardError"] / abs(1 - scale),
                     "p": test["p"]})  # yapf: disable
    return rows, report["passed"]


def plot(studio, series):
    figure, axis = plots.axes()
    fine = np.linspace(0, 90, 721)
    for (n_o, n_i, label), rows, colour in zip((("air", "glass", "air to glass"), ("glass", "air", "glass to air")), series,
                                               (plots.BLUE, plots.ORANGE)):
        index = {"air": AIR, "glass": GLASS}
        axis.plot(fine, 100 * fresnel(np.radians(fine), index[n_o], index[n_i]), color=colour, linewidth=1.2, label=f"{label}, exact")
        axis.errorbar([r["degrees"] for r in rows], [100 * r["sampled"] for r in rows], [200 * r["error"] for r in rows], fmt="o",
                      markersize=4, color=colour, capsize=2, elinewidth=1, label=f"{label}, sampled on the device")
    axis.set_xlabel("angle of incidence (degrees)")
    axis.set_ylabel("reflected (%)")
    axis.set_xlim(0, 90)
    axis.set_ylim(0, 104)
    axis.legend(loc="center", bbox_to_anchor=(0.68, 0.8))
    studio.keep_plot("fresnel", figure)


def run(studio):
    samples = studio.pick(200000, 4000)
    angles = np.sort(np.append(np.arange(0.0, 88.0, 6.0), [39.0, 41.0, 88.0]))  # more of them where the curve is steep
    into, passed_into = albedo_test(studio, AIR, GLASS, angles, samples)
    out, passed_out = albedo_test(studio, GLASS, AIR, angles, samples)
    plot(studio, (into, out))
    studio.keep_table("fresnel", into + out)
    decided = [row["p"] for row in into + out if row["error"] > 0]
    chi2 = studio.json("chi2", studio.scene("chi2-bsdfs"), "--json", *studio.pick([], ["--samples", 20000]), *studio.device_options(),
                       accept=(0, 1))[0]
    studio.keep_data("materials", {
        "samples": samples, "angles": len(angles), "passed": passed_into and passed_out,
        "tests": len(into + out), "smallest_p": min(decided),
        "largest_error": max(abs(row["sampled"] - row["exact"]) for row in into + out),
        "critical": float(np.degrees(np.arcsin(AIR / GLASS))), "normal": float(fresnel(0.0, AIR, GLASS)),
        "chi2": {"tests": len(chi2["tests"]), "passed": sum(t["passed"] for t in chi2["tests"]),
                 "samples": chi2["tests"][0]["samples"], "smallest_p": min(t["p"] for t in chi2["tests"])},
    })  # yapf: disable
