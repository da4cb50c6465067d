# SPDX-License-Identifier: Apache-2.0
"""Private Slurm on this machine for tests: own folder, key and ports. Requires root."""
from __future__ import annotations

import os
import secrets
import shutil
import socket
import subprocess
import time
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "scontrol")
PATIENCE = 30  # time limit for the start of a daemon, s


class CannotStart(Exception):
    """Slurm cannot be started; the message is one line."""


def missing_package() -> str:
    """Returns the missing Debian packages, or ""."""
    path = os.environ["PATH"] + ":/usr/sbin"
    return "" if all(shutil.which(name, path=path) for name in PROGRAMS) else "slurm-wlm"


def free_ports(count: int) -> list[int]:
    """Returns unused TCP ports."""
    sockets = [socket.socket() for _ in range(count)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


class LocalSlurm:
    """Context that runs munged, slurmctld and slurmd; `environment` contains the variables for its clients."""

    def __init__(self, folder: Path, cpus: int) -> None:
        self.folder = folder
        self.cpus = cpus
        self.daemons: list[subprocess.Popen[bytes]] = []
        self.environment = dict(os.environ, SLURM_CONF=str(folder / "slurm.conf"), PATH=os.environ["PATH"] + ":/usr/sbin")

    def __enter__(self) -> LocalSlurm:
        if os.geteuid() != 0:
            raise CannotStart("a private Slurm requires root")
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def start(self) -> None:
        """Starts the daemons in order."""
        self.folder.mkdir(parents=True)
        self.folder.chmod(0o755)
        munge = self.folder / "munge"
        munge.mkdir(mode=0o700)
        (munge / "key").write_bytes(secrets.token_bytes(128))
        (munge / "key").chmod(0o400)
        sock = munge / "socket"
        self.daemon("munged", "--foreground", "--force", f"--key-file={munge / 'key'}", f"--socket={sock}",
                    f"--pid-file={munge / 'pid'}", f"--log-file={munge / 'log'}", f"--seed-file={munge / 'seed'}")
        self.wait_for(sock.exists, "munged")
        controller, node = free_ports(2)
        host = socket.gethostname().split(".")[0]
        (self.folder / "slurm.conf").write_text(f"""ClusterName=local
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
SlurmctldPort={controller}
SlurmdPort={node}
AuthType=auth/munge
AuthInfo=socket={sock}
CredType=cred/munge
StateSaveLocation={self.folder}/state
SlurmdSpoolDir={self.folder}/spool
SlurmctldPidFile={self.folder}/slurmctld.pid
SlurmdPidFile={self.folder}/slurmd.pid
SlurmctldLogFile={self.folder}/slurmctld.log
SlurmdLogFile={self.folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SchedulerParameters=sched_interval=1,batch_sched_delay=0,sched_min_interval=100000
ReturnToService=2
JobRequeue=1
KillWait=2
NodeName={host} NodeAddr=127.0.0.1 Port={node} CPUs={self.cpus} RealMemory=8000 State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO
""")
        (self.folder / "state").mkdir()
        (self.folder / "spool").mkdir()
        self.daemon("slurmctld", "-D", "-c")
        self.daemon("slurmd", "-D", "-c")
        self.wait_for(self.node_is_idle, "slurmctld or slurmd")

    def daemon(self, *command: str) -> None:
        """Starts a daemon in the foreground, in a new process session."""
        with open(self.folder / f"{command[0]}.out", "wb") as out:
            self.daemons.append(subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT, start_new_session=True,
                                                 env=self.environment))

    def wait_for(self, ready, who: str) -> None:  # type: ignore[no-untyped-def]
        """Waits until `ready()`. Raises CannotStart with the end of the logs if a daemon does not start."""
        until = time.monotonic() + PATIENCE
        while not ready():
            if time.monotonic() > until or any(daemon.poll() is not None for daemon in self.daemons):
                outs = " | ".join(path.read_text(errors="replace").strip()[-300:] for path in self.folder.glob("*.out"))
                raise CannotStart(f"{who} does not start: {' '.join(outs.split())}")
            time.sleep(0.1)

    def node_is_idle(self) -> bool:
        """Returns whether the node accepts jobs."""
        done = subprocess.run(["sinfo", "-h", "-o", "%T"], env=self.environment, capture_output=True, text=True, check=False)
        return done.stdout.strip() == "idle"

    def stop(self) -> None:
        """Stops the daemons in reverse order."""
        for daemon in reversed(self.daemons):
            daemon.terminate()
            try:
                daemon.wait(5)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
