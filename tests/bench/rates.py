#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
# usage: rates.py BIN_FOLDER PART
# How fast the emulated machine measures a matt plate, and how well, as a table: points per second of its own time, the
# scatter about the true face, and how far from it 95 % of the points lie. Rates are set by the number of samples of a
# point. Then how much faster than real time whole scans of PART run with a host attached. Read from scan and trace.
import json
import math
import os
import resource
import struct
import subprocess
import sys
import tempfile
import time

SAMPLES = [2, 8, 10, 12, 16, 36, 544]  # with the laser on, as many off
SPEED_RUNS = 3
PLATE_MM = (10, 60, 60)  # the raster ends well within it at 60 degrees too


def read_points(path):
    """[(x, y, z, sigma)] of a scan file as the host writes it."""
    with open(path, 'rb') as file:
        data = file.read()
    header, body = data.split(b'end_header\n', 1)
    count, names, formats, in_vertex = 0, [], '<', False
    for line in header.decode().splitlines():
        words = line.split()
        if words[0] == 'element':
            in_vertex = words[1] == 'vertex'
            count = int(words[2]) if in_vertex else count
        elif words[0] == 'property' and in_vertex:
            formats += {'double': 'd', 'float': 'f', 'uint': 'I', 'uchar': 'B', 'ushort': 'H', 'int': 'i'}[words[1]]
            names.append(words[2])
    columns = [names.index(name) for name in ('x', 'y', 'z', 'sigma')]
    rows = struct.iter_unpack(formats, body[:struct.calcsize(formats) * count])
    return [tuple(row[c] for c in columns) for row in rows]


def seconds_of_measuring(trace):
    """From the first light to the last, and how often the laser came on."""
    times, lights = [], 0
    with open(trace) as file:
        next(file)
        for line in file:
            time_ns, what, value = line.rstrip('\n').split(',')
            if what == 'laser':
                times.append(int(time_ns))
                lights += value == 'on'
    return (times[-1] - times[0]) * 1e-9, lights


def virtual_seconds(trace):
    with open(trace) as file:
        return int(file.readlines()[-1].split(',')[0]) * 1e-9


def scan_with_emulator(binaries, folder, emulator_options, scan_options):
    """Scan file, trace file, wall seconds, processor seconds of emulator and host together."""
    scan, trace, socket = (os.path.join(folder, name) for name in ('scan.ply', 'trace.csv', 'machine'))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    emulator = subprocess.Popen(
        [os.path.join(binaries, 'tetragauge-emulator'), *emulator_options, '--listen', 'unix:' + socket, '--trace', trace,
         '--one-host'], stdout=subprocess.PIPE, text=True)
    emulator.stdout.readline()
    started = time.monotonic()
    subprocess.run([os.path.join(binaries, 'tetragauge'), 'scan', '--port', 'unix:' + socket, '--out', scan, '--quiet',
                    *scan_options], check=True)
    wall = time.monotonic() - started
    emulator.wait()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return scan, trace, wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(binaries, folder, incidence_deg, samples):
    turn = math.radians(incidence_deg - 35)
    height = PLATE_MM[0] * abs(math.sin(turn)) + PLATE_MM[2] * math.cos(turn)
    part, plan = os.path.join(folder, 'plate.csg'), os.path.join(folder, 'plan.json')
    with open(part, 'w') as file:
        file.write(f'cube(size = {list(PLATE_MM)}, center = true);\n')
    with open(plan, 'w') as file:
        json.dump({'pitch_mm': 0.5, 'samples': samples,
                   'window_mm': {'y': [-8, 8], 'up': [-6, 6]},
                   'views': [{'table_deg': 0, 'slide_mm': round(200 - height / 2, 3)}]}, file)
    scan, trace, _, _ = scan_with_emulator(
        binaries, folder, ['--part', part, f'--place=0,{incidence_deg - 35},0,0,0,0'], ['--plan', plan])
    measuring, lights = seconds_of_measuring(trace)
    normal = (math.cos(turn), -math.sin(turn))
    d_mm = normal[1] * height / 2 + PLATE_MM[0] / 2
    along = math.cos(math.radians(incidence_deg))
    points = read_points(scan)
    off = sorted(abs(normal[0] * x + normal[1] * z - d_mm) for x, _, z, _ in points)
    return {'rate': (lights - 1) / measuring, 'points': len(points),
            'sigma': sum(p[3] for p in points) / len(points),
            'scatter': math.sqrt(sum(d * d for d in off) / len(off)) / along,
            'p95': off[math.ceil(0.95 * len(off)) - 1]}


def main():
    binaries, part = sys.argv[1:3]
    print('| incidence, degrees | samples | points/s | points | sigma along the ray as reported, mm | scatter along the ray, mm '
          '| 95 % of the points within +- mm of the face |')
    print('|---|---|---|---|---|---|---|')
    for incidence_deg in (0, 30, 60):
        for samples in SAMPLES:
            with tempfile.TemporaryDirectory(prefix='tetragauge-rates-') as folder:
                m = measure(binaries, folder, incidence_deg, samples)
            print(f"| {incidence_deg} | {samples} | {m['rate']:.0f} | {m['points']} | {m['sigma']:.4f} | {m['scatter']:.4f} "
                  f"| {m['p95']:.3f} |", flush=True)
    runs = []
    for _ in range(SPEED_RUNS):
        with tempfile.TemporaryDirectory(prefix='tetragauge-rates-') as folder:
            _, trace, wall, cpu = scan_with_emulator(binaries, folder, ['--part', part, '--place=90,0,0,0,0,0'],
                                                     ['--pitch', '1'])
            measured = virtual_seconds(trace)
        runs.append((wall, cpu))
    print(f'\nA whole scan of {part}, pitch 1 mm, 36 samples a point: {measured:.0f} s of the machine. Times real time, host '
          f'attached, {SPEED_RUNS} runs, load of the computer {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores:')
    print('by wall clock ' + ', '.join(f'{measured / wall:.0f}' for wall, _ in runs)
          + '; by processor time of emulator and host together ' + ', '.join(f'{measured / cpu:.0f}' for _, cpu in runs) + '.')


if __name__ == '__main__':
    main()
