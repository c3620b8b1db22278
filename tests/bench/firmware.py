#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""usage: firmware.py BIN [--check] [--runs N]

What the firmware asks of a Cortex-M4F, counted by QEMU's mps2-an386 an instruction at a time (not in cycles: a chip adds its
flash's wait states), beside its budgets. --check: exit code 1 when one is exceeded. --runs N: scans the staircase N times on
mps2_an386 besides, and fails unless trace, points and every count of instructions are equal; takes a minute for each run.
"""
import argparse
import hashlib
import os
import subprocess
import sys
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')
STAIRCASE = os.path.join(ROOT, 'examples', 'staircase', 'actual.csg')
FAST_SAMPLES = 8  # with the laser on: what 2,000 points/s leave time for
# 2,000 points/s are to leave half of 168 MHz: 42,000 cycles a point, at two an instruction (the flash makes it wait).
WHOLE_POINT = 20000
LIMITS = {
    'optics solve and judgement': 10000,
    'encode + CRC + COBS': 1600,
    'next step is ready after the edge, both axes, worst': 312,  # half of the time between two steps
}


def count_in_qemu(image):
    done = subprocess.run(['qemu-system-arm', '-M', 'mps2-an386', '-display', 'none', '-monitor', 'none', '-serial', 'none', '-icount',
                           'shift=3,sleep=off', '-semihosting-config', 'enable=on,target=native', '-kernel', image],
                          capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=240, check=True)
    return {line.rsplit(',', 1)[0]: float(line.rsplit(',', 1)[1]) for line in done.stdout.splitlines()[1:]}


def scan(bin_folder, folder, name, part, board, plan=None):
    """One scan of a machine of its own: what `--work` says, and the trace and points as one hash."""
    port = f'unix:{name}.sock'
    command = [os.path.join(bin_folder, 'tetragauge-emulator'), '--part', part, '--board', board, '--listen', port, '--one-host',
               '--place=90,0,0,0,0,0', '--trace', f'{name}.trace']
    emulator = subprocess.Popen(command + (['--work', f'{name}.work'] if board != 'emulated' else []), cwd=folder,
                                stdout=subprocess.PIPE, text=True)
    try:
        emulator.stdout.readline()
        subprocess.run([os.path.join(bin_folder, 'tetragauge'), 'scan', '--port', port, '--out', f'{name}.ply', '--quiet',
                        *(['--plan', plan] if plan else [])], cwd=folder, check=True)
    finally:
        emulator.communicate(timeout=60)
    read = lambda suffix: open(os.path.join(folder, name + suffix), 'rb').read()
    points = b'\n'.join(line for line in read('.ply').split(b'\n') if not line.startswith(b'comment machine_id'))
    work = [line.split(',') for line in read('.work').decode().splitlines()[1:]] if board != 'emulated' else []
    rays = sum(int(line.split()[2]) for line in read('.ply').decode('latin-1').splitlines()[:60]
               if line.startswith(('element vertex', 'element rejected')))
    digest = hashlib.sha256(read('.trace') + points).hexdigest()[:16]
    return {(state, event): (int(turns), int(count)) for state, event, turns, count in work if event != 'line'}, digest, rays


def whole_point(bin_folder):
    """Instructions a ray in a fast scan, points and rejected ones: interrupts, main loop, and what talks to the world."""
    with tempfile.TemporaryDirectory(prefix='tetragauge-') as folder:
        with open(os.path.join(folder, 'plan.json'), 'w', encoding='utf-8') as file:
            file.write('{"pitch_mm": 1, "samples": %d, "views": [{"table_deg": -175, "slide_mm": 100, '
                       '"window_mm": {"y": [-30, 30], "up": [-30, 30]}}]}' % FAST_SAMPLES)
        work, _, _ = scan(bin_folder, folder, 'fast', STAIRCASE, 'mps2_an386', 'plan.json')
        rays = work['SCANNING', 'alarm'][0] / 3  # settled, laser risen, laser fallen
        return sum(work['SCANNING', event][1] for event in ('alarm', 'samples', 'poll')) / rays


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('bin')
    parser.add_argument('--check', action='store_true')
    parser.add_argument('--runs', type=int, default=0)
    arguments = parser.parse_args()
    bin_folder = os.path.abspath(arguments.bin)
    counts = count_in_qemu(os.path.join(bin_folder, '..', 'images', 'mps2_an386', 'instructions.elf'))
    counts[f'whole point at {FAST_SAMPLES} samples'] = whole_point(bin_folder)
    limits = {**LIMITS, f'whole point at {FAST_SAMPLES} samples': WHOLE_POINT}
    print('instructions of a Cortex-M4F (QEMU mps2-an386, -icount)')
    faults = []
    for what, count in counts.items():
        print(f'  {count:9.2f}  {what}' + (f', at most {limits[what]}' if what in limits else ''))
        if count > limits.get(what, count):
            faults.append(f'{what}: {count:.0f} instructions are more than {limits[what]}')
    if arguments.runs:
        with tempfile.TemporaryDirectory(prefix='tetragauge-') as folder:
            _, wanted, rays = scan(bin_folder, folder, 'emulated', STAIRCASE, 'emulated')
            works = []
            for run in range(arguments.runs):
                work, digest, _ = scan(bin_folder, folder, f'run{run}', STAIRCASE, 'mps2_an386')
                works.append(work)
                same = digest == wanted and work == works[0]
                print(f'  staircase, run {run + 1}: trace and points {digest} of {rays} beams, {sum(n for _, n in work.values())} instructions, '
                      f'{"same" if same else "DIFFERENT"}', flush=True)
                if not same:
                    faults.append(f'run {run + 1} of the staircase differs (emulated: {wanted})')
    for fault in faults:
        print(f'firmware.py: {fault}', file=sys.stderr)
    sys.exit(1 if faults and (arguments.check or arguments.runs) else 0)


main()
