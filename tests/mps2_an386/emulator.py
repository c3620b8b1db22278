# SPDX-License-Identifier: GPL-3.0-or-later
"""tetragauge-emulator on a socket, with what it writes about a session: its trace, and the work of an image's processor."""
import csv
import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'end_to_end'))
import command_line as cl  # noqa: E402


class Emulator:
    """Serves one host; ends with it."""

    def __init__(self, folder, name, part, board, *options):
        self.folder, self.name = folder, name
        self.port = f'unix:{name}.sock'
        command = [os.path.join(cl.BIN, 'tetragauge-emulator'), '--part', part, '--board', board, '--listen', self.port, '--one-host',
                   '--trace', f'{name}.trace', *options]
        if board == 'mps2_an386':
            command += ['--work', f'{name}.work']
        self.process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if self.process.stdout.readline().strip() != self.port:
            raise AssertionError(self.process.communicate()[1])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()

    def ended(self):
        """Exit code and what it said, after its host has gone."""
        said = self.process.communicate(timeout=300)[1]
        return self.process.returncode, said

    def trace(self):
        with open(os.path.join(self.folder, self.name + '.trace'), encoding='utf-8') as file:
            return file.read()

    def work(self):
        """(state, event) -> (turns, instructions)"""
        with open(os.path.join(self.folder, self.name + '.work'), encoding='utf-8') as file:
            return {(row['state'], row['event']): (int(row['turns']), int(row['instructions'])) for row in csv.DictReader(file)}


def children(pid):
    """Processes that this one has started: of the emulator, the QEMU that runs the image."""
    with open(f'/proc/{pid}/task/{pid}/children', encoding='ascii') as file:
        return [int(child) for child in file.read().split()]


def of_the_machine(work):
    """Without the host's frames: how often it asks depends on how long it waited."""
    return {key: counts for key, counts in work.items() if key[1] != 'line'}


def without_machine_id(scan):
    """A scan file but for the one line that names the board."""
    return b'\n'.join(line for line in scan.split(b'\n') if not line.startswith(b'comment machine_id '))
