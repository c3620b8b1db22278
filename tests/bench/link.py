# SPDX-License-Identifier: GPL-3.0-or-later
"""usage: link.py FOLDER    what a point costs on the wire; FOLDER holds tetragauge and tetragauge-emulator

A scan of a plate on which every beam gives a point, counted by a relay between host and machine. Stream items, resent
ones included, are told apart by their channel; the rest is heartbeats, replies and whatever got broken.
"""
import json
import os
import select
import socket
import subprocess
import sys
import tempfile
import threading
import time

BAUD = 921600
BYTES_A_SECOND = BAUD / 10  # 8N1
MOST_BYTES_A_POINT = 14
STREAM = 4  # channel
PLAN = {'pitch_mm': 1, 'samples': 36, 'window_mm': {'y': [-35, 35], 'up': [-20, 20]}, 'views': [{'table_deg': 0, 'slide_mm': 180}]}
LINES = [('clean', ''), ('1e-4 of the bytes flipped', 'link_flip=1e-4'), ('1e-3 of the bytes flipped', 'link_flip=1e-3')]


class Relay(threading.Thread):
    """Between one host and the machine; counts what goes to the host."""

    def __init__(self, path, machine):
        super().__init__(daemon=True)
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(path)
        self.listener.listen(1)
        self.machine = machine
        self.to_host = bytearray()
        self.came = []  # (when, bytes) of it
        self.to_machine = 0

    def run(self):
        try:
            self.pass_on()
        except BrokenPipeError:
            pass  # the one that spoke last has gone

    def pass_on(self):
        host, _ = self.listener.accept()
        machine = socket.socket(socket.AF_UNIX)
        machine.connect(self.machine)
        while True:
            for source in select.select([host, machine], [], [])[0]:
                data = source.recv(65536)
                if not data:
                    return
                if source is machine:
                    self.to_host += data
                    self.came.append((time.monotonic(), data))
                    host.sendall(data)
                else:
                    self.to_machine += len(data)
                    machine.sendall(data)


def stream_bytes(data):
    # The channel is a frame's first byte and is not 0: COBS leaves it in second place, after the code byte.
    return sum(len(frame) + 1 for frame in bytes(data).split(b'\0') if len(frame) > 1 and frame[1] == STREAM)


def measure(programs, folder, faults):
    machine_path, relay_path = os.path.join(folder, 'machine'), os.path.join(folder, 'relay')
    command = [os.path.join(programs, 'tetragauge-emulator'), '--part', 'plate.csg', '--listen', 'unix:' + machine_path, '--one-host']
    machine = subprocess.Popen(command + (['--faults', faults] if faults else []), cwd=folder, stdout=subprocess.PIPE)
    machine.stdout.readline()
    relay = Relay(relay_path, machine_path)
    relay.start()
    done = subprocess.run([os.path.join(programs, 'tetragauge'), 'scan', '--port', 'unix:' + relay_path, '--plan', 'plan.json', '--quiet',
                           '--out', 'scan.ply', '--json', '-'], cwd=folder, check=True, capture_output=True)
    relay.join(10)
    machine.wait(10)
    os.remove(relay_path)
    return json.loads(done.stdout), relay


def main():
    programs = os.path.abspath(sys.argv[1])
    print(f'line of {BAUD} baud, 8N1; a plate, 1 mm pitch, 36 samples')
    print(f'{"line":<28}{"points":>8}{"beams":>8}{"bytes a point":>15}{"all bytes":>11}{"points/s it carries":>21}{"to machine":>12}')
    worst = 0
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, 'plate.csg'), 'w', encoding='utf-8') as file:
            file.write('cube(size = [90, 90, 20], center = false);\n')
        with open(os.path.join(folder, 'plan.json'), 'w', encoding='utf-8') as file:
            json.dump(PLAN, file)
        for name, faults in LINES:
            counts, relay = measure(programs, folder, faults)
            points = counts['points'] + counts['table_points_dropped']
            a_point, everything = stream_bytes(relay.to_host) / points, len(relay.to_host) / points
            if not faults:
                worst = a_point
            print(f'{name:<28}{points:>8}{counts["beams"]:>8}{a_point:>15.2f}{everything:>11.2f}{BYTES_A_SECOND / everything:>21.0f}'
                  f'{relay.to_machine / points:>12.2f}')
    if worst > MOST_BYTES_A_POINT:
        sys.exit(f'more than {MOST_BYTES_A_POINT} bytes a point on a clean line')


if __name__ == '__main__':
    main()
