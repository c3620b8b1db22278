# SPDX-License-Identifier: GPL-3.0-or-later
"""The firmware as ARM code measures what the emulated board measures: the same trace of states and laser, the same points
and rejected beams to the byte, the same verdict; and its processor takes the same instructions for it every time."""
import json
import os

import emulator
from emulator import cl

PART = 'difference() { cube(size = [40, 30, 20], center = false); multmatrix([[1, 0, 0, 12], [0, 1, 0, 8], [0, 0, 1, 9], [0, 0, 0, 1]]) ' \
       '{ cube(size = [16, 40, 20], center = false); } }\n'
# Steps of both axes, upwards and back; settling and windows of samples; faces in and out of sight.
PLAN = '{"pitch_mm": 2, "samples": 16, "window_mm": {"y": [-40, 40], "up": [-30, 30]}, "views": [{"table_deg": -150, "slide_mm": 190}, ' \
       '{"table_deg": -100, "slide_mm": 180}, {"table_deg": -160, "slide_mm": 185, "samples": 100}]}\n'
BAD_STAIRCASE = os.path.join(cl.ROOT, 'examples', 'staircase', 'actual.csg')
TOLERANCES = os.path.join(cl.ROOT, 'examples', 'staircase', 'tolerances.json')


class Measures(cl.CommandLineTest):
    def scan(self, name, board, *options):
        """The session's emulator, ended, with its scan file's bytes."""
        with emulator.Emulator(self.folder, name, 'part.csg', board, *options) as machine:
            done = self.run_command('scan', '--port', machine.port, '--plan', 'plan.json', '--out', f'{name}.ply')
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(machine.ended(), (0, ''))
            return machine, emulator.without_machine_id(self.read(f'{name}.ply'))

    def test_same_trace_and_points_and_the_same_work_every_time(self):
        self.write('part.csg', PART)
        self.write('plan.json', PLAN)
        there, points_there = self.scan('emulated', 'emulated', '--seed', '7')
        works = []
        for run in range(2):
            here, points_here = self.scan(f'arm{run}', 'mps2_an386', '--seed', '7')
            self.assertEqual(here.trace(), there.trace())
            self.assertEqual(points_here, points_there)
            works.append(emulator.of_the_machine(here.work()))
        self.assertEqual(works[0], works[1])
        # Else nothing would be shown: steps, settled mirrors, windows of samples.
        for event, least in (('table_step', 10000), ('alarm', 3000), ('samples', 3000)):
            self.assertGreater(works[0]['SCANNING', event][0], least)
        other, points_other = self.scan('other', 'mps2_an386', '--seed', '8')
        self.assertNotEqual(points_other, points_here)

    def test_same_verdict_over_the_staircase(self):
        reports = []
        for board in ('emulated', 'mps2_an386'):
            done = self.run_command('measure', '--emulated', BAD_STAIRCASE, '--place=90,0,0,0,0,0', '--board', board, '--pitch', '2.5',
                                    '--model', cl.NOMINAL, '--tolerances', TOLERANCES, '--out', board)
            self.assertIn(done.returncode, (0, 1, 5), done.stderr)
            with open(self.path(f'{board}/report.json'), encoding='utf-8') as file:
                report = json.load(file)
            del report['timing_s']
            del report['input']  # names of files and the machine
            reports.append((done.returncode, report))
        self.assertEqual(reports[0], reports[1])
        self.assertEqual(reports[0][1]['verdict'], 'fail')


if __name__ == '__main__':
    cl.main()
