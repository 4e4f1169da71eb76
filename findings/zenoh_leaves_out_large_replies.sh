#!/usr/bin/env bash
# zenoh 1.10.2 leaves a reply that is larger than the asker's limit out of a stream and ends the stream as if it were whole.
#
# Version: eclipse-zenoh 1.10.2 (PyPI).
# Input: two peers on one link. One has transport/link/rx/max_message_size of 1 MiB, a setting that guards memory.
#   A queryable answers a get with three replies, the second of 4 MiB; and a get carries 4 MiB to a queryable.
# Guess before the run: the side that sends is told, or the get ends with an Err reply.
# Seen: every reply() returns without an error, the asker gets replies 0 and 2, and the get ends within a second with no
#   Err. The large query never reaches its queryable, and the get waits its whole timeout.
# Why it matters: a limit set on a planner's machine turns "the path is too long for you" into a stream that looks
#   complete. Whoever streams answers needs a last one of their own, counted, and has to check sizes before sending.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet eclipse-zenoh==1.10.2
cd "$folder"
seen=$(venv/bin/python - <<'PYTHON'
import json
import socket
import time

import zenoh

MIB = 1 << 20


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def session(limit, **endpoints):
    config = zenoh.Config()
    settings = {"mode": "peer", "scouting/multicast/enabled": False, "scouting/gossip/enabled": False,
                "transport/link/rx/max_message_size": limit, "listen/endpoints": [], "connect/endpoints": []}
    for key, value in {**settings, **endpoints}.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


def ask(served, asker_limit, server_limit, query_size, large_reply):
    address = f"tcp/127.0.0.1:{free_port()}"
    server = session(server_limit, **{"listen/endpoints": [address]})

    def answer(query):
        served.append(len(query.payload))
        for number, size in enumerate((100, large_reply, 100)):
            query.reply("q", bytes([number]) * size)

    queryable = server.declare_queryable("q", answer)
    asker = session(asker_limit, **{"connect/endpoints": [address]})
    time.sleep(0.5)
    began = time.monotonic()
    replies = [reply.ok.payload.to_bytes()[0] if reply.ok else reply.err.payload.to_string()
               for reply in asker.get("q", payload=bytes(query_size), timeout=5.0,
                                      consolidation=zenoh.ConsolidationMode.NONE)]
    waited = time.monotonic() - began
    asker.close()
    queryable.undeclare()
    server.close()
    return replies, "at once" if waited < 2.5 else "after its timeout"


for name, limits, sizes in (
    ("all fits", (64 * MIB, 64 * MIB), (100, 4 * MIB)),
    ("large reply", (MIB, 64 * MIB), (100, 4 * MIB)),
    ("large query", (64 * MIB, MIB), (4 * MIB, 100)),
):
    served = []
    replies, end = ask(served, *limits, *sizes)
    print(f"{name}: served {len(served)}, replies {replies}, ended {end}")
PYTHON
)
expected="all fits: served 1, replies [0, 1, 2], ended at once
large reply: served 1, replies [0, 2], ended at once
large query: served 0, replies ['Timeout'], ended after its timeout"
printf '%s\n' "$seen"
[[ "$seen" == "$expected" ]] || { printf 'expected:\n%s\n' "$expected" >&2; exit 1; }
