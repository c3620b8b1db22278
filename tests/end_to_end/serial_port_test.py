# SPDX-License-Identifier: GPL-3.0-or-later
"""The same scan session over a socket and through the real libserialport: equal scan files.

libserialport refuses pseudo-terminals (it wants an entry in /sys/class/tty and modem lines); tests/pty_preload answers
those look-ups, and nothing else is between `tetragauge scan --port /dev/pts/N` and a real port.
"""
import fcntl
import os
import struct
import subprocess
import time

import command_line as cl

PRELOAD = os.environ.get('TETRAGAUGE_PTY_PRELOAD', os.path.join(cl.BIN, '..', 'tests', 'pty_preload', 'libtetragauge_pty_preload.so'))


class SerialPort(cl.CommandLineTest):
    def emulator(self, listen):
        process = subprocess.Popen([os.path.join(cl.BIN, 'tetragauge-emulator'), '--part', cl.NOMINAL, '--place=90,0,0,0,0,0',
                                    '--seed', '3', '--listen', listen, '--one-host'], cwd=self.folder, stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.addCleanup(process.stdout.close)
        return process

    def scan(self, port, out, environment, *options):
        command = [os.path.join(cl.BIN, 'tetragauge'), 'scan', '--port', port, *options, '--pitch', '3', '--out', out]
        done = subprocess.run(command, cwd=self.folder, env={**os.environ, **environment}, capture_output=True, text=True,
                              timeout=120, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_equals_the_socket(self):
        machine = self.emulator('pty')
        port = machine.stdout.readline().strip()
        self.assertRegex(port, r'^/dev/pts/\d+$')
        # A sanitizer's runtime wants to be loaded first; here the preload is.
        # What the port was set to is asked of another descriptor of it, open until the host has gone.
        seen = os.open(port, os.O_RDWR | os.O_NOCTTY)
        self.scan(port, 'serial.ply', {'LD_PRELOAD': PRELOAD, 'ASAN_OPTIONS': 'verify_asan_link_order=0'}, '--baud', '2000000')
        # Linux's struct termios2 (TCGETS2): its last two words are the speeds, as numbers.
        speeds = struct.unpack('36xII', fcntl.ioctl(seen, 0x802C542A, bytes(44)))
        os.close(seen)
        self.assertEqual(speeds, (2000000, 2000000))
        self.assertEqual(machine.wait(30), 0, 'the emulator ends with its only host')

        self.emulator('unix:machine.sock')
        for _ in range(300):
            if os.path.exists(self.path('machine.sock')):
                break
            time.sleep(0.1)
        self.scan('unix:machine.sock', 'socket.ply', {})
        self.assertGreater(len(self.read('socket.ply')), 100000)
        self.assertEqual(self.read('serial.ply'), self.read('socket.ply'))

    def test_refused_without_the_preload(self):
        # Shows that the preload is what opens the pseudo-terminal, and that libserialport is what refuses it.
        port = self.emulator('pty').stdout.readline().strip()
        done = self.run_command('scan', '--port', port, '--out', 'out.ply')
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn(port, done.stderr)


if __name__ == '__main__':
    cl.main()
