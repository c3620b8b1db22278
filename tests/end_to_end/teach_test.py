# SPDX-License-Identifier: GPL-3.0-or-later
"""`tetragauge teach` as a person drives it, on a pseudo-terminal, and the taught plan in a scan.

Also what a person does not plan: a fault, a machine that goes away, a killed program; the terminal is as it was before.
"""
import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import termios
import time

import command_line as cl

PART = 'cube(size = [40, 30, 50], center = false);\n'


class Terminal:
    """A program on a pseudo-terminal of 90 x 28."""

    def __init__(self, test, arguments, environment=()):
        self.master, self.slave = pty.openpty()
        fcntl.ioctl(self.slave, termios.TIOCSWINSZ, struct.pack('HHHH', 28, 90, 0, 0))
        self.before = termios.tcgetattr(self.slave)
        self.seen = ''
        command = [os.path.join(cl.BIN, 'tetragauge'), *arguments]
        self.process = subprocess.Popen(command, cwd=test.folder, stdin=self.slave, stdout=self.slave, stderr=self.slave,
                                        env={**os.environ, 'TERM': 'xterm-256color', **dict(environment)}, start_new_session=True)
        self.test = test
        test.addCleanup(os.close, self.master)
        test.addCleanup(os.close, self.slave)
        test.addCleanup(self.process.wait)
        test.addCleanup(self.process.kill)

    def expect(self, pattern, timeout=60):
        """Reads until the pattern has come; what came before it is taken."""
        end = time.monotonic() + timeout
        while not (match := re.search(pattern, self.seen)):
            if time.monotonic() > end:
                self.test.fail(f'waited for {pattern!r}, saw {self.seen[-3000:]!r}')
            if select.select([self.master], [], [], 0.1)[0]:
                try:
                    self.seen += os.read(self.master, 65536).decode(errors='replace')
                except OSError:
                    break
            elif self.process.poll() is not None:
                self.test.assertRegex(self.seen, pattern)
        self.seen = self.seen[match.end():] if match else ''
        return match

    def press(self, keys):
        os.write(self.master, keys.encode())

    def leave(self):
        """The exit code; the terminal must be as it was before."""
        end = time.monotonic() + 30
        while self.process.poll() is None and time.monotonic() < end:
            if select.select([self.master], [], [], 0.05)[0]:
                self.seen += os.read(self.master, 65536).decode(errors='replace')
        code = self.process.wait(1)
        while select.select([self.master], [], [], 0.05)[0]:
            self.seen += os.read(self.master, 65536).decode(errors='replace')
        self.test.assertEqual(termios.tcgetattr(self.slave), self.before)
        return code


class Teach(cl.CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write('part.csg', PART)

    def teach(self, *arguments, environment=()):
        terminal = Terminal(self, ['teach', *arguments, '--out', 'plan.json'], environment)
        terminal.expect('space takes a preview|taught before')
        return terminal

    def test_a_plan_is_taught_and_scanned(self):
        t = self.teach('--emulated', 'part.csg')
        t.press('\x1b[A' * 5)  # the slide to 175 mm
        t.expect('slide  175.0')
        t.press(' ')
        t.expect(r'\d+ points of the part')
        t.press('f')
        t.expect('window fitted')
        t.press('.ak')
        t.expect('kept as view 1')
        t.press('+\x1b[C\x1b[C ')  # 90 degrees on
        t.expect(r'\d+ points of the part')
        t.press('fk')
        t.expect('kept as view 2')
        t.press('q')
        t.expect('Save 2 views to plan.json')
        t.press('y')
        t.expect('plan.json: 2 views')
        self.assertEqual(t.leave(), 0)
        self.assertIn('\x1b[?1049l', t.seen + '\x1b[?1049l')
        for name in ('plan.preview.png', 'plan.view-1.png', 'plan.view-2.png'):
            self.assertEqual(self.read(name)[:4], b'\x89PNG')

        counts = self.run_json('scan', '--emulated', 'part.csg', '--plan', 'plan.json', '--out', 'scan.ply')
        self.assertGreater(counts['points'], 300)
        # Windows fitted to the part: hardly more is measured than the part and a margin around it.
        self.assertGreater(counts['points'], 0.2 * counts['beams'])

        # Going on from the saved plan; leaving without a change asks nothing.
        t = self.teach('--emulated', 'part.csg')
        t.expect('plan.json: 2 views')
        t.press('\x03')
        t.expect('no plan was saved')
        self.assertEqual(t.leave(), 0)

    def test_without_colours(self):
        t = self.teach('--emulated', 'part.csg', environment={'NO_COLOR': '1'}.items())
        t.press('\x1b[A\x1b[A ')
        t.expect('@@@')
        t.expect(r'\d+ points of the part')
        t.press('q')
        self.assertEqual(t.leave(), 0)

    def test_an_open_interlock_loses_nothing(self):
        t = self.teach('--emulated', 'part.csg', '--faults', 'interlock@12s+2s')
        t.press('k')
        t.expect('kept as view 1')
        for _ in range(20):  # time passes for a machine that works only
            t.press(' ')
            if 'interlock' in t.expect(r'NO MACHINE[^:]*: [^\x1b]*|\d+ points of the part')[0]:
                break
        else:
            self.fail('no interlock')
        t.press('\x1b[Ck')
        t.expect('kept as view 2')
        t.press('s')
        t.expect('plan.json saved: 2 views')
        for _ in range(20):
            t.press('r')
            if 'ready' in t.expect('NO MACHINE|the machine is ready')[0]:
                break
        else:
            self.fail('not ready again')
        t.press(' ')
        t.expect(r'\d+ points of the part')
        t.press('q')
        self.assertEqual(t.leave(), 0)

    def emulator(self):
        machine = subprocess.Popen([os.path.join(cl.BIN, 'tetragauge-emulator'), '--part', 'part.csg', '--listen', 'unix:machine.sock'],
                                   cwd=self.folder, stdout=subprocess.PIPE, text=True)
        self.addCleanup(machine.wait)
        self.addCleanup(machine.kill)
        self.addCleanup(machine.stdout.close)
        self.assertEqual(machine.stdout.readline().strip(), 'unix:machine.sock')
        return machine

    def test_a_pulled_cable_loses_nothing(self):
        machine = self.emulator()
        t = self.teach('--port', 'unix:machine.sock')
        t.press('k')
        t.expect('kept as view 1')
        machine.kill()
        t.expect('NO MACHINE .*1 view kept')
        t.press('r')
        t.expect('NO MACHINE')
        machine.wait()
        os.remove(self.path('machine.sock'))
        self.emulator()
        t.press('r')
        t.expect('the machine is ready')
        t.press('s')
        t.expect('plan.json saved: 1 view')
        t.press('q')
        self.assertEqual(t.leave(), 0)

    def test_killed_it_keeps_the_plan_and_gives_the_terminal_back(self):
        for ending in (signal.SIGTERM, signal.SIGHUP):
            t = self.teach('--emulated', 'part.csg')
            t.press('k')
            t.expect('kept as view 1')
            t.process.send_signal(ending)
            t.expect(r'plan\.rescue\.json')
            self.assertEqual(t.leave(), 4)
            self.assertFalse(os.path.exists(self.path('plan.json')))
            counts = self.run_json('scan', '--emulated', 'part.csg', '--plan', 'plan.rescue.json', '--out', 'scan.ply')
            self.assertGreater(counts['beams'], 1000)
            os.remove(self.path('plan.rescue.json'))
        t = self.teach('--emulated', 'part.csg')
        t.process.send_signal(signal.SIGABRT)
        self.assertEqual(t.leave(), -signal.SIGABRT)

    def test_without_a_terminal(self):
        done = self.run_command('teach', '--emulated', 'part.csg', '--out', 'plan.json')
        self.assertEqual(done.returncode, 2)
        self.assertIn('terminal', done.stderr)
        self.write('bad.json', '{"views": [{"table": 0}]}')
        self.assertIn('arrows', self.run_command('teach', '--help').stdout)


if __name__ == '__main__':
    cl.main()
