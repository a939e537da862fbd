"""How the error of the naive path tracer falls with the samples, against a long render by another estimator and seed."""
import numpy as np

import plots
from studio import Render

SHOWN = (64, 512, 4096)


def slope(spp, error):
    """Least squares in log-log, and its standard error."""
    x, y = np.log(spp), np.log(error)
    (a, b), covariance = np.polyfit(x, y, 1), None
    residual = y - (a * x + b)
    covariance = residual @ residual / (len(x) - 2) / np.sum((x - x.mean()) ** 2)
    return float(a), float(np.sqrt(covariance))


def disjoint_ranges(counts):
    """Sample ranges of these lengths side by side: no two renders share a sample, so their errors are independent."""
    begin = 0
    for count in counts:
        yield begin, begin + count
        begin += count


def series(studio, estimator, define, counts, size, wanted, noise):
    rows = []
    for spp, samples in zip(counts, disjoint_ranges(counts)):
        shard = studio.render("cbox-sphere", f"{estimator}-{spp}-film", samples=samples, size=size, define=define)
        path = studio.scratch / f"{estimator}-{spp}.exr"
        studio.etendue("merge", shard.path, "--picture", "-o", path, "-o", path.with_suffix(".png"))
        picture, error = Render(path).rgb()
        raw = np.mean((picture - wanted) ** 2)
        rows.append({
            "estimator": estimator, "spp": spp,
            "rmse": float(np.sqrt(raw)),
            "rmse_corrected": float(np.sqrt(max(raw - noise, 0.0))),  # the reference's own noise taken out
            "predicted": float(np.sqrt(np.mean(error**2))),  # by the picture's own StdErr channels
        })  # yapf: disable
        if estimator == "naive" and spp in SHOWN:
            studio.keep_picture(f"convergence-{spp}", path.with_suffix(".png"), zoom=2)
    return rows


def coverage(studio, estimator, spp, wanted, wanted_error):
    """Share of pixels whose difference from the reference is within one and two standard errors."""
    picture, error = Render(studio.scratch / f"{estimator}-{spp}.exr").rgb()
    spread = np.sqrt(error**2 + wanted_error**2)
    z = np.abs(picture - wanted) / np.where(spread > 0, spread, np.inf)
    return {"one": float(np.mean(z < 1)), "two": float(np.mean(z < 2)), "spp": spp}


def plot(studio, rows, fits):
    figure, axis = plots.axes()
    for estimator, colour, label in (("naive", plots.BLUE, "naive"), ("mis", plots.ORANGE, "light sampling and MIS")):
        mine = [row for row in rows if row["estimator"] == estimator]
        spp = np.array([row["spp"] for row in mine])
        axis.loglog(spp, [row["rmse_corrected"] for row in mine], "o", color=colour, label=f"{label}: RMSE measured")
        axis.loglog(spp, [row["predicted"] for row in mine], "-", color=colour, linewidth=1.2,
                    label=f"{label}: RMSE predicted by the StdErr channels")
    first = [row for row in rows if row["estimator"] == "naive"][0]
    spp = np.array([row["spp"] for row in rows if row["estimator"] == "naive"])
    axis.loglog(spp, 1.6 * first["predicted"] * np.sqrt(spp[0] / spp), "--", color=plots.GREY, linewidth=1.2, label="slope −1/2")
    axis.set_xlabel("samples per pixel")
    axis.set_ylabel("RMSE (radiance, scene units)")
    axis.set_xticks(spp, [str(n) for n in spp])
    axis.minorticks_off()
    axis.set_ylim(bottom=0.35 * min(row["rmse_corrected"] for row in rows))  # room for the legend
    axis.legend(loc="lower left")
    studio.keep_plot("convergence", figure)


def run(studio):
    size = studio.pick((160, 120), (32, 24))
    reference_spp = studio.pick(6144, 256)
    counts = {"naive": studio.pick([8, 16, 32, 64, 128, 256, 512, 1024, 4096], [4, 16, 64, 128]),
              "mis": studio.pick([8, 16, 32, 64, 128, 256, 512], [4, 16, 64])}  # yapf: disable
    reference = studio.render("cbox-sphere", "convergence-reference", spp=reference_spp, size=size, seed=1)
    wanted, wanted_error = reference.rgb()
    noise = float(np.mean(wanted_error**2))
    studio.keep_picture("convergence-reference", reference.png(), zoom=2)
    rows = series(studio, "naive", ["integrator.nee=false"], counts["naive"], size, wanted, noise)
    rows += series(studio, "mis", [], counts["mis"], size, wanted, noise)
    if studio.quick:
        for spp in SHOWN:
            studio.keep_picture(f"convergence-{spp}", reference.png(), zoom=2)
    fits = {}
    for estimator in counts:
        mine = [row for row in rows if row["estimator"] == estimator]
        fits[estimator], fits[estimator + "_error"] = slope([row["spp"] for row in mine], [row["rmse_corrected"] for row in mine])
    plot(studio, rows, fits)
    naive = {row["spp"]: row for row in rows if row["estimator"] == "naive"}
    mis = {row["spp"]: row for row in rows if row["estimator"] == "mis"}
    both = [(naive[n]["rmse_corrected"] / mis[n]["rmse_corrected"]) ** 2 for n in mis if n in naive]
    studio.keep_table("convergence", rows)
    studio.keep_data("convergence", {
        "width": size[0], "height": size[1],
        "reference_spp": reference_spp, "reference_error": float(np.sqrt(noise)),
        "slope": fits,
        "rows": [row for row in rows if row["estimator"] == "naive"],
        "mis_worth": float(np.exp(np.mean(np.log(both)))),
        "coverage": coverage(studio, "naive", counts["naive"][-1], wanted, wanted_error),
    })  # yapf: disable
