#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The firmware as ARM code with QEMU's UART0 on a socket, instead of the FIFOs: answers the host's own library, and streams a
scan whose points lie on the plate that its board shows the cameras. Unlike the FIFO bus it runs by the computer's clock, so
nothing here says how long anything takes; `script/bench firmware` prints that."""
import json
import os
import re
import shutil
import subprocess
import sys
import unittest

from emulator import cl
from serial_qemu import PATIENCE_S, SerialQemu

IMAGE = os.path.join(cl.BIN, '..', 'images', 'mps2_an386', 'uart.elf')
OPTIONS = ['-semihosting-config', 'enable=on,target=native']
PLAN = '{"pitch_mm": 2, "samples": 4, "window_mm": {"y": [-20, 20], "up": [-20, 20]}, "views": [{"table_deg": -180, "slide_mm": 0}]}\n'


class Uart(cl.CommandLineTest):
    def test_hello_status_and_self_test(self):
        with SerialQemu('mps2-an386', IMAGE, *OPTIONS) as machine:
            done = machine.run_host(os.path.join(cl.BIN, 'tetragauge-hello'), '--port', machine.port, '--json',
                                    '--patience', str(PATIENCE_S), '--rounds', '50')
        said = json.loads(done.stdout)
        self.assertEqual(done.returncode, 0, done.stdout)
        with open(os.path.join(cl.ROOT, 'firmware', 'version.hpp'), encoding='utf-8') as file:
            version = re.search(r'kFirmwareVersion = "([^"]+)"', file.read())[1]
        self.assertEqual((said['board'], said['firmware_version'], said['state']), ('mps2_an386', version, 'IDLE'))
        self.assertEqual(said['round_trip']['rounds'], 50)

    def test_one_thing_at_a_time(self):
        """As on a workbench: what is refused is said, what is done ends in a state."""
        with SerialQemu('mps2-an386', IMAGE, *OPTIONS) as machine:
            for actions, code, says in ((['--laser', '1'], 4, 'refuses (state IDLE)'), (['--table', '5', '--slide', '2'], 0, 'state IDLE, inputs 7'),
                                        (['--home', '--mirrors', '100000,-50000', '--laser', '1'], 0, 'state READY, inputs 7'),
                                        (['--mirrors', '900000,0'], 4, "beyond the mirrors' limit")):
                done = subprocess.run([os.path.join(cl.BIN, 'tetragauge-hello'), '--port', machine.port, '--patience', str(PATIENCE_S), *actions],
                                      capture_output=True, text=True, timeout=PATIENCE_S, check=False)
                self.assertEqual(done.returncode, code, done.stderr)
                self.assertIn(says, done.stdout + done.stderr)

    def test_a_scan_streams(self):
        self.write('plan.json', PLAN)
        with SerialQemu('mps2-an386', IMAGE, *OPTIONS) as machine:
            done = machine.run_host(os.path.join(cl.BIN, 'tetragauge'), 'scan', '--port', machine.port, '--plan', self.path('plan.json'),
                                    '--out', self.path('scan.ply'), '--json', '-')
        self.assertEqual(done.returncode, 0, done.stderr)
        counts = json.loads(done.stdout)
        # 21 x 21 beams; the rows that would hit the plate below the table's top lie outside the volume.
        self.assertEqual((counts['beams'], counts['points'], counts['rejected']['outside the volume']), (441, 231, 210))


if __name__ == '__main__':
    if shutil.which('qemu-system-arm') is None:
        print('uart_test: skipped, qemu-system-arm is missing; run script/setup, which installs it')
        sys.exit(77)
    cl.main()
