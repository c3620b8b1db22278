#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""usage: make_file_seeds.py EXAMPLES_DIR OUT_DIR

The first inputs of the fuzzers of file readers: scan_files/, models/ and texts/ each have a small valid file of every
kind, behind the byte that chooses its reader (fuzz_scan_files.cpp, fuzz_models.cpp, fuzz_texts.cpp), and the broken
ones that people send: cut short, not a number, no points, counts of billions, another kind than the ending says.
"""
import os
import struct
import sys

CORNERS = [(x, y, z) for x in (0, 10) for y in (0, 20) for z in (0, 30)]
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
TRIANGLES = [t for q in QUADS for t in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))]


def rows(table):
    return '\n'.join(' '.join(map(str, row)) for row in table) + '\n'


def models():
    stl = 'solid box\n' + ''.join(
        'facet normal 0 0 0\nouter loop\n' + ''.join('vertex %g %g %g\n' % CORNERS[i] for i in t) +
        'endloop\nendfacet\n' for t in TRIANGLES) + 'endsolid box\n'
    binary_stl = bytes(80) + struct.pack('<I', len(TRIANGLES)) + b''.join(
        bytes(12) + b''.join(struct.pack('<3f', *CORNERS[i]) for i in t) + b'\0\0' for t in TRIANGLES)
    obj = 'o box\nvn 0 0 1\n' + ''.join('v %g %g %g\n' % c for c in CORNERS) + ''.join(
        'f %d//1 %d/1/1 %d -%d\n' % (q[0] + 1, q[1] + 1, q[2] + 1, 8 - q[3]) for q in QUADS)
    off = 'OFF # a box\n8 6 12\n' + rows(CORNERS) + rows((4, *q) for q in QUADS)
    head = ('ply\nformat %s 1.0\ncomment unit mm\nelement vertex 8\nproperty float x\nproperty float y\n'
            'property float z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n')
    ascii_ply = (head % 'ascii') + rows(CORNERS) + rows((4, *q) for q in QUADS)

    def binary_ply(order, name):
        return (head % name).encode() + b''.join(struct.pack(order + '3f', *c) for c in CORNERS) + b''.join(
            struct.pack(order + 'B4i', 4, *q) for q in QUADS)

    csg = ('group() {\n\tmultmatrix([[1, 0, 0, 5], [0, 1, 0, -2.5e-3], [0, 0, 1, 0], [0, 0, 0, 1]]) {\n'
           '\t\tdifference() {\n\t\t\tcube(size = [10, 20, 30], center = false);\n\t\t\t#cylinder($fn = 0, $fa = 12, '
           '$fs = 2, h = 60, r1 = 4, r2 = 4, center = true);\n\t\t}\n\t}\n\t%text(text = "a\\"b", size = undef);\n}\n'
           '/* end */ polyhedron(points = [[0, 0, 0]], faces = [[]], convexity = 1); // line\n')
    files = [('stl', 0, stl), ('binary_stl', 0, binary_stl), ('obj', 1, obj), ('off', 2, off), ('ply', 3, ascii_ply),
             ('binary_ply', 3, binary_ply('<', 'binary_little_endian')),
             ('big_endian_ply', 3, binary_ply('>', 'binary_big_endian')), ('csg', 4, csg)]
    files += [('stl_count', 0, bytes(80) + b'\xff' * 4 + bytes(50)),
              ('off_count', 2, 'OFF 4000000000 4000000000 0\n0 0 0\n'),
              ('off_corners', 2, 'OFF 1 1 0\n0 0 0\n4000000000 0 0 0\n'),
              ('ply_count', 3, (head % 'ascii').replace('vertex 8', 'vertex 4000000000')),
              ('ply_list', 3, (head % 'binary_little_endian').replace('uchar', 'double').replace('vertex 8', 'vertex 0')
               .encode() + b'\xff' * 6 + b'\xef\x7f' + bytes(60)),
              ('csg_lists', 4, 'cube(' + '[' * 2000), ('csg_calls', 4, 'group(){' * 2000),
              ('csg_numbers', 4, 'multmatrix([[1e308, 0, 0, 1e-320], [0, 1e308, 0, 0], [0, 0, 1e308, 0], [0, 0, 0, 1]]) {\n'
               'cube(size = 5, center = 1); sphere($fn = 7.5, r = -1); circle($fn = 1e300, $fa = 0, $fs = -0, r = 1e-9); }\n'),
              ('csg_extrude', 4, 'linear_extrude(height = 10, center = true, scale = [1, 1]) { polygon(points = [[0, 0], '
               '[9, 0], [0, 9]], paths = [[0, 1, 2], [-1, 4294967296, 0.5]], convexity = 1); square(size = [1, 2, 3]); }\n'
               'rotate_extrude(angle = 360, $fn = 48, $fa = 12, $fs = 2) { circle($fn = 24, r = 3); }\n'),
              ('point', 1, 'v 0 0 0\n' * 3 + 'f 1 2 3\n'), ('tiny', 2, off.replace('10', '1e-320').replace(
                  '20', '1e-320').replace('30', '1e-320')), ('huge', 2, off.replace('10', '1e300'))]
    return files


def scans():
    own = ['double x', 'double y', 'double z', 'double ray_x', 'double ray_y', 'double ray_z', 'float sigma',
           'float intensity', 'uint view', 'uint flags']
    beams = ['double origin_x', 'double origin_y', 'double origin_z', 'double direction_x', 'double direction_y',
             'double direction_z', 'uint reason', 'uint view']
    points = [(1.5, -2.25, 40 + i, 350, i, 200, 0.03125, 0.5, 1, i) for i in range(3)]
    rejected = [(350, 0, 200, 0, 0, -1, 2, 1)]

    def head(name, points=3, beams_there=1):
        return (f'ply\nformat {name} 1.0\ncomment frame part\ncomment unit mm\ncomment u_cal_mm 0.004\n'
                f'comment seed 7\ncomment machine_id m\nelement vertex {points}\n' +
                ''.join(f'property {p}\n' for p in own) + f'element rejected {beams_there}\n' +
                ''.join(f'property {p}\n' for p in beams) + 'end_header\n')

    def body(order):
        return b''.join(struct.pack(order + '6d2f2I', *p) for p in points) + struct.pack(order + '6d2I', *rejected[0])

    pcd = ('# .PCD v0.7\nVERSION 0.7\nFIELDS x y z normal_x normal_y normal_z\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\n'
           'COUNT 1 1 1 1 1 1\nWIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n'
           '1 2 3 0 0 1\nnan nan nan 0 0 1\n4 5 6 0 1 0\n')
    cloud = rows([(1, 2, 3), (4, 5.5, -6e-1)])
    ply = head('binary_little_endian').encode() + body('<')
    files = [('own', 0, ply), ('big_endian', 0, head('binary_big_endian').encode() + body('>')),
             ('ascii', 0, head('ascii') + rows(points) + rows(rejected)), ('pcd', 1 | 32, pcd),
             ('xyz', 2 | 8 | 32, cloud), ('xyz_m', 2 | 4 | 16 | 32, cloud.replace(' ', ';')),
             ('normals', 2 | 32, '1 2 3 0 0 1\n'), ('csv', 3 | 16, 'x,y,z,sigma,intensity\r\n1,2,3,0.1,1\r\n')]
    files += [('cut', 0, ply[:-20]), ('more', 0, ply + b'\0' * 64), ('nan', 0, head('ascii', 1, 0) + 'nan ' * 10),
              ('none', 0, head('ascii', 0, 0)), ('count', 0, head('binary_little_endian', 4000000000).encode() + body('<')),
              ('huge', 0, head('ascii', 1, 0) + '1 2 3 1e300 5 6 1e30 1e300 4294967296 1.5\n'),
              ('pcd_count', 1 | 32, pcd.replace('POINTS 3', 'POINTS 18446744073709551615')),
              ('pcd_binary', 1 | 32, pcd.replace('ascii', 'binary')), ('csv_twice', 3 | 8 | 32, 'x,y,z,x\n1,2,3,4\n'),
              ('binary_as_text', 2 | 8 | 32, body('<')), ('words', 2 | 8 | 32, 'to whom it may concern\n' * 3)]
    return files


def texts(examples):
    hsp = '# a wedge\n1 0 0 1 -30 200\n2 1 0 0 -10 600 # side\n3 0 -2 0 0 300\n'
    faces = ('{"schema": "s", "unit": "mm", "faces": [{"id": 1, "surface": 1, "type": "plane", "normal": [0, 0, 1], '
             '"d_mm": 30, "point_mm": [0, 0, 30], "area_mm2": 200, "covariance": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], '
             '"u": [1, 0, 0], "v": [0, 1, 0], "neighbours": [2], "points": 9}, {"id": 2, "type": "cone", "axis": [0, 0, 1], '
             '"point_on_axis_mm": [0, 0, 0], "radius_mm": 4, "half_angle_rad": 0.5, "concave": true, "area_mm2": 9}]}')
    tolerances = ('{"default": {"profile_mm": 0.1}, "type": {"plane": {"offset_mm": 0.05}}, "surface": {"2": '
                  '{"profile_mm": 1}}, "face": {"3": {"flatness_mm": 0.02}}, "skip": [1], "min_coverage": 0.4}')
    plan = ('{"window_mm": {"y": [-20, 20], "up": [0, 40]}, "pitch_mm": 2, "samples": 64, "views": [{"table_deg": 0, '
            '"slide_mm": 150}, {"table_deg": 90.5, "slide_mm": 10, "pitch_mm": 1}]}')
    world = '{"camera_1": {"shift_mm": [0.05, 0, 0]}, "numbers": {"slide_start_steps": 7}}'
    faults = ('interlock@2.5s,flash@1s+300ms:5uA,adc_rail@1s:2x1,mirror_stuck@300ms:b,link_cut@5s+2s,'
              'link_flip/to_host=1e-4,link_delay=0.5:50ms,seed=7')
    run = b'r\x10' + struct.pack('<4I', 5, 1, 0, 0)
    files = [('hsp', 0, hsp), ('faces', 1, faces), ('tolerances', 2, tolerances), ('plan', 3, plan), ('world', 4, world),
             ('faults', 5, faults), ('journal', 6, b'TGJRNL1\n' + struct.pack('<I', 2) + b'o{}' + bytes(4)),
             ('records', 7, b'o\x02{}' + run)]
    files += [('hsp_huge', 0, '1 1e200 1e200 1e200 1 1\n'), ('hsp_far', 0, '1 1e-8 0 0 1e305 1e308\n'),
              ('faces_wrap', 1, faces.replace('"id": 1', '"id": 4294967297')),
              ('faces_deep', 1, '{"faces": ' + '[' * 3000), ('faces_float', 1, faces.replace('"id": 1', '"id": 1e300')),
              ('tolerances_wrap', 2, tolerances.replace('[1]', '[4294967297]')),
              ('tolerances_deep', 2, '{"default": {"profile_mm": ' + '[' * 3000 + ']' * 3000 + '}}'),
              ('plan_deep', 3, '{"views": ' + '[' * 3000 + ']' * 3000 + '}'), ('plan_nan', 3, plan.replace('0.5', 'nan'))]
    with open(os.path.join(examples, 'staircase', 'tolerances.json'), encoding='utf-8') as file:
        files.append(('staircase', 2, file.read()))
    return files


def main():
    for folder, files in (('scan_files', scans()), ('models', models()), ('texts', texts(sys.argv[1]))):
        target = os.path.join(sys.argv[2], folder)
        os.makedirs(target, exist_ok=True)
        for name, chooser, content in files:
            data = content.encode() if isinstance(content, str) else content
            with open(os.path.join(target, name), 'wb') as file:
                file.write(bytes([chooser]) + data)


main()
