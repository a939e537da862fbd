#!/usr/bin/env python3
"""Renders every picture and measures every number of docs/report.md, docs/gallery.md and the README.

    ./run figures                    everything, into docs/images, docs/data and docs/report.md
    ./run figures --only lights      some chapters
    ./run figures --text             the report's text alone, from the data there are
    ./run figures --quick            tiny pictures into a folder of their own, to see that nothing is missing

Data repeat to the last digit on one device and driver, but for those whose names begin with time_.
"""
import argparse
import importlib
import json
import os
import platform
import resource
import shlex
import shutil
import sys
import tempfile
import time
from pathlib import Path

import template

ROOT = Path(__file__).resolve().parents[2]
CHAPTERS = ["paths", "antialiasing", "convergence", "materials", "lights", "proofs", "tree", "determinism", "performance",
            "swatches", "plugins", "gallery", "families"]
# Chapters that run only by --only, because they need other programs or take long, and what they make.
UNASKED = {"comparison": {"time_compare.json"}, "scaling": {"time_scaling.json", "scaling.svg"}}


def options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--etendue", help="the program")
    parser.add_argument("--sculpt", help="etendue-sculpt, the maker of meshes")
    parser.add_argument("--mutate", help="etendue-mutate, which plants errors")
    parser.add_argument("--out", type=Path, help="folder for images/ and data/ (default: docs; with --quick a temporary one)")
    parser.add_argument("--device", default="", help="as for etendue render (default: auto)")
    parser.add_argument("--only", nargs="+", choices=[*CHAPTERS, *UNASKED], default=CHAPTERS, metavar="CHAPTER",
                        help=", ".join([*CHAPTERS, *UNASKED]))
    parser.add_argument("--quick", action="store_true", help="tiny pictures, few samples; nothing in docs is touched")
    parser.add_argument("--text", action="store_true", help="fill in the report's text and do nothing else")
    return parser.parse_args(sys.argv[1:] + shlex.split(os.environ.get("ETENDUE_FIGURES", "")))  # the latter from ./run figures


def processor():
    """What the machine calls its processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def describe_machine(studio):
    """Which device and which machine; a render names what it ran on."""
    report = studio.render("siemens-star", "machine", spp=1, size=(16, 16)).report
    device = report["devices"][0]
    return {"device": device["device"], "driver": device["driver"], "cpu": processor(), "cores": len(os.sched_getaffinity(0))}


def cpu_seconds():
    """Processor time of this program and all it has run: unlike a clock it does not count what else the machine does."""
    return sum(u.ru_utime + u.ru_stime for u in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)))


def write_report(data, out):
    text = (ROOT / "docs" / "report" / "report.md.in").read_text(encoding="utf-8")
    try:
        known = {name: value for name, value in template.load(ROOT / "docs" / "data").items()
                 if f"{name}.json" in set().union(*UNASKED.values())}  # measured where other programs are installed
        (out / "report.md").write_text(template.fill(text, known | template.load(data)), encoding="utf-8")
    except KeyError as error:
        sys.exit(f"{error.args[0]}; run the chapter that makes it")


def need_plotting():
    """Ends with 77, which tests understand as skipped, where matplotlib is missing."""
    try:
        import matplotlib  # noqa: F401  pylint: disable=import-outside-toplevel,unused-import
    except ImportError:
        print("figures need matplotlib: ./run figures installs it (Debian: python3-matplotlib)", file=sys.stderr)
        sys.exit(77)


def work(arguments, out, scratch):
    from studio import Studio, progress  # pylint: disable=import-outside-toplevel
    studio = Studio(arguments.etendue, arguments.sculpt, arguments.mutate, out, arguments.device, arguments.quick, scratch)
    times = studio.data / "time_figures.json"
    seconds = json.loads(times.read_text(encoding="utf-8"))["cpu_seconds"] if times.exists() else {}
    for name in arguments.only:
        start, used = time.monotonic(), cpu_seconds()
        importlib.import_module(f"chapters.{name}").run(studio)
        used = cpu_seconds() - used
        progress(f"{name}: {time.monotonic() - start:.0f} s, {used:.0f} s of processor time")
        if name in CHAPTERS:
            seconds[name] = used
    studio.keep_data("time_figures", {"machine": describe_machine(studio), "cpu_seconds": seconds, "cpu_sum": sum(seconds.values())})
    if arguments.only == CHAPTERS or not arguments.out:  # a single chapter in a folder of its own is no report
        write_report(studio.data, out)
    progress(f"{len(studio.made)} files; all chapters together take {sum(seconds.values()) / 60:.1f} minutes of processor time")
    return studio


def check_quick(studio, out):
    """Every picture and every table that docs has was made, and nothing else: a new figure is committed with its picture."""
    wanted = {path.name for folder in ("images", "data") for path in (ROOT / "docs" / folder).iterdir()} - set().union(*UNASKED.values())
    made = {path.name for path in studio.made}
    for name in sorted(wanted - made):
        print(f"docs has {name}, but no chapter makes it")
    for name in sorted(made - wanted):
        print(f"a chapter makes {name}, but docs does not have it")
    left = "{{" in (out / "report.md").read_text(encoding="utf-8")
    if left:
        print("the report still holds placeholders")
    return 1 if wanted != made or left else 0


def main():
    arguments = options()
    if arguments.text:
        write_report(ROOT / "docs" / "data", ROOT / "docs")
        return 0
    if not arguments.etendue or not arguments.sculpt or not arguments.mutate:
        sys.exit("figures.py needs --etendue, --sculpt and --mutate, the paths of three programs; ./run figures gives them")
    need_plotting()
    scratch = Path(tempfile.mkdtemp(prefix="etendue-figures-"))
    try:
        out = arguments.out or (scratch / "docs" if arguments.quick else ROOT / "docs")
        studio = work(arguments, out, scratch)
        return check_quick(studio, out) if arguments.quick and arguments.only == CHAPTERS else 0
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
