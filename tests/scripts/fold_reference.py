#!/usr/bin/env python3
"""The paper's fold model once more, written from docs/physics.md without the C++ code beside it.

Prints tests/data/fold/reference.csv: holes of the folded tentacle for a few designs and pulls, which
tests/model/fold_reference_test.cpp compares with tendril's. Standard library only.

    tests/scripts/fold_reference.py > tests/data/fold/reference.csv
"""
import math


def rotation(axis, angle):
    x, y, z = axis
    c, s, v = math.cos(angle), math.sin(angle), 1 - math.cos(angle)
    return [[c + x * x * v, x * y * v - z * s, x * z * v + y * s],
            [y * x * v + z * s, c + y * y * v, y * z * v - x * s],
            [z * x * v - y * s, z * y * v + x * s, c + z * z * v]]


def mul(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def apply(a, v):
    return [sum(a[i][k] * v[k] for k in range(3)) for i in range(3)]


def unit(v):
    n = math.sqrt(sum(x * x for x in v))
    return [x / n for x in v]


def holes(taper, ratio, alpha, beta, pull, count=49, length=0.75, base=0.02, unit_length=0.03):
    b = unit_length / (1 + ratio)
    spacing = [b if i % 2 == 0 else unit_length - b for i in range(count - 1)]
    at = [0.0]
    for s in spacing:
        at.append(at[-1] + s)
    margin = (length - at[-1]) / 2
    crease = [(p + q) / 2 for p, q in zip(at, at[1:])]
    width = [base * (1 - (1 - taper) * (z + margin) / length) for z in crease]
    half = [s / 2 for s in spacing]
    low, high = 0.0, math.pi / 2 * max(w / d for w, d in zip(width, half))
    for _ in range(300):
        k = (low + high) / 2
        phi = [min(k * d / w, math.pi / 2) for d, w in zip(half, width)]
        short = math.fsum(4 * d * math.sin(p / 2) ** 2 for d, p in zip(half, phi))
        low, high = (k, high) if short < pull * at[-1] else (low, k)
    turn, shift = [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]], [0.0, 0, 0]
    points, angles = [[0.0, 0.0, at[0]]], [math.radians(alpha if i % 2 == 0 else beta) for i in range(count - 1)]
    for i, p in enumerate(phi):
        axis = [0.0, math.sin(angles[i]), math.cos(angles[i])]
        fold = rotation(axis, (-1 if i % 2 == 0 else 1) * 2 * p)  # a mountain turns the next facet toward -x
        about = [0.0, 0.0, crease[i]]
        moved = [a - c for a, c in zip(about, apply(fold, about))]
        shift = [a + c for a, c in zip(apply(turn, moved), shift)]
        turn = mul(turn, fold)
        points.append([a + c for a, c in zip(apply(turn, [0, 0, at[i + 1]]), shift)])
    d3 = unit([a - c for a, c in zip(points[1], points[0])])
    d1 = apply(rotation([0.0, math.sin(angles[0]), math.cos(angles[0])], -phi[0]), [1.0, 0, 0])
    along = sum(a * c for a, c in zip(d1, d3))
    d1 = unit([a - along * c for a, c in zip(d1, d3)])
    d2 = [d3[1] * d1[2] - d3[2] * d1[1], d3[2] * d1[0] - d3[0] * d1[2], d3[0] * d1[1] - d3[1] * d1[0]]
    return [apply([d1, d2, d3], [a - c for a, c in zip(p, points[0])]) for p in points]


print("taper,spacing_ratio,alpha_deg,beta_deg,pull,hole,x,y,z")
for design in [(1, 1, 90, 90), (0.5, 1, 90, 90), (0.5, 0.5, 90, 90), (0.5, 0.5, 90, 75), (0.7, 0.3, 75, 120)]:
    for pull in (0.01, 0.15, 0.3):
        found = holes(*design, pull)
        for i in (1, 2, 3, 12, 25, 48):
            print(",".join(["%g" % v for v in (*design, pull)] + [str(i)] + ["%.15e" % v for v in found[i]]))
