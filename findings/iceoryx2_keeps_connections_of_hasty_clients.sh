#!/usr/bin/env bash
# An iceoryx2 0.10.0 server keeps the connection of a client that ended before its request was received, for as long as
# the server lives.
#
# Version: iceoryx2 0.10.0 (PyPI).
# Input: a request-response service with one server. Eight clients, one after the other: the server sees each, the
#   client sends one request and ends; the server receives until there is nothing, before that end or after it.
# Guess before the run: a request whose client is gone is dropped, and its connection is closed with the next receive.
# Seen: where the server received first, no connection is open afterwards. Where the client ended first, receive() gives
#   None, and one connection and one data segment a client stay open.
# Why it matters: planner processes that send a path, change their mind and exit are daily life. The memory of each stays
#   mapped in the server, and the room for expired connections is bounded (128 by default). Whoever writes clients has to
#   wait for a sign that the last request was received before the port is dropped.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet iceoryx2==0.10.0
cd "$folder"
seen=$(venv/bin/python - <<'PYTHON'
import ctypes
import os

import iceoryx2 as iox

CLIENTS = 8
iox.set_log_level(iox.LogLevel.Error)
node = iox.NodeBuilder.new().create(iox.ServiceType.Ipc)


def open_connections():
    links = []
    for number in os.listdir("/proc/self/fd"):
        try:
            links.append(os.readlink(f"/proc/self/fd/{number}"))
        except OSError:
            pass  # the listing's own descriptor
    return sum(".connection" in link for link in links)


def received(server):
    count = 0
    while (request := server.receive()) is not None:
        request.delete()
        count += 1
    return count


def left_open(receives_first):
    name = iox.ServiceName.new(f"hasty-{os.getpid()}-{receives_first}")
    builder = node.service_builder(name).request_response(ctypes.c_uint64, ctypes.c_uint64)
    service = builder.enable_fire_and_forget_requests(False).create()
    server = service.server_builder().create()
    before = open_connections()
    requests = 0
    for number in range(CLIENTS):
        client = service.client_builder().create()
        requests += received(server)
        pending = client.loan_uninit().write_payload(ctypes.c_uint64(number)).send()
        if receives_first:
            requests += received(server)
        pending.delete()
        client.delete()
        requests += received(server)
    return requests, open_connections() - before


print("received first: %d requests, %d connections left open" % left_open(True))
print("ended first: %d requests, %d connections left open" % left_open(False))
PYTHON
)
expected="received first: 8 requests, 0 connections left open
ended first: 0 requests, 8 connections left open"
printf '%s\n' "$seen"
[[ "$seen" == "$expected" ]] || { printf 'expected:\n%s\n' "$expected" >&2; exit 1; }
