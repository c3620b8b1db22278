# SPDX-License-Identifier: GPL-3.0-or-later
"""The staircase, simulated in random poses: every face found and matched, with its neighbours, the pose right, nothing
invented."""
import random

import command_line as cl

POSES = 20
CENTRE_MM = [33.0, 30.0, 25.0]  # about the middle of the part, where the pose's error is judged


class Poses(cl.CommandLineTest):
    def test_random_poses(self):
        rng = random.Random(1989)
        neighbours = {f['id']: set(f['neighbours']) for f in self.run_json('model', cl.NOMINAL)['faces']}
        for run in range(POSES):
            angles = [rng.uniform(-180, 180), rng.uniform(-90, 90), rng.uniform(-180, 180)]
            shift = [rng.uniform(-100, 100) for _ in range(3)]
            pose = ','.join(f'{v:.4f}' for v in angles + shift)
            angles, shift = [round(v, 4) for v in angles], [round(v, 4) for v in shift]
            with self.subTest(pose=pose):
                done = self.run_command('simulate', '--model', cl.NOMINAL, '--out', 'scan.ply', '--points', 20000,
                                        '--sigma', 0.02, '--seed', run, f'--pose={pose}')
                self.assertEqual(done.returncode, 0, done.stderr)
                report = self.run_json('inspect', 'scan.ply', '--model', cl.NOMINAL, '--out', 'report')

                self.assertEqual([f['id'] for f in report['faces'] if f['measured']], list(range(1, 16)))
                self.assertEqual(report['extra_faces'], [])
                self.assertEqual(report['missing_faces'], [])
                self.assertEqual(report['equivalents'], [])
                self.assertEqual(report['reconstruction']['rays_lost'], 0)
                # Deep in its notch most poses leave surface in shadow; the faces still meet where the model's do.
                model_id = {p['measured']: p['model'] for p in report['pairs']}
                for face in self.run_json('faces', 'scan.ply')['faces']:
                    self.assertEqual({model_id[n] for n in face['neighbours']}, neighbours[model_id[face['id']]])
                # The report's pose takes the scan to the model: after the simulated one it is the identity.
                rotation = cl.rotation_from_degrees(*angles)
                back = cl.move(report['pose']['rotation'], report['pose']['translation_mm'],
                               cl.move(rotation, shift, CENTRE_MM))
                self.assertLess(max(abs(a - b) for a, b in zip(back, CENTRE_MM)), 0.02)
                inverse = [list(row) for row in zip(*report['pose']['rotation'])]
                self.assertLess(cl.rotation_angle_deg(inverse, rotation), 0.02)


if __name__ == '__main__':
    cl.main()
