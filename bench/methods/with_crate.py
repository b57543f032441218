"""The crate allan of Rust, in its sliding mode: 601 samples, eight averaging times of 1 to 200
samples, gaps as NaN. The noise is that at one sample.

Source: docs.rs/allan
"""

import shutil
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
from signals import LOST, STRIDE, Floats, NotHere, Record

FOLDER = Path(__file__).resolve().parents[2] / "build/bench-crate"
CARGO = """[package]
name = "sliding"
version = "0.0.0"
edition = "2021"
[dependencies]
allan = "=0.4.1"
"""
MAIN = """use allan::{Allan, DataType, Mode, Style};
use std::io::{Read, Write};
fn main() {
    let mut bytes = Vec::new();
    std::io::stdin().read_to_end(&mut bytes).unwrap();
    let mut allan = Allan::builder().max_tau(300).style(Style::Decade124).mode(Mode::Sliding)
        .data_type(DataType::Frequency).build_allan();
    let mut found = Vec::new();
    for (i, x) in bytes.chunks_exact(8).enumerate() {
        allan.record(f64::from_le_bytes(x.try_into().unwrap()));
        if i % STRIDE == STRIDE - 1 {
            let adev = if i < 600 { None } else { allan.get(1).and_then(|tau| tau.deviation()) };
            found.extend(adev.unwrap_or(f64::NAN).to_le_bytes());
        }
    }
    std::io::stdout().write_all(&found).unwrap();
}
"""


@cache
def program() -> str | None:
    """The compiled program. None: there is no cargo, or it cannot get the crate."""
    if not shutil.which("cargo"):
        return None
    (FOLDER / "src").mkdir(parents=True, exist_ok=True)
    (FOLDER / "Cargo.toml").write_text(CARGO)
    (FOLDER / "src/main.rs").write_text(f"const STRIDE: usize = {STRIDE};\n{MAIN}")
    done = subprocess.run(["cargo", "build", "--release", "--quiet"], cwd=FOLDER)
    return None if done.returncode else str(FOLDER / "target/release/sliding")


def sliding(record: Record) -> Floats:
    path = program()
    if path is None:
        raise NotHere("no cargo, or no crate")
    x = np.where(record.counts == LOST, np.nan, record.counts * record.lsb_dps)
    done = subprocess.run([path], input=x.tobytes(), stdout=subprocess.PIPE, check=True)
    answers = np.full((record.counts.size // STRIDE, 4), np.nan)
    answers[:, 0] = np.frombuffer(done.stdout)
    return answers


METHODS = {"crate allan": sliding}
