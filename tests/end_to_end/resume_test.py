# SPDX-License-Identifier: GPL-3.0-or-later
"""A host killed at any moment, against its own emulator and against a separate one: resumed, the scan file is the same.

The moments are random (seeded): while it starts and surveys, or when its journal has grown to a random part of its size.
"""
import os
import random
import signal
import subprocess
import time

import command_line as cl

MOMENTS = 10
ORDER_BYTES = 1000  # a journal larger than this has its plan
PART = 'cube(size = [40, 30, 20], center = false);\n'


class Resume(cl.CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write('part.csg', PART)
        self.random = random.Random(20261122)
        self.journal = self.path('scan.ply.journal')

    def start(self, *machine):
        host = subprocess.Popen([os.path.join(cl.BIN, 'tetragauge'), 'scan', *machine, '--out', 'scan.ply'],
                                cwd=self.folder, stderr=subprocess.PIPE)
        self.addCleanup(host.stderr.close)
        self.addCleanup(host.wait)
        self.addCleanup(host.kill)
        return host

    def journal_size(self):
        try:
            return os.path.getsize(self.journal)
        except FileNotFoundError:
            return 0

    def watch(self, host, until):
        """Waits until the journal has grown so large, or the host has ended; the largest size seen, and for how long."""
        start, largest = time.monotonic(), 0
        while host.poll() is None and largest < until:
            largest = max(largest, self.journal_size())
            time.sleep(0.001)
        return largest, time.monotonic() - start

    def clean_scan(self, *machine):
        """Its bytes, how large its journal got, and how long it took until that grew."""
        host = self.start(*machine)
        _, starting = self.watch(host, ORDER_BYTES)
        largest, _ = self.watch(host, 1 << 40)
        self.assertEqual(host.wait(), 0, host.stderr.read())
        clean = self.read('scan.ply')
        os.remove(self.path('scan.ply'))
        return clean, largest, starting

    def kill_and_resume(self, at_size, at_time, *machine):
        """How large the journal was when the host was killed."""
        host = self.start(*machine)
        if at_size > 0:
            self.watch(host, at_size)
        else:
            time.sleep(at_time)
        host.send_signal(signal.SIGKILL)
        host.wait()
        size = self.journal_size()
        if os.path.exists(self.path('scan.ply')):
            self.assertEqual(size, 0, 'finished before it could be killed')
            return 0
        done = self.run_command('scan', '--out', 'scan.ply', '--resume')
        if size < ORDER_BYTES and done.returncode == 3:  # before it was kept what to scan
            self.assertIn('scan without --resume', done.stderr)
            done = self.run_command('scan', *machine, '--out', 'scan.ply')
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertFalse(os.path.exists(self.journal))
        return size

    def kill_at_random_moments(self, *machine):
        clean, largest, starting = self.clean_scan(*machine)
        sizes = []
        for _ in range(MOMENTS):
            part = self.random.uniform(-0.2, 1)  # below 0: while it starts and surveys
            at_time = self.random.uniform(0, starting)
            sizes.append(self.kill_and_resume(int(part * largest), at_time, *machine))
            self.assertEqual(self.read('scan.ply'), clean, f'journals were {sizes} bytes of {largest}')
            os.remove(self.path('scan.ply'))
        self.assertGreaterEqual(sum(size > ORDER_BYTES for size in sizes), MOMENTS // 2, sizes)

    def test_stopped_by_the_user(self):
        machine = ('--emulated', 'part.csg', '--pitch', '1', '--operator', 'A. B', '--part-serial', '7')
        clean, largest, _ = self.clean_scan(*machine)
        self.assertIn(b'comment operator A. B\n', clean)
        self.assertIn(b'comment part_serial 7\n', clean)
        host = self.start(*machine)
        self.watch(host, largest // 2)
        host.send_signal(signal.SIGINT)
        self.assertEqual(host.wait(), 4)
        said = host.stderr.read().decode()
        for words in ('laser is off', 'scan.ply.journal', '--resume'):
            self.assertIn(words, said)
        size = self.journal_size()
        self.assertGreaterEqual(size, largest // 2)
        # Neither another scan nor other options get at what was measured.
        for wrong in (machine, ('--resume', '--seed', '9'), ('--resume', '--port', 'unix:x')):
            done = self.run_command('scan', *wrong, '--out', 'scan.ply')
            self.assertIn(done.returncode, (2, 3), done.stderr)
            self.assertIn('scan.ply.journal', done.stderr)
            self.assertEqual(self.journal_size(), size)
        self.write('part.csg', PART.replace('40', '41'))
        done = self.run_command('scan', '--resume', '--out', 'scan.ply')
        self.assertEqual(done.returncode, 3)
        self.assertIn('has changed', done.stderr)
        self.write('part.csg', PART)
        done = self.run_command('scan', '--resume', '--out', 'scan.ply')
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.read('scan.ply'), clean)
        done = self.run_command('scan', '--resume', '--out', 'scan.ply')
        self.assertEqual(done.returncode, 3)
        self.assertIn('finished', done.stderr)

    def test_own_emulator(self):
        self.kill_at_random_moments('--emulated', 'part.csg', '--pitch', '2', '--seed', '5')

    def test_separate_emulator(self):
        machine = subprocess.Popen([os.path.join(cl.BIN, 'tetragauge-emulator'), '--part', 'part.csg', '--listen', 'unix:machine.sock'],
                                   cwd=self.folder, stdout=subprocess.PIPE, text=True)
        self.addCleanup(machine.wait)
        self.addCleanup(machine.kill)
        self.addCleanup(machine.stdout.close)
        self.assertEqual(machine.stdout.readline().strip(), 'unix:machine.sock')
        self.kill_at_random_moments('--port', 'unix:machine.sock', '--pitch', '2')


if __name__ == '__main__':
    cl.main()
