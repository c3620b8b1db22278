# SPDX-License-Identifier: GPL-3.0-or-later
"""usage: pipeline.py TETRAGAUGE MODEL [POINTS...]

Without POINTS: time per stage from points to verdict, each the median of three runs. With POINTS (such as 1e5 1e6 3e6): one run each of
`reconstruct` and `faces`, reading and writing included: seconds of wall clock, seconds of all cores, and memory at its peak.
"""
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time

RUNS = 3


def machine():
    name = platform.machine()
    with open('/proc/cpuinfo', encoding='utf-8') as file:
        for line in file:
            if line.startswith('model name'):
                name = line.split(':', 1)[1].strip()
                break
    return f'{name}, {os.cpu_count()} cores'


def run_and_measure(command):
    """Wall clock and processor seconds, and the peak of resident memory in MB."""
    start = time.monotonic()
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f'{" ".join(command)}: exit code {process.returncode}')
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def time_and_memory(program, model, counts):
    print(f'machine: {machine()}; one run each')
    print(f'{"points":>8}' + ''.join(f'{name:>22}' for name in ('reconstruct wall s', 'cores s', 'MB', 'faces wall s', 'cores s', 'MB')))
    with tempfile.TemporaryDirectory() as folder:
        scan = os.path.join(folder, 'scan.ply')
        for points in counts:
            subprocess.run([program, 'simulate', '--model', model, '--out', scan, '--points', str(points), '--sigma', '0.02', '--quiet'],
                           check=True)
            figures = run_and_measure([program, 'reconstruct', scan, '--out', os.path.join(folder, 'mesh.ply'), '--quiet'])
            figures += run_and_measure([program, 'faces', scan, '--quiet'])
            print(f'{points:>8}' + ''.join(f'{value:>22.{0 if k % 3 == 2 else 2}f}' for k, value in enumerate(figures)), flush=True)


def main():
    program, model = (os.path.abspath(a) for a in sys.argv[1:3])
    if len(sys.argv) > 3:
        time_and_memory(program, model, [int(float(a)) for a in sys.argv[3:]])
        return
    print(f'machine: {machine()}; seconds, median of {RUNS} runs')
    head = None
    with tempfile.TemporaryDirectory() as folder:
        for points in (1000, 10000, 100000):
            scan = os.path.join(folder, 'scan.ply')
            subprocess.run([program, 'simulate', '--model', model, '--out', scan, '--points', str(points), '--sigma', '0.02', '--quiet'],
                           check=True)
            rows, read = [], 0
            for _ in range(RUNS):
                start = time.monotonic()
                done = subprocess.run([program, 'inspect', scan, '--model', model, '--out', os.path.join(folder, 'report'), '--quiet',
                                       '--json', '-'], check=True, capture_output=True)
                whole = time.monotonic() - start
                report = json.loads(done.stdout)
                read = report['reconstruction']['points']
                rows.append({**report['timing_s'], 'whole command': whole})
            if head is None:
                head = list(rows[0])
                print(f'{"points":>8}' + ''.join(f'{name:>15}' for name in head))
            print(f'{read:>8}' + ''.join(f'{statistics.median(row[name] for row in rows):>15.3f}' for name in head))


if __name__ == '__main__':
    main()
