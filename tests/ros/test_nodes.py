"""The nodes under Debian's Python, with a ROS master of their own."""

from __future__ import annotations

import contextlib
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from jaxwalk import cli
from jaxwalk.common.errors import UserError
from jaxwalk.export import command as export
from jaxwalk.ros import command, processes
from jaxwalk.ros.processes import Processes

PYTHON = Path("/usr/bin/python3")
try:
    processes.check(PYTHON)
except UserError as missing:
    pytest.skip(str(missing), allow_module_level=True)

MOST = 120.0  # s, for whatever is waited for
BY_ONE_PROCESS = """
import sys
from jaxwalk.deploy import Controller
from jaxwalk.ros import body, loop
from jaxwalk.ros.simulation import Simulation
from jaxwalk.ros.watch import Keeper
found = body.read("body.json")
simulation = Simulation(found)
simulation.wrench("torso", 400.0, 0.0, 1_000_000_000, 100_000_000)
keeper = Keeper(Controller.load("policy.safetensors"), found.stance, print)
for told in loop.commands(simulation, keeper, int(sys.argv[1])):
    print(*map(float.hex, told))
"""
SERVICES = """
from jaxwalk.ros import gazebo
for name in ("ApplyJointEffort", "ApplyBodyWrench"):
    print(gazebo.service(name)._md5sum)
"""


@pytest.fixture(scope="module")
def walked(tmp_path_factory):
    """The folder of a walk in lock-step, with a push after a second."""
    out = tmp_path_factory.mktemp("ros")
    line = ["ros", "shipped", "--out", str(out), "--seconds", "2", "--push", "40", "--push-time", "1"]
    assert cli.main(line) == 0
    return out


def under_debian(out: Path, program: str, *more: str) -> list[str]:
    with processes.surroundings(out, "http://127.0.0.1:1") as variables:
        line = [str(PYTHON), "-c", program, *more]
        done = subprocess.run(line, env=variables, cwd=out, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_lockstep_gives_the_commands_of_one_process_bit_for_bit(walked):
    alone = under_debian(walked, BY_ONE_PROCESS, "1000")
    assert (walked / "commands.txt").read_text().splitlines()[:1000] == alone
    assert len(set(alone)) > 990


def test_the_walk_is_reported_and_recorded(walked):
    report = json.loads((walked / "report.json").read_text())
    assert (report["ticks"], report["fell"], report["passive_ticks"]) == (1000, False, 0)
    assert report["unanswered_ticks"] == 0 and report["period"]["mean"] > 0
    assert (walked / "walk.bag").stat().st_size > 100_000


def running(out: Path) -> list[str]:
    """Command lines of processes that know the folder ``out``."""
    found = []
    for one in Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):
            told = one.read_bytes().replace(b"\0", b" ").decode(errors="replace")
            found += [told] if str(out) in told else []
    return found


def test_nothing_is_left_running(walked):
    assert running(walked) == []


def test_who_is_told_to_end_ends_what_he_began(tmp_path):
    line = [sys.executable, "-m", "jaxwalk", "ros", "shipped", "--out", str(tmp_path), "--seconds", "600"]
    one = subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    wait(lambda: lines(tmp_path / "commands.txt") > 100)
    one.terminate()
    assert one.wait(MOST) == 130
    assert running(tmp_path) == []


REPLAY = """
import rosbag
from jaxwalk.deploy import Controller
from jaxwalk.ros import body, topics, wire
from jaxwalk.ros.watch import Collector, Keeper
found = body.read("body.json")
keeper = Keeper(Controller.load("policy.safetensors"), found.stance, print)
collector = Collector()
for topic, message, _ in rosbag.Bag("walk.bag").read_messages(topics=list(wire.SENSORS)):
    frame = collector.take(topic, message.header.stamp.to_nsec(), topics.values(topic, message, found.joints))
    if frame is not None:
        print(*map(float.hex, keeper.answer(frame)))
"""


def test_a_bag_that_is_replayed_gives_the_same_commands(walked):
    assert under_debian(walked, REPLAY)[:1000] == (walked / "commands.txt").read_text().splitlines()[:1000]


def test_services_are_gazebos(tmp_path):
    """The md5 that gazebo_msgs has had since ROS Fuerte."""
    told = under_debian(tmp_path, SERVICES)
    assert told == ["c0039811b8cc919490b3cff748cdf46b", "585b9f9618aa0581b207e2f2d90866bc"]


@pytest.fixture
def run(walked, tmp_path):
    """(processes, master, a node's line): a master runs, and what a test begins ends with it."""
    port = processes.free_port()
    master = f"http://127.0.0.1:{port}"
    with processes.surroundings(tmp_path, master) as variables, Processes(variables, tmp_path) as begun:
        core = begun.begin("roscore", "roscore", "-p", str(port))
        wait(lambda: command.answers(master))

        def node(name: str, *told: str):
            files = f"_body:={walked / 'body.json'}", *told
            return begun.begin(name, str(PYTHON), "-m", f"jaxwalk.ros.{name}_node", *files)

        yield begun, core, node, tmp_path


def wait(until):
    end = time.monotonic() + MOST
    while not until():
        assert time.monotonic() < end
        time.sleep(0.05)


def lines(file: Path) -> int:
    return file.read_bytes().count(b"\n") if file.exists() else 0


def controller(node, walked, out):
    return node(
        "controller", f"_policy:={walked / 'policy.safetensors'}", f"_commands:={out / 'commands.txt'}"
    )


SERVE = """
import sys, time
import rospy
from std_srvs.srv import Empty
for name in sys.argv[1:]:
    rospy.ServiceProxy(f"/gazebo/{name}", Empty)()
    time.sleep(0.2)
"""


def test_a_reset_in_mid_walk_gives_the_commands_of_a_fresh_start_bit_for_bit(run, walked):
    begun, _, node, out = run
    node("simulation")
    controller(node, walked, out)

    def ask(*names):
        assert begun.begin("ask", str(PYTHON), "-c", SERVE, *names).wait(MOST) == 0, begun.said("ask")

    def walks():
        """The commands of each walk, split where it begins."""
        told = (out / "commands.txt").read_text().splitlines()
        begins = [row for row, line in enumerate(told) if line == fresh[0]]
        return [told[a:b] for a, b in zip(begins, [*begins[1:], len(told)], strict=True)]

    fresh = (walked / "commands.txt").read_text().splitlines()[:500]  # before its push
    wait(lambda: lines(out / "commands.txt") > 100)
    ask("reset_simulation", "reset_simulation", "reset_simulation", "pause_physics")
    paused = lines(out / "commands.txt")
    time.sleep(0.5)
    assert lines(out / "commands.txt") == paused
    ask("reset_simulation")
    assert lines(out / "commands.txt") == paused + 1  # to frame 0, where it stays
    ask("unpause_physics")
    wait(lambda: len(walks()[-1]) > 500)
    assert len(walks()) == 5
    for one in walks():
        assert one[:500] == fresh[: len(one)]


def test_a_controller_that_is_killed_leaves_passive_joints(run, walked):
    _, _, node, out = run
    report = out / "report.json"
    simulation = node("simulation", "_seconds:=60", "_patience:=1.0", f"_report:={report}")
    one = controller(node, walked, out)
    wait(lambda: lines(out / "commands.txt") > 200)
    one.kill()
    assert simulation.wait(MOST) == 0
    told = json.loads(report.read_text())
    assert told["fell"] and told["passive_ticks"] > 50 and told["seconds"] < 60
    assert "no command within 1 s: joints are passive" in (out / "simulation.log").read_text()


def test_a_master_that_is_killed_is_not_missed_by_who_walks(run, walked):
    begun, core, node, out = run
    report = out / "report.json"
    simulation = node("simulation", "_seconds:=3", f"_report:={report}")
    controller(node, walked, out)
    wait(lambda: lines(out / "commands.txt") > 100)
    begun.end(core)
    wait(lambda: report.exists())
    told = json.loads(report.read_text())
    assert (told["ticks"], told["fell"], told["passive_ticks"]) == (1500, False, 0)
    begun.end(simulation)


def test_a_simulation_that_is_killed_is_noticed(run, walked):
    _, _, node, out = run
    simulation = node("simulation", "_lockstep:=false", "_factor:=0.1")
    told = f"_policy:={walked / 'policy.safetensors'}", f"_commands:={out / 'commands.txt'}"
    node("controller", *told, "_lockstep:=false", "_factor:=0.1")
    wait(lambda: lines(out / "commands.txt") > 20)
    simulation.send_signal(signal.SIGKILL)
    wait(lambda: "safe state, joints are passive: no sensors" in (out / "controller.log").read_text())
    assert (out / "commands.txt").read_text().splitlines()[-1] == " ".join(["nan"] * 6)


def test_the_launch_file_starts_both_nodes_by_the_parameters_of_a_yaml_file(run, walked):
    begun, _, _, out = run
    package = Path(processes.__file__).parent / "package"
    given = (package / "config/walk.yaml").read_text()
    assert "seconds: 0.0 " in given and "delay: 0.0 " in given
    config = out / "walk.yaml"
    given = given.replace("seconds: 0.0 ", "seconds: 1.0 ")
    config.write_text(given.replace("delay: 0.0 ", f"commands: {out / 'commands.txt'}\n  delay: 0.0 "))
    begun.variables["ROS_PACKAGE_PATH"] = f"{package}:/usr/share"
    files = [
        f"{name}:={walked / file}" for name, file in (("body", "body.json"), ("policy", "policy.safetensors"))
    ]
    launch = begun.begin("launch", "roslaunch", "jaxwalk", "walk.launch", *files, f"config:={config}")
    assert launch.wait(MOST) == 0, begun.said("launch")
    assert (out / "commands.txt").read_text().splitlines()[:500] == (
        (walked / "commands.txt").read_text().splitlines()[:500]
    )


@pytest.mark.parametrize(
    ("told", "said"),
    [
        (["_sekonds:=3"], "jaxwalk_simulation: unknown parameter sekonds: give some of body, method"),
        (["_body:=nowhere.json"], "cannot read nowhere.json"),
        (["_factor:=0"], "jaxwalk_simulation: parameter factor: 0 is out of range: give more than 0, finite"),
        (["_report:=/nowhere/at/all"], "parameter report /nowhere/at/all: there is no folder /nowhere/at"),
    ],
)
def test_nodes_end_with_one_line_where_they_are_told_what_is_no_good(run, told, said):
    begun, _, node, _ = run
    assert node("simulation", *told).wait(MOST) == 2
    assert said in begun.said("simulation")


def test_a_policy_of_other_legs_is_refused(run, walked):
    begun, _, node, out = run
    trained, manifest = export.load("shipped-rigid")
    rigid = export.write(trained, manifest, ("safetensors",), out)["safetensors"]
    assert node("controller", f"_policy:={rigid}").wait(MOST) == 2
    assert begun.said("controller").endswith("give a policy of legs that yield, as shipped")


FOREIGN = """
import time
import rospy
from sensor_msgs.msg import JointState
rospy.init_node("foreign")
states = rospy.Publisher("/walker/joint_states", JointState, queue_size=1)
while not states.get_num_connections():
    time.sleep(0.05)
for _ in range(3):
    states.publish(JointState(name=["elbow"], position=[0.1]))
    time.sleep(0.1)
"""


def test_states_of_other_joints_are_the_safe_state_said_once(run, walked):
    begun, _, node, out = run
    one = controller(node, walked, out)
    assert begun.begin("foreign", str(PYTHON), "-c", FOREIGN).wait(MOST) == 0, begun.said("foreign")
    wait(lambda: lines(out / "commands.txt") == 3)
    assert set((out / "commands.txt").read_text().splitlines()) == {" ".join(["nan"] * 6)}
    told = (out / "controller.log").read_text()
    assert (
        told.count("safe state, joints are passive: /walker/joint_states is of elbow; wanted: hip_left") == 1
    )
    assert "Traceback" not in told and one.poll() is None


def test_without_a_master_nodes_say_so(walked, tmp_path):
    master = f"http://127.0.0.1:{processes.free_port()}"
    with processes.surroundings(tmp_path, master) as variables, Processes(variables, tmp_path) as begun:
        assert begun.begin("one", str(PYTHON), "-m", "jaxwalk.ros.simulation_node").wait(MOST) == 2
        assert f"no ROS master at {master}" in begun.said("one")


def test_a_python_without_ros_is_told_what_to_install(tmp_path, capsys):
    assert cli.main(["ros", "shipped", "--out", str(tmp_path), "--python", sys.executable]) == 2
    said = capsys.readouterr().err.strip()
    assert "lacks what ROS needs" in said and "apt-get install libode8 ros-core" in said
    assert len(said.splitlines()) == 1
