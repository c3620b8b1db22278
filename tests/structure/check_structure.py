#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""usage: check_structure.py includes|spdx|formatting ROOT [--clang-format PROGRAM]

includes: every #include between folders of the project is an edge of the layers below, or follows from them.
spdx: every source file says its licence, the one of its folder.  formatting: clang-format would change nothing.
"""
import argparse
import os
import re
import subprocess
import sys

# Who may include whom, directly; edges are transitive. None goes back.
EDGES = {
    'host/base': [],
    'host/geometry': ['host/base'],
    'host/scan': ['host/geometry'],
    'host/solid': ['host/geometry'],
    'host/simulate': ['host/scan', 'host/solid'],
    'host/reconstruct': ['host/scan', 'host/solid'],
    'host/faces': ['host/reconstruct'],
    'host/match': ['host/faces', 'host/solid'],
    'host/inspect': ['host/match'],
    'host/report': ['host/inspect'],
    'host/history': ['host/report'],
    'host/link': ['host/base', 'protocol', 'firmware/optics'],
    'host/hello': ['host/link'],
    'host/session': ['host/link', 'host/scan'],
    # The firmware's own rules say how long it takes, its optics where it reaches.
    'host/plan': ['host/session', 'host/solid', 'firmware'],
    'host/measure': ['host/plan', 'host/report'],
    'host/teach': ['host/session'],
    'host/cli': ['host/teach', 'host/measure', 'host/history', 'host/simulate'],
    'protocol': [],
    'firmware': ['protocol'],
    'firmware/optics': [],
    'sim': ['host/solid'],
    'boards/emulated': ['firmware', 'sim', 'host/solid'],
    'boards/emulated/emulator': ['boards/emulated', 'boards/mps2_an386'],
    'boards/cortex_m4': [],
    'boards/stm32_h405': ['boards/cortex_m4', 'firmware'],
    'boards/mps2_an386': ['boards/cortex_m4', 'boards/emulated'],
}
# Libraries that one folder keeps to itself.
ONLY_IN = {
    r'CGAL/': ['host/reconstruct', 'host/faces', 'tests/bench'],
    r'sqlite3\.h': ['host/history'],
    r'boost/math/': ['host/history'],
    r'boost/graph/': ['host/reconstruct', 'host/faces'],
    r'embree': ['host/solid'],
    r'libserialport': ['host/link', 'tests/pty_preload'],
    r'pb(_encode|_decode|_common)?\.h': ['protocol'],
    r'CLI/': ['host/cli', 'host/hello', 'boards/emulated', 'tests/bench'],
    r'(gp_|TopoDS|BRep|STEP|Standard_|Geom|TopExp|TDF|XCAF|Poly_|GProp|Shape)\w*\.hxx': ['host/solid'],
}
LICENCES = [('host/', 'GPL-3.0-or-later'), ('sim/', 'GPL-3.0-or-later'), ('tests/', 'GPL-3.0-or-later'),
            ('protocol/', 'Apache-2.0'), ('firmware/', 'Apache-2.0'), ('boards/', 'Apache-2.0')]
SOURCE = ('.cpp', '.hpp', '.c', '.h', '.py', '.proto', '.cmake', '.scad', '.s', '.S', '.ld', '.sh', '.js', '.css')


def files(root):
    for folder, names, entries in os.walk(root):
        names[:] = sorted(n for n in names if n not in ('build', '.git', 'node_modules', '__pycache__'))
        for entry in sorted(entries):
            yield os.path.relpath(os.path.join(folder, entry), root)


def module_of(path):
    """The longest module that holds the file, or None."""
    best = None
    for module in EDGES:
        if path.startswith(module + '/') and (best is None or len(module) > len(best)):
            best = module
    return best


def reachable(module):
    seen, todo = set(), [module]
    while todo:
        at = todo.pop()
        if at not in seen:
            seen.add(at)
            todo += EDGES[at]
    if 'firmware' in seen:
        seen.add('firmware/optics')
    return seen


def allowed(path, target):
    """Whether the file may include the file `target`, both from the root."""
    module, other = module_of(path), module_of(target)
    if module is None or other is None or other == module:
        return True
    # firmware/optics is a part of firmware that others may see alone; within firmware all is one module.
    if module.startswith('firmware') and other.startswith('firmware'):
        return module == 'firmware'
    if path.endswith('_test.cpp') or os.path.basename(path).startswith('test_'):  # a test may check against any layer, as its oracle
        return True
    return other in reachable(module)


def check_includes(root):
    for path in files(root):
        if not path.endswith(('.cpp', '.hpp', '.c', '.h')):
            continue
        module = module_of(path) or path.rsplit('/', 1)[0]
        for number, line in enumerate(open(os.path.join(root, path), encoding='utf-8'), 1):
            match = re.match(r'\s*#\s*include\s*([<"])([^>"]+)[>"]', line)
            if not match:
                continue
            target = match[2]
            if match[1] == '"' and '/' not in target:
                yield f'{path}:{number}: write includes from the root of the repository, not "{target}"'
            elif not allowed(path, target):
                yield f'{path}:{number}: {module} must not include {target} (layers: DESIGN, docs/code-flow.md)'
            for pattern, owners in ONLY_IN.items():
                if match[1] == '<' and re.match(pattern, target) and not any(
                        module == o or module.startswith(o + '/') for o in owners):
                    yield f'{path}:{number}: {target} is for {", ".join(owners)} only'


def check_spdx(root):
    for path in files(root):
        name = os.path.basename(path)
        is_script = path.startswith('script/') or path == '.ci/run'
        if not (path.endswith(SOURCE) or name == 'CMakeLists.txt' or is_script):
            continue
        with open(os.path.join(root, path), encoding='utf-8') as file:
            head = file.readline() + file.readline()
        match = re.search(r'SPDX-License-Identifier: (\S+)', head)
        if not match:
            yield f'{path}: no SPDX-License-Identifier in its first two lines'
            continue
        wanted = next((licence for prefix, licence in LICENCES if path.startswith(prefix)), None)
        if wanted and match[1] != wanted:
            yield f'{path}: its licence is {match[1]}, that of its folder {wanted}'


def check_formatting(root, clang_format):
    sources = [p for p in files(root) if p.endswith(('.cpp', '.hpp', '.c', '.h'))]
    for start in range(0, len(sources), 50):
        batch = sources[start:start + 50]
        result = subprocess.run([clang_format, '--dry-run', '-Werror', *batch], cwd=root, capture_output=True, text=True)
        bad = sorted({line.split(':')[0] for line in result.stderr.splitlines() if 'code should be clang-formatted' in line})
        if result.returncode != 0 and not bad:
            yield result.stderr.strip()
        for path in bad:
            yield f'{path}: not formatted; run script/format'


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('check', choices=['includes', 'spdx', 'formatting'])
    parser.add_argument('root')
    parser.add_argument('--clang-format', default='clang-format-14')
    arguments = parser.parse_args()
    faults = list({'includes': check_includes, 'spdx': check_spdx,
                   'formatting': lambda root: check_formatting(root, arguments.clang_format)}[arguments.check](arguments.root))
    print('\n'.join(faults) or 'nothing to mend')
    sys.exit(1 if faults else 0)


if __name__ == '__main__':
    main()
