#!/usr/bin/env python3
"""What Mesa's compiler for AMD GPUs makes of the kernels that render some scenes: a table in Markdown.

RADV compiles for any generation on its null device, without a GPU (RADV_FORCE_FAMILY). The scenes are compiled for the
CPU driver, whose constants the kernels get. Ends with 77 where a driver is missing; and with --most-vgprs, with 1 where a
kernel takes more vector registers, spills them, or has scratch memory.
"""

import argparse
import json
import os
import subprocess
import sys

COLUMNS = (("VGPRs", "VGPRs"), ("SGPRs", "SGPRs"), ("spilled VGPRs", "Spilled VGPRs"),
           ("spilled SGPRs", "Spilled SGPRs"), ("scratch", "Scratch size"), ("LDS", "LDS size"),
           ("waves per SIMD", "Subgroups per SIMD"), ("instructions", "Instructions"), ("code", "Code size"))


def manifests():
    """The manifests of the CPU driver and of RADV, if they are there."""
    found = []
    for folder in ("/usr/share", "/usr/local/share", "/etc"):
        folder = os.path.join(folder, "vulkan/icd.d")
        for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
            if name.startswith(("lvp_icd", "radeon_icd")) and "i686" not in name:
                found.append(os.path.join(folder, name))
    return found


def kernels(etendue, names, drivers, scenes):
    """What `etendue bench` says of each scene, compiled for a family, which has other names in other versions of Mesa."""
    for family in names:
        environment = dict(os.environ, RADV_FORCE_FAMILY=family)
        environment["VK_DRIVER_FILES"] = environment["VK_ICD_FILENAMES"] = ":".join(drivers)  # the second for older loaders
        run = subprocess.run([etendue, "bench", "--part", "kernels", "--repetitions", "0", "--device", "llvmpipe",
                              "--compiler", f"RADV {family.upper()}", "--json", *scenes],
                             env=environment, capture_output=True, text=True)
        if run.returncode == 0:
            return family, json.loads(run.stdout)["scenes"]
        if run.returncode > 0 and run.returncode != 4:
            sys.exit(run.stderr.strip() or f"etendue bench ended with {run.returncode}")
    # RADV ends the process where it does not know a family.
    print(f"Not compiled for {names[0]}: {run.stderr.strip() or 'the driver ended the process'}", file=sys.stderr)
    return names[0], []


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--etendue", required=True)
    parser.add_argument("--families", default="vega10,navi10,navi21,navi31/gfx1100")
    parser.add_argument("--most-vgprs", type=int)
    parser.add_argument("scenes", nargs="+")
    options = parser.parse_args()
    drivers = manifests()
    for driver, package in (("lvp_icd", "lavapipe"), ("radeon_icd", "RADV")):
        if not any(driver in d for d in drivers):
            print(f"{package} is missing, Mesa's driver that this needs; install mesa-vulkan-drivers.", file=sys.stderr)
            sys.exit(77)
    bad, compiler, rows, others = [], "", [], []
    for names in options.families.split(","):
        family, scenes = kernels(options.etendue, names.split("/"), drivers, options.scenes)
        for scene in scenes:
            compiler = scene["compiler"].split(", ")[-1]
            for kernel in scene["kernels"]:
                for part in kernel["parts"]:
                    values = part["statistics"]
                    if kernel["kernel"] == "render":
                        rows.append([family, scene["scene"]] + [str(values[key]) for _, key in COLUMNS])
                    else:
                        others.append((values["VGPRs"], values["Scratch size"]))
                    most = options.most_vgprs
                    if most and (values["VGPRs"] > most or values["Scratch size"] or values["Spilled VGPRs"]):
                        bad.append(f"{kernel['kernel']} of {scene['scene']} for {family}")
    if not rows:
        print("No kernel was compiled: RADV knows none of the families.", file=sys.stderr)
        sys.exit(77)
    header = ["GPU", "scene"] + [name for name, _ in COLUMNS]
    print(f"{compiler}:\n\n| " + " | ".join(header) + " |\n" + "|---" * 2 + "|---:" * len(COLUMNS) + "|")
    for row in rows:
        print("| " + " | ".join(row) + " |")
    print(f"\nThe kernel take_samples has at most {max(vgprs for vgprs, _ in others)} VGPRs, "
          f"and at most {max(scratch for _, scratch in others)} bytes of scratch.")
    if bad:
        sys.exit(f"More than {options.most_vgprs} vector registers, or some in memory: " + "; ".join(bad))


if __name__ == "__main__":
    main()
