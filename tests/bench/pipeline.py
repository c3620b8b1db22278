# SPDX-License-Identifier: GPL-3.0-or-later
"""usage: pipeline.py TETRAGAUGE MODEL    time per stage from points to verdict, each the median of three runs"""
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


def main():
    program, model = (os.path.abspath(a) for a in sys.argv[1:3])
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
