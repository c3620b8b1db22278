# SPDX-License-Identifier: GPL-3.0-or-later
"""Ten kinds of bad input: each a clear error with the right exit code, and nothing half written."""
import os
import socket
import subprocess
import threading
import time

import command_line as cl

USAGE, BAD_INPUT, MACHINE = 2, 3, 4
PLACE = '--place=90,0,0,0,0,0'


class BadInput(cl.CommandLineTest):
    def refused(self, code, words, *arguments, timeout=60):
        """The command ends with `code`, says all of `words` on stderr, and leaves no output."""
        before = {name for name in os.listdir(self.folder) if not name.startswith('out')}
        done = self.run_command(*arguments, timeout=timeout)
        self.assertEqual(done.returncode, code, f'{arguments}\n{done.stderr}')
        for word in words:
            self.assertIn(word, done.stderr)
        self.assertNotIn('terminate called', done.stderr)
        left = set()
        for folder, _, names in os.walk(self.folder):
            left |= {os.path.relpath(os.path.join(folder, name), self.folder) for name in names}
        self.assertEqual(left, before, 'an output was left behind')

    def small_scan(self):
        done = self.run_command('simulate', '--model', cl.NOMINAL, '--out', 'scan.ply', '--points', 2000)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.read('scan.ply')

    def test_missing_file(self):
        self.refused(BAD_INPUT, ['no_such.ply'], 'faces', 'no_such.ply', '--json', 'out.json')
        self.refused(BAD_INPUT, ['no_such.step'], 'model', 'no_such.step', '--json', 'out.json')
        self.refused(BAD_INPUT, ['no_such.csg'], 'scan', '--emulated', 'no_such.csg', '--out', 'out.ply')

    def test_truncated_scan(self):
        self.write('cut.ply', self.small_scan()[:50000])
        self.refused(BAD_INPUT, ['cut.ply', 'truncated'], 'inspect', 'cut.ply', '--model', cl.NOMINAL, '--out', 'out')

    def test_nan_coordinate(self):
        header = 'ply\nformat ascii 1.0\nelement vertex 5\nproperty double x\nproperty double y\nproperty double z\nend_header\n'
        self.write('nan.ply', header + '0 0 0\n1 0 0\n0 nan 0\n0 0 1\n1 1 1\n')
        self.refused(BAD_INPUT, ['nan.ply', 'point 2'], 'reconstruct', 'nan.ply', '--ray-origin', '0,0,9', '--sigma', '0.1',
                     '--out', 'out.ply')

    def test_step_that_is_not_step(self):
        self.write('poem.step', 'Shall I compare thee to a summer\'s day?\n')
        self.refused(BAD_INPUT, ['poem.step', 'STEP'], 'model', 'poem.step', '--json', 'out.json')

    def test_csg_with_an_unknown_call(self):
        self.write('hull.csg', 'group() {\n\thull() {\n\t\tcube(size = [1, 1, 1], center = false);\n\t}\n}\n')
        self.refused(BAD_INPUT, ['hull.csg', '2', 'hull'], 'model', 'hull.csg', '--json', 'out.json')

    def test_empty_scan(self):
        self.write('empty.ply', 'ply\nformat ascii 1.0\nelement vertex 0\nproperty double x\nproperty double y\n'
                                'property double z\nend_header\n')
        self.refused(BAD_INPUT, ['empty.ply', '0 points'], 'inspect', 'empty.ply', '--model', cl.NOMINAL, '--out', 'out')
        self.write('nothing.ply', '')
        self.refused(BAD_INPUT, ['nothing.ply'], 'faces', 'nothing.ply', '--json', 'out.json')

    def test_wrong_port(self):
        self.refused(MACHINE, ['/dev/ttyNOSUCH'], 'scan', '--port', '/dev/ttyNOSUCH', '--out', 'out.ply')
        self.refused(MACHINE, ['no_such.sock'], 'scan', '--port', 'unix:no_such.sock', '--out', 'out.ply')

    def test_firmware_that_does_not_answer(self):
        server = socket.socket(socket.AF_UNIX)
        self.addCleanup(server.close)
        server.bind(self.path('silent.sock'))
        server.listen()
        self.refused(MACHINE, ['answer'], 'scan', '--port', 'unix:silent.sock', '--out', 'out.ply')

    def test_unplugged_in_the_middle(self):
        emulator = subprocess.Popen([os.path.join(cl.BIN, 'tetragauge-emulator'), '--part', cl.NOMINAL, PLACE,
                                     '--listen', 'unix:machine.sock'], cwd=self.folder,
                                    stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(emulator.wait)
        self.addCleanup(emulator.kill)
        for _ in range(300):
            if os.path.exists(self.path('machine.sock')):
                break
            time.sleep(0.1)
        cable = socket.socket(socket.AF_UNIX)
        self.addCleanup(cable.close)
        cable.bind(self.path('cable.sock'))
        cable.listen()

        def carry(limit):
            host, _ = cable.accept()
            machine = socket.socket(socket.AF_UNIX)
            machine.connect(self.path('machine.sock'))

            def forward(source, target):
                carried = 0
                try:
                    while carried < limit and (data := source.recv(4096)):
                        target.sendall(data)
                        carried += len(data)
                except OSError:
                    pass
                for end in (host, machine):  # the plug is out: both ways at once
                    try:
                        end.shutdown(socket.SHUT_RDWR)
                    except OSError:
                        pass

            threading.Thread(target=forward, args=(host, machine), daemon=True).start()
            forward(machine, host)
            host.close()
            machine.close()

        thread = threading.Thread(target=carry, args=(60000,), daemon=True)
        thread.start()
        self.refused(MACHINE, [], 'scan', '--port', 'unix:cable.sock', '--out', 'out.ply', timeout=120)
        thread.join(10)
        self.assertFalse(thread.is_alive())

    def test_part_outside_the_volume(self):
        self.write('long.csg', 'cube(size = [300, 20, 20], center = false);\n')
        self.refused(BAD_INPUT, ['long.csg', 'volume'], 'scan', '--emulated', 'long.csg', '--out', 'out.ply')

    def test_usage(self):
        self.refused(USAGE, ['--out'], 'simulate', '--model', cl.NOMINAL)
        self.refused(USAGE, ['no_folder'], 'simulate', '--model', cl.NOMINAL, '--out', 'no_folder/out.ply')
        self.refused(USAGE, ['--pose'], 'simulate', '--model', cl.NOMINAL, '--out', 'out.ply', '--pose', '1,2,3')
        self.refused(USAGE, ['furlong'], 'model', cl.NOMINAL, '--unit', 'furlong', '--json', 'out.json')

    def test_tolerance_file(self):
        scan = self.small_scan()
        self.assertTrue(scan)
        for text, words in [('{"default": {"profile": 0.1}}', ['profile', 'profile_mm']), ('{"skip": [99]}', ['99']),
                            ('{', ['tolerances.json']), ('{"min_coverage": 2}', ['min_coverage'])]:
            self.write('tolerances.json', text)
            self.refused(BAD_INPUT, words, 'inspect', 'scan.ply', '--model', cl.NOMINAL, '--tolerances', 'tolerances.json',
                         '--out', 'out')


if __name__ == '__main__':
    cl.main()
