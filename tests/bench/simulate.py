#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
# usage: simulate.py TETRAGAUGE [MODEL...]
# Rays per second of `tetragauge simulate`, model read and file written: 8 views of 1000 x 1000 rays in a window that
# the part fills, so that nearly every second ray or more ends on it. Processor time (user and system) is counted over
# all threads: what one core does in a second, whatever else the computer is busy with; wall time beside it.
import math
import os
import resource
import subprocess
import sys
import tempfile
import time

VIEWS, RAYS = 8, 1000
# From four times the part's radius (simulate's own distance) its sphere fills twice asin(1/4).
WINDOW_DEG = 2 * math.degrees(math.asin(1 / 4))

PLATE = 'difference() { cube(size = [120, 80, 12], center = true);\n' + ''.join(
    f'multmatrix([[1, 0, 0, {x}], [0, 1, 0, {y}], [0, 0, 1, 0], [0, 0, 0, 1]]) '
    f'{{ cylinder($fn = 0, h = 20, r1 = {2 + (x + y) % 3}, r2 = {2 + (x + y) % 3}, center = true); }}\n'
    for x in range(-50, 51, 10) for y in range(-30, 31, 10)) + '}\n'


def processor_s():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def measure(program, name, model, out):
    before, start = processor_s(), time.monotonic()
    result = subprocess.run([program, 'simulate', '--model', model, '--out', out, '--views', str(VIEWS), '--window',
                             f'{WINDOW_DEG},{WINDOW_DEG}', '--rays', f'{RAYS},{RAYS}'], capture_output=True, text=True)
    wall, processor = time.monotonic() - start, processor_s() - before
    if result.returncode:
        sys.exit(f'simulate.py: {model}: {result.stderr}')
    rays = VIEWS * RAYS * RAYS
    points = int(result.stderr.split()[-2])
    print(f'{name:34} {rays:10} {points:10} {processor:11.2f} {rays / processor / 1e6:13.2f} {wall:7.2f} '
          f'{rays / wall / 1e6:13.2f}', flush=True)


def main():
    program, models = sys.argv[1], sys.argv[2:]
    print(f'{os.cpu_count()} cores')
    print(f'{"model":34} {"rays":>10} {"points":>10} {"processor s":>11} {"Mrays/s, core":>13} {"wall s":>7} '
          f'{"Mrays/s, wall":>13}')
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, 'scan.ply')
        plate = os.path.join(folder, 'plate.csg')
        with open(plate, 'w', encoding='utf-8') as file:
            file.write(PLATE)
        measure(program, 'plate with 77 holes', plate, out)
        for model in models:
            measure(program, os.path.basename(model), model, out)


main()
