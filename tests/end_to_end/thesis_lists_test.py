# SPDX-License-Identifier: GPL-3.0-or-later
"""The face lists printed in the thesis (Cakir, Bath 1989, figures 7.8, C2.2 and C3.1), matched."""
import os

import command_line as cl

THESIS = os.path.join(cl.SHARED, 'data', 'thesis')
# measured -> model, from the thesis's figure 7.9.
STEPS = {1: 2, 2: 1, 3: 13, 4: 7, 5: 14, 6: 5, 7: 3, 8: 10, 9: 11, 10: 9, 11: 6, 12: 4, 13: 12, 14: 8}


@cl.needs_shared('data/thesis/steps-model.hsp')
class ThesisLists(cl.CommandLineTest):
    def match(self, model, measured, *more):
        return self.run_json('match', '--model', os.path.join(THESIS, model), '--measured', os.path.join(THESIS, measured),
                             '--unsigned', '--unit', 'cm', *more)

    def test_staircase(self):
        match = self.match('steps-model.hsp', 'steps-measured.hsp')
        self.assertEqual({p['measured']: p['model'] for p in match['pairs']}, STEPS)
        identity = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
        self.assertLess(cl.rotation_angle_deg(match['pose']['rotation'], identity), 0.1)
        self.assertLess(max(map(abs, match['pose']['translation_mm'])), 0.1)

    def test_staircase_with_an_extra_face(self):
        match = self.match('steps-model.hsp', 'steps-measured-extra.hsp')
        self.assertEqual({p['measured']: p['model'] for p in match['pairs']}, STEPS)
        self.assertEqual(match['unmatched_measured'], [15])

    def test_channel(self):
        # Measured face -> model face by the equations in the two lists, as they stand and after half a turn about z.
        match = self.match('samp-model.hsp', 'samp-measured.hsp')
        pairs = {p['measured']: p['model'] for p in match['pairs']}
        as_it_stands = {1: 2, 2: 9, 3: 1, 4: 4, 5: 7, 6: 3, 7: 8, 8: 6, 9: 5}
        turned = {1: 5, 2: 9, 3: 4, 4: 1, 5: 8, 6: 3, 7: 7, 8: 6, 9: 2}
        self.assertIn(pairs, [as_it_stands, turned])

    def test_the_thesis_s_own_method(self):
        for links in 'all', 'modes':
            match = self.match('steps-model.hsp', 'steps-measured.hsp', '--method', 'procrustes', '--links', links)
            self.assertEqual(match['method'], 'procrustes')
            self.assertEqual({p['measured']: p['model'] for p in match['pairs']}, STEPS)
            self.assertAlmostEqual(match['rotation_deg']['angle'], 0.168, delta=0.01)
            self.assertIsNone(match['pose']['covariance'])
            printed_mm = [-0.016, -0.093, 0.015]
            difference_mm = match['procrustes']['plane_centre_difference_mm']
            self.assertLess(sum((a - b) ** 2 for a, b in zip(difference_mm, printed_mm)) ** 0.5, 0.03)

    def test_pairs_fixed_and_forbidden(self):
        rules = self.write('pairs.json', '{"fix": [[14, 5]], "forbid": [[13, 3]]}')
        match = self.match('steps-model.hsp', 'steps-measured-extra.hsp', '--pairs', rules)
        pairs = {p['measured']: p['model'] for p in match['pairs']}
        self.assertEqual(pairs, {k: v for k, v in STEPS.items() if k != 3})
        self.assertEqual(match['changes']['broken'], [{'model': 13, 'measured': 3}])
        self.assertEqual(match['changes']['made'], [])
        # The extra face 15 for the slope 14, at right angles to it: the part lies another way.
        rules = self.write('pairs.json', '{"fix": [[14, 15]]}')
        match = self.match('steps-model.hsp', 'steps-measured-extra.hsp', '--pairs', rules)
        self.assertEqual({p['measured']: p['model'] for p in match['pairs']}[15], 14)
        self.assertIn({'model': 14, 'measured': 15}, match['changes']['made'])
        self.assertGreater(match['changes']['turn_deg'], 80)


if __name__ == '__main__':
    cl.main()
