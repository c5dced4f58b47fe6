# SPDX-License-Identifier: MIT
"""Examples at the end of every --help; a test parses each with the program's own parser."""

EXAMPLES = {
    "": """\
seatrial auto run1.bag run2.bag            # from logs to a model and its report
seatrial identify run1.bag run2.bag --vehicle boat.yaml -o model.yaml
seatrial report model.yaml run3.bag -o report.html""",
    "auto": """\
seatrial auto run1.bag run2.bag
seatrial auto 00000012.BIN --test 00000013.BIN -o otter
seatrial auto log.csv --lever 0.3 0 --yes  # asks nothing, states what it assumes""",
    "demo": """\
seatrial demo                              # into the folder demo
seatrial demo --out /tmp/tour""",
    "inspect": """\
seatrial inspect run1.bag                  # its topics, rates and clocks
seatrial inspect run1.bag --vehicle boat.yaml
seatrial inspect run*.mcap --vehicle boat.yaml --json - | jq .signs""",
    "init": """\
seatrial init run1.bag -o boat.yaml
seatrial init log.csv -o boat.yaml --pose x=easting,y=northing,heading=yaw --commands left,right
seatrial init 00000012.BIN -o boat.yaml --name otter --force""",
    "live": """\
seatrial live boat.yaml udp:7001 --walls -2 -1.5 2 1.5
seatrial live boat.yaml run1.bag --speed 10   # how it would have been
seatrial live boat.yaml udp:7001 --address 192.168.1.5 --token "$SECRET"   # for a phone at the pool""",
    "convert": """\
seatrial convert 00000012.BIN -o tables
seatrial convert run1.bag --vehicle boat.yaml -o run1.mcap""",
    "simulate": """\
seatrial simulate -o trials                # the paper's S1 to S7, as tables
seatrial simulate --model model.yaml --vehicle boat.yaml -o trials
seatrial simulate --vehicle mallard-mp --seeds 50 -o boats  # then: seatrial fleet boats""",
    "identify": """\
seatrial identify run1.bag run2.bag --vehicle boat.yaml -o model.yaml
seatrial identify run*.bag --vehicle boat.yaml --structure auto --effect current -o model.yaml
seatrial identify short.bag --vehicle boat.yaml --prior model.yaml -o loaded.yaml""",
    "validate": """\
seatrial validate model.yaml run3.bag
seatrial validate model.yaml run3.bag run4.bag --horizon 2 --json scores.json
seatrial validate model.yaml run3.bag --against old.yaml""",
    "report": """\
seatrial report model.yaml run3.bag -o report.html
seatrial report model.yaml run3.bag --scores scores.json -o report.html
seatrial report model.yaml run3.bag -o report.html --figures figures --tables tables""",
    "compare": """\
seatrial compare before.yaml after.yaml
seatrial compare before.yaml after.yaml run5.bag -o change.html""",
    "fleet": """\
seatrial fleet boats                       # one folder a boat, on all cores
seatrial fleet boats -o may --last-time april
seatrial fleet fleet.yaml --scheduler tcp://10.0.0.5:8786""",
    "select": """\
seatrial select run1.bag run2.bag --vehicle boat.yaml
seatrial select run*.bag --vehicle boat.yaml -o chosen.yaml
seatrial select run*.bag --vehicle boat.yaml --candidates 'Y_r * r' 'N_v * v'""",
    "tune": """\
seatrial tune model.yaml
seatrial tune model.yaml --knob 2 --delay 0.05 -o gains.yaml --report tuning.html
seatrial tune model.yaml --ros2 gains_ros2.yaml""",
    "predict": """\
seatrial predict model.yaml run3.bag -o odometry.csv
seatrial predict model.yaml --live         # lines from standard input
seatrial predict model.yaml --live --udp 7001 --to 7002 --rate 20""",
    "allocate": """\
seatrial allocate model.yaml
seatrial allocate boat.yaml --wrench 0.4 0 0.1
seatrial allocate model.yaml run3.bag --scheme always-forward -o allocation.html""",
    "export": """\
seatrial export model.yaml --to c -o boat.h
seatrial export model.yaml --to fmu -o boat.fmu
seatrial export model.yaml --to sdf --mass 12 --inertia 0.9 --size 0.9 0.4 0.3 -o boat.sdf""",
    "sim": """\
seatrial sim model.yaml --duration 60 --speed 0 < commands.jsonl
seatrial sim model.yaml other.yaml --scene harbour.yaml --udp 7001""",
    "mimic": """\
seatrial mimic model.yaml --speed 0.5 --yaw-rate 1.0 --acceleration 0.4
seatrial mimic model.yaml --udp 7001 --to 7002 --rate 50 --clock system""",
    "completion": """\
seatrial completion bash > ~/.local/share/bash-completion/completions/seatrial
seatrial completion zsh > ~/.zfunc/_seatrial""",
}
