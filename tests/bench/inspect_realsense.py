# SPDX-License-Identifier: GPL-3.0-or-later
"""usage: inspect_realsense.py TETRAGAUGE FOLDER [SIGMA_MM]

Matches the RealSense scans of printed parts in FOLDER (CAD/, filtered/) to their CAD and compares with their true poses: how many are
matched within 5 degrees and 5 mm, up to the symmetries that the true poses list and the free directions that the report names.
Sigma: depth noise of a stereo camera is Z^2 s / (f B) (Intel, "Best-Known-Methods for Tuning Intel RealSense D400 Depth Cameras"); at
Z = 250 mm with sub-pixel s = 0.08, f = 420 pixels, B = 50 mm that is 0.24 mm.
"""
import glob
import json
import math
import os
import struct
import subprocess
import sys
import tempfile

SIGMA_MM = 0.24
GOOD_DEG, GOOD_MM = 5.0, 5.0


def times(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def transposed(a):
    return [list(row) for row in zip(*a)]


def apply(a, v):
    return [sum(a[i][k] * v[k] for k in range(3)) for i in range(3)]


def angle_deg(r):
    skew = math.sqrt((r[2][1] - r[1][2])**2 + (r[0][2] - r[2][0])**2 + (r[1][0] - r[0][1])**2)
    return math.degrees(math.atan2(skew, r[0][0] + r[1][1] + r[2][2] - 1))


def free_of(vector, axes):
    """Without its parts along the free directions."""
    for axis in axes:
        along = sum(a * b for a, b in zip(axis, vector))
        vector = [b - along * a for a, b in zip(axis, vector)]
    return vector


def surface_centroid_mm(stl):
    """Of a binary STL in cm: the true poses turn about it."""
    with open(stl, 'rb') as file:
        data = file.read()
    total, sums = 0.0, [0.0, 0.0, 0.0]
    for k in range(struct.unpack_from('<I', data, 80)[0]):
        v = struct.unpack_from('<9f', data, 84 + 50 * k + 12)
        a, b, c = v[0:3], v[3:6], v[6:9]
        u, w = [x - y for x, y in zip(b, a)], [x - y for x, y in zip(c, a)]
        area = math.dist((u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]), (0, 0, 0)) / 2
        total += area
        sums = [s + area * (x + y + z) / 3 for s, x, y, z in zip(sums, a, b, c)]
    return [10 * s / total for s in sums]


def error(pose, truth, centre, free):
    """(degrees, mm) between the pose (model from scan) and one true pose: p_scan = truth (p_model - centre)."""
    found = transposed(pose['rotation'])  # scan from model
    place = apply(found, [c - t for c, t in zip(centre, pose['translation_mm'])])
    true = [row[:3] for row in truth[:3]]
    shift = [a - 1000 * row[3] for a, row in zip(place, truth[:3])]
    turn = times(transposed(true), found)  # model frame
    spun = [f['axis'] for f in free if f['kind'] == 'rotation']
    # About a free axis any turn is as good: what counts is where the axis itself points.
    degrees = angle_deg(turn)
    if len(spun) == 1:
        image = apply(turn, spun[0])
        degrees = math.degrees(math.acos(max(-1.0, min(1.0, sum(a * b for a, b in zip(image, spun[0]))))))
    elif len(spun) > 1:
        degrees = 0.0
    slid = [apply(found, f['axis']) for f in free if f['kind'] == 'translation']
    return degrees, math.dist(free_of(shift, slid), (0, 0, 0))


def inspected(program, folder, scan, sigma):
    """(error of each pose that the report of one scan gives, the report); of no pose (None, what the program said)."""
    name = os.path.basename(scan).removesuffix('_Source.ply')
    with open(os.path.join(folder, 'filtered', name + '.json'), encoding='utf-8') as file:
        truth = json.load(file)
    stl = os.path.join(folder, 'CAD', truth['name'] + '.stl')
    centre = surface_centroid_mm(stl)
    with tempfile.TemporaryDirectory() as out:
        done = subprocess.run([program, 'inspect', scan, '--model', stl,
                               '--scan-unit', 'm', '--model-unit', 'cm', '--ray-origin', '0,0,0', '--sigma', str(sigma),
                               '--out', out, '--json', '-', '--quiet'], capture_output=True, text=True, check=False)
    if not done.stdout:
        return None, done.stderr.strip()
    report = json.loads(done.stdout)
    return [min((error(p, t, centre, report['undetermined']) for t in truth['transformation']), key=max)
            for p in [report['pose'], *report['equivalents']]], report


def is_good(e):
    return e[0] < GOOD_DEG and e[1] < GOOD_MM


def scans_in(folder):
    return sorted(glob.glob(os.path.join(folder, 'filtered', '*_Source.ply')))


def main():
    program, folder = sys.argv[1:3]
    sigma = float(sys.argv[3]) if len(sys.argv) > 3 else SIGMA_MM
    matched = determined = 0
    scans = scans_in(folder)
    print(f'{"scan":<20}{"degrees":>9}{"mm":>8}  poses  what')
    for scan in scans:
        name = os.path.basename(scan).removesuffix('_Source.ply')
        errors, report = inspected(program, folder, scan, sigma)
        if not errors:
            print(f'{name:<20}{"-":>9}{"-":>8}{"-":>7}  no pose: {report}')
            continue
        good = [is_good(e) for e in errors]
        matched += any(good)
        determined += any(good) and not report['undetermined']
        best = min(errors, key=max)
        what = 'matched' if good[0] else 'matched by one of its equivalents' if any(good) else 'WRONG'
        free = ', '.join(f['kind'] for f in report['undetermined'])
        faces = f'{len(report["pairs"])} faces paired'
        print(f'{name:<20}{best[0]:>9.2f}{best[1]:>8.2f}{len(errors):>7}  {what}; {faces}' + (f'; free: {free}' if free else ''), flush=True)
    print(f'{matched} of {len(scans)} matched within {GOOD_DEG:.0f} degrees and {GOOD_MM:.0f} mm, sigma {sigma} mm; '
          f'{determined} of them in all six directions, the others but for the free directions named')


if __name__ == '__main__':
    main()
