# SPDX-License-Identifier: GPL-3.0-or-later
"""A batch of parts into a history file, and what `tetragauge history` says of it."""
import hashlib
import json
import os
import signal
import sqlite3
import statistics
import subprocess
import time

import command_line as cl

PLAN = {'pitch_mm': 2.5, 'samples': 8, 'window_mm': {'y': [-40, 40], 'up': [-45, 45]},
        'views': [{'table_deg': angle, 'slide_mm': 180} for angle in (20, 110, 200, 290)]}


def step(height_mm):
    """A block with a step; the step's top stands at this height."""
    return ('union() {\n\tcube(size = [40, 30, 20], center = false);\n'
            f'\tcube(size = [15, 30, {height_mm}], center = false);\n}}\n')


class History(cl.CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write('nominal.csg', step(40))
        self.write('plan.json', json.dumps(PLAN))
        self.write('tolerances.json', json.dumps({'default': {'profile_mm': 0.4}}))

    def measure(self, *arguments, out='reports', history='parts.db', **more):
        return self.run_command('measure', *arguments, '--model', 'nominal.csg', '--tolerances', 'tolerances.json', '--plan', 'plan.json',
                                '--rounds', '0', '--history', history, '--out', out, **more)

    def is_measuring(self, journal):
        """Points are in it, and not only what is to be measured."""
        try:
            return os.path.getsize(self.path(journal)) > 5000
        except FileNotFoundError:
            return False

    def folder_of_parts(self):
        os.mkdir(self.path('parts'))
        for name, height in (('b2', 40.05), ('a1', 40), ('c3', 40.9)):
            self.write(f'parts/{name}.csg', step(height))
        self.write('parts/a2.csg', 'cube(size = [40, 30')  # cut off
        self.write('parts/notes.txt', 'no part')

    def test_a_batch_of_emulated_parts(self):
        self.folder_of_parts()
        done = self.measure('--emulated', 'parts', '--json', 'batch.json')
        self.assertEqual(done.returncode, 3, done.stderr)  # a2 is worse than c3, which fails
        for words in ('a1.csg', 'a2.csg', 'n too small', 'verdict'):
            self.assertIn(words, done.stdout)
        self.assertLessEqual(max(map(len, done.stdout.splitlines())), 100)
        parts = json.loads(self.read('batch.json'))['models'][0]['parts']
        self.assertEqual([p['part'] for p in parts], ['a1.csg', 'a2.csg', 'b2.csg', 'c3.csg'])
        self.assertEqual(parts[3]['verdict'], 'fail')
        self.assertEqual(parts[1]['verdict'], 'not_measured')
        self.assertIn('a2.csg', parts[1]['reason'])
        self.assertEqual([p['seed'] for p in parts], [1, 2, 3, 4])

        # The rows against the reports: another way to the same numbers.
        shown = self.run_json('history', 'parts.db')
        model = shown['models'][0]
        self.assertEqual(len(shown['models']), 1)
        self.assertEqual(model['model_sha256'], hashlib.sha256(self.read('nominal.csg')).hexdigest())
        self.assertEqual(model['parts'][0]['tolerances_sha256'], hashlib.sha256(self.read('tolerances.json')).hexdigest())
        self.assertEqual(model['parts'][0]['plan_sha256'], hashlib.sha256(self.read('plan.json')).hexdigest())
        reports = [json.loads(self.read(f'reports/{name}/report.json')) for name in ('a1', 'b2', 'c3')]
        for face in model['faces']:
            in_reports = [next(f for f in report['faces'] if f['id'] == face['face']) for report in reports]
            values = [f['deviations']['offset_mm'] for f in in_reports if f['measured']]
            self.assertEqual(face['not_measured'], len(reports) - len(values))
            if not values:
                continue
            offset = next(q for q in face['quantities'] if q['name'] == 'offset')
            self.assertEqual([v['value'] for v in offset['values']], values)
            self.assertAlmostEqual(offset['mean'], statistics.mean(values), places=12)
            self.assertAlmostEqual(offset['s'], statistics.stdev(values), places=12)
            self.assertEqual(offset['upper_limit'], 0.2)
            self.assertIsNone(offset['Cp'])
        self.assertFalse(model['parts'][0]['start_time'])

        # A second run goes on; equal runs make equal files.
        before = self.read('parts.db')
        self.measure('--emulated', 'parts', history='again.db', out='again')
        self.assertEqual(self.read('again.db'), before)
        self.measure('--emulated', 'parts')
        numbers = [p['number'] for p in self.run_json('history', 'parts.db')['models'][0]['parts']]
        self.assertEqual(numbers, list(range(1, 9)))
        one = self.run_command('history', 'parts.db', '--face', '2')
        self.assertEqual(one.returncode, 0, one.stderr)
        with sqlite3.connect(self.path('parts.db')) as database:
            self.assertEqual(database.execute('PRAGMA integrity_check').fetchone(), ('ok',))
            self.assertEqual(database.execute('PRAGMA foreign_key_check').fetchall(), [])

    def test_a_batch_that_is_stopped_is_gone_on_with(self):
        os.mkdir(self.path('parts'))
        for name in ('a', 'b', 'c'):
            self.write(f'parts/{name}.csg', step(40))
        self.measure('--emulated', 'parts', history='whole.db', out='whole')
        arguments = ('measure', '--emulated', 'parts', '--model', 'nominal.csg', '--tolerances', 'tolerances.json', '--plan', 'plan.json',
                     '--rounds', '0', '--history', 'parts.db', '--out', 'reports')
        for signal_number in (signal.SIGINT, signal.SIGKILL):
            more = ('--resume',) if signal_number == signal.SIGKILL else ()
            host = subprocess.Popen([os.path.join(cl.BIN, 'tetragauge'), *arguments, *more], cwd=self.folder, stdout=subprocess.PIPE,
                                    stderr=subprocess.PIPE, text=True)
            self.addCleanup(host.kill)
            # While b is measured for the first time, and then again.
            while not self.is_measuring('reports/b/scan.ply.journal') and host.poll() is None:
                time.sleep(0.001)
            host.send_signal(signal_number)
            _, stderr = host.communicate(timeout=120)
            if signal_number == signal.SIGINT:
                self.assertEqual(host.returncode, 4, stderr)
                self.assertIn('1 of 3 parts are finished', stderr)
            self.assertEqual([p['part'] for p in self.run_json('history', 'parts.db')['models'][0]['parts']], ['a.csg'], 'half a part is no row')
        other = self.run_command(*arguments, '--resume', '--seed', 7)
        self.assertEqual(other.returncode, 3)
        self.assertIn('--seed', other.stderr)
        done = self.run_command(*arguments, '--resume')
        self.assertIn('a.csg: measured before, kept', done.stderr)
        self.assertIn('b.csg: was broken off, measured from its beginning', done.stderr)
        # As if nothing had happened.
        self.assertEqual(self.read('parts.db'), self.read('whole.db'))
        for name in ('a.csg', 'b.csg', 'c.csg'):
            self.assertIn(name, done.stdout)
        again = self.run_command(*arguments, '--resume')
        self.assertEqual(again.returncode, 3)
        self.assertIn('no batch that was broken off', again.stderr)

    def test_a_port_without_a_terminal_takes_one_part(self):
        self.write('part.csg', step(40))
        machine = subprocess.Popen([os.path.join(cl.BIN, 'tetragauge-emulator'), '--part', 'part.csg', '--listen', 'unix:machine.sock'],
                                   cwd=self.folder, stdout=subprocess.PIPE, text=True)
        self.addCleanup(machine.wait)
        self.addCleanup(machine.kill)
        self.addCleanup(machine.stdout.close)
        machine.stdout.readline()
        for arguments, name in (((), '1'), (('--part-serial', 'S 7/b'), 'S_7_b')):
            done = self.measure('--port', 'unix:machine.sock', *arguments)
            self.assertIn(done.returncode, (0, 5), done.stderr)
            self.assertTrue(os.path.exists(self.path(f'reports/{name}/report.json')))
        self.assertEqual([p['part'] for p in self.run_json('history', 'parts.db')['models'][0]['parts']], ['1', 'S 7/b'])

    def test_what_goes_wrong_is_said(self):
        self.write('part.csg', step(40))
        self.write('no.db', 'this is a text, and no database at all, but long enough to be looked at' * 20)
        for arguments, words in ((('history', 'absent.db'), 'no such file'), (('history', 'no.db'), 'not an SQLite database')):
            done = self.run_command(*arguments)
            self.assertEqual(done.returncode, 3)
            self.assertIn(words, done.stderr)
        # Before anything is measured.
        done = self.measure('--emulated', 'part.csg', history='no.db')
        self.assertEqual(done.returncode, 3)
        self.assertFalse(os.path.exists(self.path('reports/report.json')))
        os.mkdir(self.path('empty'))
        done = self.measure('--emulated', 'empty')
        self.assertEqual(done.returncode, 3)
        self.assertIn('no model of a part', done.stderr)
        # A fault of the machine is a row with its reason.
        os.mkdir(self.path('parts'))
        self.write('parts/a.csg', step(40))
        done = self.measure('--emulated', 'parts', '--faults', 'interlock@9s')
        self.assertEqual(done.returncode, 4, done.stderr)
        part = self.run_json('history', 'parts.db')['models'][0]['parts'][0]
        self.assertIn('interlock', part['reason'])
        self.assertNotIn('--resume', part['reason'])
        self.assertNotIn('unix:', part['reason'], 'another name in every run')
        self.assertEqual(self.run_command('history', 'parts.db', '--model-hash', 'zz').returncode, 3)
        self.assertEqual(self.run_command('history', 'parts.db', '--face', '3').returncode, 3)


if __name__ == '__main__':
    cl.main()
