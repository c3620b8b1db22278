# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts in OpenSCAD's language: its own mesh of a part against what `tetragauge model` makes of its .csg text."""
import math
import os
import shutil
import struct
import subprocess
import unittest

import command_line as cl

# Numbers that six digits hold, so that what OpenSCAD prints is the part.
PARTS = {
    'cube': 'cube([10, 20, 30]);',
    'turned_cube': 'rotate([10, 20, 30]) cube([10, 20, 30], center = true);',
    'prism': 'cylinder(h = 10, r = 4, $fn = 6);',
    'pyramid': 'translate([3, 4, 5]) cylinder(h = 12, r1 = 8, r2 = 0, $fn = 4);',
    'truncated_cone': 'rotate([0, 90, 0]) cylinder(h = 12, r1 = 8, r2 = 3, $fn = 24);',
    'turned_cone': 'rotate([35, -20, 70]) translate([1, 2, 3]) cylinder(h = 12, r1 = 3, r2 = 8, $fn = 17);',
    'upside_down': 'mirror([0, 0, 1]) cylinder(h = 12, r1 = 8, r2 = 3, $fn = 9);',
    'ball': 'sphere(r = 10, $fn = 14);',
    'ball_of_odd_sides': 'sphere(d = 12, $fn = 9);',
    'default_facets': 'cylinder(h = 5, r = 7); translate([30, 0, 0]) sphere(3);',
    'fine_facets': 'cylinder(h = 5, r = 7, $fa = 5, $fs = 0.5);',
    'hole': 'difference() { cube([40, 40, 10], center = true); cylinder(h = 20, r = 5, center = true, $fn = 32); }',
    'nested': '''difference() {
        union() { cube([40, 40, 10]); translate([10, 10, 10]) cube([20, 20, 15]);
                  intersection() { translate([20, 20, 0]) cylinder(h = 40, r = 8, $fn = 12); cube([30, 30, 32]); } }
        translate([20, 20, -1]) cylinder(h = 50, r = 3, $fn = 7);
        for (x = [5, 35], y = [5, 35]) translate([x, y, -1]) cylinder(h = 12, r = 2, $fn = 5); }''',
    'mirrored_pair': '''module half() { difference() { cube([20, 15, 8]); translate([10, 8, 4]) rotate([0, 30, 0])
        cylinder(h = 30, r = 3, center = true, $fn = 10); } }
        half(); mirror([1, 0, 0]) half();''',
    'mirror_about_a_slanted_plane': 'mirror([1, 2, 3]) difference() { cube([10, 12, 14]); translate([2, 2, 2]) cube([20, 3, 4]); }',
    'uneven_scale': 'scale([1, 2, 0.5]) rotate([0, 0, 30]) cylinder(h = 10, r = 5, $fn = 8);',
    'skew': 'multmatrix([[1, 0.25, 0, 0], [0, 1, 0.5, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) cube([10, 10, 10]);',
    'touching': 'cube([10, 10, 10]); translate([10, 0, 0]) cube([5, 10, 10]); translate([0, 10, 0]) cube([15, 4, 10]);',
    'touching_when_turned': '''rotate([10, 20, 30]) { cube([50, 40, 30]); translate([50, 0, 0]) cube([20, 40, 30]);
        translate([0, 0, 30]) cube([70, 20, 10]); }''',
    'polygon_with_holes': '''linear_extrude(height = 5, center = true) polygon(
        points = [[0, 0], [30, 0], [30, 20], [0, 20], [5, 5], [10, 5], [10, 10], [5, 10], [15, 5], [25, 5], [20, 15]],
        paths = [[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10]]);''',
    'flat_booleans': '''linear_extrude(height = 4) difference() { union() { square([30, 10]); translate([15, 10]) circle(r = 8, $fn = 20); }
        translate([5, 5]) circle(r = 3, $fn = 6); translate([20, 2]) square([4, 4]); }''',
    'flat_mirror': 'linear_extrude(height = 4) mirror([1, 1]) polygon([[0, 0], [12, 0], [3, 9]]);',
    'ring': 'rotate_extrude($fn = 16) translate([10, 0]) square([4, 6]);',
    'turned_hole': 'rotate_extrude($fn = 20) difference() { translate([5, 0]) square([10, 8]); translate([10, 4]) circle(r = 2, $fn = 8); }',
    'part_of_a_turn': 'rotate_extrude(angle = 120, $fn = 24) translate([10, 0]) square([4, 6]);',
    'turn_on_the_axis': 'rotate_extrude($fn = 12) polygon([[0, 0], [8, 0], [4, 6], [0, 10]]);',
    'polyhedron': '''polyhedron(points = [[0, 0, 0], [20, 0, 0], [20, 10, 0], [0, 10, 0], [5, 5, 15]],
        faces = [[4, 1, 0], [4, 2, 1], [4, 3, 2], [4, 0, 3], [0, 1, 2, 3]]);''',
    'coloured_and_rendered': 'color("red") render() difference() { cube(10); translate([2, 2, 2]) cube(20); }',
    'two_bodies': 'cube(5); translate([20, 0, 0]) rotate([0, 0, 45]) cube([4, 5, 6]);',
    'loops_and_functions': '''function f(i) = 4 + i; difference() { cube([60, 10, 10]);
        for (i = [0 : 4]) translate([8 + 11 * i, 5, 10 - f(i) / 2]) cylinder(h = 10, r = 2 + i / 4, $fn = 6 + i); }''',
}

# (name, truly round, the same with N sides): a body of revolution has (N / pi) sin(pi / N) cos(pi / N) of its section.
ROUND_PARTS = {
    'cylinder': 'cylinder(h = 20, r = 7, $fn = {n});',
    'cone': 'rotate([20, 30, 40]) cylinder(h = 20, r1 = 9, r2 = 4, $fn = {n});',
    'tube': 'difference() {{ cylinder(h = 20, r = 9, $fn = {n}); translate([0, 0, -1]) cylinder(h = 30, r = 5, $fn = {n}); }}',
    'ring': 'rotate_extrude($fn = {n}) translate([10, 0]) square([4, 6]);',
    'disc': 'linear_extrude(height = 3) circle(r = 11, $fn = {n});',
}
SIDES = 400


def stl_volume_and_area(path):
    with open(path, 'rb') as file:
        content = file.read()
    volume = area = 0.0
    for values in struct.iter_unpack('<12fH', content[84:]):
        a, b, c = values[3:6], values[6:9], values[9:12]
        u, v = [q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]
        n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        area += math.sqrt(sum(x * x for x in n)) / 2
        volume += sum(p * x for p, x in zip(a, n)) / 6
    return volume, area


@unittest.skipUnless(shutil.which('openscad'), 'SKIPPED ALL: openscad is not installed (script/setup installs it)')
class OpenScad(cl.CommandLineTest):
    def export(self, name, text, ending):
        self.write(name + '.scad', text)
        # Binary STL: floats, where the text has six digits.
        binary = ['--export-format', 'binstl'] if ending == '.stl' else []
        done = subprocess.run(['openscad', *binary, '-o', self.path(name + ending), self.path(name + '.scad')],
                              capture_output=True, text=True, timeout=120, env={**os.environ, 'QT_QPA_PLATFORM': 'offscreen'})
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.path(name + ending)

    def test_facets_have_the_volume_and_area_of_openscads_mesh(self):
        for name, text in PARTS.items():
            with self.subTest(name):
                volume, area = stl_volume_and_area(self.export(name, text, '.stl'))
                model = self.run_json('model', self.export(name, text, '.csg'), '--facets')
                self.assertEqual(model['warnings'], [])
                self.assertAlmostEqual(model['volume_mm3'] / volume, 1, delta=1e-6)
                self.assertAlmostEqual(model['area_mm2'] / area, 1, delta=1e-6)
                self.assertEqual(set(model['count_by_type']), {'plane'})

    def test_round_bodies_are_rounder_than_any_mesh(self):
        share = SIDES / math.pi * math.sin(math.pi / SIDES) * math.cos(math.pi / SIDES)
        for name, text in ROUND_PARTS.items():
            with self.subTest(name):
                volume, _ = stl_volume_and_area(self.export(name, text.format(n=SIDES), '.stl'))
                model = self.run_json('model', self.export(name + '_round', text.format(n=0), '.csg'))
                self.assertNotEqual(set(model['count_by_type']), {'plane'})
                self.assertAlmostEqual(model['volume_mm3'] * share / volume, 1, delta=2e-6)

    def test_the_mesh_is_the_same_part(self):
        # OpenSCAD's STL read as a mesh: the same volume, and planes where .csg has them.
        for name in ('nested', 'touching_when_turned', 'polygon_with_holes', 'mirrored_pair'):
            with self.subTest(name):
                mesh = self.run_json('model', self.export(name, PARTS[name], '.stl'), '--facets')
                model = self.run_json('model', self.export(name, PARTS[name], '.csg'), '--facets')
                self.assertEqual(len(mesh['faces']), len(model['faces']))
                self.assertAlmostEqual(mesh['volume_mm3'] / model['volume_mm3'], 1, delta=1e-6)


if __name__ == '__main__':
    cl.main()
