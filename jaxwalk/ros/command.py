"""``jaxwalk ros``: a master, both nodes, a push and a bag; what came of it; and nothing left running."""

from __future__ import annotations

import contextlib
import http.client
import json
import os
import time
import xmlrpc.client
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.parsers.expat import ExpatError

from rich.console import Console
from rich.table import Table

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.export import command as export
from jaxwalk.learn.policies import named
from jaxwalk.ros import body as bodies
from jaxwalk.ros import making, processes, wire
from jaxwalk.ros.processes import Processes

if TYPE_CHECKING:
    from jaxwalk.ros.options import RosArgs

_STARTING = 30.0  # s that a master may take to answer
_ANSWERING = 3.0  # s that one may, who is there


def main(args: RosArgs) -> None:
    """Run ``jaxwalk ros``.

    Raises:
      UserError: something is missing, or a node ended by itself; its line is told.
    """
    processes.check(args.python)
    subject = named.load(args.policy)
    body = making.body(subject.config, args.seed)
    files.make_folder("--out", args.out)
    out = args.out.resolve()
    trained, told = export.load(args.policy)
    policy = export.write(trained, told, ("safetensors",), out)["safetensors"]
    files.write_bytes(out / "body.json", bodies.text(body).encode())
    files.write_bytes(out / "report.json", b"{}")
    with Console(markup=False, stderr=True).status("walking through ROS"):
        _walk(args, out, policy, body.joints)
    _print(args, json.loads((out / "report.json").read_text(encoding="utf-8")))


def answers(master: str) -> bool:
    """Whether a ROS master does at that address, within `_ANSWERING` s for each part of its answer."""
    # What is no master may be anything: other HTTP, other XML, or somebody who takes calls and is silent.
    none = (
        OSError,
        http.client.HTTPException,
        xmlrpc.client.Error,
        ExpatError,
        ValueError,
        TypeError,
        LookupError,
    )
    with contextlib.suppress(*none):
        asked: Any = xmlrpc.client.ServerProxy(master, _Prompt())
        return asked.getPid("/jaxwalk")[0] == 1
    return False


class _Prompt(xmlrpc.client.Transport):
    """It does not wait for an answer for ever."""

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        made = super().make_connection(host)
        made.timeout = _ANSWERING
        return made


def _walk(args: RosArgs, out: Path, policy: Path, joints: tuple[str, ...]) -> None:
    given = os.environ.get("ROS_MASTER_URI", "")
    own = not (given and answers(given))
    port = processes.free_port()
    master = f"http://127.0.0.1:{port}" if own else given
    node = [str(args.python), "-m"]
    both = [f"_body:={out / 'body.json'}", f"_lockstep:={str(args.lockstep).lower()}"]
    with processes.surroundings(out, master) as variables, Processes(variables, out) as run:
        if own:
            _await(run, run.begin("roscore", "roscore", "-p", str(port)), master)
        both.append(f"_factor:={args.factor}")
        simulated = [f"_seconds:={args.seconds}", f"_method:={args.step}"]
        simulated += [f"_report:={out / 'report.json'}", f"_listeners:={2 if args.bag else 1}"]
        simulation = run.begin("simulation", *node, "jaxwalk.ros.simulation_node", *both, *simulated)
        if args.push:
            asked = [f"_impulse:={args.push}", f"_begin:={args.push_time}"]
            push = run.begin("push", *node, "jaxwalk.ros.push_node", *asked)
            if push.wait():
                raise UserError(f"jaxwalk ros: the push failed: {run.said('push')}")
        if args.bag:
            topics = ["/clock", *wire.SENSORS, *map(wire.command, joints)]
            run.begin("bag", "rosbag", "record", "--tcpnodelay", "-O", str(out / "walk.bag"), *topics)
        lines = [f"_policy:={policy}", f"_commands:={out / 'commands.txt'}"]
        controller = run.begin("controller", *node, "jaxwalk.ros.controller_node", *both, *lines)
        while simulation.poll() is None:
            time.sleep(0.1)
            if controller.poll() is not None:
                raise UserError(f"jaxwalk ros: the controller ended: {run.said('controller')}")
        if simulation.returncode:
            raise UserError(f"jaxwalk ros: the simulation ended: {run.said('simulation')}")


def _await(run: Processes, core: Any, master: str) -> None:
    end = time.monotonic() + _STARTING
    while not answers(master):
        if core.poll() is not None or time.monotonic() > end:
            raise UserError(f"jaxwalk ros: roscore does not start: {run.said('roscore')}")
        time.sleep(0.1)


def _print(args: RosArgs, report: dict[str, Any]) -> None:
    table = Table("", "", title=f"{args.policy}, through ROS", show_header=False)
    speed = report["speed"]
    table.add_row("walked", f"{report['seconds']:.2f} s{', then fell' if report['fell'] else ''}")
    table.add_row("speed", "-" if speed is None else f"{speed:.3f} m/s")
    table.add_row("took", f"{report['wall_seconds']:.1f} s")
    period, latency = report["period"], report["latency"]
    table.add_row(
        "period", f"{period['mean']:.2f} ms, jitter {period['jitter']:.2f}, 99 % below {period['p99']:.2f}"
    )
    told = "-" if latency["mean"] is None else f"{latency['mean']:.2f} ms, 99 % below {latency['p99']:.2f}"
    table.add_row("latency of commands", told)
    table.add_row("ticks without an answer", f"{report['unanswered_ticks']} of {report['ticks']}")
    table.add_row("passive ticks", str(report["passive_ticks"]))
    Console(markup=False).print(table)
    print(f"{args.out}: report.json, commands.txt, logs{', walk.bag' if args.bag else ''}")
