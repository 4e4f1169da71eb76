"""Has the problem of a folder answered and prints length and path, each number by its bits."""

import struct
import sys

import taut

with taut.connect() as daemon:
    problem = daemon.load_problem(f"{sys.argv[1]}/problem.json")
    best = daemon.shorten(problem.path, problem.robot, problem.scene, budget=6000, seed=7).result()
    for number in [best.length, *best.path.flatten()]:
        print(struct.pack(">d", number).hex())
