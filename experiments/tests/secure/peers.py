"""Who hears what among peers with the configuration of examples/secure: one line for each try.

    peers.py DIR PORT [unguarded]

DIR is what secure.sh has made for two UAVs. The world, two UAVs and a spectator do what csat does; then
another spectator and another UAV 1, without access control of their own, say what belongs to others, and
peers without a certificate try to come in. With `unguarded` no peer has access control.
"""

import json
import sys
import time

import zenoh

folder, port, *unguarded = sys.argv[1:]
with open(f"{folder}/zenoh.json5", encoding="utf-8") as file:
    TEXT = file.read()
WORLD = f"tls/127.0.0.1:{port}"
heard = []


def peer(name, listen, connect, guarded=True):
    config = zenoh.Config.from_json5(TEXT.replace("{folder}", folder).replace("{peer}", name))
    for key, value in [
        ("mode", "peer"),
        ("scouting/multicast/enabled", False),
        ("open/return_conditions/connect_scouted", False),
        ("connect/endpoints", connect),
        ("listen/endpoints", listen),
        ("access_control/enabled", guarded and not unguarded),
    ]:
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


def subscribe(session, name, key):
    return session.declare_subscriber(key, lambda sample: heard.append(name))


def tell(what, action=None):
    """Who heard something of it."""
    heard.clear()
    if action:
        action()
    time.sleep(0.5)
    print(f"{what}: {' '.join(sorted(set(heard))) or 'nobody'}", flush=True)


def ask(session, key):
    return [reply.ok.payload.to_string() for reply in session.get(key, timeout=2.0) if reply.ok]


anywhere = ["tls/127.0.0.1:0"]
world = peer("world", [WORLD], [])
uavs = [peer(f"uav-{i}", anywhere, [WORLD]) for i in range(2)]
declared = [
    subscribe(world, "world", "csat/5/uav/*/*"),
    world.liveliness().declare_subscriber("csat/5/alive/*", lambda sample: heard.append("world")),
    world.declare_queryable("csat/5/join/*", lambda query: query.reply("csat/5/join/0", "welcome")),
]
for i, uav in enumerate(uavs):
    names = ["clock", "link/*/*", f"uav/{i}/frame"]
    declared += [subscribe(uav, f"uav-{i}", f"csat/5/{name}") for name in names]
looker = peer("spectator", [], [WORLD])
declared.append(subscribe(looker, "spectator", "csat/**"))
thieves = {"spectator": peer("spectator", [], [WORLD], False), "uav-1": peer("uav-1", anywhere, [WORLD], False)}
time.sleep(2)

tell("clock of the world", lambda: world.put("csat/5/clock", "x"))
tell("frame of the world", lambda: world.put("csat/5/uav/0/frame", "x"))
tell("command of uav-0", lambda: uavs[0].put("csat/5/uav/0/command", "x"))
tell("message of uav-1", lambda: uavs[1].put("csat/5/link/1/0", "x"))
tell("token of uav-0", lambda: declared.append(uavs[0].liveliness().declare_token("csat/5/alive/0")))
print("welcome of uav-0:", *ask(uavs[0], "csat/*/join/0"))
for name, thief in thieves.items():
    for key in ["clock", "*", "**", "uav/0/frame", "uav/0/command", "uav/0/report", "link/0/0", "view/0/pose"]:
        tell(f"{key} of another {name}", lambda: thief.put(f"csat/5/{key}", "x"))
    tokens = thief.liveliness()
    tell(f"token of another {name}", lambda: declared.append(tokens.declare_token(f"csat/5/alive/{len(declared)}")))
    print(f"welcome of another {name}:", *(ask(thief, "csat/*/join/0") or ["nobody"]))
for what, endpoint in [("without a certificate", WORLD), ("in the clear", WORLD.replace("tls/", "tcp/"))]:
    config = zenoh.Config()
    for key, value in [
        ("scouting/multicast/enabled", False),
        ("listen/endpoints", []),
        ("connect/endpoints", [endpoint]),
        ("connect/timeout_ms", 2000),
        ("connect/exit_on_failure", True),
        ("transport/link/tls/root_ca_certificate", f"{folder}/ca.pem"),
    ]:
        config.insert_json5(key, json.dumps(value))
    try:
        stranger = zenoh.open(config)
        # TLS 1.3 tells a peer only when it speaks that its certificate was wanted.
        time.sleep(1)
        print(f"{what}: {len(stranger.info.peers_zid())} peers")
        stranger.close()
    except zenoh.ZError:
        print(f"{what}: 0 peers")
for session in [world, *uavs, looker, *thieves.values()]:
    session.close()
