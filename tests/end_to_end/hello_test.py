# SPDX-License-Identifier: GPL-3.0-or-later
"""tetragauge-hello on a workbench: a machine that an earlier host has left with its laser on takes orders again, without a reset."""
import os
import signal
import subprocess
import sys

import command_line as cl
from other_host_test import OtherHost

HELLO = os.path.join(cl.BIN, 'tetragauge-hello')


class Hello(cl.CommandLineTest):
    def setUp(self):
        super().setUp()
        subprocess.run(['protoc', '--proto_path', cl.ROOT, '--python_out', self.folder, 'protocol/machine.proto'], check=True)
        sys.path.insert(0, self.folder)
        self.addCleanup(sys.path.remove, self.folder)
        from protocol import machine_pb2
        self.m = machine_pb2
        process = subprocess.Popen([os.path.join(cl.BIN, 'tetragauge-emulator'), '--part', cl.NOMINAL, '--listen', 'unix:line'],
                                   cwd=self.folder, stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.addCleanup(process.stdout.close)
        self.assertEqual(process.stdout.readline().strip(), 'unix:line')

    def hello(self, *options):
        return subprocess.run([HELLO, '--port', 'unix:line', *options], cwd=self.folder, capture_output=True, text=True, timeout=120, check=False)

    def leave_the_laser_paused(self):
        """A host that turns the laser on, falls silent, and goes."""
        m, host = self.m, OtherHost(self.m, self.path('line'))
        host.ask(hello=m.Hello(protocol_version=1))
        self.assertEqual(host.ask(laser_set=m.LaserSet(on=True))[0], 'done')
        while True:
            _, _, message = host.frame()
            if message.WhichOneof('body') == 'heartbeat' and message.heartbeat.state == m.STATE_PAUSED:
                break
        host.line.close()

    def test_a_paused_machine_is_shown_and_takes_orders(self):
        self.assertEqual(self.hello('--home').stdout, 'state READY, inputs 7\n')
        self.leave_the_laser_paused()
        shown = self.hello()
        self.assertEqual(shown.returncode, 4)
        self.assertIn('state PAUSED', shown.stdout)
        self.assertNotIn('self-test', shown.stdout)
        self.assertIn('refuses (state PAUSED)', shown.stderr)
        for order in (['--laser', '0.2'], ['--table', '1', '--mirrors', '1000,-1000']):
            done = self.hello(*order)
            self.assertEqual((done.returncode, done.stdout), (0, 'state READY, inputs 7\n'), done.stderr)
            self.leave_the_laser_paused()
        done = self.hello('--bootloader')
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_ctrl_c_turns_the_laser_off(self):
        with subprocess.Popen([HELLO, '--port', 'unix:line', '--home', '--laser', '600'], cwd=self.folder, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True) as lit:
            self.assertEqual(lit.stderr.readline(), 'the laser is on for 600 s; Ctrl-C turns it off\n')
            lit.send_signal(signal.SIGINT)
            self.assertEqual(lit.communicate(timeout=120)[0], 'state READY, inputs 7\n')
            self.assertEqual(lit.returncode, 0)

    def test_the_eight_channels_are_shown(self):
        shown = self.hello()
        self.assertEqual(shown.returncode, 0, shown.stdout)
        for camera in (1, 2):
            self.assertRegex(shown.stdout, rf'camera {camera}, mean codes: x1 -?\d+, x2 -?\d+, y1 -?\d+, y2 -?\d+')


if __name__ == '__main__':
    cl.main()
