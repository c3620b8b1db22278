#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""usage: worst_stack.py --most BYTES [--main NAME] [--interrupts "LOW [LOW...] / HIGH ..."] LINKED_SYMBOLS FILE.ci...

The most stack that any chain of calls takes, from the compiler's call graph with its frames (-fcallgraph-info=su): main
program and, on top of it, the interrupts by priority. Assumed on the safe side:
- a call through a pointer goes to whichever linked function nobody calls by name that takes most;
- functions that call one another in a circle (nanopb, a message within a message) run through the whole circle once for
  each level of messages: 4, Host- or MachineMessage > Config > StageConfig > AxisMotion;
- a function without a known frame (the compiler's own helpers, memcpy) takes 64 bytes.
"""
import argparse
import re
import sys

MESSAGE_LEVELS = 4
UNKNOWN_BYTES = 64
EXCEPTION_BYTES = 112  # what the processor stacks with its floating-point registers, and alignment
INDIRECT = '__indirect_call'


def read_graph(paths, linked):
    frames, names, calls = {}, {}, {}
    for path in paths:
        text = open(path, encoding='utf-8').read()
        for title, label in re.findall(r'node: { title: "([^"]+)" label: "([^"]*)"', text):
            size = re.search(r'(\d+) bytes \((\w+)', label)
            if size:
                if size[2] not in ('static', 'dynamic,bounded') and 'static' not in size[2]:
                    sys.exit(f'worst_stack: {title} has a frame of no known size')
                frames[title] = int(size[1])
                names[title] = label.split('\\n')[0]
        for source, target in re.findall(r'edge: { sourcename: "([^"]+)" targetname: "([^"]+)"', text):
            calls.setdefault(source, set()).add(target)
    # A title is the linker's symbol, with its file in front for a function of that file alone.
    kept = {t for t in frames if t.split(':')[-1] in linked}
    return {t: frames[t] for t in kept}, names, {t: calls.get(t, set()) for t in kept}


def circles(calls):
    """Tarjan: which functions lie on a circle together; in an order in which callees come first."""
    index, low, stack, on_stack, groups = {}, {}, [], set(), []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        on_stack.add(node)
        for callee in sorted(calls.get(node, ())):
            if callee not in index:
                visit(callee)
                low[node] = min(low[node], low[callee])
            elif callee in on_stack:
                low[node] = min(low[node], index[callee])
        if low[node] == index[node]:
            group = []
            while True:
                member = stack.pop()
                on_stack.discard(member)
                group.append(member)
                if member == node:
                    break
            groups.append(group)

    for node in sorted(calls):
        if node not in index:
            visit(node)
    return groups


def depths(frames, calls, indirect):
    """Function -> (bytes with all it calls, the deepest callee)."""
    depth = {}
    for group in circles(calls):
        members = set(group)
        below = (0, None)
        for member in group:
            for callee in calls.get(member, ()):
                if callee in members:
                    continue
                if callee == INDIRECT:
                    candidate = (indirect, INDIRECT)
                else:
                    candidate = (depth[callee][0] if callee in depth else UNKNOWN_BYTES, callee)
                below = max(below, candidate, key=lambda c: (c[0], c[1] or ''))
        own = sum(frames.get(member, UNKNOWN_BYTES) for member in group)
        if len(group) > 1 or group[0] in calls.get(group[0], ()):
            own *= MESSAGE_LEVELS
        for member in group:
            depth[member] = (own + below[0], below[1])
    return depth


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('--most', type=int, required=True)
    parser.add_argument('--main', default='Reset_Handler')
    parser.add_argument('--interrupts', default='Alarm_Handler Samples_Handler / Interlock_Handler / Step_Handler',
                        help='from low to high priority; those of one priority cannot interrupt one another')
    parser.add_argument('linked')
    parser.add_argument('graphs', nargs='+')
    arguments = parser.parse_args()
    linked = set(open(arguments.linked, encoding='utf-8').read().split())
    sys.setrecursionlimit(10000)
    frames, names, calls = read_graph(arguments.graphs, linked)

    interrupts = [level.split() for level in arguments.interrupts.split('/')]
    entries = {arguments.main}.union(*interrupts)
    missing = entries - set(frames)
    if missing:
        sys.exit(f'worst_stack: no frame of {", ".join(sorted(missing))}; is it still a function of its own?')
    called = {callee for callees in calls.values() for callee in callees}
    by_pointer = [t for t in frames if t not in called and t not in entries]
    without = depths(frames, calls, 0)
    indirect = max((without[t][0] for t in by_pointer), default=0)
    depth = depths(frames, calls, indirect)

    total = depth[arguments.main][0]
    print(f'stack of the main program: {total} bytes, along')
    node = arguments.main
    while node is not None:
        own = frames.get(node, UNKNOWN_BYTES)
        print(f'  {own:5d}  {names.get(node, node)[:110]}')
        node = depth[node][1] if node in depth else None
    for level in interrupts:
        worst = max(level, key=lambda t: depth[t][0])
        print(f'on top of it {worst}: {depth[worst][0]} bytes, {EXCEPTION_BYTES} by the processor')
        total += depth[worst][0] + EXCEPTION_BYTES
    print(f'worst case of the stack: {total} of {arguments.most} bytes')
    if total > arguments.most:
        sys.exit('worst_stack: more than there is')


main()
