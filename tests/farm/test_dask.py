# SPDX-License-Identifier: GPL-3.0-or-later
"""The Dask launcher, on local clusters. One of them loses a worker during a bake."""

import json
import os
import shutil
import signal
import subprocess
import time

import pytest
from build import environment
from conftest import ROOT

LAUNCHER = ROOT / "farm/dask/bake.py"


@pytest.fixture(scope="module")
def python():
    return environment.dask()


@pytest.fixture
def processes():
    """Starts processes, which end with the test."""
    started = []

    def start(*command, **options):
        started.append(subprocess.Popen([str(part) for part in command], **options))
        return started[-1]

    yield start
    for process in reversed(started):
        if process.poll() is None:
            process.terminate()
            process.wait(timeout=60)


def bake(python, blender, arm_file, out, *cluster, further=()):
    command = [
        python, LAUNCHER, arm_file, "--object", "An Arm", "--frames", "3..38", "--output", out, "--blender", blender,
        *cluster, "--", "--step", "5", *further,
    ]  # fmt: skip
    return [str(part) for part in command]


def wait_until(holds, event):
    for _ in range(600):
        if holds():
            return
        time.sleep(0.1)
    raise AssertionError(f"{event} did not happen in a minute")


@pytest.mark.slow
def test_two_local_workers(python, blender, arm_file, whole, tmp_path):
    command = bake(python, blender, arm_file, tmp_path / "out", "--local", 2, "--chunks", 3)
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["files"][0]["object"] == "An Arm" and "(3 of 3)" in done.stderr
    assert (tmp_path / "out" / "An Arm.pc2").read_bytes() == whole


def test_a_scene_that_does_not_exist_is_reported(python, blender, arm_file, tmp_path):
    command = bake(
        python, blender, arm_file, tmp_path, "--local", 1, "--chunks", 1, "--retries", 0, further=("--scene", "Other")
    )
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 1 and "There is no scene 'Other'" in done.stderr and not done.stdout


def test_a_worker_that_is_killed_during_a_bake(python, blender, arm_file, whole, tmp_path, processes):
    """Dask gives the chunk to the other worker, and the result has the same bytes."""
    started = tmp_path / "started"
    program = tmp_path / "blender"
    program.write_text(f'#!/bin/sh\necho $PPID >>"{started}"\nexec "{blender}" "$@"\n')
    program.chmod(0o755)
    address = tmp_path / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    local = ("--host", "127.0.0.1", "--no-dashboard")
    processes(python, "-m", "distributed.cli.dask_scheduler", *local, "--port", 0, "--scheduler-file", address, **quiet)
    wait_until(address.exists, "a scheduler")
    scheduler = json.loads(address.read_text())["address"]
    workers = [
        processes(python, "-m", "distributed.cli.dask_worker", scheduler, *local, "--no-nanny", "--nthreads", 1, **quiet)
        for _ in range(2)
    ]
    command = bake(python, program, arm_file, tmp_path / "out", "--scheduler", scheduler, "--chunks", 4)
    launcher = processes(*command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wait_until(lambda: started.exists() and len(started.read_text().split()) >= 2, "a second Blender")
    victim = int(started.read_text().split()[1])
    assert victim in [worker.pid for worker in workers]
    os.kill(victim, signal.SIGKILL)
    out, err = launcher.communicate(timeout=600)
    assert launcher.returncode == 0, err
    assert len(started.read_text().split()) >= 6, "no chunk was started again"
    assert (tmp_path / "out" / "An Arm.pc2").read_bytes() == whole and json.loads(out)["ok"]


@pytest.fixture
def certificates(tmp_path):
    """The options of a certificate that signs itself, as of scheduler, workers and launcher."""
    if shutil.which("openssl") is None:
        pytest.skip("NOT TESTED: openssl is not installed, which makes the certificate")
    cert, key = tmp_path / "cert.pem", tmp_path / "key.pem"
    subject = ("-subj", "/CN=localhost", "-addext", "subjectAltName=IP:127.0.0.1,DNS:localhost")
    make = ("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", key, "-out", cert, "-days", "2", *subject)
    subprocess.run(list(map(str, make)), check=True, capture_output=True, timeout=60)
    return f"--tls-ca-file={cert}", f"--tls-cert={cert}", f"--tls-key={key}"


@pytest.mark.slow
def test_a_cluster_with_certificates(python, blender, arm_file, whole, tmp_path, processes, certificates):
    address = tmp_path / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    local = ("--host", "tls://127.0.0.1", *certificates, "--no-dashboard")
    scheduler = ("--port", 0, "--scheduler-file", address)
    processes(python, "-m", "distributed.cli.dask_scheduler", *local, *scheduler, **quiet)
    wait_until(address.exists, "a scheduler")
    tls = json.loads(address.read_text())["address"]
    assert tls.startswith("tls://")
    processes(python, "-m", "distributed.cli.dask_worker", tls, *local, "--no-nanny", "--nthreads", 1, **quiet)
    command = bake(python, blender, arm_file, tmp_path / "out", "--scheduler", tls, *certificates, "--chunks", 2)
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert "warning" not in done.stderr and (tmp_path / "out" / "An Arm.pc2").read_bytes() == whole


def test_a_scheduler_with_tls_requires_certificates(python, arm_file, tmp_path):
    command = bake(python, "blender", arm_file, tmp_path, "--scheduler", "tls://127.0.0.1:1")
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and "--tls-ca-file" in done.stderr


def test_wrong_arguments(python, arm_file, tmp_path):
    command = [str(part) for part in (python, LAUNCHER, arm_file, "--object", "An Arm", "--output", tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and "--scheduler" in done.stderr
