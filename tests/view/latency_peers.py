"""What latency_mitsuba.py and latency_cycles.py share: starts a Python program again and again, and tells the medians of its times."""

import os
import statistics
import subprocess
import sys
import time


def measure(program, arguments, rounds, environment=None):
    """Runs `python -c program arguments… START`, where START is the time of the start in seconds. The program prints lines
    `LATENCY what milliseconds`; `what` is first, drag or full."""
    times = {"first": [], "drag": [], "full": []}
    for _ in range(rounds):
        told = subprocess.run([sys.executable, "-c", program, *arguments, str(time.time())], check=True, capture_output=True, text=True,
                              env={**os.environ, **(environment or {})})
        for line in told.stdout.splitlines():
            if line.startswith("LATENCY"):
                _, what, milliseconds = line.split()
                times[what].append(float(milliseconds))
    for what, values in times.items():
        print(f"{what}: median {statistics.median(values):.0f} ms, {min(values):.0f} to {max(values):.0f}, of {len(values)}")
