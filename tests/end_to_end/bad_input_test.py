# SPDX-License-Identifier: GPL-3.0-or-later
"""Kinds of bad input: each a clear error with the right exit code, and nothing half written."""
import os
import socket
import stat
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

    def test_output_that_is_an_input(self):
        """Refused before the work, and the input is still what it was."""
        scan = self.small_scan()
        with open(cl.NOMINAL, 'rb') as file:
            model = file.read()
        self.write('part.csg', model)
        self.write('faces.json', '{}')
        os.mkdir(self.path('out'))
        os.symlink('scan.ply', self.path('link.ply'))
        os.link(self.path('scan.ply'), self.path('out/deviation.ply'))
        self.write('out/report.json', '{}')
        for arguments in [('simulate', '--model', 'part.csg', '--out', 'part.csg'),
                          ('simulate', '--model', 'part.csg', '--out', 'new.ply', '--json', './part.csg'),
                          ('simulate', '--model', 'part.csg', '--out', 'new.ply', '--json', './new.ply'),
                          ('reconstruct', 'scan.ply', '--out', 'link.ply'),
                          ('faces', 'scan.ply', '--json', 'link.ply'),
                          ('model', 'part.csg', '--json', 'part.csg'),
                          ('match', '--model', 'part.csg', '--measured', 'faces.json', '--json', 'faces.json'),
                          ('scan', '--emulated', 'part.csg', '--out', 'part.csg'),
                          ('measure', '--emulated', 'part.csg', '--model', 'part.csg', '--out', 'new', '--json', 'part.csg'),
                          ('inspect', 'out/deviation.ply', '--model', 'part.csg', '--out', 'out'),
                          ('inspect', 'scan.ply', '--model', 'part.csg', '--tolerances', 'out/report.json', '--out', 'out')]:
            with self.subTest(arguments):
                done = self.run_command(*arguments, timeout=60)
                self.assertEqual(done.returncode, USAGE, done.stderr)
                self.assertIn('cannot write', done.stderr)
                self.assertEqual(self.read('scan.ply'), scan)
                self.assertEqual(self.read('part.csg'), model)
                self.assertEqual(self.read('faces.json'), b'{}')
                self.assertEqual(self.read('out/report.json'), b'{}')
                self.assertFalse(os.path.exists(self.path('new.ply')))

    def test_output_that_cannot_be(self):
        os.mkfifo(self.path('pipe'))
        os.symlink('far.ply', self.path('outlink.ply'))
        simulate = ('simulate', '--model', cl.NOMINAL, '--points', 500)
        self.refused_early(['--out'], *simulate, '--out', '')
        self.refused_early(['--out'], 'inspect', 'scan.ply', '--model', cl.NOMINAL, '--out', '')
        self.refused_early(['--json'], *simulate, '--out', 'out.ply', '--json', '')
        self.refused_early(['pipe'], *simulate, '--out', 'pipe')
        self.refused_early(['pipe'], *simulate, '--out', 'out.ply', '--json', 'pipe')
        self.refused_early(['no_folder'], *simulate, '--out', 'out.ply', '--json', 'no_folder/out.json')
        self.assertTrue(stat.S_ISFIFO(os.lstat(self.path('pipe')).st_mode))
        done = self.run_command(*simulate, '--out', 'outlink.ply')
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(os.path.islink(self.path('outlink.ply')))
        self.assertTrue(self.read('far.ply').startswith(b'ply'))

    def refused_early(self, words, *arguments):
        done = self.run_command(*arguments, timeout=60)
        self.assertEqual(done.returncode, USAGE, f'{arguments}\n{done.stderr}')
        for word in words:
            self.assertIn(word, done.stderr)
        self.assertEqual([name for name in os.listdir(self.folder) if name.startswith('out.')], [])

    def test_lost_standard_output(self):
        """What was printed and did not get there is an error."""
        program = os.path.join(cl.BIN, 'tetragauge')
        for arguments in (f"model '{cl.NOMINAL}'", f"model '{cl.NOMINAL}' --json -", '--help', 'scan --help', '--version'):
            for where in ('>/dev/full', '>&-'):
                with self.subTest(f'{arguments} {where}'):
                    done = subprocess.run(f"'{program}' {arguments} {where}", shell=True, cwd=self.folder, timeout=60,
                                          stderr=subprocess.PIPE, text=True, check=False)
                    self.assertEqual(done.returncode, BAD_INPUT, done.stderr)
                    self.assertIn('standard output', done.stderr)

    def test_port_out_of_range(self):
        for port in ('0', '65536', '99999', '-1', 'x', ''):
            self.refused(USAGE, ['65535'], 'scan', '--port', f'tcp:127.0.0.1:{port}', '--out', 'out.ply')

    def test_killed_while_scanning(self):
        """The emulator that a killed host started ends at once and leaves no folder."""
        host = subprocess.Popen([os.path.join(cl.BIN, 'tetragauge'), 'scan', '--emulated', cl.NOMINAL, PLACE, '--speed', '1',
                                 '--out', 'out.ply'], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(host.wait)
        self.addCleanup(host.kill)
        children = f'/proc/{host.pid}/task/{host.pid}/children'
        arguments = []
        for _ in range(300):
            with open(children, encoding='ascii') as file:
                emulators = file.read().split()
            if emulators:
                with open(f'/proc/{emulators[0]}/cmdline', encoding='utf-8') as file:
                    arguments = file.read().split('\0')
                if '--listen' in arguments and os.path.exists(arguments[arguments.index('--listen') + 1][len('unix:'):]):
                    break
            time.sleep(0.05)
        self.assertIn('--listen', arguments)
        folder = os.path.dirname(arguments[arguments.index('--listen') + 1][len('unix:'):])
        self.assertTrue(os.path.isdir(folder), folder)
        time.sleep(0.5)  # in the middle of the survey
        host.kill()
        host.wait()
        deadline = time.monotonic() + 1
        while os.path.exists(folder) and time.monotonic() < deadline:
            time.sleep(0.02)
        self.assertFalse(os.path.exists(folder), folder)

    def test_help_says_defaults(self):
        for command, options in [('simulate', ['--views', '--pitch', '--sigma', '--seed']), ('inspect', ['--rule']),
                                 ('scan', ['--pitch', '--seed', '--speed']), ('measure', ['--rule', '--pitch'])]:
            text = ' '.join(self.run_command(command, '--help').stdout.split())
            for option in options:
                self.assertRegex(text, rf' {option} \S+( in \[[^]]*\])?=(guarded|max|[0-9.]+) ', command)

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
