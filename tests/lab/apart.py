"""Starts a file of tests in davarlab's own environment, which has numpy."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PYTHON = ROOT / "build/venv-lab/bin/python"
ENVIRONMENT = {"PYTHONPATH": ROOT / "tools/lab", "DAVAR_LAB_LIBRARY": ROOT / "build/tools/tools/lab/libdavar_lab.so"}


def passes(case, name):
    subprocess.run([ROOT / "tools/davarlab", "effects"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    done = subprocess.run([PYTHON, ROOT / "tests/lab" / name], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          env={name: str(value) for name, value in ENVIRONMENT.items()})
    case.assertEqual(done.returncode, 0, done.stdout)
