#!/usr/bin/env bash
# zenoh 1.10.2 ends the sending of a closed link on the one thread that sends for all links, and waits there for whoever
# is waiting for that link.
#
# Version: eclipse-zenoh 1.10.2 (PyPI).
# Input: a peer that answers queries, each on a thread of its own; a peer that asks for eight answers of 4 MiB at once and
#   is stopped (SIGSTOP) while they come; a third that asks one small query after another, over a link of its own.
#   `wait_before_close` is 1 s. Four times.
# Guess before the run: the third notices nothing; the stopped one's link is closed after a second.
# Seen: the link is closed after a second, and then the third waits for up to a second too. With 16 threads that send
#   (ZENOH_RUNTIME in the environment, read once at the start of a process) it does not.
# Why: a thread that waits for room on a link holds the lock of what it is writing. When the link is closed, the task that
#   sends on it takes that lock (PipelineConsumer::drain), and blocks its thread until the one that waits has given up,
#   another wait_before_close later. There is one such thread by default.
# Why it matters: a client that stops is felt by all others, on direct links too. Who serves many links needs more sending
#   threads than clients that may stop at once.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet eclipse-zenoh==1.10.2
cd "$folder"
cat > peer.py <<'PYTHON'
import json
import sys
import threading
import time

import zenoh

role, address, seconds = sys.argv[1], sys.argv[2], float(sys.argv[3])
is_server = role == "server"
settings = {"mode": "peer", "scouting/multicast/enabled": False, "scouting/gossip/enabled": False,
            "transport/link/tx/lease": 10000,
            "transport/link/tx/queue/congestion_control/block/wait_before_close": 1000000,
            "listen/endpoints": [address] if is_server else [], "connect/endpoints": [] if is_server else [address]}
config = zenoh.Config()
for key, value in settings.items():
    config.insert_json5(key, json.dumps(value))
session = zenoh.open(config)


def answer(query):
    query.reply("q", bytes(4 << 20 if query.parameters else 64))


def ask(parameters):
    options = {"congestion_control": zenoh.CongestionControl.BLOCK, "timeout": 30.0}
    return sum(1 for reply in session.get("q" + parameters, **options) if reply.ok)


if is_server:
    queryable = session.declare_queryable("q", lambda query: threading.Thread(target=answer, args=(query,)).start())
    print("ready", flush=True)
    time.sleep(seconds)
elif role == "large":
    while ask("") == 0:
        time.sleep(0.01)
    threads = [threading.Thread(target=ask, args=("?large",), daemon=True) for _ in range(8)]
    for thread in threads:
        thread.start()
    print("asked", flush=True)
    time.sleep(seconds)
else:
    longest = 0.0
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        began = time.monotonic()
        if ask("") == 1:
            longest = max(longest, time.monotonic() - began)
        time.sleep(0.002)
    print(longest, flush=True)
PYTHON
started=()

# Starts a peer in the background and waits for its first word, if it has one.
peer() {
    rm -f says
    mkfifo says
    timeout 40 venv/bin/python peer.py "$@" >says &
    started+=($!)
    read -r word <says
}

# Prints the longest that the third waited; the argument is the environment of the one that answers.
round() {
    local address=tcp/127.0.0.1:$((20000 + RANDOM % 20000)) word
    started=()
    ZENOH_RUNTIME="$1" peer server "$address" 12
    timeout 40 venv/bin/python peer.py witness "$address" 5 >witness.txt &
    local witness=$!
    sleep 1.5
    peer large "$address" 10
    # `timeout` runs it as its child.
    local large
    large=$(ps -o pid= --ppid "${started[1]}")
    sleep 0.03
    kill -STOP $large
    wait "$witness"
    kill -9 $large "${started[@]}" 2>/dev/null || true
    wait "${started[@]}" 2>/dev/null || true
    cat witness.txt
}

trial() {
    local longest
    longest=$(for _ in 1 2 3 4; do round "$1"; done | sort -g | tail -1)
    echo "  longest $longest s" >&2
    awk -v longest="$longest" 'BEGIN { print (longest > 0.5 ? "more than 0.5 s" : "less than 0.5 s") }'
}

seen="one sending thread: $(trial '(tx: (worker_threads: 1))')
16 sending threads: $(trial '(tx: (worker_threads: 16))')"
expected="one sending thread: more than 0.5 s
16 sending threads: less than 0.5 s"
printf '%s\n' "$seen"
[[ "$seen" == "$expected" ]] || { printf 'expected:\n%s\n' "$expected" >&2; exit 1; }
