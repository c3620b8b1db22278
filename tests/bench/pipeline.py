# SPDX-License-Identifier: GPL-3.0-or-later
"""usage: pipeline.py PROGRAMS MODEL [POINTS...]

Time and memory from points to faces, reading and writing included: the model simulated at 1e3, 1e4, 1e5, 1e6 and 3e6 points (or POINTS),
then one run each of `tetragauge reconstruct` and `tetragauge faces` (which reconstructs by itself). Seconds by the clock, processor
seconds of all cores, memory at its peak; beside them CGAL's bare Delaunay_triangulation_3 of the same points, as CGAL sorts them.
"""
import os
import platform
import subprocess
import sys
import tempfile
import time

POINTS = (1e3, 1e4, 1e5, 1e6, 3e6)


def machine():
    name = platform.machine()
    with open('/proc/cpuinfo', encoding='utf-8') as file:
        for line in file:
            if line.startswith('model name'):
                name = line.split(':', 1)[1].strip()
                break
    return f'{name}, {os.cpu_count()} cores'


def run_and_measure(command):
    """Wall clock and processor seconds, and the peak of resident memory in MB."""
    start = time.monotonic()
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f'{" ".join(command)}: exit code {process.returncode}')
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def main():
    programs, model = (os.path.abspath(a) for a in sys.argv[1:3])
    tetragauge = os.path.join(programs, 'tetragauge')
    print(f'machine: {machine()}, load {os.getloadavg()[0]:.1f} at the start; seconds, cores: processor seconds of all cores; one run each')
    print('                  reconstruct                   faces         bare Delaunay   faces / bare')
    print('  points   clock   cores     MB    clock   cores     MB    clock   cores   clock   cores')
    with tempfile.TemporaryDirectory() as folder:
        scan = os.path.join(folder, 'scan.ply')
        for points in (int(float(a)) for a in sys.argv[3:] or POINTS):
            subprocess.run([tetragauge, 'simulate', '--model', model, '--out', scan, '--points', str(points), '--sigma', '0.02', '--quiet'],
                           check=True)
            whole = run_and_measure([tetragauge, 'reconstruct', scan, '--out', os.path.join(folder, 'mesh.ply'), '--quiet'])
            faces = run_and_measure([tetragauge, 'faces', scan, '--quiet'])
            bare = subprocess.run([os.path.join(programs, 'tetragauge-bare-delaunay'), scan], check=True, capture_output=True, text=True)
            bare_wall, bare_cores = (float(a) for a in bare.stdout.split()[1:])
            print(f'{points:>8}' + ''.join(f'{wall:>8.2f}{cores:>8.2f}{megabytes:>7.0f} ' for wall, cores, megabytes in (whole, faces))
                  + f'{bare_wall:>8.2f}{bare_cores:>8.2f}{faces[0] / bare_wall:>8.1f}{faces[1] / bare_cores:>8.1f}', flush=True)


if __name__ == '__main__':
    main()
