"""One run of a program: what it printed, and what it took."""

import json
import os
import re
import subprocess
import sys
import tempfile

USAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'usage.py')


class TooLong(RuntimeError):
    """The program was ended at the limit of its time."""


class Run:
    """One process: what it printed, its wall-clock seconds, the CPU seconds of all its threads together, and the most
    memory that it had resident."""

    def __init__(self, command, threads, environment=None, limit=0):
        """`environment`: added to that of this process; None removes a variable. `limit`: seconds, 0 for none."""
        environment = {**os.environ, 'LP_NUM_THREADS': str(threads), **(environment or {})}  # LP: of Mesa's lavapipe
        environment = {name: value for name, value in environment.items() if value is not None}
        with (
            tempfile.TemporaryFile('w+', encoding='utf-8', errors='replace') as out,
            tempfile.NamedTemporaryFile('r', encoding='utf-8') as usage,
        ):
            starter = [sys.executable, '-S', '-E', USAGE, usage.name, str(limit)]
            subprocess.run([*starter, *command], stdout=out, stderr=subprocess.STDOUT, env=environment, check=True)
            out.seek(0)
            self.output = out.read()
            took = json.load(usage)
        self.seconds, self.cpu_seconds, self.peak_bytes = took['seconds'], took['cpu_seconds'], took['peak_bytes']
        if limit and took['code'] < 0 and self.seconds >= limit:
            raise TooLong(f'takes more than {limit} s')
        if took['code'] != 0:
            raise RuntimeError(f"'{' '.join(command)}' ended with code {took['code']}:\n{self.output[-2000:]}")

    def json(self):
        """The JSON object in the output; messages may stand before and after it."""
        start = re.search(r'^\{', self.output, re.MULTILINE)
        if not start:
            raise RuntimeError(f'no JSON in the output:\n{self.output[-2000:]}')
        return json.JSONDecoder().raw_decode(self.output[start.start() :])[0]
