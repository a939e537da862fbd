"""Where the chapters work: runs etendue, keeps pictures and data, knows whether a quick run is wanted."""
import csv
import hashlib
import json
import os
import resource
import statistics
import subprocess
import sys
import time
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
from PIL import Image

import exr

ROOT = Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes"
MADE = "etendue:"  # begins the names of files that the build makes for scenes
LUMINANCE = np.array([0.212671, 0.715160, 0.072169])


class Render:
    """What one `etendue render` left behind."""

    def __init__(self, path, report=None, cpu=0.0):
        self.path = path
        self.report = report
        self.seconds = report["render_seconds"] if report else 0.0
        self.cpu = cpu  # processor time of the whole run, seconds

    def rgb(self):
        """Picture and standard error, both [height, width, 3]."""
        return exr.rgb(self.path)

    def png(self):
        return self.path.with_suffix(".png")

    def variance(self):
        """Mean over pixels and channels of the variance of one sample: StdErr² · samples."""
        planes = exr.read(self.path)
        squares = np.mean([np.mean(planes["StdErr." + c].astype(np.float64) ** 2 * planes["SampleCount"]) for c in "RGB"])
        return float(squares)


class Studio:
    def __init__(self, etendue, sculpt, mutate, out, device, quick, scratch):
        self.program = Path(etendue).resolve()
        self.sculptor = Path(sculpt).resolve()
        self.mutator = Path(mutate).resolve()
        self.images = Path(out) / "images"
        self.data = Path(out) / "data"
        self.device = device
        self.quick = quick
        self.scratch = Path(scratch)
        self.made = []
        for folder in (self.images, self.data, self.scratch):
            folder.mkdir(parents=True, exist_ok=True)

    def pick(self, full, quick):
        """`full` for the report, `quick` for the test that only looks whether all is produced."""
        return quick if self.quick else full

    def etendue(self, *arguments, accept=(0,), environment=None):
        return self.run(self.program, *arguments, accept=accept, environment=environment)

    def run(self, program, *arguments, accept=(0,), environment=None):
        """Runs a command and returns what it printed. Ends with its message when it fails."""
        command = [str(program), *map(str, arguments)]
        result = subprocess.run(command, capture_output=True, text=True, cwd=self.scratch,
                                env={**os.environ, **(environment or {})}, check=False)
        if result.returncode not in accept:
            sys.exit(f"'{' '.join(command)}' ended with exit code {result.returncode}:\n{result.stderr}")
        return result.stdout

    def json(self, *arguments, accept=(0,), environment=None):
        return json.loads(self.etendue(*arguments, accept=accept, environment=environment))

    def json_file(self, *arguments, accept=(0,)):
        """For JSON in a file, beside the text on stdout."""
        return self.json_file_of(self.program, *arguments, accept=accept)

    def json_file_of(self, program, *arguments, accept=(0,)):
        path = self.scratch / "result.json"
        self.run(program, *arguments, f"--json={path}", accept=accept)
        return json.loads(path.read_text(encoding="utf-8"))

    def device_options(self, device=None):
        device = device or self.device
        return ["--device", device] if device else []

    def render(self, scene, name, spp=None, size=None, seed=0, define=(), samples=None, device=None, more=(),
               environment=None):
        """Renders scene (a path, or a name in scenes/) to <scratch>/<name>.exr and .png."""
        path = self.scratch / f"{name}.exr"
        command = ["render", self.scene(scene), "--force", "-q", "--json", "--seed", seed, "-o", path, "-o", path.with_suffix(".png")]
        command += ["--spp", spp] if spp else []
        command += ["--size", f"{size[0]}x{size[1]}"] if size else []
        command += ["--samples", f"{samples[0]}:{samples[1]}"] if samples else []
        for definition in define:
            command += ["-D", definition]
        command += self.device_options(device)
        before = child_seconds()
        report = json.loads(self.etendue(*command, *more, environment=environment))
        return Render(path, report, child_seconds() - before)

    def costs(self, scene, spp, size, ways, repeats):
        """Seconds of a sample per pixel for each way (a list of -D definitions by name): medians over interleaved runs, so that all see the same
        machine. A driver that computes on the processor is measured by the processor's time, which other programs do not disturb; a run of
        one sample is taken off for reading the scene and compiling the kernel."""
        on_processor = self.driver_on_processor()
        costs = {way: [] for way in ways}
        for i in range(repeats):
            for way, define in ways.items():
                long = self.render(scene, f"cost-{way}", spp=spp, size=size, seed=i, define=define)
                short = long if self.quick else self.render(scene, f"cost-{way}", spp=1, size=size, seed=i, define=define)
                costs[way].append((long.cpu - short.cpu) / (spp - 1) if on_processor else long.seconds / spp)
        return {way: max(statistics.median(values), 1e-9) for way, values in costs.items()}

    def driver_on_processor(self):
        """True for lavapipe and its like."""
        name = self.render("siemens-star", "which-device", spp=1, size=(8, 8)).report["devices"][0]["device"]
        return any(device["name"] == name and device["type"] == "CPU" for device in self.json("devices", "--json"))

    def scene(self, scene):
        """The file of a scene; in a quick run one with small meshes in place of the large ones that the build sculpts."""
        if isinstance(scene, Path):
            return scene
        path = SCENES / f"{scene}.xml"
        if self.quick and MADE in path.read_text(encoding="utf-8"):
            return self.variant(path, f"{path.stem}-small", self.shrink_meshes)
        return path

    def asset(self, name):
        """The file of a glTF asset that the build makes, here made once more: a quick run has none."""
        path = self.scratch / name
        self.run(self.sculptor, "--kind", path.stem, "-o", path)
        return path

    def shrink_meshes(self, root):
        for entry in root.iter("string"):
            value = entry.get("value")
            if value.startswith(MADE):
                mesh = Path(value.removeprefix(MADE))
                small = self.scratch / mesh
                if not small.exists():
                    self.run(self.sculptor, *self.small(mesh), "-o", small)
                entry.set("value", str(small))

    @staticmethod
    def small(mesh):
        """What scenes/CMakeLists.txt asks the sculptor for, in small."""
        if mesh.suffix == ".png":
            return "--picture", mesh.stem, "--size", 64
        return "--kind", {"lantern": "bumpy-sphere"}.get(mesh.stem, mesh.stem), "--triangles", 1000

    def variant(self, scene, name, change):
        """A changed copy of a scene in the scratch folder: `change` gets the root element. Meshes keep their places."""
        source = self.scene(scene)
        tree = xml.parse(source)
        for entry in tree.iter("string"):
            if entry.get("name") == "filename" and not entry.get("value").startswith(MADE):
                entry.set("value", str((source.parent / entry.get("value")).resolve()))
        change(tree.getroot())
        path = self.scratch / f"{name}.xml"
        tree.write(path, encoding="utf-8", xml_declaration=True)
        return path

    # What is kept.

    def keep_picture(self, name, source, crop=None, zoom=1):
        """A PNG for the report from a PNG file or an array of linear radiance; `crop` is (left, top, width, height)."""
        image = Image.fromarray(to_srgb(source)) if isinstance(source, np.ndarray) else Image.open(source).convert("RGB")
        if crop:
            image = image.crop((crop[0], crop[1], crop[0] + crop[2], crop[1] + crop[3]))
        if zoom > 1:
            image = image.resize((image.width * zoom, image.height * zoom), Image.Resampling.NEAREST)
        path = self.images / f"{name}.png"
        image.save(path, optimize=True)
        self.made.append(path)
        return path

    def keep_photo(self, name, source):
        """A JPEG from a PNG file: a large picture in a tenth of the bytes."""
        path = self.images / f"{name}.jpg"
        Image.open(source).convert("RGB").save(path, quality=88, optimize=True, progressive=True, subsampling=0)
        self.made.append(path)
        return path

    def keep_image(self, name, image, colors):
        """A small PNG of at most so many colours."""
        path = self.images / f"{name}.png"
        image.quantize(colors, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)
        self.made.append(path)

    def keep_plot(self, name, figure):
        import plots  # pylint: disable=import-outside-toplevel
        path = self.images / f"{name}.svg"
        plots.save(figure, path)
        self.made.append(path)

    def keep_data(self, name, values):
        path = self.data / f"{name}.json"
        path.write_text(json.dumps(rounded(values), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        self.made.append(path)

    def keep_table(self, name, rows):
        """Rows (dictionaries with equal keys) as CSV."""
        path = self.data / f"{name}.csv"
        with open(path, "w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rounded(rows))
        self.made.append(path)


def rounded(value):
    """Floats to seven significant digits: as many as a float32 picture carries."""
    if isinstance(value, dict):
        return {key: rounded(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(entry) for entry in value]
    if isinstance(value, (float, np.floating)):
        return float(f"{value:.7g}")
    if isinstance(value, np.integer):
        return int(value)
    return value


def to_srgb(linear):
    """Linear radiance to 8-bit sRGB, clamped, as `etendue` writes PNG files."""
    linear = np.clip(linear, 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return (encoded * 255 + 0.5).astype(np.uint8)


def luminance(picture):
    return picture @ LUMINANCE


def child_seconds():
    """Processor time of all programs run so far."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def sha256(path):
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def progress(text):
    print(f"[{time.strftime('%H:%M:%S')}] {text}", file=sys.stderr, flush=True)
