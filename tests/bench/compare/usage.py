"""Runs a command and writes what it took into a file: usage.py FILE SECONDS COMMAND …; it is ended after so many
seconds, 0 for never.

A process of its own, because before a program starts it is a copy of the one that starts it, and the most memory that
either had resident counts as the program's: this one is small.
"""

import json
import os
import signal
import sys
import time


def main():
    start = time.monotonic()
    child = os.fork()
    if child == 0:
        try:
            os.setpgid(0, 0)  # so that it ends with its children
            os.execvp(sys.argv[3], sys.argv[3:])
        except OSError as reason:
            print(f'{sys.argv[3]} cannot be started: {reason.strerror}.', file=sys.stderr, flush=True)
            os._exit(127)
    limit = float(sys.argv[2])
    if limit > 0.0:
        signal.signal(signal.SIGALRM, lambda *_: os.killpg(child, signal.SIGKILL))
        signal.setitimer(signal.ITIMER_REAL, limit)
    _, status, usage = os.wait4(child, 0)
    seconds = time.monotonic() - start
    with open(sys.argv[1], 'w', encoding='utf-8') as file:
        cpu = usage.ru_utime + usage.ru_stime
        code = os.waitstatus_to_exitcode(status)
        json.dump({'code': code, 'seconds': seconds, 'cpu_seconds': cpu, 'peak_bytes': 1024 * usage.ru_maxrss}, file)


if __name__ == '__main__':
    main()
