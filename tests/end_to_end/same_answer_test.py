# SPDX-License-Identifier: GPL-3.0-or-later
"""Shuffling a scan or changing the number of threads changes no byte of the answer; moving it moves the answer."""
import json
import random
import struct

import command_line as cl

# Quarter turns and a shift by powers of two, where nothing is rounded much, and any other pose.
POSES = [((90, 0, 180), (64.0, -32.0, 128.0)), ((17.3, -41.9, 118.7), (250.0, -90.0, 35.0))]
SIZES = {'double': 'd', 'float': 'f', 'uint': 'I', 'uchar': 'B'}


class Ply:
    """A binary scan: its header and its vertices as bytes."""

    def __init__(self, data):
        end = data.index(b'end_header\n') + len(b'end_header\n')
        self.header, body = data[:end], data[end:]
        record, count, inside = '<', 0, False
        for line in self.header.decode().splitlines():
            words = line.split()
            if words[0] == 'element':
                inside = words[1] == 'vertex'
                count = int(words[2]) if inside else count
            elif words[0] == 'property' and inside:
                record += SIZES[words[1]]
        size = struct.calcsize(record)
        self.record = record
        self.vertices = [body[i * size:(i + 1) * size] for i in range(count)]
        self.rest = body[count * size:]

    def bytes(self, vertices):
        return self.header + b''.join(vertices) + self.rest


class SameAnswer(cl.CommandLineTest):
    def setUp(self):
        super().setUp()
        done = self.run_command('simulate', '--model', cl.NOMINAL, '--out', 'scan.ply', '--points', 12000, '--sigma', 0.03)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.scan = Ply(self.read('scan.ply'))

    def output(self, command, scan, threads):
        """What the command says on stdout and, for reconstruct, the surface it writes."""
        options = ('--out', 'surface.ply') if command == 'reconstruct' else ()
        done = self.run_command(command, scan, *options, '--json', '-', '--quiet', '--threads', threads)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(json.loads(done.stdout))
        return done.stdout, self.read('surface.ply') if options else b''

    def test_shuffles_and_threads(self):
        for command in ('reconstruct', 'faces'):
            first = self.output(command, 'scan.ply', 1)
            self.assertEqual(self.output(command, 'scan.ply', 1), first, f'{command}, the second run')
            for threads in (0, 2, 5):
                self.assertEqual(self.output(command, 'scan.ply', threads), first, f'{command}, {threads} threads')
            for seed in (1, 2, 3):
                vertices = list(self.scan.vertices)
                random.Random(seed).shuffle(vertices)
                self.write('shuffled.ply', self.scan.bytes(vertices))
                self.assertEqual(self.output(command, 'shuffled.ply', 2), first, f'{command}, shuffle {seed}')

    def test_moved_scans(self):
        here = json.loads(self.output('faces', 'scan.ply', 0)[0])['faces']
        self.assertEqual(len(here), 15)
        for angles, shift in POSES:
            rotation = cl.rotation_from_degrees(*angles)
            moved = []
            for vertex in self.scan.vertices:
                v = list(struct.unpack(self.scan.record, vertex))
                v[0:3], v[3:6] = cl.move(rotation, shift, v[0:3]), cl.move(rotation, shift, v[3:6])
                moved.append(struct.pack(self.scan.record, *v))
            self.write('moved.ply', self.scan.bytes(moved))
            there = json.loads(self.output('faces', 'moved.ply', 0)[0])['faces']
            self.assertEqual(len(there), len(here))
            for face in here:
                normal = cl.move(rotation, (0, 0, 0), face['normal'])
                d = face['d_mm'] + sum(n * t for n, t in zip(normal, shift))
                point = cl.move(rotation, shift, face['point_mm'])
                same = min(there, key=lambda f: sum((a - b)**2 for a, b in zip(f['point_mm'], point)))
                # Averaged vertices lie on a lattice of the scan's axes, so another pose may give a border point to the other side:
                # the planes agree far below sigma / sqrt(n), 0.001 mm here.
                self.assertLess(max(abs(a - b) for a, b in zip(same['normal'], normal)), 2e-5, face['id'])
                self.assertLess(abs(same['d_mm'] - d - sum((a - b) * p for a, b, p in zip(same['normal'], normal, point))),
                                3e-4, face['id'])
                self.assertLess(abs(same['area_mm2'] / face['area_mm2'] - 1), 0.01, face['id'])
                self.assertEqual(len(same['neighbours']), len(face['neighbours']), face['id'])


if __name__ == '__main__':
    cl.main()
