"""The same picture in one piece and in many: are the bytes equal?"""
from studio import sha256


def merged(studio, name, size, ranges, more=()):
    """The samples of these ranges rendered one by one and put together."""
    shards = [studio.render("bubble", f"{name}-{i}", samples=samples, size=size, more=more) for i, samples in enumerate(ranges)]
    path = studio.scratch / f"{name}.exr"
    studio.etendue("merge", *[shard.path for shard in shards], "--picture", "-o", path)
    return path


def resumed(studio, size, spp, cut):
    """Stopped after `cut` samples and taken up again."""
    first = studio.render("bubble", "resumed-first", samples=(0, cut), size=size)
    return studio.render("bubble", "resumed", spp=spp, size=size, more=["--resume", first.path]).path


def run(studio):
    size, spp = studio.pick((160, 90), (32, 18)), studio.pick(32, 8)
    whole = studio.render("bubble", "whole", spp=spp, size=size).path
    half, odd = spp // 2, [(a, min(a + 5, spp)) for a in range(0, spp, 5)]
    one_thread = {"LP_NUM_THREADS": "1"}
    ways = [
        ("in one piece", whole),
        ("once more", studio.render("bubble", "again", spp=spp, size=size).path),
        ("two halves, merged", merged(studio, "halves", size, [(0, half), (half, spp)])),
        ("pieces of five samples, merged in reverse order", merged(studio, "fives", size, odd[::-1])),
        ("stopped after a third and resumed", resumed(studio, size, spp, spp // 3)),
        ("one sample a dispatch", studio.render("bubble", "single", spp=spp, size=size, more=["--pass-samples", 1]).path),
        ("one thread instead of all", studio.render("bubble", "thread", spp=spp, size=size, environment=one_thread).path),
    ]
    if not studio.device:
        ways.append(("shared by two contexts of one device", studio.render("bubble", "team", spp=spp, size=size, device="0,0").path))
    other = studio.render("bubble", "other", spp=spp, size=size, seed=1).path
    rows = [{"way": way, "sha256": sha256(path)[:16], "equal": sha256(path) == sha256(whole)} for way, path in ways]
    studio.keep_data("determinism", {
        "rows": rows, "spp": spp, "width": size[0], "height": size[1], "equal": sum(row["equal"] for row in rows), "count": len(rows),
        "other_seed": sha256(other)[:16], "other_differs": sha256(other) != sha256(whole),
    })  # yapf: disable
