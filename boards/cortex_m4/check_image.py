#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""usage: check_image.py IMAGE.elf --interrupts "LOW .. / HIGH .." [--flash-kb N] [--ram-kb N]

What an image takes, against its budgets: flash, memory with the stack in it, the most stack that any chain of calls takes;
and that nothing of a heap, of exceptions or of run-time type information got in. The compiler's call graphs (.ci) are
looked for beside the image. Exit code 1 when something is too much.
"""
import argparse
import os
import re
import subprocess
import sys

BANNED = re.compile(r'(?:^|\s)(malloc|free|calloc|realloc|_malloc_r|_free_r|_sbrk|operator new\(unsigned int\)|operator delete.*|__cxa_throw|'
                    r'__cxa_begin_catch|__gxx_personality.*|typeinfo for .*|_Unwind_.*|abort)$')
WORST_STACK = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'firmware', 'arm_check', 'worst_stack.py')


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def sections(image):
    """name -> (bytes, address, takes room in the file)"""
    found = {}
    for line in run('arm-none-eabi-objdump', '-h', '-w', image).splitlines():
        parts = line.split()
        if len(parts) > 6 and parts[0].isdigit() and 'ALLOC' in line:
            found[parts[1]] = (int(parts[2], 16), int(parts[3], 16), 'CONTENTS' in line)
    return found


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('image')
    parser.add_argument('--interrupts', required=True)
    parser.add_argument('--flash-kb', type=int, default=192)
    parser.add_argument('--ram-kb', type=int, default=64)
    arguments = parser.parse_args()
    faults = []

    parts = sections(arguments.image)
    flash = sum(size for size, _, in_file in parts.values() if in_file)
    ram = sum(size for size, address, _ in parts.values() if address >= 0x20000000)
    stack = parts['.stack'][0]
    name = os.path.basename(arguments.image)
    print(f'{name}')
    for what, used, most in (('flash', flash, arguments.flash_kb * 1024), ('memory', ram, arguments.ram_kb * 1024)):
        print(f'  {what:7s} {used:7d} of {most} bytes ({100 * used / most:.1f} %)' + (f', {stack} of them the stack' if what == 'memory' else ''))
        if used > most:
            faults.append(f'{what}: {used} bytes are more than {most}')

    symbols = run('arm-none-eabi-nm', '-C', arguments.image)
    banned = [line for line in symbols.splitlines() if BANNED.search(line.split(' ', 2)[-1])]
    print(f'  heap, exceptions, RTTI: {"none" if not banned else len(banned)}')
    faults += [f'must not be in an image: {line}' for line in banned]

    folder = os.path.dirname(os.path.abspath(arguments.image))
    linked = os.path.join(folder, 'linked.txt')
    with open(linked, 'w', encoding='utf-8') as out:
        out.write('\n'.join(line.split()[-1] for line in run('arm-none-eabi-nm', arguments.image).splitlines()))
    graphs = sorted(os.path.join(at, file) for at, _, files in os.walk(folder) for file in files if file.endswith('.ci'))
    worst = subprocess.run([sys.executable, '-B', WORST_STACK, '--most', str(stack), '--main', 'tetragauge_start', '--interrupts',
                            arguments.interrupts, linked, *graphs], capture_output=True, text=True)
    print('\n'.join('  ' + line for line in worst.stdout.splitlines()))
    if worst.returncode != 0:
        faults.append(worst.stderr.strip())
    for fault in faults:
        print(f'check_image: {name}: {fault}', file=sys.stderr)
    sys.exit(1 if faults else 0)


main()
