#!/usr/bin/env bash
# zenoh 1.10.2 closes a dead link on one of the two threads that read all links, and there the close takes ten seconds.
#
# Version: eclipse-zenoh 1.10.2 (PyPI).
# Input: a peer with a queryable, and four peers on other hosts (network namespaces on a bridge; this takes root and
#   iproute2) that ask it one query after another and get 64 KiB each. The lease is 1 s. After 3 s the cables of three
#   are pulled at once; the fourth asks on.
# Guess before the run: the fourth notices nothing; the others' links are closed a second later.
# Seen: with the usual two reading threads the fourth's longest query takes 10 s. With 16 of them (ZENOH_RUNTIME in the
#   environment, read once at the start of a process) it takes less than half a second.
# Why: TCP links are made with SO_LINGER of 10 s, so that close() of one whose last bytes nobody acknowledges waits
#   as long, and it is called on a thread that reads other links.
# Why it matters: machines that lose power or network let everybody else wait. Who serves many links needs more reading
#   threads than links that may die at once.
set -euo pipefail
[[ $EUID == 0 ]] && command -v ip >/dev/null || { echo "not run: this takes root and iproute2" >&2; exit 1; }
folder=$(mktemp -d)
prefix=zd$$
hosts=(server one two three witness)
remove() {
    # End with their host only what was started here.
    for host in switch "${hosts[@]}"; do
        ip netns pids "$prefix-$host" 2>/dev/null | xargs -r kill -9 || true
        ip netns del "$prefix-$host" 2>/dev/null || true
    done
    rm -rf "$folder"
}
trap remove EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet eclipse-zenoh==1.10.2
cd "$folder"
cat > peer.py <<'PYTHON'
import json
import sys
import time

import zenoh

role, seconds = sys.argv[1], float(sys.argv[2])
address = "tcp/10.99.0.1:7447"
settings = {"mode": "peer", "scouting/multicast/enabled": False, "scouting/gossip/enabled": False,
            "transport/link/tx/lease": 1000, "listen/endpoints": [address] if role == "server" else [],
            "connect/endpoints": [] if role == "server" else [address]}
config = zenoh.Config()
for key, value in settings.items():
    config.insert_json5(key, json.dumps(value))
session = zenoh.open(config)
end = time.monotonic() + seconds
if role == "server":
    queryable = session.declare_queryable("q", lambda query: query.reply("q", bytes(65536)))
    print("ready", flush=True)
    time.sleep(seconds)
else:
    longest = 0.0
    answered = 0
    while time.monotonic() < end:
        began = time.monotonic()
        answered += sum(1 for reply in session.get("q", timeout=20.0) if reply.ok)
        longest = max(longest, time.monotonic() - began)
        time.sleep(0.002)
    print(longest, answered, flush=True)
PYTHON
on() { ip netns exec "$prefix-$1" "${@:2}"; }
for host in switch "${hosts[@]}"; do ip netns add "$prefix-$host"; done
ip -n "$prefix-switch" link add bridge type bridge
ip -n "$prefix-switch" link set bridge up
number=0
for host in "${hosts[@]}"; do
    number=$((number + 1))
    ip -n "$prefix-switch" link add "$host" type veth peer name eth0 netns "$prefix-$host"
    ip -n "$prefix-switch" link set "$host" master bridge up
    ip -n "$prefix-$host" addr add "10.99.0.$number/24" dev eth0
    ip -n "$prefix-$host" link set eth0 up
    ip -n "$prefix-$host" link set lo up
done

# Prints how the longest query of the fourth was; the arguments are the environment of the one that answers.
trial() {
    local started=() host
    for host in one two three; do ip -n "$prefix-switch" link set "$host" up; done
    mkfifo says
    on server env "$@" timeout 40 venv/bin/python peer.py server 22 >says &
    started+=($!)
    read -r _ <says
    for host in one two three; do
        on "$host" timeout 40 venv/bin/python peer.py client 20 >/dev/null 2>&1 &
        started+=($!)
    done
    on witness timeout 40 venv/bin/python peer.py witness 18 >witness.txt &
    local witness=$!
    sleep 3
    for host in one two three; do ip -n "$prefix-switch" link set "$host" down; done
    wait "$witness"
    kill -9 "${started[@]}" 2>/dev/null || true
    for host in one two three server; do ip netns pids "$prefix-$host" | xargs -r kill -9 2>/dev/null || true; done
    wait "${started[@]}" 2>/dev/null || true
    rm says
    read -r longest answered <witness.txt
    echo "  longest $longest s, $answered answered" >&2
    awk -v longest="$longest" -v answered="$answered" \
        'BEGIN { print (answered < 50 ? "no trial" : longest > 5 ? "more than 5 s" : longest < 3 ? "less than 3 s" : "3 to 5 s") }'
}

seen="two reading threads: $(trial TRIAL=1)
16 reading threads: $(trial 'ZENOH_RUNTIME=(rx: (worker_threads: 16))')"
expected="two reading threads: more than 5 s
16 reading threads: less than 3 s"
printf '%s\n' "$seen"
[[ "$seen" == "$expected" ]] || { printf 'expected:\n%s\n' "$expected" >&2; exit 1; }
