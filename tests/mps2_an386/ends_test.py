# SPDX-License-Identifier: GPL-3.0-or-later
"""Host, world, and the QEMU with the image are three processes: whichever ends first, the others end with a message that
says so, and none is left over. What is missing is named with what brings it."""
import os
import shutil
import signal
import subprocess
import time

import emulator
from emulator import cl

PART = 'cube(size = [40, 30, 20], center = false);\n'
# Near where the axes stand after homing, and long enough to be disturbed.
PLAN = '{"pitch_mm": 1, "samples": 8, "views": [{"table_deg": -175, "slide_mm": 5}, {"table_deg": -170, "slide_mm": 10}]}'


def alive(pid):
    try:
        with open(f'/proc/{pid}/stat', encoding='ascii') as file:
            return file.read().rsplit(')', 1)[1].split()[0] != 'Z'
    except FileNotFoundError:
        return False


class Ends(cl.CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write('part.csg', PART)
        self.write('plan.json', PLAN)

    def start_host(self, *machine):
        host = subprocess.Popen([os.path.join(cl.BIN, 'tetragauge'), 'scan', *machine, '--plan', 'plan.json', '--out', 'scan.ply'], cwd=self.folder,
                                stderr=subprocess.PIPE, text=True)
        self.addCleanup(host.stderr.close)
        self.addCleanup(host.wait)
        self.addCleanup(host.kill)
        return host

    def until(self, happens, what):
        for _ in range(30000):
            if happens():
                return
            time.sleep(0.01)
        self.fail(what)

    def until_it_scans(self, host):
        """Until its journal has points."""
        journal = self.path('scan.ply.journal')
        self.until(lambda: os.path.exists(journal) and os.path.getsize(journal) > 10000 or host.poll() is not None, 'it does not scan')
        self.assertIsNone(host.poll())

    def measuring(self):
        """A host and its machine in the midst of a scan."""
        machine = emulator.Emulator(self.folder, 'machine', 'part.csg', 'mps2_an386')
        self.addCleanup(machine.__exit__)
        host = self.start_host('--port', machine.port)
        self.until_it_scans(host)
        qemu, = emulator.children(machine.process.pid)
        return host, machine, qemu

    def test_qemu_ends(self):
        host, machine, qemu = self.measuring()
        os.kill(qemu, signal.SIGKILL)
        self.assertEqual(host.wait(timeout=300), 4)
        self.assertIn('--resume', host.stderr.read())
        code, said = machine.ended()
        self.assertEqual(code, 4)
        self.assertIn('QEMU was ended by signal 9', said)

    def test_the_world_ends(self):
        host, machine, qemu = self.measuring()
        machine.process.kill()
        self.assertEqual(host.wait(timeout=300), 4)
        self.assertIn('connection ended', host.stderr.read())
        self.until(lambda: not alive(qemu), 'QEMU is left over')

    def test_the_host_ends(self):
        host, machine, qemu = self.measuring()
        host.kill()
        self.assertEqual(machine.ended(), (0, ''))
        self.assertFalse(alive(qemu))

    def test_the_host_is_told_by_its_own_machine(self):
        host = self.start_host('--emulated', 'part.csg', '--board', 'mps2_an386')
        self.until_it_scans(host)
        world, = emulator.children(host.pid)
        qemu, = emulator.children(world)
        os.kill(qemu, signal.SIGKILL)
        self.assertEqual(host.wait(timeout=300), 4)
        self.assertIn('QEMU was ended by signal 9', host.stderr.read())
        self.assertFalse(alive(world))
        # And the scan goes on from there, on the same board.
        done = self.run_command('scan', '--resume', '--out', 'scan.ply')
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(b'comment machine_id mps2_an386/', self.read('scan.ply'))

    def test_no_image(self):
        os.mkdir(self.path('bin'))
        shutil.copy(os.path.join(cl.BIN, 'tetragauge-emulator'), self.path('bin'))
        done = subprocess.run(['bin/tetragauge-emulator', '--part', 'part.csg', '--board', 'mps2_an386'], cwd=self.folder,
                              capture_output=True, text=True, timeout=300, check=False)
        self.assertEqual(done.returncode, 4)
        self.assertIn('images/mps2_an386/tetragauge-mps2_an386.elf is not there; run script/setup', done.stderr)

    def test_no_qemu(self):
        done = subprocess.run([os.path.join(cl.BIN, 'tetragauge'), 'scan', '--emulated', 'part.csg', '--board', 'mps2_an386', '--out', 'scan.ply'],
                              cwd=self.folder, env={**os.environ, 'PATH': self.folder}, capture_output=True, text=True, timeout=300, check=False)
        self.assertEqual(done.returncode, 4)
        self.assertIn("qemu-system-arm is not installed; run script/setup, or install Debian's package qemu-system-arm", done.stderr)

    def test_no_image_that_speaks(self):
        os.makedirs(self.path('bin'))
        os.makedirs(self.path('images/mps2_an386'))
        shutil.copy(os.path.join(cl.BIN, 'tetragauge-emulator'), self.path('bin'))
        self.write('images/mps2_an386/tetragauge-mps2_an386.elf', 'no image')
        done = subprocess.run(['bin/tetragauge-emulator', '--part', 'part.csg', '--board', 'mps2_an386'], cwd=self.folder,
                              capture_output=True, text=True, timeout=300, check=False)
        self.assertEqual(done.returncode, 4)
        self.assertIn('--board mps2_an386: QEMU', done.stderr)


if __name__ == '__main__':
    cl.main()
