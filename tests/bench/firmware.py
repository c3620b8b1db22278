#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""usage: firmware.py BIN [--check] [--runs N]

What the firmware asks of a Cortex-M4F, counted by QEMU's mps2-an386 an instruction at a time (not in cycles: a chip adds its
flash's wait states), beside its budgets. --check: exit code 1 when one is exceeded. --runs N: scans the staircase N times on
mps2_an386 besides, and fails unless trace, points and every count of instructions are equal; takes a minute for each run.
"""
import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')
sys.path.insert(0, os.path.join(ROOT, 'tests', 'mps2_an386'))
from link import Relay  # noqa: E402
from serial_qemu import PATIENCE_S, SerialQemu  # noqa: E402

UART_OPTIONS = ['-semihosting-config', 'enable=on,target=native']
STAIRCASE = os.path.join(ROOT, 'examples', 'staircase', 'actual.csg')
# With the laser on; as many off. A converter of 100,000 samples/s leaves time for 8 at 2,000 points/s; 36 are the default.
SAMPLES = (8, 36)
# 2,000 points/s are to leave half of 168 MHz: 42,000 cycles a point, at two an instruction (the flash makes it wait).
WHOLE_POINT = 20000
LIMITS = {
    'optics solve and judgement': 10000,
    'encode + CRC + COBS': 1600,
    # 840 cycles between two steps at 200 kHz, two an instruction; at speed, where a move stays, half of QEMU's 625.
    'next step is ready after the edge, both axes speeding up, worst': 420,
    'next step is ready after the edge, both axes at 200 kHz, worst': 312,
}


def count_in_qemu(image):
    done = subprocess.run(['qemu-system-arm', '-M', 'mps2-an386', '-display', 'none', '-monitor', 'none', '-serial', 'none', '-icount',
                           'shift=3,sleep=off', '-semihosting-config', 'enable=on,target=native', '-kernel', image],
                          capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=1800, check=True)
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
        emulator.communicate(timeout=300)
    read = lambda suffix: open(os.path.join(folder, name + suffix), 'rb').read()
    points = b'\n'.join(line for line in read('.ply').split(b'\n') if not line.startswith(b'comment machine_id'))
    work = [line.split(',') for line in read('.work').decode().splitlines()[1:]] if board != 'emulated' else []
    rays = sum(int(line.split()[2]) for line in read('.ply').decode('latin-1').splitlines()[:60]
               if line.startswith(('element vertex', 'element rejected')))
    digest = hashlib.sha256(read('.trace') + points).hexdigest()[:16]
    return {(state, event): (int(turns), int(count)) for state, event, turns, count in work if event != 'line'}, digest, rays


def whole_point(bin_folder, samples):
    """Instructions a ray in a fast scan, points and rejected ones: interrupts, main loop, and what talks to the world."""
    with tempfile.TemporaryDirectory(prefix='tetragauge-') as folder:
        with open(os.path.join(folder, 'plan.json'), 'w', encoding='utf-8') as file:
            file.write('{"pitch_mm": 1, "samples": %d, "views": [{"table_deg": -175, "slide_mm": 100, '
                       '"window_mm": {"y": [-30, 30], "up": [-30, 30]}}]}' % samples)
        work, _, _ = scan(bin_folder, folder, 'fast', STAIRCASE, 'mps2_an386', 'plan.json')
        rays = work['SCANNING', 'alarm'][0] / 3  # settled, laser risen, laser fallen
        return sum(work['SCANNING', event][1] for event in ('alarm', 'samples', 'poll')) / rays


def talk_over_uart(bin_folder):
    """How long answers take and how fast points come over QEMU's UART0 on a socket, by this computer's clock: what host, socket
    and the firmware's main loop cost, without the time that bytes take on a wire."""
    image = os.path.join(bin_folder, '..', 'images', 'mps2_an386', 'uart.elf')
    hello = os.path.join(bin_folder, 'tetragauge-hello')
    with SerialQemu('mps2-an386', image, *UART_OPTIONS) as machine, tempfile.TemporaryDirectory(prefix='tetragauge-') as folder:
        said = json.loads(machine.run_host(hello, '--port', machine.port, '--patience', str(PATIENCE_S), '--rounds', '2000', '--json').stdout)
        trip = said['round_trip']
        print('line: UART0 of mps2-an386 on a socket, by this computer\'s clock')
        print(f'  {trip["median_us"]:9d}  us a round trip of Status, median of {trip["rounds"]}; 99 % within {trip["p99_us"]}, worst {trip["worst_us"]}')
        plan = os.path.join(folder, 'plan.json')
        with open(plan, 'w', encoding='utf-8') as file:
            file.write('{"pitch_mm": 0.5, "samples": 2, "window_mm": {"y": [-20, 20], "up": [-15, 15]}, "views": [{"table_deg": -180, "slide_mm": 0}]}')
        relay = Relay(os.path.join(folder, 'relay'), machine.port.removeprefix('unix:'))
        relay.start()
        done = machine.run_host(os.path.join(bin_folder, 'tetragauge'), 'scan', '--port', 'unix:' + os.path.join(folder, 'relay'), '--plan', plan,
                                '--quiet', '--out', os.path.join(folder, 'scan.ply'), '--json', '-')
        if done.returncode != 0:
            sys.exit(f'firmware.py: the scan over UART0 ended with {done.returncode}: {done.stderr}')
        relay.join(10)
        beams = json.loads(done.stdout)['beams']
        streamed = relay.came
        # Most beams come within the stream's middle: from the first tenth of all bytes to the last.
        total, seen, begins, ends = sum(len(data) for _, data in streamed), 0, None, None
        for at, data in streamed:
            seen += len(data)
            if begins is None and seen >= 0.1 * total:
                begins, first = at, seen
            if seen <= 0.9 * total:
                ends, last = at, seen
        rate = (last - first) / (ends - begins)
        print(f'  {rate:9.0f}  bytes/s to the host while {beams} beams stream, {rate * beams / total:.0f} beams/s; 921,600 baud carry 92160 bytes/s')


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('bin')
    parser.add_argument('--check', action='store_true')
    parser.add_argument('--runs', type=int, default=0)
    arguments = parser.parse_args()
    bin_folder = os.path.abspath(arguments.bin)
    counts = count_in_qemu(os.path.join(bin_folder, '..', 'images', 'mps2_an386', 'instructions.elf'))
    limits = dict(LIMITS)
    for samples in SAMPLES:
        counts[f'whole point at {samples} samples'] = whole_point(bin_folder, samples)
        limits[f'whole point at {samples} samples'] = WHOLE_POINT
    print('instructions of a Cortex-M4F (QEMU mps2-an386, -icount)')
    faults = []
    for what, count in counts.items():
        print(f'  {count:9.2f}  {what}' + (f', at most {limits[what]}' if what in limits else ''))
        if count > limits.get(what, count):
            faults.append(f'{what}: {count:.0f} instructions are more than {limits[what]}')
    talk_over_uart(bin_folder)
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
