# SPDX-License-Identifier: GPL-3.0-or-later
"""`plan` and `measure` as a person runs them: a plan that says what nobody can see, rounds in the report, and a machine
that dies in the middle of a round."""
import json
import os
import signal
import subprocess
import time

import jsonschema

import command_line as cl

PART = ('difference() { cube(size = [60, 50, 40], center = false);\n'
        'multmatrix([[1, 0, 0, 34], [0, 1, 0, -1], [0, 0, 1, 22], [0, 0, 0, 1]]) { cube(size = [27, 52, 19], center = false); } }\n')
BOTTOM = [0, 0, -1]


class Measure(cl.CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write('part.csg', PART)
        self.write('tolerances.json', '{"default": {"profile_mm": 0.4}}')
        faces = self.run_json('model', 'part.csg')['faces']
        self.bottom = next(f['id'] for f in faces if f['normal'] == BOTTOM)

    def check_schema(self, report):
        with open(os.path.join(cl.ROOT, 'host', 'report', 'report.schema.json'), encoding='utf-8') as file:
            jsonschema.Draft202012Validator(json.load(file)).validate(report)

    def test_plan(self):
        forecast = self.run_json('plan', '--model', 'part.csg', '--pitch', 2, '--points', 60, '--out', 'plan.json')
        self.assertEqual(forecast['schema'], 'tetragauge/plan/1')
        unseen = [f for f in forecast['faces'] if not f['seen']]
        self.assertEqual([f['id'] for f in unseen], [self.bottom])
        self.assertIn('underside', unseen[0]['why'])
        for face in forecast['faces']:
            self.assertTrue(not face['seen'] or face['points'] >= 60, face)
        # What it says is what the scan takes and finds.
        scan = self.run_json('scan', '--emulated', 'part.csg', '--plan', 'plan.json', '--out', 'scan.ply')
        self.assertLess(abs(scan['machine_time_s'] / forecast['predicted_s'] - 1), 0.1)
        report = self.run_json('inspect', 'scan.ply', '--model', 'part.csg', '--out', 'report')
        self.assertEqual([f['id'] for f in report['faces'] if not f['measured']], [self.bottom])
        # Again, and on one thread: the same plan.
        first = self.read('plan.json')
        self.run_json('plan', '--model', 'part.csg', '--pitch', 2, '--points', 60, '--out', 'plan.json', '--threads', 1)
        self.assertEqual(self.read('plan.json'), first)
        # Lying on its back the bottom is a side, and another face lies down.
        turned = self.run_json('plan', '--model', 'part.csg', '--place=90,0,0,0,0,0', '--out', 'plan.json')
        self.assertNotIn(self.bottom, [f['id'] for f in turned['faces'] if not f['seen']])

    def test_plan_errors(self):
        for arguments, code, words in ((('--pose', '1,2,3'), 2, ('--pose',)), (('--samples', '7'), 2, ('--samples', 'even')),
                                       (('--pose', '0,0,0,0,0,5000'), 3, ('no face', 'pose'))):
            done = self.run_command('plan', '--model', 'part.csg', '--out', 'plan.json', *arguments)
            self.assertEqual(done.returncode, code, done.stderr)
            for word in words:
                self.assertIn(word, done.stderr)
            self.assertFalse(os.path.exists(self.path('plan.json')))

    def test_rounds_are_in_the_report(self):
        self.write('tolerances.json', json.dumps({'default': {'profile_mm': 0.4}, 'skip': [self.bottom]}))
        reports = []
        for threads in (1, 2):
            report = self.run_json('measure', '--emulated', 'part.csg', '--model', 'part.csg', '--tolerances', 'tolerances.json', '--pitch', 2,
                                   '--rounds', 2, '--threads', threads, '--out', 'report')
            self.check_schema(report)
            report.pop('timing_s')
            reports.append(report)
        self.assertEqual(*reports)
        self.assertEqual(report['verdict'], 'pass')
        self.assertIn('the pose found', report['plan'])
        self.assertGreater(len(report['rounds']), 0)
        for before, after in zip(report['rounds'], report['rounds'][1:]):
            self.assertEqual(before['after'], after['before'])
        self.assertIn('round 1:', self.read('report/report.txt').decode())
        # The scan beside the report is all that it was judged from.
        again = self.run_json('inspect', 'report/scan.ply', '--model', 'part.csg', '--tolerances', 'tolerances.json', '--out', 'again')
        self.assertEqual(again['faces'], report['faces'])

    def test_machine_that_dies_in_a_round(self):
        machine = subprocess.Popen([os.path.join(cl.BIN, 'tetragauge-emulator'), '--part', 'part.csg', '--listen', 'unix:machine.sock'],
                                   cwd=self.folder, stdout=subprocess.PIPE, text=True)
        self.addCleanup(machine.wait)
        self.addCleanup(machine.kill)
        self.addCleanup(machine.stdout.close)
        machine.stdout.readline()
        host = subprocess.Popen([os.path.join(cl.BIN, 'tetragauge'), 'measure', '--port', 'unix:machine.sock', '--model', 'part.csg', '--tolerances',
                                 'tolerances.json', '--pitch', '2', '--out', 'report'], cwd=self.folder, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)
        self.addCleanup(host.kill)
        # The first scan is whole when it is there; before the rounds it is inspected.
        while not os.path.exists(self.path('report/scan.ply')) and host.poll() is None:
            time.sleep(0.001)
        machine.send_signal(signal.SIGKILL)
        stdout, stderr = host.communicate(timeout=120)
        self.assertEqual(host.returncode, 4, stderr)
        self.assertIn('judged from what was measured before', stderr)
        self.assertIn('BROKEN OFF', stdout)
        report = json.loads(self.read('report/report.json'))
        self.check_schema(report)
        self.assertNotEqual(report['interruption'], '')
        self.assertEqual([f['id'] for f in report['faces'] if not f['measured']], [self.bottom])
        self.assertFalse(os.path.exists(self.path('report/scan.ply.journal')))
        # There is no going on with rounds, and it says so.
        done = self.run_command('measure', '--emulated', 'part.csg', '--model', 'part.csg', '--out', 'report', '--resume')
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn('measure the part anew', done.stderr)


if __name__ == '__main__':
    cl.main()
